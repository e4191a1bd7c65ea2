//! What all CAD formats share: the outcome for each face, and scenes made of their models.
//!
//! A reader such as [`step`](crate::step) makes a [`BrepFile`]: the model, and a [`ReadingReport`] about what it could not take over. The
//! faces of the model are then trimmed ([`glanz_brep::face`]), and become the shapes of a description; the [`CadReport`] tells what became
//! of each.

mod budget;
mod cad_model;
mod cad_report;
mod describe;
mod describe_edges;
mod error;
mod nested_reach;
mod occurrence_colors;
mod refusal;
mod report;
mod spline;
#[cfg(test)]
pub(crate) mod testing;

pub(crate) use budget::{CopyBudget, ENTITY_COST};
pub(crate) use cad_model::{CadModel, TOO_MANY_COLORS};
pub(crate) use cad_report::CadWarning;
pub use cad_report::{CadBody, CadFace, CadFaceOutcome, CadReport};
pub(crate) use describe::CadSettings;
pub(crate) use nested_reach::{PartReaches, bounded, invertible};
pub(crate) use refusal::Refusal;
pub use report::{BrepFile, EntityNote, FaceCounts, NoteList, ReadingReport};
pub(crate) use spline::{spline_curve, spline_surface};
