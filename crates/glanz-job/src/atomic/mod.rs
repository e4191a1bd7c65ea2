//! Files that are written as a whole or not at all.

#[cfg(test)]
mod tests;

use std::error::Error;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

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
/// permissions, a symbolic link stays one. What is not a regular file (a pipe, a device) is written directly.
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
    let (temporary, mut file) = TemporaryFile::create_beside(&path)?;
    content(&mut file)?;
    if let Some(permissions) = existing {
        file.set_permissions(permissions)?;
    }
    // Otherwise a crash after the rename could leave an empty file.
    file.sync_all()?;
    drop(file);
    temporary.take_name(&path)
}

/// A file that is removed when dropped, unless it has taken another name.
struct TemporaryFile(Option<PathBuf>);

impl TemporaryFile {
    /// A new file in the folder of `path`.
    fn create_beside(path: &Path) -> io::Result<(Self, File)> {
        let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        for attempt in 0..100_u32 {
            let mut hidden = std::ffi::OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".{}-{attempt}.tmp", std::process::id()));
            let candidate = path.with_file_name(hidden);
            match File::create_new(&candidate) {
                Ok(file) => return Ok((Self(Some(candidate)), file)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::from(io::ErrorKind::AlreadyExists))
    }

    fn take_name(mut self, path: &Path) -> io::Result<()> {
        if let Some(temporary) = &self.0 {
            fs::rename(temporary, path)?;
        }
        self.0 = None;
        Ok(())
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        if let Some(path) = self.0.take() {
            // The error that led here is reported instead.
            let _ = fs::remove_file(path);
        }
    }
}
