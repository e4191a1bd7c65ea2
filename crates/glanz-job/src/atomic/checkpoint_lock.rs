//! Locks of checkpoints.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{error, fmt};

use super::temporary::{FileLock, LOCK, START, is_named, lock};
use crate::{ContentHash, IoFault};

/// Attempts to get a lock. A process that tidies up a folder holds the locks of others for microseconds.
const ATTEMPTS: u32 = 20;

/// Time between two attempts.
const PAUSE: Duration = Duration::from_millis(10);

/// Claim of a checkpoint, which keeps other processes from writing it until it is dropped or its process ends in any way.
///
/// It is the lock of a hidden file beside the checkpoint, since every save replaces the checkpoint itself. After a kill the file
/// stays until the next claim, or [`remove_orphans`](crate::remove_orphans).
#[derive(Debug)]
pub struct CheckpointLock {
    path: PathBuf,
    /// Keeps the lock.
    _file: File,
}

/// A checkpoint that cannot be claimed.
#[derive(Debug)]
pub enum CheckpointLockError {
    /// A running process has it.
    Taken {
        /// Its number, if it is known.
        process: Option<u32>,
    },
    /// The lock file cannot be created, removed or locked.
    Io(io::Error),
}

impl fmt::Display for CheckpointLockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken { process: Some(number) } => {
                write!(f, "process {number} is writing this checkpoint")
            }
            Self::Taken { process: None } => f.write_str("another process is writing this checkpoint"),
            Self::Io(error) => write!(f, "cannot be locked: {}", IoFault::sentence(error)),
        }
    }
}

impl error::Error for CheckpointLockError {}

impl CheckpointLock {
    /// Claims the file `checkpoint`, which need not exist. `None` for a pipe or a device, and where the file system has no locks.
    ///
    /// # Errors
    /// [`CheckpointLockError::Taken`] if another process, or another job of this one, has it; [`CheckpointLockError::Io`] if its
    /// folder cannot be written, or locking fails.
    pub fn acquire(checkpoint: &Path) -> Result<Option<Self>, CheckpointLockError> {
        if fs::metadata(checkpoint).is_ok_and(|found| !found.is_file()) {
            return Ok(None);
        }
        // All names of the file have one lock.
        let checkpoint = fs::canonicalize(checkpoint).unwrap_or_else(|_| checkpoint.to_owned());
        let mut hash = ContentHash::default();
        hash.add_file(checkpoint.file_name().unwrap_or_default().as_encoded_bytes());
        let path = checkpoint.with_file_name(format!("{START}{:032x}{LOCK}", hash.value()));
        for _ in 0..ATTEMPTS {
            let Some((mut file, origin)) = open(&path).map_err(CheckpointLockError::Io)? else { continue };
            match lock(&file).map_err(CheckpointLockError::Io)? {
                // It was removed between opening and locking.
                FileLock::Own if !is_named(&file, &path) => {}
                // The next attempt creates one.
                FileLock::Own if origin == LockFileOrigin::ReadOnly => {
                    fs::remove_file(&path).map_err(CheckpointLockError::Io)?;
                }
                FileLock::Own => {
                    // Only for the message of others.
                    let _ = file.set_len(0).and_then(|()| write!(file, "{}", std::process::id()));
                    return Ok(Some(Self { path, _file: file }));
                }
                FileLock::Other => std::thread::sleep(PAUSE),
                FileLock::Unsupported => {
                    if origin == LockFileOrigin::New {
                        let _ = fs::remove_file(&path);
                    }
                    return Ok(None);
                }
            }
        }
        let mut text = String::new();
        let read = File::open(&path).and_then(|mut file| file.read_to_string(&mut text));
        Err(CheckpointLockError::Taken { process: read.ok().and_then(|_| text.parse().ok()) })
    }
}

/// Where an open lock file comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LockFileOrigin {
    /// It was created.
    New,
    /// It existed.
    Existing,
    /// It existed, and may only be read: that of another user.
    ReadOnly,
}

/// Opens or creates the lock file `path`; `None` if it was removed meanwhile.
fn open(path: &Path) -> io::Result<Option<(File, LockFileOrigin)>> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        created => return created.map(|file| Some((file, LockFileOrigin::New))),
    }
    let opened = match options.open(path) {
        Err(error) if error.kind() == ErrorKind::PermissionDenied => {
            File::open(path).map(|file| (file, LockFileOrigin::ReadOnly))
        }
        opened => opened.map(|file| (file, LockFileOrigin::Existing)),
    };
    match opened {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        opened => opened.map(Some),
    }
}

impl Drop for CheckpointLock {
    fn drop(&mut self) {
        // Before the lock is released: who opened the file earlier finds that it has no name.
        let _ = fs::remove_file(&self.path);
    }
}
