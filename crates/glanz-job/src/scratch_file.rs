//! Temporary files for data above the limit of memory.

use std::env;
use std::error::Error;
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::IoFault;

/// A file that has no name and ends with the program. Any thread may read and write it, at any place.
#[derive(Debug)]
pub struct ScratchFile {
    file: File,
    folder: PathBuf,
    #[cfg(not(unix))]
    position: std::sync::Mutex<()>,
}

/// An error of a [`ScratchFile`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScratchFileError {
    /// Folder of the file.
    pub folder: PathBuf,
    /// Kind of the fault.
    pub kind: io::ErrorKind,
    /// Number of the fault in the system, if it has one.
    pub code: Option<i32>,
    /// The fault, as a sentence.
    pub fault: String,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl fmt::Display for ScratchFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { folder, fault, bytes, .. } = self;
        let (folder, megabytes) = (folder.display(), bytes.div_ceil(1_000_000));
        write!(
            f,
            "the temporary file in {folder}: {fault}; set TMPDIR to a folder with room for {megabytes} MB"
        )
    }
}

impl Error for ScratchFileError {}

/// The folders for a temporary file that may be larger than the memory.
fn folders() -> impl Iterator<Item = PathBuf> {
    let large = env::var_os("TMPDIR").is_none().then(|| PathBuf::from("/var/tmp"));
    large.into_iter().chain([env::temp_dir()])
}

/// Checks that the file system is on a disk, as that of the usual folder is not on many systems. A folder that `TMPDIR` names is taken as it is.
#[cfg(target_os = "linux")]
fn check_disk(file: &File) -> io::Result<()> {
    // TMPFS_MAGIC; the type of this number differs between processors.
    let is_in_memory = rustix::fs::fstatfs(file).is_ok_and(|found| found.f_type == 0x0102_1994);
    match env::var_os("TMPDIR") {
        None if is_in_memory => Err(io::Error::new(io::ErrorKind::Unsupported, "the folder is in memory")),
        _ => Ok(()),
    }
}

/// Reserves room on the disk, so that a lack of it shows before the work. Where the file system cannot, it shows when the file is written.
#[cfg(target_os = "linux")]
fn reserve(file: &File, start: u64, bytes: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    use rustix::io::{Errno, retry_on_intr};
    match retry_on_intr(|| fallocate(file, FallocateFlags::empty(), start, bytes)) {
        Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(target_os = "linux"))]
fn check_disk(_: &File) -> io::Result<()> {
    Ok(())
}

#[cfg(not(target_os = "linux"))]
fn reserve(_: &File, _: u64, _: u64) -> io::Result<()> {
    Ok(())
}

impl ScratchFile {
    /// A file of zeros in the first folder with room for it: `TMPDIR`, or `/var/tmp` and the usual one where they are on a disk.
    ///
    /// # Errors
    /// [`ScratchFileError`] of the first folder if none has room.
    pub fn try_new(bytes: u64) -> Result<Self, ScratchFileError> {
        let mut first = None;
        for folder in folders() {
            let file = tempfile::tempfile_in(&folder);
            let made = file.and_then(|file| check_disk(&file).map(|()| file));
            let made = made.map_err(|error| error_of(&folder, &error, bytes)).and_then(|file| {
                let made = Self {
                    file,
                    folder,
                    #[cfg(not(unix))]
                    position: std::sync::Mutex::default(),
                };
                made.resize(bytes).map(|()| made)
            });
            match made {
                Ok(file) => return Ok(file),
                Err(error) => first = first.or(Some(error)),
            }
        }
        Err(first.unwrap_or_else(|| error_of(&env::temp_dir(), &io::ErrorKind::NotFound.into(), bytes)))
    }

    /// Makes it this long, with zeros behind what it has.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the disk has no room.
    pub fn resize(&self, bytes: u64) -> Result<(), ScratchFileError> {
        let resized = self.file.metadata().and_then(|metadata| {
            let length = metadata.len();
            if bytes > length {
                reserve(&self.file, length, bytes - length)?;
            }
            self.file.set_len(bytes)
        });
        resized.map_err(|error| self.error(&error, bytes))
    }

    /// Fills `bytes` from the place `start` on.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the disk fails, or the file is shorter.
    pub fn read(&self, bytes: &mut [u8], start: u64) -> Result<(), ScratchFileError> {
        let end = start.saturating_add(bytes.len() as u64);
        self.read_at(bytes, start).map_err(|error| self.error(&error, end))
    }

    /// Writes `bytes` from the place `start` on.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the disk fails or is full.
    pub fn write(&self, bytes: &[u8], start: u64) -> Result<(), ScratchFileError> {
        let end = start.saturating_add(bytes.len() as u64);
        self.write_at(bytes, start).map_err(|error| self.error(&error, end))
    }

    #[cfg(unix)]
    fn read_at(&self, bytes: &mut [u8], start: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, start)
    }

    #[cfg(unix)]
    fn write_at(&self, bytes: &[u8], start: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::write_all_at(&self.file, bytes, start)
    }

    #[cfg(not(unix))]
    fn read_at(&self, bytes: &mut [u8], start: u64) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let _position = self.position.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        (&self.file).seek(SeekFrom::Start(start))?;
        (&self.file).read_exact(bytes)
    }

    #[cfg(not(unix))]
    fn write_at(&self, bytes: &[u8], start: u64) -> io::Result<()> {
        use std::io::{Seek, SeekFrom, Write};
        let _position = self.position.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        (&self.file).seek(SeekFrom::Start(start))?;
        (&self.file).write_all(bytes)
    }

    /// The same file for calls that go from place to place, its beginning first. The place is common to all that this returns.
    ///
    /// # Errors
    /// [`ScratchFileError`] if too many files are open.
    pub fn stream(&self) -> Result<File, ScratchFileError> {
        self.file.try_clone().map_err(|error| self.error(&error, 0))
    }

    /// The error of a call of the system for the file with `bytes`.
    #[must_use]
    pub fn error(&self, error: &io::Error, bytes: u64) -> ScratchFileError {
        let length = self.file.metadata().map_or(0, |metadata| metadata.len());
        error_of(&self.folder, error, bytes.max(length))
    }
}

fn error_of(folder: &Path, error: &io::Error, bytes: u64) -> ScratchFileError {
    let fault = IoFault::sentence(error).to_string();
    ScratchFileError {
        folder: folder.to_owned(),
        kind: error.kind(),
        code: error.raw_os_error(),
        fault,
        bytes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_from_their_places() {
        let file = ScratchFile::try_new(10).unwrap();
        file.write(b"abc", 4).unwrap();
        let mut bytes = [1; 10];
        file.read(&mut bytes, 0).unwrap();
        assert_eq!(bytes, *b"\0\0\0\0abc\0\0\0");
        file.resize(20).unwrap();
        file.read(&mut bytes, 10).unwrap();
        assert_eq!(bytes, [0; 10]);
        let error = file.read(&mut bytes, 15).unwrap_err();
        assert_eq!(error.bytes, 25);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_beyond_the_disk_is_refused_with_its_size() {
        let error = ScratchFile::try_new(1 << 60).unwrap_err();
        assert_eq!(error.bytes, 1 << 60);
        assert!(error.to_string().contains("room for 1152921504607 MB"), "{error}");
    }
}
