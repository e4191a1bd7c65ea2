//! Folder of one upload.

use std::fs::{DirBuilder, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::server::access_key::AccessKey;

/// Name of the subfolder of the uploaded files.
pub(crate) const FILES_FOLDER: &str = "files";

/// Name of the file of the model.
pub(crate) const MODEL_FILE: &str = "model";

/// Name of the file that is locked as long as the folder is in use.
const LOCK: &str = "lock";

/// Beginning of the names of folders.
const PREFIX: &str = "glanz-upload-";

/// Largest number of names that are tried for a folder: another server that starts may take a new one for abandoned.
const ATTEMPTS: usize = 8;

/// A folder that only this user may read, with an empty subfolder for the files, removed with its content when it is dropped.
#[derive(Debug)]
pub(crate) struct UploadFolder {
    path: PathBuf,
    /// Released by the system if the server is killed, so that the next one removes the folder.
    _lock: File,
}

impl UploadFolder {
    /// Makes a folder with a random name among the system's temporary files.
    ///
    /// # Errors
    /// The error of the system.
    pub(crate) fn try_new() -> io::Result<Self> {
        Self::try_new_in(&std::env::temp_dir())
    }

    fn try_new_in(parent: &Path) -> io::Result<Self> {
        for _ in 0..ATTEMPTS {
            if let Some(folder) = Self::try_once_in(parent)? {
                return Ok(folder);
            }
        }
        Err(io::ErrorKind::WouldBlock.into())
    }

    /// Makes a folder; `None` if another server takes it for abandoned.
    fn try_once_in(parent: &Path) -> io::Result<Option<Self>> {
        let key = AccessKey::random().map_err(io::Error::other)?;
        let path = parent.join(format!("{PREFIX}{key}"));
        let mut builder = DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        // An error if anything of this name exists.
        builder.create(&path)?;
        let lock = File::create_new(path.join(LOCK)).inspect_err(|_| {
            let _ = std::fs::remove_dir(&path);
        })?;
        let folder = Self { path, _lock: lock };
        match folder._lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            // On systems without locks the folder of a killed server stays.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(error),
        }
        match builder.create(folder.files()) {
            Ok(()) => Ok(Some(folder)),
            // It was removed before it was locked.
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Removes the folders of servers that were killed.
    pub(crate) fn remove_abandoned() {
        remove_abandoned_in(&std::env::temp_dir());
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Folder of the uploaded files.
    pub(crate) fn files(&self) -> PathBuf {
        self.path.join(FILES_FOLDER)
    }

    /// Path of the model.
    pub(crate) fn model(&self) -> PathBuf {
        self.path.join(MODEL_FILE)
    }
}

impl Drop for UploadFolder {
    fn drop(&mut self) {
        // What the system does not remove now, it removes with its other temporary files.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Removes the folders of uploads whose lock nobody holds.
fn remove_abandoned_in(parent: &Path) {
    let entries = std::fs::read_dir(parent).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes())) {
        let (path, lock) = (entry.path(), entry.path().join(LOCK));
        // Opening a pipe of another user would wait for its writer.
        if !lock.symlink_metadata().is_ok_and(|about| about.is_file()) {
            continue;
        }
        // Folders of other users cannot be opened.
        let Ok(lock) = File::open(lock) else { continue };
        if lock.try_lock().is_ok() {
            let _ = std::fs::remove_dir_all(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_is_private_and_gone_afterwards() {
        let (folder, other) = (UploadFolder::try_new().unwrap(), UploadFolder::try_new().unwrap());
        assert_ne!(folder.path(), other.path());
        std::fs::create_dir(folder.files().join("textures")).unwrap();
        std::fs::write(folder.files().join("textures/wood.png"), b"x").unwrap();
        #[cfg(unix)]
        for path in [folder.path(), &folder.files()] {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(path).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o700);
        }
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists() && other.path().exists());
    }

    #[test]
    fn only_folders_of_killed_servers_are_removed() {
        let parent = tempfile::TempDir::new().unwrap();
        let used = UploadFolder::try_new_in(parent.path()).unwrap();
        let abandoned = UploadFolder::try_new_in(parent.path()).unwrap();
        let path = abandoned.path().to_owned();
        std::fs::write(abandoned.files().join("a.pbrt"), "x").unwrap();
        // A server that is killed releases its locks and removes nothing.
        abandoned._lock.unlock().unwrap();
        std::mem::forget(abandoned);
        let unlocked = parent.path().join(format!("{PREFIX}x"));
        std::fs::create_dir(&unlocked).unwrap();
        remove_abandoned_in(parent.path());
        assert!(used.path().exists() && unlocked.exists() && !path.exists());
    }
    #[cfg(unix)]
    #[test]
    fn a_pipe_in_place_of_the_lock_is_not_opened() {
        let parent = tempfile::TempDir::new().unwrap();
        let folder = parent.path().join(format!("{PREFIX}x"));
        std::fs::create_dir(&folder).unwrap();
        let made = std::process::Command::new("mkfifo").arg(folder.join(LOCK)).status().unwrap();
        assert!(made.success());
        remove_abandoned_in(parent.path());
        assert!(folder.exists());
    }
}
