//! Rooms: scene files that are named on the command line.

use std::path::{Path, PathBuf};

use glanz_formats::{Loaded, Options, load};

use crate::study::StudyError;

/// Where rooms are that are named without a folder, from the working folder.
const FOLDER: &str = "scenes/rooms";

/// A scene file that was read.
pub(crate) struct RoomFile {
    pub(crate) path: PathBuf,
    /// The file's name without folder and extension.
    pub(crate) name: String,
    pub(crate) loaded: Loaded,
}

/// Reads the room `named`: a scene file, or the name of one in [`FOLDER`].
///
/// # Errors
/// A file that is no scene.
pub(crate) fn read(named: &str) -> Result<RoomFile, StudyError> {
    let path = room_path(named);
    if !path.is_file() {
        return Err(StudyError::Setting {
            name: "rooms",
            value: path.display().to_string(),
            needed: "a scene file; names without .pbrt are looked for in scenes/rooms of the working folder",
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
