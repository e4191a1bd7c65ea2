//! Checkpoints as files, and what pictures say about themselves.

use std::collections::BTreeMap;
use std::path::Path;

use glanz_formats::image::write_atomically;
use glanz_transport::{Checkpoint, Film, PictureIdentity};

use crate::messages::Failure;
use crate::outputs;

/// Refuses a checkpoint that cannot be written, or would be lost.
///
/// # Errors
/// Why.
pub(crate) fn check(path: Option<&Path>, resume: bool) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    outputs::check_writable(path)?;
    if path.exists() && !resume {
        return Err(Failure::new(format!("{}: this checkpoint exists already", path.display()))
            .with_help("go on from it with --resume, or remove it to begin anew"));
    }
    Ok(())
}

/// Reads the checkpoint `path`.
///
/// # Errors
/// Why the file cannot be read, or is no checkpoint.
pub(crate) fn read(path: &Path) -> Result<Checkpoint, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    Checkpoint::from_bytes(&bytes).map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

/// Puts `film` into the file `path`; until it is all there, the file keeps its old content.
///
/// # Errors
/// Why the file cannot be written.
pub(crate) fn write(path: &Path, identity: &PictureIdentity, film: &Film) -> Result<(), Failure> {
    write_atomically(path, &Checkpoint::encode(identity, film))
        .map_err(|error| Failure::new(error.to_string()))
}

/// What goes into the header of an EXR file: only what the picture depends on, so that equal pictures are equal files.
pub(crate) fn attributes(identity: &PictureIdentity, film: &Film) -> BTreeMap<String, String> {
    let entries = [
        ("software", format!("Glanz {}", identity.version)),
        ("glanz.integrator", identity.integrator.to_string()),
        ("glanz.sampler", identity.sampler.name().to_owned()),
        ("glanz.samples", film.samples().to_string()),
        ("glanz.seed", identity.seed.to_string()),
    ];
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
