//! Rays.

use crate::DVec3;

/// A half-line `origin + t * direction`, `t > 0`.
///
/// The direction need not have unit length: the parameter `t` stays the same when a ray is transformed into the local frame of a
/// scaled object.
///
/// In memory it is six numbers: the origin, then the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Origin, metres.
    pub origin: DVec3,
    /// Direction, of any length but zero.
    pub direction: DVec3,
}

impl Ray {
    /// The ray from `origin` along `direction`.
    #[inline]
    #[must_use]
    pub const fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction }
    }

    /// The point at parameter `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}
