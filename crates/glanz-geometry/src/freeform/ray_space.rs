//! The space of a ray: two planes through it, whose signed distances from a patch vanish at a root.

use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3, Frame, Ray};

use crate::ray_line::RayLine;

/// Distance from the origin of the coordinates, relative to the size of the surface, from which a surface has coordinates of its own.
/// Nearer ones lose at most ten of their fifty bits, and keep 1e-9 of their size by far.
const FAR_AWAY: f64 = 1024.0;

/// Position and size of a surface, on which the rounding of all its rays depends.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceFrame {
    /// Origin of the surface's own coordinates: 0, or its centre if that is far away.
    pub(super) origin: DVec3,
    /// The centre in these coordinates, as are all other lengths.
    pub(super) center: DVec3,
    /// Rounding of a point in the common coordinates, metres.
    position_rounding: f64,
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
        let diagonal = bounds.diagonal();
        let radius_squared = 0.25 * diagonal.length_squared();
        let relative = gamma(4 * (p + q) as u32 + 24);
        let is_moved = size > FAR_AWAY * diagonal.length();
        let (origin, rounding) =
            if is_moved { (bounds.center(), f64::EPSILON * size) } else { (DVec3::ZERO, 0.0) };
        Self {
            origin,
            center: if is_moved { DVec3::ZERO } else { bounds.center() },
            position_rounding: rounding,
            far_squared: 16.0 * radius_squared,
            size: if is_moved { diagonal.max_element() } else { size },
            relative,
        }
    }

    /// Whether the surface has coordinates of its own.
    pub(super) fn is_moved(&self) -> bool {
        self.origin != DVec3::ZERO
    }

    /// A point in the common coordinates.
    #[inline(always)]
    pub(super) fn in_common(&self, point: DVec3) -> DVec3 {
        if self.is_moved() { point + self.origin } else { point }
    }

    /// A box in the common coordinates.
    pub(super) fn bounds_in_common(&self, bounds: Bounds3) -> Bounds3 {
        if !self.is_moved() {
            return bounds;
        }
        let pad = DVec3::splat(self.position_rounding);
        Bounds3::new(bounds.min + self.origin - pad, bounds.max + self.origin + pad)
    }

    /// Homogeneous control points in the surface's own coordinates.
    pub(super) fn own_net(&self, points: &[DVec4]) -> Vec<DVec4> {
        let moved = |p: &DVec4| ((p.truncate() / p.w - self.origin) * p.w).extend(p.w);
        let polynomial = |p: &DVec4| (p.truncate() - self.origin).extend(p.w);
        points.iter().map(|p| if p.w == 1.0 { polynomial(p) } else { moved(p) }).collect()
    }

    /// Largest noise of a ray that starts within the surface, metres.
    pub(super) fn noise_within(&self) -> f64 {
        self.relative * 2.0 * self.size + self.position_rounding
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
        if self.is_moved() {
            return RayLine::about(ray, self.origin, self.center, self.far_squared);
        }
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

    /// Fills `cells` with the signed distances of homogeneous points, times weight, from both planes through the ray, and with the weights
    /// if `rational`: one list after the other, in the order of `points`.
    pub(super) fn project_net(&self, points: &[DVec4], rational: bool, cells: &mut Vec<f64>) {
        cells.clear();
        let o = self.line.origin;
        for axis in self.axes {
            cells.extend(points.iter().map(|h| axis.dot(h.truncate() - o * h.w)));
        }
        if rational {
            cells.extend(points.iter().map(|h| h.w));
            // Products of very large or small weights would overflow.
            let largest = points.iter().fold(f64::MIN_POSITIVE, |most, h| most.max(h.w));
            let per = 1.0 / power_of_two_below(largest);
            cells.iter_mut().for_each(|x| *x *= per);
        }
    }
}

/// The largest power of two up to `x`, a positive normal number.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & f64::INFINITY.to_bits())
}

/// The z component of the cross product.
#[inline(always)]
pub(super) fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}
