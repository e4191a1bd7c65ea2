//! Cylinders.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::AzimuthRange;
use super::revolution::QuadricOfRevolution;
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface};
use crate::error::{SurfaceError, finite, positive};
use crate::rational::Profile;

/// An open cylinder about the z axis.
///
/// `u` is the azimuth as a fraction of its range, `v` runs from the smallest z to the largest. The normal points outward.
/// Sampled uniformly by area.
///
/// # Source
/// @pharr2023 section 6.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    radius: f64,
    z: [f64; 2],
}

impl Cylinder {
    /// The cylinder of `radius` (m) between the two values of `z` (m, any order) with azimuth up to `phi_max`
    /// (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `radius` or `phi_max`, [`SurfaceError::EmptyRange`] if both z
    /// are the same.
    pub fn try_new(radius: f64, z: [f64; 2], phi_max: f64) -> Result<Self, SurfaceError> {
        let radius = positive("radius", radius)?;
        let [a, b] = [finite("z", z[0])?, finite("z", z[1])?];
        if a == b {
            return Err(SurfaceError::EmptyRange { parameter: "z", min: a, max: b });
        }
        let z = [a.min(b), a.max(b)];
        Ok(Self {
            quadric: QuadricOfRevolution::new([0.0, 0.0, radius * radius], 0.0, z, radius),
            azimuth: AzimuthRange::try_new(phi_max)?,
            radius,
            z,
        })
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.azimuth.phi_max() * self.radius * self.height()
    }

    fn height(&self) -> f64 {
        self.z[1] - self.z[0]
    }
}

impl SurfaceOfRevolution for Cylinder {
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
        self.azimuth.bounds([self.radius; 2], self.z)
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        if !(p.z >= self.z[0] && p.z <= self.z[1]) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        Some(DVec2::new(u, ((p.z - self.z[0]) / self.height()).min(1.0)))
    }

    fn tangents(&self, p: DVec3, _uv: DVec2) -> [DVec3; 2] {
        [self.azimuth.derivative(p), DVec3::Z * self.height()]
    }

    fn position(&self, uv: DVec2, _near: DVec3) -> DVec3 {
        (self.azimuth.direction(uv.x) * self.radius).extend(self.z[0] + uv.y * self.height())
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        (self.position(xi, DVec3::ZERO), xi)
    }

    fn density(&self, _: impl FnOnce() -> [DVec3; 2]) -> f64 {
        1.0 / self.area()
    }
}

impl_ray_surface!(Cylinder);

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    #[test]
    fn ray_parallel_to_the_axis_misses() {
        let cylinder = Cylinder::try_new(1.0, [0.0, 1.0], TAU).unwrap();
        for x in [0.0, 0.5, 1.0, 2.0] {
            assert_eq!(
                cylinder.intersect(&Ray::new(DVec3::new(x, 0.0, -1.0), DVec3::Z), f64::INFINITY),
                None
            );
        }
    }

    #[test]
    fn ray_through_the_open_end_meets_the_inside() {
        let cylinder = Cylinder::try_new(1.0, [0.0, 1.0], TAU).unwrap();
        let ray = Ray::new(DVec3::new(0.0, 0.0, 1.5), DVec3::new(1.0, 0.0, -1.0));
        let hit = cylinder.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (1.0, 0.0, 0.5));
        assert_eq!(cylinder.point(&ray, &hit).normal, DVec3::X);
    }

    #[test]
    fn wire_a_million_times_longer_than_thick_is_hit_from_its_own_length() {
        let wire = Cylinder::try_new(1e-3, [-500.0, 500.0], TAU).unwrap();
        let ray = Ray::new(DVec3::new(-700.0, 0.5e-3, 3.0), DVec3::X);
        let hit = wire.intersect(&ray, f64::INFINITY).unwrap();
        // x = -sqrt(r^2 - y^2); t is rounded at 700.
        let expected = 700.0 - 0.75_f64.sqrt() * 1e-3;
        assert!((hit.t - expected).abs() < 2e-13, "{:e}", hit.t - expected);
    }

    #[test]
    fn half_cylinder_has_half_the_area() {
        assert_eq!(Cylinder::try_new(2.0, [3.0, -1.0], PI).unwrap().area(), PI * 2.0 * 4.0);
        assert!(Cylinder::try_new(2.0, [3.0, 3.0], PI).is_err());
    }
}
