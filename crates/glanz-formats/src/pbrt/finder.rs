//! Files that a scene refers to.

use std::collections::BTreeSet;
use std::io;
use std::path::{Component, Path, PathBuf};

use glanz_job::ContentHash;

/// Finds and reads files, and fingerprints what was read.
#[derive(Clone, Debug, Default)]
pub(crate) struct FileFinder {
    /// Folders to look in, in order: the scene's, those of `SearchPath`.
    folders: Vec<PathBuf>,
    confinement: Option<Confinement>,
    /// Everything that was read.
    pub(crate) paths: BTreeSet<PathBuf>,
    pub(crate) hash: ContentHash,
}

/// The folder that no file may lie outside of.
#[derive(Clone, Debug)]
struct Confinement {
    /// As it was given.
    folder: PathBuf,
    /// As the system names it, without links.
    real: PathBuf,
}

/// Errors of finding a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FindError {
    /// None of the folders has it.
    Missing,
    /// It is not in the folder that a scene is confined to: see [`crate::Options::confined`].
    Outside,
}

impl FindError {
    /// Message about a file, without its name.
    pub(crate) fn what(self) -> &'static str {
        match self {
            Self::Missing => "is not there",
            Self::Outside => "is outside the folder of the scene",
        }
    }

    /// Remedy.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::Missing => "names are relative to the folder of the scene file",
            Self::Outside => {
                "give the file together with the scene, and name it without \"..\" or a leading slash"
            }
        }
    }
}

impl FileFinder {
    /// Looks in the folder of the scene first.
    pub(crate) fn new(folder: Option<&Path>) -> Self {
        Self { folders: folder.map(Path::to_owned).into_iter().collect(), ..Self::default() }
    }

    /// Finds nothing outside of `folder`.
    ///
    /// # Errors
    /// Those of the file system, if there is no such folder.
    pub(crate) fn confined_to(folder: &Path) -> io::Result<Self> {
        let confinement = Confinement { folder: folder.to_owned(), real: std::fs::canonicalize(folder)? };
        Ok(Self { confinement: Some(confinement), ..Self::new(Some(folder)) })
    }

    /// Looks in `folder` too, after the others.
    ///
    /// # Errors
    /// [`FindError::Outside`] if it leads out of the folder that the scene is confined to.
    pub(crate) fn add_folder(&mut self, folder: &str) -> Result<(), FindError> {
        self.check_name(folder)?;
        let base = self.folders.first().cloned().unwrap_or_default();
        let folder = base.join(folder);
        if self.folders.len() < MAX_FOLDERS && !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
        Ok(())
    }

    /// True if a name can denote a file in the folder that the scene is confined to.
    fn check_name(&self, name: &str) -> Result<(), FindError> {
        let slashed = name.replace('\\', "/");
        let inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        let leads_out = || !Path::new(&slashed).components().all(inside);
        if self.confinement.is_some() && leads_out() { Err(FindError::Outside) } else { Ok(()) }
    }

    /// A path as messages show it: relative to the folder that the scene is confined to, which is nobody's business.
    pub(crate) fn shown<'a>(&self, path: &'a Path) -> &'a Path {
        self.confinement.as_ref().and_then(|c| path.strip_prefix(&c.folder).ok()).unwrap_or(path)
    }

    /// The file of that name: in the scene's folder as pbrt has it, in the folders of `SearchPath`, beside the file
    /// that asks for it, or one above the scene's folder, where it is if a part of a scene is opened alone. Backslashes
    /// count as slashes if there is no such file otherwise.
    ///
    /// # Errors
    /// [`FindError`].
    pub(crate) fn find(&self, name: &str, asking: Option<&Path>) -> Result<PathBuf, FindError> {
        if name.is_empty() || name.contains('\0') {
            return Err(FindError::Missing);
        }
        self.check_name(name)?;
        let slashed = name.replace('\\', "/");
        let beside = asking.and_then(Path::parent);
        let above = self.folders.first().filter(|_| self.confinement.is_none()).map(|f| f.join(".."));
        let folders = || self.folders.iter().map(PathBuf::as_path).chain(beside).chain(above.as_deref());
        let path = [name, slashed.as_str()]
            .iter()
            .flat_map(|name| folders().map(move |f| f.join(name)))
            .find(|path| path.is_file())
            .ok_or(FindError::Missing)?;
        // A link inside may still lead out.
        let is_inside = |real: &Path| std::fs::canonicalize(&path).is_ok_and(|p| p.starts_with(real));
        match &self.confinement {
            Some(confinement) if !is_inside(&confinement.real) => Err(FindError::Outside),
            _ => Ok(path),
        }
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
        self.paths.insert(path.to_owned());
        self.hash.add_file(&bytes);
        Ok(bytes)
    }
}

/// Folders of `SearchPath` at most.
const MAX_FOLDERS: usize = 64;
