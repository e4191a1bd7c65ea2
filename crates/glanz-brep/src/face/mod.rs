//! Faces of a model as trimmed surfaces.
//!
//! [`trimmed_faces`] converts the surface of each face to its carrier, lays its edges onto it, and closes its boundary. An edge that two
//! faces share is a curve on each; both faces extend beyond it by several times the distance
//! by which both stray from it, so that they overlap instead of leaving a slit.

mod geometry;
mod measure;
#[cfg(test)]
mod tests;
mod trim;

pub use geometry::FaceGeometry;
pub use measure::FaceMeasure;
pub use trim::{FaceRefusal, FaceRepair, FaceTrim, TrimmedFace, TrimmedFaces, trimmed_faces};
