//! One-sheeted hyperboloids.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::{AzimuthRange, widened};
use super::revolution::{QuadricOfRevolution, point_on_ray};
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface, parameter_density};
use crate::error::{SurfaceError, finite};
use crate::rational::Profile;

/// The surface that the segment from `p1` to `p2` sweeps about the z axis: a one-sheeted hyperboloid or, as special cases, a
/// cone, a double cone or a cylinder.
///
/// `u` is the angle of the rotation as a fraction of its range, `v` runs from `p1` to `p2`. The normal points away from the
/// axis if `p2` is above `p1`, and to the axis otherwise. Sampled uniformly in (u, v).
///
/// # Source
/// @pbrt3 section 3.5. Departures: the segment need only not be horizontal, while pbrt's implicit equation
/// is valid only if the line is closest to the axis at z = 0; `p1` and `p2` are never swapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hyperboloid {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    p1: DVec3,
    p2: DVec3,
}

impl Hyperboloid {
    /// The segment from `p1` to `p2` (m) swept by `phi_max` (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `phi_max`, [`SurfaceError::Degenerate`] if both ends have the
    /// same z (a ring is a disk with a hole) or lie on the axis.
    pub fn try_new(p1: DVec3, p2: DVec3, phi_max: f64) -> Result<Self, SurfaceError> {
        for (parameter, p) in [("p1", p1), ("p2", p2)] {
            for value in p.to_array() {
                finite(parameter, value)?;
            }
        }
        let d = p2 - p1;
        if d.z == 0.0 {
            let reason = "both ends of the segment have the same z, use a disk";
            return Err(SurfaceError::Degenerate { reason, value: p1.z });
        }
        let widest = p1.truncate().length().max(p2.truncate().length());
        if !(widest > 0.0) {
            let reason = "the segment lies on the axis";
            return Err(SurfaceError::Degenerate { reason, value: widest });
        }
        // The equation is centred at the point of the segment nearest to the axis: at a waist or an apex its terms are as
        // small as the surface there.
        let flat = d.truncate();
        let to_waist = -p1.truncate().dot(flat) / flat.length_squared();
        let waist = if to_waist > 0.0 && to_waist < 1.0 { to_waist } else { f64::from(to_waist >= 1.0) };
        let next = point_on_ray(p1, d, waist);
        let next = if waist == 1.0 { p2 } else { next };
        // Inside the segment, the nearest point has no linear term.
        let beta = if waist == to_waist { 0.0 } else { 2.0 * next.truncate().dot(flat) / d.z };
        let alpha = flat.length_squared() / (d.z * d.z);
        let gamma = next.truncate().length_squared();
        let heights = [p1.z.min(p2.z), p1.z.max(p2.z)];
        Ok(Self {
            quadric: QuadricOfRevolution::new([alpha, beta, gamma], next.z, heights, widest),
            azimuth: AzimuthRange::try_new(phi_max)?,
            p1,
            p2,
        })
    }

    fn on_segment(&self, v: f64) -> DVec3 {
        self.p1 * (1.0 - v) + self.p2 * v
    }
}

impl SurfaceOfRevolution for Hyperboloid {
    fn quadric(&self) -> &QuadricOfRevolution {
        &self.quadric
    }

    fn orientation(&self) -> f64 {
        (self.p2.z - self.p1.z).signum()
    }

    fn azimuth(&self) -> AzimuthRange {
        self.azimuth
    }

    fn profiles(&self) -> Vec<Profile> {
        vec![Profile::line(self.p1, self.p2)]
    }

