//! Batches of rays: plain arrays in, plain arrays out.
//!
//! [`RaySurface::closest_batch`] and [`RaySurface::occluded_batch`] give the same bits as [`RaySurface::intersect`] and
//! [`RaySurface::occluded`] ray by ray, for any size and order of the batch. Freeform surfaces trace batches as streams, whose
//! rays share the work in nodes and leaves; some thousand rays are a good size, and the closer they are together, the faster.
//!
//! [`RaySurface::closest_batch`]: crate::RaySurface::closest_batch
//! [`RaySurface::occluded_batch`]: crate::RaySurface::occluded_batch
//! [`RaySurface::intersect`]: crate::RaySurface::intersect
//! [`RaySurface::occluded`]: crate::RaySurface::occluded

use glanz_math::{DVec3, Ray};

/// A ray and its end.
///
/// In memory it is seven numbers: origin, direction, end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BoundedRay {
    /// The ray.
    pub ray: Ray,
    /// Hits with `0 < t < t_max` count; infinite for a ray without end.
    pub t_max: f64,
}

impl BoundedRay {
    /// The ray of unused lanes; it meets nothing.
    pub(crate) const NONE: Self = Self::new(Ray::new(DVec3::ZERO, DVec3::X), f64::NEG_INFINITY);

    /// The ray up to `t_max`.
    #[inline]
    #[must_use]
    pub const fn new(ray: Ray, t_max: f64) -> Self {
        Self { ray, t_max }
    }
}

impl From<Ray> for BoundedRay {
    /// The ray without end.
    #[inline]
    fn from(ray: Ray) -> Self {
        Self { ray, t_max: f64::INFINITY }
    }
}
