//! Two-sheeted hyperboloids.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::azimuth::AzimuthRange;
use super::revolution::QuadricOfRevolution;
use super::surface_of_revolution::{SurfaceOfRevolution, impl_ray_surface, parameter_density};
use crate::error::{SurfaceError, finite, positive};
use crate::rational::Profile;

/// The surface `z^2 / c^2 - (x^2 + y^2) / a^2 = 1` about the z axis, with apices at z = c and z = -c.
///
/// The range of z selects one sheet or both. `u` is the azimuth as a fraction of its range. `v` is linear in the hyperbolic
/// angle s of the profile `(a sinh |s|, sign(s) c cosh s)`, from the smallest z to the largest: regular at the apices,
/// where z is not a regular parameter; with both sheets it jumps from one apex to the other at s = 0. The normal points to the
/// convex side of each sheet, into the gap between them. Sampled uniformly in (u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSheetedHyperboloid {
    quadric: QuadricOfRevolution,
    azimuth: AzimuthRange,
    a: f64,
    c: f64,
    /// Range of z that a hit must lie in; 0 stands for an end at an apex, where rounding must not clip.
    z_clip: [f64; 2],
    /// z of both ends.
    heights: [f64; 2],
    /// Hyperbolic angles of both ends.
    s: [f64; 2],
}

impl TwoSheetedHyperboloid {
    /// The hyperboloid with half axes `a` (radial, m) and `c` (along z, m) between the two values of `z` (m, any
    /// order), with azimuth up to `phi_max` (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `a`, `c` or `phi_max`, [`SurfaceError::EmptyRange`] if the
    /// range of z contains no part of either sheet.
    pub fn try_new(a: f64, c: f64, z: [f64; 2], phi_max: f64) -> Result<Self, SurfaceError> {
        let (a, c) = (positive("a", a)?, positive("c", c)?);
        let [z0, z1] = [finite("z", z[0])?, finite("z", z[1])?];
        let z_clip = [z0.min(z1), z0.max(z1)].map(|z| if z.abs() <= c { 0.0 } else { z });
        if !(z_clip[0] < z_clip[1]) {
            return Err(SurfaceError::EmptyRange { parameter: "z", min: z0, max: z1 });
        }
        let radii = z_clip.map(|z| radius_at(a, c, z));
        let heights = heights(c, z_clip);
        let slope = a / c;
        Ok(Self {
            quadric: QuadricOfRevolution::new(
                [slope * slope, 0.0, -a * a],
                0.0,
                heights,
                radii[0].max(radii[1]),
            ),
            azimuth: AzimuthRange::try_new(phi_max)?,
            a,
            c,
            z_clip,
            heights,
            s: [angle(a, radii[0], z_clip[0]), angle(a, radii[1], z_clip[1])],
        })
    }

    fn turn(&self) -> f64 {
        self.s[1] - self.s[0]
    }
}

/// Distance from the axis at height `z`; 0 between the apices.
fn radius_at(a: f64, c: f64, z: f64) -> f64 {
    a / c * ((z.abs() - c) * (z.abs() + c)).max(0.0).sqrt()
}

/// z of both ends, with that of the apex in place of 0.
fn heights(c: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    [if low == 0.0 { c } else { low }, if high == 0.0 { -c } else { high }]
}

/// Signed hyperbolic angle of a point at `rho` from the axis on the sheet that has the sign of `z`.
fn angle(a: f64, rho: f64, z: f64) -> f64 {
    (rho / a).asinh().copysign(z)
}

impl SurfaceOfRevolution for TwoSheetedHyperboloid {
    fn quadric(&self) -> &QuadricOfRevolution {
        &self.quadric
    }

    fn azimuth(&self) -> AzimuthRange {
        self.azimuth
    }

    fn profiles(&self) -> Vec<Profile> {
        let [low, high] = self.s;
        let v = |s: f64| (s - low) / self.turn();
        let arcs = |upper, from: f64, to: f64| {
            if from < to {
                Profile::hyperbola([self.a, self.c], upper, [from, to], [v(from), v(to)])
            } else {
                Vec::new()
            }
        };
        [arcs(false, low, high.min(0.0)), arcs(true, low.max(0.0), high)].concat()
    }

