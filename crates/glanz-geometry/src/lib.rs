//! Exact surfaces, and the hierarchy that finds the ones a ray may meet.
//!
//! A surface answers the questions of [`RaySurface`]: where a ray meets it, what it looks like there, how to pick a
//! point on it. [`Surface`] is the closed set of all surfaces; each lives in its own local frame. [`bvh`] sees boxes
//! only, never surfaces.

pub mod algebraic;
pub mod bezier;
pub mod bilinear;
pub mod bvh;
pub mod cuboid;
pub mod error;
pub mod face;
pub mod freeform;
pub mod hit;
mod line;
pub mod mesh;
pub mod polyhedron;
pub mod quadric;
pub mod rational;
pub mod spline;
pub mod surface;
pub mod torus;
pub mod triangle;
pub mod trim;
pub mod trimmed;

pub use error::SurfaceError;
pub use face::{FaceDomain, FacePoint};
pub use hit::{Hit, SurfacePoint, SurfaceSample};
pub use surface::{RaySurface, Surface};
