//! Tori.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::ControlFlow;

use glanz_math::polynomial::visit_roots;
use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::error::{SurfaceError, finite, positive};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::rational::Profile;
use crate::ray_line::RayLine;
use crate::surface::RaySurface;

/// A torus around the z axis, full or up to an angle, without caps; its normal points out of the tube.
///
/// `u` is the angle around the axis divided by `phi_max`, `v` the angle around the tube divided by 2 pi, from the outer equator
/// upwards:
///
/// `p = ((R + r cos 2 pi v) cos(u phi_max), (R + r cos 2 pi v) sin(u phi_max), r sin 2 pi v)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    major: f64,
    minor: f64,
    phi_max: f64,
    bounds: Bounds3,
    /// Distance from the surface below which the quartic may have a wrong sign, times the distance from the axis.
    quartic_error: f64,
}

impl Torus {
    /// The torus with a tube of radius `minor` around a circle of radius `major` (metres), from angle 0 to `phi_max` (radians)
    /// around z.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`], and [`SurfaceError::OutOfRange`] if `phi_max`
    /// exceeds 2 pi or `minor` is not below `major`: horn and spindle tori have points without a tangent plane, and
    /// spindle tori have no inside and outside.
    pub fn try_new(major: f64, minor: f64, phi_max: f64) -> Result<Self, SurfaceError> {
        let major = positive("major radius", major)?;
        let minor = positive("minor radius", minor)?;
        let phi_max = positive("phi_max", phi_max)?;
        finite("outer radius to the fourth power", (major + minor).powi(4))?;
        if phi_max > TAU {
            return Err(SurfaceError::OutOfRange {
                parameter: "phi_max",
                value: phi_max,
                min: 0.0,
                max: TAU,
            });
        }
        // An inner equator within rounding of the axis is a horn torus.
        if minor >= major * (1.0 - gamma(64)) {
            return Err(SurfaceError::OutOfRange {
                parameter: "minor radius",
                value: minor,
                min: 0.0,
                max: major,
            });
        }
        let outer = major + minor;
        let (low, high) = arc_extent(phi_max, major - minor, outer);
        let bounds =
            Bounds3 { min: DVec3::new(low.x, low.y, -minor), max: DVec3::new(high.x, high.y, minor) };
        Ok(Self {
            major,
            minor,
            phi_max,
            // Sines of the ends of the arc are rounded.
            bounds: bounds.expanded(outer * gamma(4)),
            // The quartic is a sum of terms of at most 8 A^4 in the bounding ball of radius A, each with fewer than 16
            // roundings; its gradient on the surface is 8 R r rho at the distance rho from the axis.
            quartic_error: gamma(16) * outer.powi(4) / (major * minor),
        })
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.phi_max * self.major * TAU * self.minor
    }

    pub(crate) fn phi_max(&self) -> f64 {
        self.phi_max
    }

    /// The profile curves.
    pub(crate) fn profiles(&self) -> Vec<Profile> {
        Profile::circle(self.major, self.minor, [0.0, TAU])
    }

    /// The interval of arc length in front of the ray's origin and close to the surface, if it begins before `t_max`.
    ///
    /// The ball and the slab are slightly too large: clipping saves time and digits but must not decide about a crossing. The end
    /// does not depend on `t_max`, so that a hit always has the same digits.
    fn clip(&self, ray: &Ray, line: &RayLine, t_max: f64) -> Option<(f64, f64)> {
        let outer = (self.major + self.minor) * (1.0 + 1.0 / 64.0);
        let half2 = outer * outer - line.origin.length_squared();
        if half2 < 0.0 {
            return None;
        }
        let half = half2.sqrt();
        let (mut low, mut high) = (line.s(0.0).max(-half), half);
        let (z, dz) = (line.origin.z, line.direction.z);
        // The last term is the rounding error of a distant origin.
        let reach = self.minor * (1.0 + 1.0 / 16.0) + gamma(4) * ray.origin.length();
        if dz != 0.0 {
            let (a, b) = ((-reach - z) / dz, (reach - z) / dz);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        } else if z.abs() > reach {
            return None;
        }
        (low <= high && low <= line.s(t_max)).then_some((low, high))
    }

