//! Files of guides.

use std::path::Path;
use std::sync::Arc;

use glanz_job::ContentHash;
use glanz_transport::Guide;

use crate::error::Error;
use crate::file;

/// A guide read from a file, with the content hash of the file.
#[derive(Clone, Debug)]
pub(super) struct FixedGuide {
    pub(super) guide: Arc<Guide>,
    pub(super) hash: u128,
}

/// Reads a guide from the file `path`.
pub(super) fn read(path: &Path) -> Result<FixedGuide, Error> {
    let bytes = file::read(path)?;
    let guide = Guide::from_bytes(&bytes).map_err(Error::of_file(path))?;
    let mut hash = ContentHash::default();
    hash.add_file(&bytes);
    Ok(FixedGuide { guide: Arc::new(guide), hash: hash.value() })
}

/// Writes `guide` to the file `path`.
pub(super) fn write(path: &Path, guide: &Guide) -> Result<(), Error> {
    file::write(path, &guide.to_bytes())
}
