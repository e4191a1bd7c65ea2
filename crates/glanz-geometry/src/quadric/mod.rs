//! Quadrics about the z axis, and the flat pieces that go with them.
//!
//! The curved ones share one solver: all are `x^2 + y^2 = alpha w^2 + beta w + gamma` with `w = z - z0`, cut by a
//! range of z and a sweep of the azimuth. Each file holds what is its own: the checks, the range, the parameters.
//! Parameters follow pbrt (@pharr2023 chapter 6) where pbrt has the shape; angles are in radians.

// `!(a < b)` holds for NaN, `a >= b` does not: what is not a number must fail the checks.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod clip;
pub mod cone;
pub mod cylinder;
pub mod disk;
pub mod hyperboloid;
pub mod paraboloid;
pub mod plane;
mod revolution;
pub mod sphere;
mod swept;
pub mod two_sheets;

pub use cone::Cone;
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use hyperboloid::Hyperboloid;
pub use paraboloid::Paraboloid;
pub use plane::Plane;
pub use sphere::Sphere;
pub use two_sheets::TwoSheetedHyperboloid;
