//! Search for the files that a scene refers to.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use glanz_job::{BudgetError, ContentHash, Resource, ResourceBudget};
use glanz_light::Pixels;
use glanz_scene::Diagnostics;
use glanz_scene::description::GroupDescription;
use glanz_shading::texture::{MipMap, MipMapError, TextureCache};

use crate::file_list::{FileKind, SceneFile, SceneFileList};
use crate::registry::{Options, failure};
use crate::source::MISSING_FILE;

/// Finder and reader of files, with the hash of their contents.
#[derive(Clone, Debug, Default)]
pub(crate) struct FileFinder {
    /// Search folders, in order: the scene's, those of `SearchPath`.
    folders: Vec<PathBuf>,
    confinement: Option<Confinement>,
    /// All files that were found, and those that are missing, by their paths.
    files: BTreeMap<PathBuf, SceneFile>,
    /// Whether files are only listed: those that name no others are not read.
    pub(crate) lists: bool,
    /// Hash of their bytes.
    pub(crate) hash: ContentHash,
    /// What reading may still use.
    pub(crate) budget: ResourceBudget,
    /// The memory of pictures.
    textures: TextureCache,
}

/// Pictures take at most this part of the memory: 1 in 2. Those above it are in a temporary file.
const PICTURE_SHARE: u64 = 2;

/// The folder to which files are confined.
#[derive(Clone, Debug)]
struct Confinement {
    /// The path as given.
    folder: PathBuf,
    /// The path with links resolved.
    real: PathBuf,
}

/// Errors of finding a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FindError {
    /// The file is in none of the folders.
    Missing,
    /// The file is outside the folder to which the scene is confined: see [`crate::Options::confined`].
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
    /// A finder for the scene file `path` with these bytes, which count in the hash. `name`: its name in messages.
    ///
    /// # Errors
    /// A message, if the folder to which the scene is confined does not exist.
    pub(crate) fn of_scene(
        name: &str,
        path: Option<&Path>,
        bytes: &[u8],
        options: &Options,
        budget: &ResourceBudget,
    ) -> Result<Self, Diagnostics> {
        let folder = options.folder.as_deref().or_else(|| path.and_then(Path::parent));
        let unreadable = |error| failure(name, MISSING_FILE, format!("the folder cannot be read: {error}"));
        let mut finder = match folder {
            Some(folder) if options.confined => Self::confined_to(folder).map_err(unreadable)?,
            folder => Self::new(folder),
        };
        finder.budget = budget.clone();
        // Scenes of untrusted users must not fill a disk, and a confined process may be unable to write one.
        if !options.confined {
            finder.textures = TextureCache::new(budget.limits().memory / PICTURE_SHARE);
        }
        path.into_iter().for_each(|path| finder.add(path.to_owned(), FileKind::Scene, true));
        finder.hash.add_file(bytes);
        Ok(finder)
    }

    /// A finder that searches the folder of the scene first.
    pub(crate) fn new(folder: Option<&Path>) -> Self {
        Self { folders: folder.map(Path::to_owned).into_iter().collect(), ..Self::default() }
    }

    /// Confines the finder to `folder`.
    ///
    /// # Errors
    /// Those of the file system, if the folder does not exist.
    pub(crate) fn confined_to(folder: &Path) -> io::Result<Self> {
        let confinement = Confinement { folder: folder.to_owned(), real: std::fs::canonicalize(folder)? };
        Ok(Self { confinement: Some(confinement), ..Self::new(Some(folder)) })
    }

    /// The picture for textures and lights, in memory or in a temporary file, of which the memory is taken off the budget.
    ///
    /// # Errors
    /// The problem. If it is that of the budget or of the temporary file, the budget has failed.
    pub(crate) fn picture(&self, pixels: &Pixels) -> Result<MipMap, String> {
        // Four bytes for each value and a third for the smaller levels, beside the pixels.
        let made = self.budget.reserve(16 * pixels.len() as u64).map_err(|end| end.to_string())?;
        let before = self.textures.file_size();
        let picture = MipMap::try_new_in(pixels, &self.textures).map_err(|error| {
            if let MipMapError::File(fault) = &error {
                self.budget.fail_with(fault.clone().into());
            }
            error.to_string()
        })?;
        drop(made);
        // The first picture in the file brings the memory of the tiles.
        let tiles = if before == 0 && picture.cache().is_some() { self.textures.tile_memory() } else { 0 };
        let spent = self.budget.spend(Resource::Memory, picture.memory().saturating_add(tiles));
        spent.map(|()| picture).map_err(|end| end.to_string())
    }

    /// Adds a search folder after the others.
    ///
    /// # Errors
    /// [`FindError::Outside`] if it is outside the folder to which the scene is confined.
    pub(crate) fn add_folder(&mut self, folder: &str) -> Result<(), FindError> {
        self.check_name(folder)?;
        let base = self.folders.first().cloned().unwrap_or_default();
        let folder = base.join(folder);
        if self.folders.len() < MAX_FOLDERS && !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
        Ok(())
    }

    /// Refuses names that cannot denote a file in the folder to which the scene is confined.
    fn check_name(&self, name: &str) -> Result<(), FindError> {
        let slashed = name.replace('\\', "/");
        let inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        let leads_out = || !Path::new(&slashed).components().all(inside);
        if self.confinement.is_some() && leads_out() { Err(FindError::Outside) } else { Ok(()) }
    }

    /// A path for messages: relative to the folder to which the scene is confined, so that messages do not reveal the folder.
    pub(crate) fn shown<'a>(&self, path: &'a Path) -> &'a Path {
        self.confinement.as_ref().and_then(|c| path.strip_prefix(&c.folder).ok()).unwrap_or(path)
    }

    /// The file of this name: in the scene's folder, as in pbrt, in the folders of `SearchPath`, in the folder of the file
    /// that refers to it, or one above the scene's folder, which is needed if a part of a scene is opened alone. Backslashes
    /// count as slashes if the file is not found otherwise.
    ///
    /// # Errors
    /// [`FindError`].
    pub(crate) fn locate(&self, name: &str, asking: Option<&Path>) -> Result<PathBuf, FindError> {
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
        // A link inside may lead outside.
        let is_inside = |real: &Path| std::fs::canonicalize(&path).is_ok_and(|p| p.starts_with(real));
        match &self.confinement {
            Some(confinement) if !is_inside(&confinement.real) => Err(FindError::Outside),
            _ => Ok(path),
        }
    }

    /// As [`FileFinder::locate`]; the file, or its place in the scene's folder if it is missing, is added to those of the scene.
    ///
    /// # Errors
    /// [`FindError`].
    pub(crate) fn find(
        &mut self,
        name: &str,
        asking: Option<&Path>,
        kind: FileKind,
    ) -> Result<PathBuf, FindError> {
        let found = self.locate(name, asking);
        match &found {
            Ok(path) => self.add(path.clone(), kind, true),
            Err(FindError::Missing) if !name.is_empty() => {
                let folder = self.folders.first().map_or_else(PathBuf::new, PathBuf::clone);
                self.add(folder.join(name), kind, false);
            }
            Err(FindError::Missing | FindError::Outside) => {}
        }
        found
    }

    fn add(&mut self, path: PathBuf, kind: FileKind, exists: bool) {
        self.files.entry(path.clone()).or_insert(SceneFile { path, kind, exists });
    }

    /// The paths of all files that were found.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        self.files.values().filter(|file| file.exists).map(|file| file.path.clone()).collect()
    }

    /// All files, and the errors of reading those that name others.
    pub(crate) fn into_list(self, diagnostics: Diagnostics) -> SceneFileList {
        SceneFileList { files: self.files.into_values().collect(), diagnostics }
    }

    /// The bytes of a file, which are added to the hash.
    ///
    /// # Errors
    /// Those of the file system, that of the budget, [`io::ErrorKind::Unsupported`] if files are only listed and those of this kind name no others, and [`io::ErrorKind::InvalidInput`] for anything but a regular file.
    pub(crate) fn read(&mut self, path: &Path, kind: FileKind) -> io::Result<Vec<u8>> {
        if self.lists && !kind.names_files() {
            return Err(io::Error::new(io::ErrorKind::Unsupported, "the file is only listed"));
        }
        let read = read_file(path, &self.budget);
        // A folder or a file that grows is there, and so is one for which the budget does not suffice.
        let is_there =
            |error: &io::Error| matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Other);
        if read.as_ref().is_err_and(|error| !is_there(error)) {
            self.files.entry(path.to_owned()).and_modify(|file| file.exists = false);
        }
        let bytes = read?;
        self.hash.add_file(&bytes);
        Ok(bytes)
    }
}

