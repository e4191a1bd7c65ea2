//! Quadrics of revolution about the z axis, disks and planes.
//!
//! The curved surfaces share one solver: all are `x^2 + y^2 = alpha w^2 + beta w + gamma` with `w = z - z0`, clipped to ranges of
//! z and of the azimuth. Each file holds the checks, the ranges and the parameters of its surface. Parameters follow pbrt
//! (@pharr2023 chapter 6) where pbrt has the shape; angles are in radians.

// `!(a < b)` holds for NaN, `a >= b` does not: NaN must fail the checks.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod azimuth;
pub mod cone;
pub mod cylinder;
pub mod disk;
pub mod hyperboloid;
pub mod paraboloid;
pub mod plane;
mod revolution;
pub mod sphere;
mod surface_of_revolution;
pub mod two_sheets;

pub use cone::Cone;
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use hyperboloid::Hyperboloid;
pub use paraboloid::Paraboloid;
pub use plane::Plane;
pub use sphere::Sphere;
pub use two_sheets::TwoSheetedHyperboloid;
