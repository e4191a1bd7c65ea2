//! The space of a ray: two planes through it, whose signed distances from a patch vanish at a root.

use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3, Frame, Ray};

use crate::ray_line::RayLine;

/// Position and size of a surface, on which the rounding of all its rays depends.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceFrame {
    pub(super) center: DVec3,
    /// Square of the distance from the centre beyond which the origin of a ray is moved closer.
    far_squared: f64,
    /// Largest coordinate, metres.
    size: f64,
    /// Rounding of a point, relative to its coordinates and those of the ray.
    relative: f64,
}

impl SurfaceFrame {
    /// The frame of a surface in `bounds`, where `size` bounds its coordinates and `degrees` those of its patches.
    pub(super) fn new(bounds: &Bounds3, size: f64, (p, q): (usize, usize)) -> Self {
        let radius_squared = 0.25 * bounds.diagonal().length_squared();
        let relative = gamma(4 * (p + q) as u32 + 24);
        Self { center: bounds.center(), far_squared: 16.0 * radius_squared, size, relative }
    }

    /// Largest noise of a ray that starts within the surface, metres.
    pub(super) fn noise_within(&self) -> f64 {
        self.relative * 2.0 * self.size
    }

    /// The factors of the noise: it is the first times the sum of the second and the largest coordinate of the line's origin.
    pub(super) fn rounding(&self) -> [f64; 2] {
        [self.relative, self.size]
    }

    /// Square of the distance from the centre beyond which the origin of a ray is moved closer.
    pub(super) fn far_squared(&self) -> f64 {
        self.far_squared
    }

    /// The line of a ray.
    #[inline(always)]
    pub(super) fn line(&self, ray: &Ray) -> RayLine {
        // A far origin costs digits; a near one must stay in place, since hits are counted from it.
        let far = ray.origin.distance_squared(self.center) > self.far_squared;
        if far { RayLine::nearest_to(ray, self.center) } else { RayLine::new(ray, 0.0) }
    }

    /// The space of a ray.
    #[inline(always)]
    pub(super) fn ray_space(&self, ray: &Ray) -> RaySpace {
        self.line_space(self.line(ray))
    }

    /// The space of a ray by its line.
    #[inline(always)]
    pub(super) fn line_space(&self, line: RayLine) -> RaySpace {
        let axes = Frame::from_z(line.direction);
        let noise = self.relative * (self.size + line.origin.abs().max_element());
        let from = self.center - line.origin;
        let center = DVec2::new(axes.x.dot(from), axes.y.dot(from));
        RaySpace { line, axes: [axes.x, axes.y], center, noise }
    }
}

/// A ray with two directions across it.
pub(super) struct RaySpace {
    pub(super) line: RayLine,
    /// Unit vectors across the ray.
    pub(super) axes: [DVec3; 2],
    /// The centre of the surface, projected along the ray.
    pub(super) center: DVec2,
    /// Bound on the rounding error of a computed point of the surface across the ray, metres.
    pub(super) noise: f64,
}

impl RaySpace {
    /// A vector, projected along the ray.
    #[inline(always)]
    pub(super) fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.axes[0].dot(v), self.axes[1].dot(v))
    }
}

/// The z component of the cross product.
#[inline(always)]
pub(super) fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}
