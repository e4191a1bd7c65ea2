//! Faces of a model as trimmed surfaces.
//!
//! [`trimmed_faces`] converts the surface of each face to its carrier, lays its edges onto it, and closes its boundary. An edge that two
//! faces share is a curve on each; both faces extend beyond it by several times the distance
//! by which both stray from it, so that they overlap instead of leaving a slit.
//! [`trimmed_faces_with_edges`] adds what a picture of the edges needs.

mod border;
mod bounded_edge;
mod check;
mod edges;
mod geometry;
mod laid_face;
mod measure;
mod offset_part;
mod outcome;
mod stretch;
mod surface;
mod surface_part;
#[cfg(test)]
mod tests;
mod trim;

pub use edges::EdgeNormals;
pub use geometry::FaceGeometry;
pub use measure::FaceMeasure;
pub use outcome::{FaceRefusal, FaceRepair};
pub use trim::{
    FaceTrim, TrimmedFace, TrimmedFaces, trimmed_faces, trimmed_faces_while, trimmed_faces_with_edges,
};
