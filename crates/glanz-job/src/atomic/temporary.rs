//! Temporary files, and the files that killed processes have left.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Beginning of the names of all files that exist only while a process of Glanz lives.
pub(super) const START: &str = ".glanz-";

/// End of the names of temporary files.
const TEMPORARY: &str = ".tmp";

/// End of the names of lock files.
pub(super) const LOCK: &str = ".lock";

/// A file that is removed when dropped, unless it has taken another name. Its lock shows other processes that its own one lives.
pub(super) struct TemporaryFile {
    /// `None` when it has another name.
    path: Option<PathBuf>,
    pub(super) file: File,
}

impl TemporaryFile {
    /// A new file in the folder of `path`.
    pub(super) fn create_beside(path: &Path) -> io::Result<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        for _ in 0..100 {
            // A short name, so that it is valid wherever that of the file is.
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let name = format!("{START}{}-{number}{TEMPORARY}", std::process::id());
            let candidate = path.with_file_name(name);
            match File::create_new(&candidate) {
                // Otherwise another process has removed it before it was locked.
                Ok(file) if !matches!(lock(&file), Ok(FileLock::Other)) && is_named(&file, &candidate) => {
                    return Ok(Self { path: Some(candidate), file });
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(Error::from(ErrorKind::AlreadyExists))
    }

    /// Gives the file the name `path`, in place of an existing file.
    pub(super) fn take_name(mut self, path: &Path) -> io::Result<()> {
        if let Some(temporary) = &self.path {
            fs::rename(temporary, path)?;
        }
        self.path = None;
        Ok(())
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        if let Some(path) = self.path.take() {
            // The error that led here is reported instead.
            let _ = fs::remove_file(path);
        }
    }
}

/// Outcome of an attempt to lock a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileLock {
    /// This process has the lock until the file is closed.
    Own,
    /// Another process has it.
    Other,
    /// The file system has no locks.
    Unsupported,
}

pub(super) fn lock(file: &File) -> io::Result<FileLock> {
    match file.try_lock() {
        Ok(()) => Ok(FileLock::Own),
        Err(TryLockError::WouldBlock) => Ok(FileLock::Other),
        Err(TryLockError::Error(error)) if is_unsupported(&error) => Ok(FileLock::Unsupported),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

fn is_unsupported(error: &Error) -> bool {
    // ENOTSUP and EOPNOTSUPP, and ENOLCK of network folders without locks, which have no kind in some versions of the standard library: of Linux; of macOS and the BSDs.
    let numbers: &[i32] = if cfg!(target_os = "linux") {
        &[37, 95]
    } else if cfg!(unix) {
        &[45, 77, 102]
    } else {
        &[]
    };
    error.kind() == ErrorKind::Unsupported
        || error.raw_os_error().is_some_and(|number| numbers.contains(&number))
}

/// Whether `path` is a name of the open file; elsewhere than on Unix it is assumed.
pub(super) fn is_named(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        match (file.metadata(), fs::symlink_metadata(path)) {
            (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
            _ => false,
        }
    }
    #[cfg(not(unix))]
    {
        let _ = (file, path);
        true
    }
}

/// Removes temporary files and lock files from `folder` whose processes have been killed: those whose lock is free.
///
/// Files of other programs and of processes that live stay, and so does everything where the file system has no locks. In a network folder whose locks are
/// those of each machine alone (NFS mounted with `nolock` or `local_lock`), files of processes on other machines count as left.
pub fn remove_orphans(folder: &Path) {
    // A folder that cannot be read cannot be tidied up; its other uses report that.
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if !is_own_name(&entry.file_name()) || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = entry.path();
        // Locks of network folders need a file that is open for writing; those of other users may have to be opened for reading.
        let opened = OpenOptions::new().write(true).open(&path).or_else(|error| match error.kind() {
            ErrorKind::PermissionDenied => File::open(&path),
            _ => Err(error),
        });
        let Ok(file) = opened else { continue };
        if matches!(lock(&file), Ok(FileLock::Own)) && is_named(&file, &path) {
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether files of this name are temporary files or lock files.
fn is_own_name(name: &OsStr) -> bool {
    let Some(rest) = name.to_str().and_then(|name| name.strip_prefix(START)) else { return false };
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_temporary = |text: &str| text.split_once('-').is_some_and(|(a, b)| is_number(a) && is_number(b));
    let is_hash = |text: &str| text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    rest.strip_suffix(TEMPORARY).is_some_and(is_temporary) || rest.strip_suffix(LOCK).is_some_and(is_hash)
}
