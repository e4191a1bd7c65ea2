//! The line of a ray relative to a point near the surface, so that distant origins cost no digits.

use glanz_math::polynomial::compensated::{two_product, two_sum};
use glanz_math::{DVec3, Ray};

/// The line of a ray, parameterized by arc length from one of its points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLine {
    /// The point of the ray at `s = 0`.
    pub(crate) origin: DVec3,
    /// Unit direction.
    pub(crate) direction: DVec3,
    /// Ray parameter of `origin`.
    pub(crate) shift: f64,
    /// Length of the ray's direction, metres per unit of its parameter.
    pub(crate) speed: f64,
}

impl RayLine {
    /// The line with arc length 0 at the ray parameter `shift`.
    ///
    /// That point is accurate to a few roundings of its own size plus one of the distance to the ray's origin, since the
    /// remainders of the products are added.
    #[inline]
    pub(crate) fn new(ray: &Ray, shift: f64) -> Self {
        let speed = ray.direction.length();
        let coordinate = |o: f64, d: f64| {
            let (product, remainder) = two_product(shift, d);
            (o + product) + remainder
        };
        let (o, d) = (ray.origin, ray.direction);
        let origin = if shift == 0.0 {
            o
        } else {
            DVec3::new(coordinate(o.x, d.x), coordinate(o.y, d.y), coordinate(o.z, d.z))
        };
        Self { origin, direction: d / speed, shift, speed }
    }

    /// The line in coordinates about `about`, which is far from the origin of the coordinates; arc length is 0 at the point nearest to
    /// `center` in the new coordinates if the ray starts farther from it than the root of `far_squared`.
    ///
    /// What the difference of both origins rounds away is added to that point, so that it is as accurate as in coordinates in which the
    /// surface is near the origin.
    pub(crate) fn about(ray: &Ray, about: DVec3, center: DVec3, far_squared: f64) -> Self {
        let [(ox, rx), (oy, ry), (oz, rz)] = [0, 1, 2].map(|k| two_sum(ray.origin[k], -about[k]));
        let (origin, rest, d) = (DVec3::new(ox, oy, oz), DVec3::new(rx, ry, rz), ray.direction);
        let local = Self::new(&Ray::new(origin, d), 0.0);
        let is_far = origin.distance_squared(center) > far_squared;
        if !is_far {
            return local;
        }
        let shift = (center - origin).dot(d) / d.length_squared();
        let coordinate = |k: usize| {
            let (product, remainder) = two_product(shift, d[k]);
            (origin[k] + product) + (remainder + rest[k])
        };
        Self { origin: DVec3::new(coordinate(0), coordinate(1), coordinate(2)), shift, ..local }
    }

    /// The line with arc length 0 at the point nearest to `center`.
    #[inline]
    pub(crate) fn nearest_to(ray: &Ray, center: DVec3) -> Self {
        let d = ray.direction;
        Self::new(ray, (center - ray.origin).dot(d) / d.length_squared())
    }

    /// Arc length at the ray parameter `t`.
    pub(crate) fn s(&self, t: f64) -> f64 {
        (t - self.shift) * self.speed
    }

    /// Ray parameter at the arc length `s`.
    pub(crate) fn t(&self, s: f64) -> f64 {
        self.shift + s / self.speed
    }

    /// The point at the arc length `s`.
    pub(crate) fn at(&self, s: f64) -> DVec3 {
        self.origin + self.direction * s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arc_length_and_parameter_are_the_same_point() {
        let ray = Ray::new(DVec3::new(1e5, -3e5, 2e5), DVec3::new(-3.0, 9.0, -6.0));
        let line = RayLine::nearest_to(&ray, DVec3::new(1.0, 2.0, 3.0));
        // (1, 2, 3) projected on the line through the origin along (-1, 3, -2): 14 s = -1 + 6 - 6, s = -1/14.
        let expected = DVec3::new(-1.0, 3.0, -2.0) * (-1.0 / 14.0);
        assert!((line.origin - expected).length() < 1e-10);
        assert_eq!(line.s(line.t(0.0)), 0.0);
        let step = 3.0 * 14.0_f64.sqrt();
        assert!((line.t(step) - line.t(0.0) - 1.0).abs() < 1e-12);
        assert!((line.at(step) - line.origin - ray.direction).length() < 1e-14);
    }

    #[test]
    fn distant_origins_cost_one_rounding_only() {
        // On the line x = 1e9 + t (1/3), the point at t = -3e9: 1/3 is rounded down by 2^-54 / 3 exactly, and that
        // error times 3e9 is 1e9 2^-54; naive arithmetic would add roundings of the product, 2^-24 each.
        let ray = Ray::new(DVec3::new(1e9, 0.0, 0.0), DVec3::new(1.0 / 3.0, 0.0, 0.0));
        let line = RayLine::new(&ray, -3e9);
        assert_eq!(line.origin.x, 1e9 * 2.0_f64.powi(-54));
    }
}
