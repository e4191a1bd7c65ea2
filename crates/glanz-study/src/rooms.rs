//! Rooms: scene files that are named on the command line.

use std::path::{Path, PathBuf};

use glanz_formats::{Loaded, Options, load};

use crate::study::StudyError;

/// Folder of rooms that are given by name, relative to the working folder.
const FOLDER: &str = "scenes/rooms";

/// A room read from its file.
pub(crate) struct RoomFile {
    pub(crate) path: PathBuf,
    /// The file's name without folder and extension.
    pub(crate) name: String,
    pub(crate) loaded: Loaded,
}

/// Reads the room `named`: a scene file, or the name of one in [`FOLDER`].
///
/// # Errors
/// A file that cannot be read as a scene.
pub(crate) fn read(named: &str) -> Result<RoomFile, StudyError> {
    let path = room_path(named);
    if !path.is_file() {
        return Err(StudyError::Setting {
            name: "rooms",
            value: path.display().to_string(),
            needed: "a scene file, or the name of one in scenes/rooms of the working folder",
        });
    }
    let loaded = load(&path, &Options::default())
        .map_err(|diagnostics| StudyError::Unreadable(diagnostics.to_string()))?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(RoomFile { path, name, loaded })
}

fn room_path(named: &str) -> PathBuf {
    let path = Path::new(named);
    if path.extension().is_some() {
        path.to_owned()
    } else {
        Path::new(FOLDER).join(named).with_extension("pbrt")
    }
}
