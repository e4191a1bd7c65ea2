//! Cones.

use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::AzimuthRange;
use super::revolution::QuadricOfRevolution;
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface};
use crate::error::{SurfaceError, positive};
use crate::hit::SurfacePoint;
use crate::rational::Profile;

/// A cone about the z axis, open at its base in z = 0, apex at z = height.
///
/// `u` is the azimuth as a fraction of its range, `v` runs from the base to the apex. The normal points outward; at the
/// apex it is the limit at the azimuth of `u`. Sampled uniformly by area.
///
/// # Source
/// @pbrt3 section 3.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    radius: f64,
    height: f64,
}

impl Cone {
    /// The cone of `radius` (m) at its base and the given `height` (m) with azimuth up to `phi_max` (radians, limited to
    /// 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`].
    pub fn try_new(radius: f64, height: f64, phi_max: f64) -> Result<Self, SurfaceError> {
        let (radius, height) = (positive("radius", radius)?, positive("height", height)?);
        let slope = radius / height;
        Ok(Self {
            quadric: QuadricOfRevolution::new([slope * slope, 0.0, 0.0], height, [0.0, height], radius),
            azimuth: AzimuthRange::try_new(phi_max)?,
            radius,
            height,
        })
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.azimuth.phi_max() * self.radius * self.radius.hypot(self.height)
    }
}

impl SurfaceOfRevolution for Cone {
    fn quadric(&self) -> &QuadricOfRevolution {
        &self.quadric
    }

    fn azimuth(&self) -> AzimuthRange {
        self.azimuth
    }

    fn profiles(&self) -> Vec<Profile> {
        vec![Profile::line(self.position(DVec2::ZERO, DVec3::ZERO), self.position(DVec2::Y, DVec3::ZERO))]
    }

    fn extent(&self) -> Bounds3 {
        self.azimuth.bounds([0.0, self.radius], [0.0, self.height])
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        // The other nappe begins at the apex. There z is accurate to a few roundings of coordinates up to four heights, and a
        // ray through the apex must still hit.
        if !(p.z >= 0.0 && p.z - self.height <= gamma(16) * self.height) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        Some(DVec2::new(u, (p.z / self.height).min(1.0)))
    }

    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2] {
        let radial = self.azimuth.direction_at(p, || uv.x);
        [self.azimuth.derivative(p), (radial * -self.radius).extend(self.height)]
    }

    fn normal(&self, p: DVec3, uv: impl FnOnce() -> DVec2) -> DVec3 {
        // From the azimuth alone, so that it is valid up to the apex.
        (self.azimuth.direction_at(p, || uv().x) * self.height).extend(self.radius).normalize()
    }

    fn normal_derivatives_at(&self, point: &SurfacePoint) -> [DVec3; 2] {
        let radial = self.azimuth.direction_at(point.position, || point.uv.x);
        let turn = self.azimuth.phi_max() * self.height / self.radius.hypot(self.height);
        [DVec3::new(-radial.y, radial.x, 0.0) * turn, DVec3::ZERO]
    }

    fn position(&self, uv: DVec2, _near: DVec3) -> DVec3 {
        (self.azimuth.direction(uv.x) * (self.radius * (1.0 - uv.y))).extend(uv.y * self.height)
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        // Area grows with the square of the distance from the apex.
        let uv = DVec2::new(xi.x, 1.0 - (1.0 - xi.y).sqrt());
        (self.position(uv, DVec3::ZERO), uv)
    }

    fn density(&self, _: impl FnOnce() -> [DVec3; 2]) -> f64 {
        1.0 / self.area()
    }
}

impl_ray_surface!(Cone);

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    #[test]
    fn apex_is_hit_from_above_and_the_mirrored_nappe_is_not() {
        let cone = Cone::try_new(1.3, 0.7, TAU).unwrap();
        let hit = cone.intersect(&Ray::new(DVec3::Z * 3.3, -DVec3::Z), f64::INFINITY).unwrap();
        assert!((hit.t - 2.6).abs() < 1e-15 && hit.v == 1.0);
        let above = Ray::new(DVec3::new(-5.0, 0.0, 1.0), DVec3::X);
        assert_eq!(cone.intersect(&above, f64::INFINITY), None);
    }

    #[test]
    fn ray_parallel_to_a_ruling_meets_the_other_side_once() {
        // Cone x^2 + y^2 = (1 - z)^2; the ray x = s - 1/2, z = s is parallel to the ruling (-1, 0, 0) + s (1, 0, 1)
        // and meets the opposite one, x = 1 - z, at s = 3/4.
        let cone = Cone::try_new(1.0, 1.0, TAU).unwrap();
        let mut hits = Vec::new();
        cone.all_hits(
            &Ray::new(DVec3::new(-0.5, 0.0, 0.0), DVec3::new(1.0, 0.0, 1.0)),
            f64::INFINITY,
            &mut hits,
        );
        assert_eq!(hits.iter().map(|h| h.t).collect::<Vec<_>>(), [0.75]);
    }

    #[test]
    fn normal_leans_up_and_outward() {
        let cone = Cone::try_new(1.0, 2.0, TAU).unwrap();
        let ray = Ray::new(DVec3::new(3.0, 0.0, 1.0), -DVec3::X);
        let hit = cone.intersect(&ray, f64::INFINITY).unwrap();
        let point = cone.point(&ray, &hit);
        assert!((point.normal - DVec3::new(2.0, 0.0, 1.0).normalize()).length() < 1e-15);
        assert!((point.dpdu.cross(point.dpdv).normalize() - point.normal).length() < 1e-15);
    }
}
