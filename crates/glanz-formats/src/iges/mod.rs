//! CAD models in IGES files, version 5.3 and before (@iges53).
//!
//! [`read`] gives a [`BrepModel`](glanz_brep::model::BrepModel) as that of [`step`](crate::step): solids (186) and shells (514) whose faces
//! share their edges, and faces without topology: trimmed surfaces (144), bounded surfaces (143), and surfaces by themselves. Entities have
//! the numbers of their directory entries.
//!
//! Surfaces are planes (108), ruled surfaces (118), surfaces of revolution (120), tabulated cylinders (122), rational splines (128), their offsets (140), and those of
//! the types 190 to 198; curves are arcs (100), composite curves (102), conics (104), copious data (106), lines (110), and splines (112, 126). Transformations (124),
//! subfigures (308, 408), assemblies and instances of solids (184, 430), groups (402), names (406 form 15), colours (314), levels and blank status are taken over.
//! Where a boundary or an edge has no curve in space, its curves in parameters give one. All else is reported, such as offset curves (130) and constructive solids. The
//! compressed form is refused.
//!
//! Memory is in proportion to the file. A damaged file gives what of it can be read.

mod attributes;
mod border;
mod boundary;
mod conic;
mod contents;
mod curves;
mod entity;
mod error;
mod file;
mod global;
mod instances;
mod lowering;
mod parts;
mod records;
mod ruled;
mod solids;
mod surface_curves;
mod surfaces;
#[cfg(test)]
mod tests;
mod trimmed;
mod values;

pub use error::IgesError;
pub(crate) use records::is_iges;

use crate::cad::{BrepFile, ReadingReport};
use file::IgesFile;
use glanz_job::ResourceBudget;
use lowering::IgesReader;

/// Reads an IGES file.
///
/// # Errors
/// [`IgesError`] if the bytes are no IGES file, are in its compressed form, have no directory, or are too many. Everything else that cannot
/// be read is in the report.
pub fn read(bytes: &[u8]) -> Result<BrepFile, IgesError> {
    read_with(bytes, &ResourceBudget::default())
}

/// Bytes for each byte of a file, beside the geometry, which is counted as it is made: 16 for a value of two, in a list that grows.
const MEMORY_PER_BYTE: u64 = 24;

/// As [`read`] within a budget.
///
/// # Errors
/// Those of [`read`].
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<BrepFile, IgesError> {
    let _reserved = budget.reserve(MEMORY_PER_BYTE.saturating_mul(bytes.len() as u64))?;
    let mut report = ReadingReport::default();
    let file = IgesFile::parse(bytes, &mut report, budget)?;
    let mut reader = IgesReader::new(&file, report, budget);
    reader.read_all();
    budget.check()?;
    Ok(reader.finish())
}
