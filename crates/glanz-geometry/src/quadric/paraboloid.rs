//! Paraboloids.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::AzimuthRange;
use super::revolution::QuadricOfRevolution;
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface};
use crate::error::{SurfaceError, finite, positive};
use crate::rational::Profile;

/// A paraboloid about the z axis that opens to +z, apex at the origin.
///
/// `u` is the azimuth as a fraction of its range, `v` runs from the smallest z to the largest. The normal points to the
/// convex side: away from the axis, down at the apex. Sampled uniformly by area.
///
/// # Source
/// @pbrt3 section 3.5; departure: a negative smaller z is replaced by 0 (in pbrt `v` starts below the apex).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraboloid {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    z: [f64; 2],
    /// Lower bound on z of a hit: minus infinity at the apex, where rounding must not clip.
    z_clip: f64,
    /// x^2 + y^2 = rise * z.
    rise: f64,
}

impl Paraboloid {
    /// The paraboloid with the given `radius` (m) at the larger z, between the two values of `z` (m, any order), with
    /// azimuth up to `phi_max` (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `radius`, `phi_max` or the larger z,
    /// [`SurfaceError::EmptyRange`] if both z are the same.
    pub fn try_new(radius: f64, z: [f64; 2], phi_max: f64) -> Result<Self, SurfaceError> {
        let radius = positive("radius", radius)?;
        let [a, b] = [finite("z", z[0])?, finite("z", z[1])?];
        let top = positive("larger z", a.max(b))?;
        let z = [a.min(b).max(0.0), top];
        if !(z[0] < z[1]) {
            return Err(SurfaceError::EmptyRange { parameter: "z", min: a, max: b });
        }
        let rise = radius / top * radius;
        Ok(Self {
            quadric: QuadricOfRevolution::new([0.0, rise, 0.0], 0.0, z, radius),
            azimuth: AzimuthRange::try_new(phi_max)?,
            z,
            z_clip: if z[0] > 0.0 { z[0] } else { f64::NEG_INFINITY },
            rise,
        })
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        let [s0, s1] = self.arms();
        // s1^3 - s0^3 without cancellation, where s1 - s0 = rise (z1 - z0) / (s1 + s0).
        let cubes = self.rise * self.height() / (s1 + s0) * (s1 * s1 + s1 * s0 + s0 * s0);
        self.azimuth.phi_max() * 2.0 / (3.0 * self.rise) * cubes
    }

    fn height(&self) -> f64 {
        self.z[1] - self.z[0]
    }

    /// The root s at both ends; the area up to z is phi_max times the integral of sqrt(rise z + rise^2 / 4) dz, which is
    /// phi_max 2 s^3 / (3 rise).
    fn arms(&self) -> [f64; 2] {
        self.z.map(|z| (self.rise * (z + 0.25 * self.rise)).sqrt())
    }

    fn v_of(&self, z: f64) -> f64 {
        ((z - self.z[0]) / self.height()).clamp(0.0, 1.0)
    }
}

impl SurfaceOfRevolution for Paraboloid {
    fn quadric(&self) -> &QuadricOfRevolution {
        &self.quadric
    }

    fn azimuth(&self) -> AzimuthRange {
        self.azimuth
    }

    fn profiles(&self) -> Vec<Profile> {
        vec![Profile::parabola(self.rise, self.z.map(|z| (self.rise * z).sqrt()))]
    }