    fn extent(&self) -> Bounds3 {
        let radii = self.z_clip.map(|z| radius_at(self.a, self.c, z));
        let inner = if self.z_clip[0] * self.z_clip[1] > 0.0 { radii[0].min(radii[1]) } else { 0.0 };
        self.azimuth.bounds([inner, radii[0].max(radii[1])], self.heights)
    }

    fn parameters(&self, p: DVec3) -> Option<DVec2> {
        if !(p.z >= self.z_clip[0] && p.z <= self.z_clip[1]) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        let s = angle(self.a, p.truncate().length(), p.z);
        Some(DVec2::new(u, ((s - self.s[0]) / self.turn()).clamp(0.0, 1.0)))
    }

    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2] {
        let radial = self.azimuth.direction_at(p, || uv.x);
        // d/ds of (a sinh |s|, sign(s) c cosh s) by the point itself: a cosh s = a |z| / c, c sinh |s| = c rho / a.
        let outward = self.a / self.c * p.z;
        let up = self.c / self.a * p.truncate().length();
        [self.azimuth.derivative(p), (radial * outward).extend(up) * self.turn()]
    }

    fn position(&self, uv: DVec2, near: DVec3) -> DVec3 {
        let s = self.s[0] + uv.y * self.turn();
        let z = (self.c * s.cosh()).copysign(near.z).clamp(self.heights[0], self.heights[1]);
        (self.azimuth.direction(uv.x) * (self.a * s.abs().sinh())).extend(z)
    }

    fn near(&self, uv: DVec2) -> DVec3 {
        let s = self.s[0] + uv.y * self.turn();
        // At s = 0 the sheet is the one that is kept, or the upper one of two.
        let lower = s < 0.0 || (s == 0.0 && self.s[1] <= 0.0);
        if lower { -DVec3::Z } else { DVec3::Z }
    }

    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2) {
        (self.position(xi, self.near(xi)), xi)
    }

    fn density(&self, tangents: impl FnOnce() -> [DVec3; 2]) -> f64 {
        parameter_density(tangents())
    }
}

impl_ray_surface!(TwoSheetedHyperboloid);

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glanz_math::Ray;

    use super::*;
    use crate::surface::RaySurface;

    fn hits(h: &TwoSheetedHyperboloid, ray: &Ray) -> Vec<f64> {
        let mut hits = Vec::new();
        h.all_hits(ray, f64::INFINITY, &mut hits);
        hits.iter().map(|h| h.t).collect()
    }

    #[test]
    fn axis_meets_the_apex_of_each_sheet_that_is_kept() {
        let axis = Ray::new(DVec3::Z * -5.0, DVec3::Z);
        let sheets = |z| hits(&TwoSheetedHyperboloid::try_new(1.5, 2.0, z, TAU).unwrap(), &axis);
        assert_eq!(sheets([-3.0, 3.0]), [3.0, 7.0]);
        assert_eq!(sheets([0.0, 3.0]), [7.0]);
        assert_eq!(sheets([-3.0, 2.0]), [3.0]);
        assert_eq!(sheets([2.5, 3.0]), [0.0; 0]);
    }

    #[test]
    fn normals_point_into_the_gap() {
        let h = TwoSheetedHyperboloid::try_new(1.0, 1.0, [-3.0, 3.0], TAU).unwrap();
        let ray = Ray::new(DVec3::ZERO, DVec3::Z);
        assert_eq!(h.point(&ray, &h.intersect(&ray, 9.0).unwrap()).normal, -DVec3::Z);
        let down = Ray::new(DVec3::ZERO, -DVec3::Z);
        assert_eq!(h.point(&down, &h.intersect(&down, 9.0).unwrap()).normal, DVec3::Z);
    }

    #[test]
    fn range_between_the_apices_is_refused() {
        assert!(matches!(
            TwoSheetedHyperboloid::try_new(1.0, 1.0, [-1.0, 1.0], TAU),
            Err(SurfaceError::EmptyRange { .. })
        ));
    }
}