    /// The polynomial in s that vanishes where the line crosses the whole torus.
    ///
    /// `(|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + y^2)` with `p = c + s d`; the constant term is factored, which is accurate for thin
    /// tubes.
    fn quartic(&self, line: &RayLine) -> [f64; 5] {
        let (c, d) = (line.origin, line.direction);
        let (big, small) = (self.major, self.minor);
        let cd = c.dot(d);
        let xi = c.length_squared() + (big - small) * (big + small);
        let rho = c.truncate().length();
        let tube = |ring: f64| ring * ring + (c.z - small) * (c.z + small);
        let four_big2 = 4.0 * big * big;
        [
            tube(rho - big) * tube(rho + big),
            4.0 * cd * xi - 2.0 * four_big2 * (c.x * d.x + c.y * d.y),
            4.0 * cd * cd + 2.0 * xi - four_big2 * (d.x * d.x + d.y * d.y),
            4.0 * cd,
            1.0,
        ]
    }

    /// The hit at arc length `s`, if it is in range.
    fn hit(&self, line: &RayLine, s: f64, t_max: f64) -> Option<Hit> {
        let t = line.t(s);
        let p = line.at(s);
        let phi = angle(p.y, p.x);
        let inside = t > 0.0 && t < t_max && phi <= self.phi_max;
        let v = angle(p.z, p.truncate().length() - self.major) / TAU;
        inside.then(|| Hit::new(t, phi / self.phi_max, v, 0))
    }

    /// Visits the hits in ascending order until `visit` breaks.
    fn visit_hits<B>(
        &self,
        ray: &Ray,
        t_max: f64,
        mut visit: impl FnMut(Hit) -> ControlFlow<B>,
    ) -> Option<B> {
        let line = RayLine::nearest_to(ray, DVec3::ZERO);
        let (low, high) = self.clip(ray, &line, t_max)?;
        let mut last = 0.0;
        let end = visit_roots(&self.quartic(&line), low, high, |s| {
            let Some(hit) = self.hit(&line, s, t_max) else { return ControlFlow::Continue(()) };
            // Two arc lengths may round to one parameter of a distant ray.
            let is_new = hit.t > last;
            last = hit.t;
            if is_new { visit(hit) } else { ControlFlow::Continue(()) }
        });
        end.break_value()
    }

    pub(crate) fn point_at(&self, u: f64, v: f64) -> SurfacePoint {
        let (sin_phi, cos_phi) = (u * self.phi_max).sin_cos();
        let (sin_theta, cos_theta) = (v * TAU).sin_cos();
        let rho = self.major + self.minor * cos_theta;
        let position = DVec3::new(rho * cos_phi, rho * sin_phi, self.minor * sin_theta);
        let normal = DVec3::new(cos_theta * cos_phi, cos_theta * sin_phi, sin_theta);
        let around_tube = DVec3::new(-sin_theta * cos_phi, -sin_theta * sin_phi, cos_theta);
        let around_axis = DVec3::new(-sin_phi, cos_phi, 0.0);
        SurfacePoint {
            position,
            // Five roundings of the position, and twice the distance that the quartic does not resolve: it is evaluated for the
            // hit and again for the next ray.
            error: DVec3::splat(gamma(6) * (self.major + self.minor) + 2.0 * self.quartic_error / rho),
            normal,
            shading_normal: normal,
            uv: DVec2::new(u, v),
            dpdu: around_axis * (self.phi_max * rho),
            dpdv: around_tube * (TAU * self.minor),
        }
    }
}

/// The angle of (x, y) in [0, 2 pi).
fn angle(y: f64, x: f64) -> f64 {
    let a = y.atan2(x);
    if a < 0.0 { (a + TAU).min(TAU.next_down()) } else { a }
}

/// Smallest and largest x and y of a ring between two radii, from angle 0 to `phi_max`.
fn arc_extent(phi_max: f64, inner: f64, outer: f64) -> (DVec2, DVec2) {
    let mut extent = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let mut include = |direction: DVec2| {
        for radius in [inner, outer] {
            extent.0 = extent.0.min(direction * radius);
            extent.1 = extent.1.max(direction * radius);
        }
    };
    include(DVec2::X);
    include(DVec2::from_angle(phi_max));
    for (quarter, axis) in [(1.0, DVec2::Y), (2.0, -DVec2::X), (3.0, -DVec2::Y)] {
        if phi_max >= quarter * FRAC_PI_2 {
            include(axis);
        }
    }
    extent
}

