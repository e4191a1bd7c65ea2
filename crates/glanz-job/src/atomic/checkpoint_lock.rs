//! Locks of checkpoints.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{error, fmt};

use super::temporary::{FileLock, LOCK, START, is_named, lock};
use crate::ContentHash;

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
    /// The lock file cannot be created.
    Io(io::Error),
}

impl fmt::Display for CheckpointLockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken { process: Some(number) } => {
                write!(f, "process {number} is writing this checkpoint")
            }
            Self::Taken { process: None } => f.write_str("another process is writing this checkpoint"),
            Self::Io(error) => write!(f, "cannot be locked: {error}"),
        }
    }
}

impl error::Error for CheckpointLockError {}

impl CheckpointLock {
    /// Claims the file `checkpoint`, which need not exist. `None` for a pipe or a device, and where the file system has no locks.
    ///
    /// # Errors
    /// [`CheckpointLockError::Taken`] if another process, or another job of this one, has it; [`CheckpointLockError::Io`] if its
    /// folder cannot be written.
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
            let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = opened.map_err(CheckpointLockError::Io)?;
            match lock(&file) {
                FileLock::Own if is_named(&file, &path) => {
                    // Only for the message of others.
                    let _ = file.set_len(0).and_then(|()| write!(file, "{}", std::process::id()));
                    return Ok(Some(Self { path, _file: file }));
                }
                // It was removed between opening and locking.
                FileLock::Own => {}
                FileLock::Other => std::thread::sleep(PAUSE),
                FileLock::Unsupported => {
                    let _ = fs::remove_file(&path);
                    return Ok(None);
                }
            }
        }
        let mut text = String::new();
        let read = File::open(&path).and_then(|mut file| file.read_to_string(&mut text));
        Err(CheckpointLockError::Taken { process: read.ok().and_then(|_| text.parse().ok()) })
    }
}

impl Drop for CheckpointLock {
    fn drop(&mut self) {
        // Before the lock is released: who opened the file earlier finds that it has no name.
        let _ = fs::remove_file(&self.path);
    }
}
