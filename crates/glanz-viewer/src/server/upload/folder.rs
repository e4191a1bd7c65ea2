//! Folder of one upload.

use std::fs::DirBuilder;
use std::io;
use std::path::{Path, PathBuf};

use crate::server::access_key::AccessKey;

/// An empty folder that only this user may read, removed with its content when it is dropped.
#[derive(Debug)]
pub(super) struct UploadFolder(PathBuf);

impl UploadFolder {
    /// Makes a folder with a random name among the system's temporary files.
    ///
    /// # Errors
    /// The error of the system.
    pub(super) fn try_new() -> io::Result<Self> {
        let key = AccessKey::random().map_err(io::Error::other)?;
        let path = std::env::temp_dir().join(format!("glanz-{key}"));
        let mut builder = DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        // An error if anything of this name exists.
        builder.create(&path)?;
        Ok(Self(path))
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for UploadFolder {
    fn drop(&mut self) {
        // What the system does not remove now, it removes with its other temporary files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_is_private_and_gone_afterwards() {
        let (folder, other) = (UploadFolder::try_new().unwrap(), UploadFolder::try_new().unwrap());
        assert_ne!(folder.path(), other.path());
        std::fs::create_dir(folder.path().join("textures")).unwrap();
        std::fs::write(folder.path().join("textures/wood.png"), b"x").unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(folder.path()).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o700);
        }
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists() && other.path().exists());
    }
}
