//! Guides as files.

use std::path::Path;
use std::sync::Arc;

use glanz_formats::ContentHash;
use glanz_formats::image::write_atomically;
use glanz_transport::Guide;

use crate::messages::Failure;

/// A guide that was read, and the fingerprint of its file.
#[derive(Clone, Debug)]
pub(crate) struct FixedGuide {
    pub(crate) guide: Arc<Guide>,
    pub(crate) hash: u128,
}

/// Reads the guide `path`.
///
/// # Errors
/// Why the file cannot be read, or is no guide.
pub(crate) fn read(path: &Path) -> Result<FixedGuide, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    let guide =
        Guide::from_bytes(&bytes).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    let mut hash = ContentHash::default();
    hash.add_file(&bytes);
    Ok(FixedGuide { guide: Arc::new(guide), hash: hash.value() })
}

/// Puts `guide` into the file `path`; until it is all there, the file keeps its old content.
///
/// # Errors
/// Why the file cannot be written.
pub(crate) fn write(path: &Path, guide: &Guide) -> Result<(), Failure> {
    write_atomically(path, &guide.to_bytes()).map_err(|error| Failure::new(error.to_string()))
}
