//! Files: checks before the work starts, reading, and atomic replacement.

use std::fs::{self, File};
use std::path::Path;

use glanz_job::WriteError;

use crate::error::{Error, FileFault};

/// Checks that the file `path` can be created or replaced, without changing it.
///
/// # Errors
/// [`Error::File`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(FileFault::NoFolder(folder.to_owned()).of(path));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(FileFault::IsFolder.of(path)),
        Ok(found) if found.permissions().readonly() => return Err(FileFault::ReadOnly.of(path)),
        _ => {}
    }
    // Permissions alone do not suffice (read-only file systems, access lists): a file with a unique name is created as a test.
    let probe = folder.join(format!(".glanz-{}.tmp", std::process::id()));
    File::create(&probe)
        .and_then(|_| fs::remove_file(&probe))
        .map_err(|error| FileFault::NotWritable(error).of(path))
}

/// Checks that the output `path` is not the file `input`, also by another name.
///
/// # Errors
/// [`Error::File`].
pub fn check_not_input(path: &Path, input: &Path) -> Result<(), Error> {
    match (fs::canonicalize(path), fs::canonicalize(input)) {
        (Ok(output), Ok(input)) if output == input => Err(FileFault::IsInput.of(path)),
        _ => Ok(()),
    }
}

/// Checks that the checkpoint `path` can be written without losing an existing one; `resume`: whether an existing one is resumed.
///
/// # Errors
/// [`Error::File`].
pub fn check_checkpoint(path: &Path, resume: bool) -> Result<(), Error> {
    check_writable(path)?;
    if path.exists() && !resume { Err(FileFault::Exists.of(path)) } else { Ok(()) }
}

/// The bytes of the file `path`.
///
/// # Errors
/// [`Error::File`].
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(Error::of_file(path))
}

/// Writes `bytes` to the file `path`, which keeps its old content until all bytes are written.
///
/// # Errors
/// [`Error::File`].
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let written = glanz_job::write_atomically(path, bytes);
    written.map_err(|WriteError { path, source }| FileFault::Io(source).of(&path))
}

/// Creates the folder if it does not exist.
///
/// # Errors
/// [`Error::File`].
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|error| FileFault::NotMade(error).of(folder))
}
