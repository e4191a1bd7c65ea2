//! CAD models in STEP files: AP203, AP214 and AP242 (@iso10303-21, @iso10303-42).
//!
//! [`read`] gives a [`BrepModel`](glanz_brep::model::BrepModel) of solids, shells and surfaces, in products that contain one another,
//! with their names, colours and layers. Every length is in metres and every angle in radians, whatever the units of its representation.
//!
//! `part21` reads the syntax; the other modules read kinds of entities. Nothing is dropped silently: the
//! [`ReadingReport`](crate::cad::ReadingReport) counts every face of the file, and lists by entity number what was left out and what was
//! mended. A damaged file gives what of it can be read.
//!
//! Not read are offset curves, replicas, boundaries in parameters alone, wireframes and tessellated shapes.
//!
//! Names are cut to 200 characters. Memory is at most 300 bytes per byte of the file, whatever its content; usual files take 3 to 5.

mod assembly;
mod bodies;
mod bounded_surface;
mod colors;
mod curves;
mod edges;
mod entities;
mod error;
mod faces;
mod geometry;
mod hidden;
mod lowering;
mod part21;
mod parts;
mod placement;
mod polygons;
mod spline;
mod style_overrides;
mod styles;
mod surfaces;
#[cfg(test)]
mod tests;
mod trim;
mod units;

pub use error::StepError;

use glanz_job::ResourceBudget;
use lowering::StepReader;
use part21::ExchangeFile;
use parts::PartReader;

use crate::cad::BrepFile;

/// Reads a STEP file.
///
/// ```
/// let file = glanz_formats::step::read(b"ISO-10303-21;HEADER;ENDSEC;DATA;ENDSEC;END-ISO-10303-21;")?;
/// assert_eq!(file.report.faces.total, 0);
/// # Ok::<(), glanz_formats::step::StepError>(())
/// ```
///
/// # Errors
/// [`StepError`] if the bytes are no STEP file, have no data, or are too many. Everything else that cannot be read is in the report.
pub fn read(bytes: &[u8]) -> Result<BrepFile, StepError> {
    read_with(bytes, &ResourceBudget::default())
}

/// Bytes for each byte of a file, beside the geometry, which is counted as it is made: 16 for a token of two, in a list that grows, and the list of instances.
const MEMORY_PER_BYTE: u64 = 24;

/// As [`read`] within a budget.
///
/// # Errors
/// Those of [`read`].
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<BrepFile, StepError> {
    let _reserved = budget.reserve(MEMORY_PER_BYTE.saturating_mul(bytes.len() as u64))?;
    let file = ExchangeFile::parse(bytes, budget)?;
    let mut reader = StepReader::new(&file, budget);
    PartReader::new(&mut reader).read_all();
    budget.check()?;
    Ok(reader.finish())
}
