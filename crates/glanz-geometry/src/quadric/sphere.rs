//! Spheres.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::AzimuthRange;
use super::revolution::QuadricOfRevolution;
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface};
use crate::error::{SurfaceError, finite, positive};
use crate::rational::Profile;

/// A sphere about the origin, or the part of it in a range of z and of azimuth.
///
/// `u` is the azimuth as a fraction of its range, `v` the polar angle as a fraction of its range, from the smallest z to the
/// largest. The normal points outward. Sampled uniformly by area.
///
/// # Source
/// @pharr2023 section 6.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    radius: f64,
    z: [f64; 2],
    /// Range of z that a hit must lie in: infinite at a pole, where rounding must not clip.
    z_clip: [f64; 2],
    /// Polar angles of the two ends.
    theta: [f64; 2],
}

impl Sphere {
    /// The part of the sphere of `radius` (m) with z between the two values of `z` (m, any order, clipped to the sphere)
    /// and azimuth up to `phi_max` (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `radius` or `phi_max`, [`SurfaceError::EmptyRange`] if the
    /// range of z misses the sphere or is a single value.
    pub fn try_new(radius: f64, z: [f64; 2], phi_max: f64) -> Result<Self, SurfaceError> {
        let radius = positive("radius", radius)?;
        let [a, b] = [finite("z", z[0])?, finite("z", z[1])?];
        let cut = [a.min(b).clamp(-radius, radius), a.max(b).clamp(-radius, radius)];
        if !(cut[0] < cut[1]) {
            return Err(SurfaceError::EmptyRange { parameter: "z", min: a, max: b });
        }
        let widest = if cut[0] <= 0.0 && cut[1] >= 0.0 {
            radius
        } else {
            radius_at(radius, cut[0]).max(radius_at(radius, cut[1]))
        };
        Ok(Self {
            quadric: QuadricOfRevolution::new([-1.0, 0.0, radius * radius], 0.0, cut, widest),
            azimuth: AzimuthRange::try_new(phi_max)?,
            radius,
            z: cut,
            z_clip: [
                if cut[0] <= -radius { f64::NEG_INFINITY } else { cut[0] },
                if cut[1] >= radius { f64::INFINITY } else { cut[1] },
            ],
            theta: cut.map(|z| (z / radius).acos()),
        })
    }

    /// The whole sphere of `radius` (m).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`].
    pub fn try_full(radius: f64) -> Result<Self, SurfaceError> {
        Self::try_new(radius, [-radius, radius], std::f64::consts::TAU)
    }

    /// Radius, metres.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.azimuth.phi_max() * self.radius * (self.z[1] - self.z[0])
    }

    /// Whether it is a full sphere.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.z == [-self.radius, self.radius] && self.azimuth.phi_max() >= std::f64::consts::TAU
    }

    fn v_of(&self, rho: f64, z: f64) -> f64 {
        // The arc tangent is accurate at the poles, where the arc cosine of z / r loses half of the digits.
        let theta = rho.atan2(z);
        ((theta - self.theta[0]) / (self.theta[1] - self.theta[0])).clamp(0.0, 1.0)
    }
}

/// Distance from the axis at height `z`.
fn radius_at(radius: f64, z: f64) -> f64 {
    ((radius - z) * (radius + z)).max(0.0).sqrt()
}

impl SurfaceOfRevolution for Sphere {
    fn quadric(&self) -> &QuadricOfRevolution {
        &self.quadric
    }

    fn azimuth(&self) -> AzimuthRange {
        self.azimuth
    }

    fn profiles(&self) -> Vec<Profile> {
        // Latitudes.
        let [from, to] = self.theta.map(|theta| std::f64::consts::FRAC_PI_2 - theta);
        Profile::circle(0.0, self.radius, [from, to])
    }

