//! Bézier patches over rectangles and triangles.
//!
//! A patch is a net of control points with weights: [`TensorPatch`] over the unit square, [`TrianglePatch`] over a triangle.
//! Both lie in the convex hull of their points and can be evaluated with all derivatives, split and raised in degree. Each
//! converts to the other, and a triangular patch also to three square ones of its own degree ([`TrianglePatch::to_quads`]), for
//! programs that handle squares only. [`junction`] measures the continuity of two patches and constructs smooth neighbours.
//!
//! Patches that share the control points of an edge also share the bits of its points and of its parts after halving, so that
//! no gap opens between them.
//!
//! ```
//! use glanz_geometry::bezier::TrianglePatch;
//! use glanz_math::DVec3;
//!
//! // The paraboloid z = x^2 + y^2 above the triangle (0, 0), (1, 0), (0, 1).
//! let net = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [1.0, 0.0, 1.0], [0.5, 0.5, 0.0], [0.0, 1.0, 1.0]];
//! let patch = TrianglePatch::try_from_points(2, &net.map(DVec3::from_array), None)?;
//! assert_eq!(patch.point(0.5, 0.25), DVec3::new(0.5, 0.25, 0.3125));
//! for quad in patch.to_quads() {
//!     let at = quad.triangle_parameters(0.5, 0.5);
//!     assert!(quad.patch.point(0.5, 0.5).distance(patch.point(at.x, at.y)) < 1e-15);
//! }
//! # Ok::<(), glanz_geometry::SurfaceError>(())
//! ```

pub(crate) mod bernstein;
mod convert;
pub(crate) mod homogeneous;
pub mod junction;
mod net;
mod quads;
mod subdivide;
pub mod tensor;
#[cfg(test)]
mod tests;
pub mod triangle;

pub use homogeneous::{Derivatives, MAX_DEGREE};
pub use junction::{BorderContinuation, JunctionDeviation, PatchBorder};
pub use quads::TriangleQuad;
pub use tensor::{TensorEdge, TensorPatch};
pub use triangle::{Barycentric, TriangleEdge, TrianglePatch};