/// The angle around the tube below which the fraction `xi` of the area lies: `theta + e sin theta = 2 pi xi`.
///
/// Kepler's equation with the sign of e reversed, e = r / R < 1: the left side increases, so that Newton's method in a shrinking
/// bracket converges.
fn tube_angle(e: f64, xi: f64) -> f64 {
    let target = TAU * xi;
    let (mut low, mut high) = ((target - e).max(0.0), (target + e).min(TAU));
    let mut theta = target.clamp(low, high);
    loop {
        let (sin, cos) = theta.sin_cos();
        let excess = theta + e * sin - target;
        if excess > 0.0 {
            high = theta;
        } else {
            low = theta;
        }
        let newton = theta - excess / (1.0 + e * cos);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - theta).abs() <= f64::EPSILON * theta.abs() || next <= low || next >= high {
            return next;
        }
        theta = next;
    }
}

impl RaySurface for Torus {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.visit_hits(ray, t_max, ControlFlow::Break)
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let _: Option<()> = self.visit_hits(ray, t_max, |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        });
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.u, hit.v)
    }

    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        // Those of the position, by the radii of curvature.
        let rho = self.major + self.minor * (hit.v * TAU).cos();
        [point.dpdu * ((hit.v * TAU).cos() / rho), point.dpdv / self.minor]
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let (u, v) = (xi.x, tube_angle(self.minor / self.major, xi.y) / TAU);
        Some(SurfaceSample {
            hit: Hit::new(0.0, u, v, 0),
            point: self.point_at(u, v),
            pdf: AreaPdf(1.0 / self.area()),
        })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(AreaPdf(1.0 / self.area()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::rounding::offset_origin;
    use std::f64::consts::PI;

    fn all(torus: &Torus, ray: &Ray) -> Vec<f64> {
        let mut hits = Vec::new();
        torus.all_hits(ray, f64::INFINITY, &mut hits);
        hits.iter().map(|h| h.t).collect()
    }

    #[test]
    fn line_through_the_middle_meets_the_tube_four_times() {
        let torus = Torus::try_new(2.0, 0.5, TAU).unwrap();
        let ray = Ray::new(DVec3::new(-5.0, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0));
        for (t, x) in all(&torus, &ray).iter().zip([-2.5, -1.5, 1.5, 2.5]) {
            assert!((t - (x + 5.0) / 0.5).abs() < 1e-14, "{t}");
        }
        assert_eq!(all(&torus, &ray).len(), 4);
    }

    #[test]
    fn tangent_along_the_top_circle_appears_once() {
        let torus = Torus::try_new(2.0, 0.5, TAU).unwrap();
        // The plane z = r touches along the circle rho = R.
        let ray = Ray::new(DVec3::new(-5.0, 0.0, 0.5), DVec3::X);
        assert_eq!(all(&torus, &ray), [3.0, 7.0]);
        // The inner equator is touched from inside the hole.
        let ray = Ray::new(DVec3::new(1.5, -4.0, 0.0), DVec3::Y);
        let hits = all(&torus, &ray);
        assert_eq!(hits.len(), 3, "{hits:?}");
        assert!((hits[1] - 4.0).abs() < 1e-7);
    }

    #[test]
    fn far_origin_keeps_the_accuracy() {
        for (major, minor) in [(1.0, 0.3), (1.0, 1e-3), (1e-3, 0.9e-3), (1e4, 10.0)] {
            let torus = Torus::try_new(major, minor, TAU).unwrap();
            let size = major + minor;
            for i in 0..200 {
                let (a, b) = (f64::from(i) * 0.7, f64::from(i) * 0.37);
                let target = torus.point_at((a / TAU).fract(), (b / TAU).fract());
                let tangent = target.dpdu.normalize() * a.sin() + target.dpdv.normalize() * b.cos();
                let direction = (target.normal + tangent).normalize();
                let ray = Ray::new(target.position - direction * (1e5 * size), direction);
                let nearest =
                    all(&torus, &ray).iter().map(|t| (t - 1e5 * size).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-10 * size, "{nearest:e}");
            }
        }
    }

    #[test]
    fn leaving_ray_misses_outside_and_returns_inside() {
        let mut worst = 0.0_f64;
        for (major, minor) in [(1.0, 0.3), (1.0, 1e-3), (5.0, 4.9), (1e4, 10.0)] {
            let torus = Torus::try_new(major, minor, TAU).unwrap();
            for i in 0..2000 {
                let (u, v) =
                    ((f64::from(i) * 0.618_033_988_7).fract(), (f64::from(i) * 0.754_877_666).fract());
                let p = torus.point_at(u, v);
                worst = worst.max(p.error.x / minor);
                let tangent =
                    p.dpdu.normalize() * f64::from(i).sin() + p.dpdv.normalize() * f64::from(i).cos();
                let along = p.normal * 10.0_f64.powi(-(i % 12)) + tangent;
                // Beyond the tangent planes of the outer half there is no surface.
                if p.position.dot(p.normal) > major * p.normal.z.abs().max(0.0) && v.min(1.0 - v) < 0.2 {
                    let origin = offset_origin(p.position, p.error, p.normal, along);
                    assert!(torus.intersect(&Ray::new(origin, along), f64::INFINITY).is_none());
                }
                let inward = tangent - p.normal * 10.0_f64.powi(-(i % 5));
                let origin = offset_origin(p.position, p.error, p.normal, inward);
                let count = all(&torus, &Ray::new(origin, inward)).len();
                assert!(count % 2 == 1, "{count} crossings on the way out of {torus:?} from {u}, {v}");
            }
        }
        assert!(worst < 1e-6, "{worst:e}");
    }

    #[test]
    fn partial_ring_is_hit_within_its_angle_only() {
        let torus = Torus::try_new(2.0, 0.5, PI).unwrap();
        let down = |x: f64, y: f64| Ray::new(DVec3::new(x, y, 3.0), -DVec3::Z);
        assert_eq!(all(&torus, &down(0.0, 2.0)), [2.5, 3.5]);
        assert!(all(&torus, &down(0.0, -2.0)).is_empty());
        assert!(torus.bounds().contains(DVec3::new(-2.5, 0.0, 0.5)));
        assert!(torus.bounds().min.y > -1e-14);
    }

    #[test]
    fn derivatives_are_differences() {
        let torus = Torus::try_new(2.0, 0.7, 4.0).unwrap();
        let h = 1e-6;
        for (u, v) in [(0.1, 0.2), (0.5, 0.5), (0.9, 0.8), (0.3, 0.0)] {
            let p = torus.point_at(u, v);
            let hit = Hit::new(1.0, u, v, 0);
            let [dndu, dndv] = torus.normal_derivatives(&hit, &p);
            let (pu, pv) = (torus.point_at(u + h, v), torus.point_at(u, v + h));
            let (mu, mv) = (torus.point_at(u - h, v), torus.point_at(u, v - h));
            assert!(((pu.position - mu.position) / (2.0 * h) - p.dpdu).length() < 1e-8);
            assert!(((pv.position - mv.position) / (2.0 * h) - p.dpdv).length() < 1e-8);
            assert!(((pu.normal - mu.normal) / (2.0 * h) - dndu).length() < 1e-8);
            assert!(((pv.normal - mv.normal) / (2.0 * h) - dndv).length() < 1e-8);
            assert!((p.dpdu.cross(p.dpdv).normalize() - p.normal).length() < 1e-14);
        }
    }

    #[test]
    fn samples_are_uniform_over_the_area() {
        // The fraction of the area with theta in [0, pi/2] is (pi/2 + e) / 2 pi.
        let torus = Torus::try_new(1.0, 0.8, TAU).unwrap();
        let n = 1000;
        let count = (0..n)
            .filter(|&i| {
                let v = torus.sample(DVec2::new(0.3, (f64::from(i) + 0.5) / f64::from(n))).unwrap().hit.v;
                v < 0.25
            })
            .count();
        let expected = (FRAC_PI_2 + 0.8) / TAU * f64::from(n);
        assert!((count as f64 - expected).abs() <= 1.0);
    }

    #[test]
    fn horn_and_spindle_tori_are_refused() {
        for minor in [1.0, 1.5] {
            assert!(
                matches!(Torus::try_new(1.0, minor, TAU), Err(SurfaceError::OutOfRange { value, .. }) if value == minor)
            );
        }
        assert!(matches!(Torus::try_new(1.0, 0.5, 7.0), Err(SurfaceError::OutOfRange { .. })));
        assert!(matches!(Torus::try_new(-1.0, 0.5, 1.0), Err(SurfaceError::NotPositive { .. })));
        assert!(matches!(Torus::try_new(1.0, f64::NAN, 1.0), Err(SurfaceError::NotFinite { .. })));
    }
}
