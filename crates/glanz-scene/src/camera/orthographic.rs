//! Parallel projection.

use glanz_math::{DVec2, DVec3, Ray};

/// Parallel rays along +z that start in the plane z = 0.
#[derive(Clone, Copy, Debug)]
pub struct Orthographic;

impl Orthographic {
    /// The ray through a point of the screen.
    #[must_use]
    pub fn ray(&self, screen: DVec2) -> Ray {
        Ray::new(DVec3::new(screen.x, screen.y, 0.0), DVec3::Z)
    }
}