    fn extent(&self) -> Bounds3 {
        let ends = self.z.map(|z| radius_at(self.radius, z));
        let widest = if self.z[0] <= 0.0 && self.z[1] >= 0.0 { self.radius } else { ends[0].max(ends[1]) };
        self.azimuth.bounds([ends[0].min(ends[1]), widest], self.z)
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        if !(p.z >= self.z_clip[0] && p.z <= self.z_clip[1]) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        Some(DVec2::new(u, self.v_of(p.truncate().length(), p.z)))
    }

    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2] {
        let radial = self.azimuth.direction_at(p, || uv.x);
        let rho = p.truncate().length();
        let dpdv = (radial * p.z).extend(-rho) * (self.theta[1] - self.theta[0]);
        [self.azimuth.derivative(p), dpdv]
    }

    fn position(&self, uv: DVec2, _near: DVec3) -> DVec3 {
        let (sin, cos) = (self.theta[0] + uv.y * (self.theta[1] - self.theta[0])).sin_cos();
        let z = (self.radius * cos).clamp(self.z[0], self.z[1]);
        (self.azimuth.direction(uv.x) * (self.radius * sin)).extend(z)
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        let position = self.sample_position(xi);
        (position, DVec2::new(xi.x, self.v_of(radius_at(self.radius, position.z), position.z)))
    }

    fn sample_position(&self, xi: DVec2) -> DVec3 {
        // Archimedes: the area between two heights is proportional to their difference.
        let z = self.z[0] + xi.y * (self.z[1] - self.z[0]);
        (self.azimuth.direction(xi.x) * radius_at(self.radius, z)).extend(z)
    }

    fn density(&self, _: impl FnOnce() -> [DVec3; 2]) -> f64 {
        1.0 / self.area()
    }
}

impl_ray_surface!(Sphere);

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    #[test]
    fn hit_from_outside_and_from_inside() {
        let sphere = Sphere::try_full(2.0).unwrap();
        let outside = Ray::new(DVec3::new(-5.0, 0.0, 0.0), DVec3::X);
        assert_eq!(sphere.intersect(&outside, f64::INFINITY).unwrap().t, 3.0);
        let inside = Ray::new(DVec3::ZERO, DVec3::new(0.0, 0.0, 4.0));
        let hit = sphere.intersect(&inside, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.v), (0.5, 1.0));
        assert_eq!(sphere.point(&inside, &hit).normal, DVec3::Z);
    }

    #[test]
    fn clipped_first_root_leaves_the_second() {
        let half = Sphere::try_new(1.0, [-1.0, 1.0], PI).unwrap();
        let ray = Ray::new(DVec3::new(0.0, -3.0, 0.0), DVec3::Y);
        let hit = half.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (4.0, 0.5, 0.5));
    }

    #[test]
    fn parameters_are_those_of_pbrt() {
        // z from 0 to 1: theta from pi/2 to 0, so the equator is v = 0.
        let upper = Sphere::try_new(1.0, [0.0, 1.0], TAU).unwrap();
        let ray = Ray::new(DVec3::new(0.0, 2.0, 0.5), -DVec3::Y);
        let hit = upper.intersect(&ray, f64::INFINITY).unwrap();
        assert!((hit.u - 0.25).abs() < 1e-15);
        assert!((hit.v - (FRAC_PI_2 - 0.5_f64.acos()) / FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn area_of_a_zone_is_that_of_archimedes() {
        let zone = Sphere::try_new(3.0, [-1.0, 2.0], PI).unwrap();
        assert!((zone.area() - PI * 3.0 * 3.0).abs() < 1e-13);
    }

    #[test]
    fn invalid_spheres_are_refused() {
        assert!(Sphere::try_full(0.0).is_err());
        assert!(Sphere::try_full(f64::NAN).is_err());
        assert!(matches!(Sphere::try_new(1.0, [2.0, 3.0], 1.0), Err(SurfaceError::EmptyRange { .. })));
        assert!(matches!(Sphere::try_new(1.0, [0.0, 1.0], 0.0), Err(SurfaceError::NotPositive { .. })));
    }
}