    fn extent(&self) -> Bounds3 {
        let (a, b) = (self.p1.truncate(), self.p2.truncate());
        let widest = a.length().max(b.length());
        // Azimuth of the start and signed angle to the end, below pi in magnitude.
        let start = a.to_angle();
        let turn = if a.length() > 0.0 && b.length() > 0.0 { a.angle_to(b) } else { 0.0 };
        let crosses_axis = a.length() == 0.0 || b.length() == 0.0 || turn.abs() > 3.0;
        let (low, high) = (start + turn.min(0.0), start + turn.max(0.0) + self.azimuth.phi_max());
        let sin_cos = self.azimuth.direction(1.0);
        let mut points = vec![a, b, sin_cos.rotate(a), sin_cos.rotate(b)];
        for (quarter, axis) in [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].into_iter().enumerate() {
            let phi = quarter as f64 * std::f64::consts::FRAC_PI_2;
            let turns = ((low - phi) / std::f64::consts::TAU).ceil();
            // The circle of the wider end bounds every arc that crosses a coordinate axis: simple, and tight for most.
            if crosses_axis || phi + turns * std::f64::consts::TAU <= high {
                points.push(axis * widest);
            }
        }
        widened(Bounds3::from_points(points.iter().flat_map(|p| [p.extend(self.p1.z), p.extend(self.p2.z)])))
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        let v = (p.z - self.p1.z) / (self.p2.z - self.p1.z);
        if !((0.0..=1.0).contains(&v)) {
            return None;
        }
        let start = self.on_segment(v).truncate();
        let here = p.truncate();
        let u = self.azimuth.parameter(start.dot(here), start.perp_dot(here))?;
        Some(DVec2::new(u, v))
    }

    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2] {
        let d = self.p2 - self.p1;
        let dpdv = self.azimuth.direction(uv.x).rotate(d.truncate()).extend(d.z);
        [self.azimuth.derivative(p), dpdv]
    }

    fn position(&self, uv: DVec2, _near: DVec3) -> DVec3 {
        let p = self.on_segment(uv.y);
        self.azimuth.direction(uv.x).rotate(p.truncate()).extend(p.z)
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        (self.position(xi, DVec3::ZERO), xi)
    }

    fn density(&self, tangents: impl FnOnce() -> [DVec3; 2]) -> f64 {
        parameter_density(tangents())
    }
}

impl_ray_surface!(Hyperboloid);

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    #[test]
    fn unit_hyperboloid_is_hit_at_its_waist() {
        // The line (1, s, s) sweeps x^2 + y^2 = 1 + z^2.
        let h = Hyperboloid::try_new(DVec3::new(1.0, -1.0, -1.0), DVec3::new(1.0, 1.0, 1.0), TAU).unwrap();
        let ray = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
        let mut hits = Vec::new();
        h.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(
            hits.iter().map(|h| (h.t, h.u, h.v)).collect::<Vec<_>>(),
            [(2.0, 0.5, 0.5), (4.0, 0.0, 0.5)]
        );
        assert_eq!(h.point(&ray, &hits[1]).normal, DVec3::X);
    }

    #[test]
    fn segment_off_the_waist_that_pbrt_cannot_have_is_exact() {
        // (1, s, s) for s from 2 to 3 has its waist at z = 0, outside; shifted by 10 along z pbrt's equation fails.
        let h = Hyperboloid::try_new(DVec3::new(1.0, 2.0, 12.0), DVec3::new(1.0, 3.0, 13.0), TAU).unwrap();
        let ray = Ray::new(DVec3::new(-9.0, 0.0, 12.5), DVec3::X);
        let hit = h.intersect(&ray, f64::INFINITY).unwrap();
        assert!((hit.t - (9.0 - (1.0_f64 + 2.5 * 2.5).sqrt())).abs() < 1e-14);
    }

    #[test]
    fn downward_segment_turns_the_normal_to_the_axis() {
        let h = Hyperboloid::try_new(DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, -1.0), TAU).unwrap();
        let ray = Ray::new(DVec3::new(3.0, 0.0, 0.0), -DVec3::X);
        let point = h.point(&ray, &h.intersect(&ray, f64::INFINITY).unwrap());
        assert_eq!(point.normal, -DVec3::X);
        assert!(point.dpdu.cross(point.dpdv).dot(point.normal) > 0.0);
    }

    #[test]
    fn rulings_lie_on_the_surface() {
        let h = Hyperboloid::try_new(DVec3::new(1.0, -1.0, -1.0), DVec3::new(1.0, 1.0, 1.0), TAU).unwrap();
        for k in 0..100 {
            let (sin, cos) = (f64::from(k) * 0.1).sin_cos();
            let d = DVec3::new(-sin, cos, 1.0);
            let ray = Ray::new(DVec3::new(cos, sin, 0.0) - d * 2.0, d);
            if let Some(hit) = h.intersect(&ray, f64::INFINITY) {
                let p = h.point(&ray, &hit);
                assert!((p.position.truncate().length_squared() - 1.0 - p.position.z.powi(2)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn horizontal_and_axial_segments_are_refused() {
        assert!(Hyperboloid::try_new(DVec3::X, DVec3::Y, TAU).is_err());
        assert!(Hyperboloid::try_new(DVec3::ZERO, DVec3::Z, TAU).is_err());
    }
}
