//! Files that a scene refers to.

use std::io;
use std::path::{Path, PathBuf};

use crate::content_hash::ContentHash;

/// Finds and reads files, and fingerprints what was read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finder {
    /// Folders to look in, in order: the scene's, those of `SearchPath`.
    folders: Vec<PathBuf>,
    pub(crate) hash: ContentHash,
}

impl Finder {
    /// Looks in the folder of the scene first.
    pub(crate) fn new(folder: Option<&Path>) -> Self {
        Self { folders: folder.map(Path::to_owned).into_iter().collect(), hash: ContentHash::default() }
    }

    /// Looks in `folder` too, after the others.
    pub(crate) fn add_folder(&mut self, folder: &str) {
        let base = self.folders.first().cloned().unwrap_or_default();
        let folder = base.join(folder);
        if self.folders.len() < MAX_FOLDERS && !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
    }

    /// The file of that name: in the scene's folder as pbrt has it, in the folders of `SearchPath`, beside the file
    /// that asks for it, or one above the scene's folder, where it is if a part of a scene is opened alone. Backslashes
    /// count as slashes if there is no such file otherwise.
    pub(crate) fn find(&self, name: &str, asking: Option<&Path>) -> Option<PathBuf> {
        if name.is_empty() || name.contains('\0') {
            return None;
        }
        let slashed = name.replace('\\', "/");
        let beside = asking.and_then(Path::parent);
        let above = self.folders.first().map(|f| f.join(".."));
        let folders = || self.folders.iter().map(PathBuf::as_path).chain(beside).chain(above.as_deref());
        [name, slashed.as_str()]
            .iter()
            .flat_map(|name| folders().map(move |f| f.join(name)))
            .find(|path| path.is_file())
    }

    /// The bytes of a file, which enter the fingerprint.
    ///
    /// # Errors
    /// Those of the file system, and [`io::ErrorKind::InvalidInput`] for what is not a regular file.
    pub(crate) fn read(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        if !std::fs::metadata(path)?.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
        }
        let bytes = std::fs::read(path)?;
        self.hash.add_file(&bytes);
        Ok(bytes)
    }
}

/// Folders of `SearchPath` at most.
const MAX_FOLDERS: usize = 64;