/// The bytes of a file, which is taken off the budget before it is read.
///
/// # Errors
/// Those of the file system, that of the budget, [`io::ErrorKind::InvalidInput`] for anything but a regular file, and a message for a file that is longer than its size, because it grows
/// or the system makes its content.
pub fn read_file(path: &Path, budget: &ResourceBudget) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    let size = metadata.len();
    budget.check_now().map_err(io::Error::other)?;
    spend_file(budget, size).map_err(io::Error::other)?;
    // Its memory is that of what is made of it: here it only has to fit.
    budget.reserve(size).map(drop).map_err(io::Error::other)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX)).map_err(io::Error::other)?;
    File::open(path)?.take(size.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > size {
        return Err(io::Error::other("it has grown, or has no size"));
    }
    Ok(bytes)
}

/// Takes a file of so many bytes off the budget.
///
/// # Errors
/// The budget is used up.
pub(crate) fn spend_file(budget: &ResourceBudget, bytes: u64) -> Result<(), BudgetError> {
    budget.spend(Resource::Files, 1)?;
    budget.spend(Resource::Bytes, bytes)
}

/// Bytes of an entry of a list of the description that grows: it is in the old list, and in one of twice the length.
pub(crate) fn entry_bytes<T>(name: &str) -> u64 {
    (3 * size_of::<T>() + 2 * name.len()) as u64
}

/// Takes groups of a description off the budget.
///
/// # Errors
/// The budget is used up.
pub(crate) fn spend_groups(budget: &ResourceBudget, groups: &[GroupDescription]) -> Result<(), BudgetError> {
    for group in groups {
        budget.check()?;
        budget.spend(Resource::Objects, group.object_count())?;
        budget.spend(Resource::Memory, group.bytes())?;
    }
    Ok(())
}

/// Largest number of folders of `SearchPath`.
const MAX_FOLDERS: usize = 64;

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_size_is_refused() {
        let error = read_file(Path::new("/proc/self/status"), &ResourceBudget::default()).unwrap_err();
        assert_eq!(error.to_string(), "it has grown, or has no size");
    }
}
