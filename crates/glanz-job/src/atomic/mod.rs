//! Files that are written as a whole or not at all.

mod checkpoint_lock;
mod temporary;
#[cfg(test)]
mod tests;

pub use checkpoint_lock::{CheckpointLock, CheckpointLockError};
pub use temporary::remove_orphans;

use std::error::Error;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use temporary::TemporaryFile;

/// A file that was not written.
#[derive(Debug)]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// The error.
    pub source: io::Error,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.source)
    }
}

impl Error for WriteError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&self.source)
    }
}

/// Writes `bytes` to the file `path`, so that at any moment, a crash included, the file has its old content or the new
/// one: they go into a temporary file of the same folder, which then takes the name. An existing file keeps its
/// permissions, a symbolic link stays one. What is not a regular file (a pipe, a device) is written directly. A temporary file
/// that a kill leaves is removed by [`remove_orphans`].
///
/// # Errors
/// [`WriteError`]; the temporary file is removed then and an old file `path` is untouched. An existing read-only
/// file is an error.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_atomically_with(path, |out| out.write_all(bytes))
}

/// As [`write_atomically`], of bytes that `content` writes; it is not buffered.
///
/// # Errors
/// As [`write_atomically`], also if `content` returns an error.
pub fn write_atomically_with(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    write_file_atomically(path, |file| content(file))
}

/// As [`write_atomically_with`], where `content` may return to earlier bytes; on a pipe seeking fails.
///
/// # Errors
/// As [`write_atomically_with`].
pub fn write_file_atomically(
    path: &Path,
    content: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), WriteError> {
    replace(path, content).map_err(|source| WriteError { path: path.to_owned(), source })
}

fn replace(path: &Path, content: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    // A rename would replace the link, not the file that it names.
    let path = if path.is_symlink() { fs::canonicalize(path)? } else { path.to_owned() };
    let existing = match fs::metadata(&path) {
        Ok(found) if found.is_file() => Some(found.permissions()),
        Ok(found) if found.is_dir() => return Err(io::Error::from(io::ErrorKind::IsADirectory)),
        Ok(_) => return content(&mut fs::OpenOptions::new().write(true).open(&path)?),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    if existing.as_ref().is_some_and(fs::Permissions::readonly) {
        return Err(io::Error::from(io::ErrorKind::PermissionDenied));
    }
    let mut temporary = TemporaryFile::create_beside(&path)?;
    content(&mut temporary.file)?;
    if let Some(permissions) = existing {
        temporary.file.set_permissions(permissions)?;
    }
    // Otherwise a crash after the rename could leave an empty file.
    temporary.file.sync_all()?;
    temporary.take_name(&path)
}

/// Creates the folder if it does not exist, and removes what killed processes have left in it ([`remove_orphans`]).
///
/// # Errors
/// That of creating the folder.
pub fn make_folder(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    remove_orphans(folder);
    Ok(())
}

/// Checks that the folder of `path` can take a new file, by a temporary one: permissions do not show read-only file systems and access lists.
///
/// # Errors
/// That of creating the file.
pub fn check_creatable(path: &Path) -> io::Result<()> {
    TemporaryFile::create_beside(path).map(drop)
}