    fn extent(&self) -> Bounds3 {
        self.azimuth.bounds(self.z.map(|z| (self.rise * z).sqrt()), self.z)
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        if !(p.z >= self.z_clip && p.z <= self.z[1]) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        // From the distance from the axis, which is more accurate than z near the apex.
        Some(DVec2::new(u, self.v_of(p.truncate().length_squared() / self.rise)))
    }

    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2] {
        let radial = self.azimuth.direction_at(p, || uv.x);
        // d rho / dz = rise / (2 rho), which is infinite at the apex.
        let dpdv = (radial * (0.5 * self.rise / p.truncate().length())).extend(1.0) * self.height();
        [self.azimuth.derivative(p), if dpdv.is_finite() { dpdv } else { DVec3::ZERO }]
    }

    fn position(&self, uv: DVec2, _near: DVec3) -> DVec3 {
        let z = self.z[0] + uv.y * self.height();
        (self.azimuth.direction(uv.x) * (self.rise * z).sqrt()).extend(z)
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        let [s0, s1] = self.arms();
        // s^3 = s0^3 + xi (s1^3 - s0^3) and s^2 - s0^2 = rise (z - z0), without cancellation.
        let grown = self.rise * self.height() / (s1 + s0) * (s1 * s1 + s1 * s0 + s0 * s0) / (s0 * s0 * s0);
        let rise = s0 * s0 * (2.0 / 3.0 * (xi.y * grown).ln_1p()).exp_m1() / self.rise;
        let z = (self.z[0] + rise).clamp(self.z[0], self.z[1]);
        let uv = DVec2::new(xi.x, self.v_of(z));
        (self.position(uv, DVec3::ZERO), uv)
    }

    fn density(&self, _: impl FnOnce() -> [DVec3; 2]) -> f64 {
        1.0 / self.area()
    }
}

impl_ray_surface!(Paraboloid);

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    #[test]
    fn ray_parallel_to_the_axis_meets_the_dish_once() {
        // x^2 + y^2 = 4 z: at x = 1, z = 1/4.
        let dish = Paraboloid::try_new(2.0, [0.0, 1.0], TAU).unwrap();
        let ray = Ray::new(DVec3::new(1.0, 0.0, 5.0), -DVec3::Z);
        let mut hits = Vec::new();
        dish.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.iter().map(|h| (h.t, h.u, h.v)).collect::<Vec<_>>(), [(4.75, 0.0, 0.25)]);
        let point = dish.point(&ray, &hits[0]);
        assert!((point.normal - DVec3::new(1.0, 0.0, -2.0).normalize()).length() < 1e-15);
    }

    #[test]
    fn axial_rays_reflect_into_the_focus() {
        // Focus of x^2 + y^2 = 4 z at z = 1.
        let dish = Paraboloid::try_new(2.0, [0.0, 1.0], TAU).unwrap();
        for x in [0.1, 0.7, 1.5, 1.99] {
            let ray = Ray::new(DVec3::new(x, -0.1, 7.0), -DVec3::Z);
            let hit = dish.intersect(&ray, f64::INFINITY).unwrap();
            let p = dish.point(&ray, &hit);
            let reflected = ray.direction - p.normal * (2.0 * p.normal.dot(ray.direction));
            let to_focus = (DVec3::Z - p.position).normalize();
            assert!((reflected - to_focus).length() < 1e-15);
        }
    }

    #[test]
    fn axis_through_the_apex_is_a_hit() {
        let dish = Paraboloid::try_new(0.7, [0.0, 0.3], TAU).unwrap();
        let hit = dish.intersect(&Ray::new(-DVec3::Z, DVec3::Z), f64::INFINITY).unwrap();
        assert_eq!(hit.t, 1.0);
    }

    #[test]
    fn area_agrees_with_the_published_formula() {
        // pi r / (6 h^2) ((r^2 + 4 h^2)^(3/2) - r^3)
        let (r, h) = (1.5_f64, 0.8);
        let dish = Paraboloid::try_new(r, [0.0, h], TAU).unwrap();
        let book = PI * r / (6.0 * h * h) * ((r * r + 4.0 * h * h).powf(1.5) - r * r * r);
        assert!((dish.area() - book).abs() < 1e-14);
        // A dish of one micrometre depth is a disk: (1 + h^2 / r^2) pi r^2 to second order.
        let flat = Paraboloid::try_new(1.0, [0.0, 1e-6], TAU).unwrap();
        assert!((flat.area() - PI * (1.0 + 1e-12)).abs() < 1e-14);
    }
}
