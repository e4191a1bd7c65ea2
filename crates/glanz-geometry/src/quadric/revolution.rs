//! The quadric of revolution about the z axis and its intersection with rays.

use glanz_math::polynomial::quadratic::difference_of_products;
use glanz_math::rounding::gamma;
use glanz_math::{DVec3, Ray};

/// Distance, in half extents of the kept part, beyond which the equation is formed at the point of the ray nearest to that part
/// instead of its origin. Any value well above sqrt(2), the distance of the corners, will do; secondary rays start closer.
const FAR: f64 = 4.0;

/// Ratio of the discriminant to the squared linear coefficient below which two roots are close together: their distance is
/// then less than a tenth of the distance of their middle.
const CLOSE: f64 = 0.01;

/// `x^2 + y^2 = alpha w^2 + beta w + gamma` with `w = z - z0`; outside, the left side is larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuadricOfRevolution {
    alpha: f64,
    beta: f64,
    gamma: f64,
    z0: f64,
    /// Middle of the kept range of z.
    center: f64,
    /// Largest distance of the kept part from the axis, squared.
    radius_squared: f64,
    /// Squared ratio of radius to half height of the kept part, which makes lengths along the axis comparable to radii.
    weight: f64,
}

/// A point where a ray meets the quadric.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuadricCrossing {
    /// Ray parameter.
    pub(super) t: f64,
    /// The point, more accurate than the ray at `t` if the origin is distant.
    pub(super) p: DVec3,
}

/// A root as an offset from a nearby point of the ray, so that a distant origin costs no digits.
#[derive(Clone, Copy)]
struct OffsetRoot {
    base: DVec3,
    t_base: f64,
    t: f64,
}

impl QuadricOfRevolution {
    /// The quadric with the given coefficients and the kept part, with z in `heights` and distances from the axis up to
    /// `radius`.
    pub(super) fn new([alpha, beta, gamma]: [f64; 3], z0: f64, heights: [f64; 2], radius: f64) -> Self {
        let half_height = 0.5 * (heights[1] - heights[0]);
        let ratio = radius / half_height;
        Self {
            alpha,
            beta,
            gamma,
            z0,
            center: 0.5 * (heights[0] + heights[1]),
            radius_squared: radius * radius,
            weight: ratio * ratio,
        }
    }

    /// The points with t > 0, ascending, where the ray meets the whole quadric close to the kept part.
    ///
    /// For an origin close to the surface, the sign of the near root follows from the side on which the origin is computed to
    /// be, so that a ray that starts off the surface by the bound of [`QuadricOfRevolution::error`] does not meet its own point.
    /// For a distant origin the equation is formed at the point of the ray nearest to the kept part, and roots close together
    /// are computed from their middle to avoid cancellation (@haines2019).
    #[inline]
    pub(super) fn crossings(&self, ray: &Ray) -> [Option<QuadricCrossing>; 2] {
        if self.is_left_by(ray) { [None; 2] } else { self.roots_ahead(ray) }
    }

    /// Whether both roots lie behind the origin by the signs of their sum and product: so do most rays that leave the surface.
    ///
    /// On cones and hyperboloids, the value at a distant origin is a difference of large numbers, whose sign proves nothing.
    #[inline]
    fn is_left_by(&self, ray: &Ray) -> bool {
        let (half, c) = self.half_slope_and_value(ray.origin, ray.direction);
        let is_left = half >= 0.0 && c > 0.0 && self.leading(ray.direction) > 0.0;
        is_left && (self.alpha <= 0.0 || !self.is_distant(ray.origin))
    }

    /// Whether the equation at `p` would lose digits.
    fn is_distant(&self, p: DVec3) -> bool {
        !(self.distance_squared(p) <= FAR * FAR * self.radius_squared)
    }

    fn roots_ahead(&self, ray: &Ray) -> [Option<QuadricCrossing>; 2] {
        let Some((base, t_base)) = self.approach(ray) else { return [None; 2] };
        let Some(roots) = self.roots(base, t_base, ray.direction) else { return [None; 2] };
        let [first, second] = roots.map(|root| self.crossing(root, ray.direction));
        match (first, second) {
            (Some(a), Some(b)) if a.t == b.t => [first, None],
            (Some(a), Some(b)) if a.t > b.t => [second, first],
            (None, Some(_)) => [second, None],
            _ => [first, second],
        }
    }

    /// The point of the ray at which to form the equation, and its parameter; `None` if the ray misses the kept part.
    fn approach(&self, ray: &Ray) -> Option<(DVec3, f64)> {
        let (o, d) = (ray.origin, ray.direction);
        if !self.is_distant(o) {
            return Some((o, 0.0));
        }
        let numerator = o.x * d.x + o.y * d.y + self.weight * (o.z - self.center) * d.z;
        let t = -numerator / (d.x * d.x + d.y * d.y + self.weight * (d.z * d.z));
        if !(t > 0.0) {
            return None;
        }
        // The fused product rounds only the small result: the point is on the ray up to its own last digits.
        let near = point_on_ray(o, d, t);
        self.is_near(near).then_some((near, t))
    }

    /// Squared distance from the middle of the kept part, scaled so that all its half extents equal its radius.
    fn distance_squared(&self, p: DVec3) -> f64 {
        let z = p.z - self.center;
        p.x * p.x + p.y * p.y + self.weight * (z * z)
    }

    /// Whether `p` may belong to the kept part, which extends sqrt(2) half extents; the rest is a margin for rounding.
    fn is_near(&self, p: DVec3) -> bool {
        self.distance_squared(p) <= 4.0 * self.radius_squared
    }

    /// Half the derivative of the equation along `d`, and its value, at `p`.
    fn half_slope_and_value(&self, p: DVec3, d: DVec3) -> (f64, f64) {
        let w = p.z - self.z0;
        let half = p.x * d.x + p.y * d.y - (self.alpha * w + 0.5 * self.beta) * d.z;
        (half, self.value(p))
    }

    /// Left minus right side of the equation, positive outside.
    fn value(&self, p: DVec3) -> f64 {
        let w = p.z - self.z0;
        p.x * p.x + p.y * p.y - (self.alpha * w + self.beta) * w - self.gamma
    }

    /// Both roots of `a t^2 + 2 half t + c = 0`, formed at `base`; not sorted.
    fn roots(&self, base: DVec3, t_base: f64, d: DVec3) -> Option<[OffsetRoot; 2]> {
        let a = self.leading(d);
        let (half, c) = self.half_slope_and_value(base, d);
        if a == 0.0 {
            let root = OffsetRoot { base, t_base, t: -0.5 * c / half };
            return Some([root, root]);
        }
        let discriminant = difference_of_products(half, half, a, c);
        if discriminant.abs() > CLOSE * half * half {
            let [t0, t1] = stable_roots(a, half, c, discriminant)?;
            return Some([t0, t1].map(|t| OffsetRoot { base, t_base, t }));
        }
        // Both roots are far from the base on the same side, so their middle becomes the new base. There `half` almost
        // vanishes, and the discriminant is as accurate as the equation at that point.
        let to_middle = -half / a;
        let middle = point_on_ray(base, d, to_middle);
        let (half, c) = self.half_slope_and_value(middle, d);
        let mut discriminant = difference_of_products(half, half, a, c);
        // A line steeper than a cone always meets it: at the apex the two roots coincide. `a` has four roundings; an `a` that
        // may be zero decides nothing.
        let a_error = gamma(4) * (d.x * d.x + d.y * d.y + self.alpha * (d.z * d.z));
        if self.beta == 0.0 && self.gamma == 0.0 && a < -a_error {
            discriminant = discriminant.max(0.0);
        }
        let roots = stable_roots(a, half, c, discriminant)?;
        Some(roots.map(|t| OffsetRoot { base: middle, t_base: t_base + to_middle, t }))
    }

    /// The root as a crossing, if it is in front of the origin and close to the kept part.
    fn crossing(&self, root: OffsetRoot, d: DVec3) -> Option<QuadricCrossing> {
        let at = |t: f64| QuadricCrossing { t: root.t_base + t, p: point_on_ray(root.base, d, t) };
        let mut best = at(root.t);
        if !(best.t > 0.0 && self.is_near(best.p)) {
            return None;
        }
        if self.alpha <= 0.0 {
            return Some(best);
        }
        // Along an asymptote `a` cancels, and near an apex the surface is small compared with the coordinates of the base:
        // Newton steps with the equation at the point itself restore the digits.
        let a = self.leading(d);
        let (mut t, mut residual) = (root.t, self.value(best.p).abs());
        for _ in 0..3 {
            let (half, value) = self.half_slope_and_value(best.p, d);
            // Kantorovich's condition, with half of its bound: Newton's iteration converges to this root.
            if 2.0 * (a * value).abs() > half * half {
                break;
            }
            t -= 0.5 * value / half;
            let better = at(t);
            let left = self.value(better.p).abs();
            if !(left < residual && better.t > 0.0) {
                break;
            }
            (best, residual) = (better, left);
        }
        Some(best)
    }

    /// Half the second derivative of the equation along `d`.
    fn leading(&self, d: DVec3) -> f64 {
        d.x * d.x + d.y * d.y - self.alpha * (d.z * d.z)
    }

    /// Outward gradient of the equation.
    pub(super) fn gradient(&self, p: DVec3) -> DVec3 {
        let w = p.z - self.z0;
        DVec3::new(2.0 * p.x, 2.0 * p.y, -2.0 * self.alpha * w - self.beta)
    }

    /// The point of the quadric nearest to `p`, which is close to it: two Newton steps.
    pub(super) fn refined(&self, p: DVec3) -> DVec3 {
        self.corrected(self.corrected(p))
    }

    /// `p` after a Newton step along the gradient, which squares the relative distance from the quadric: enough for a point that is off
    /// it by roundings.
    #[inline]
    pub(super) fn corrected(&self, p: DVec3) -> DVec3 {
        let gradient = self.gradient(p);
        let square = gradient.length_squared();
        if square > 0.0 { p - gradient * (self.value(p) / square) } else { p }
    }

    /// The bound of [`crate::SurfacePoint::error`] at a point after [`QuadricOfRevolution::corrected`] or `refined`.
    ///
    /// Evaluating the equation chains at most 8 roundings, so its error is below gamma(8) M, where M is the sum of the absolute
    /// terms. The distance of the point from the surface is up to (|residual| + gamma(8) M) / |gradient|; the origin of the
    /// next ray must be so far away that the equation has the right sign there despite another gamma(8) M. gamma(20) also
    /// covers the roundings of this bound and of the normal. The term with |p| is the rounding of the coordinates.
    pub(super) fn error(&self, p: DVec3) -> DVec3 {
        let w = p.z - self.z0;
        let terms = p.x * p.x
            + p.y * p.y
            + (self.alpha * w).abs() * w.abs()
            + (self.beta * w).abs()
            + self.gamma.abs();
        let slope = self.gradient(p).length();
        let off = if slope > 0.0 { (2.0 * self.value(p).abs() + gamma(20) * terms) / slope } else { 0.0 };
        DVec3::splat(off) + p.abs() * gamma(2)
    }

    /// Unit outward normal; +z where the gradient vanishes.
    pub(super) fn normal(&self, p: DVec3) -> DVec3 {
        self.gradient(p).try_normalize().unwrap_or(DVec3::Z)
    }

    /// Derivative of the unit outward normal along `tangent`; zero where there is no normal.
    ///
    /// The Weingarten map from the Hessian of the equation, which is valid at degenerate parameters too, unlike the one from
    /// fundamental forms (@docarmo1976 section 3.2).
    pub(super) fn normal_derivative(&self, p: DVec3, normal: DVec3, tangent: DVec3) -> DVec3 {
        let slope = self.gradient(p).length();
        if slope == 0.0 {
            return DVec3::ZERO;
        }
        let turned = DVec3::new(2.0 * tangent.x, 2.0 * tangent.y, -2.0 * self.alpha * tangent.z) / slope;
        turned - normal * normal.dot(turned)
    }
}

/// `o + t d` with one rounding per coordinate.
pub(super) fn point_on_ray(o: DVec3, d: DVec3, t: f64) -> DVec3 {
    DVec3::new(t.mul_add(d.x, o.x), t.mul_add(d.y, o.y), t.mul_add(d.z, o.z))
}

/// Roots of `a t^2 + 2 half t + c` without cancellation (@higham2002 section 1.8).
fn stable_roots(a: f64, half: f64, c: f64, discriminant: f64) -> Option<[f64; 2]> {
    if !(discriminant >= 0.0) {
        return None;
    }
    let q = -(half + discriminant.sqrt().copysign(half));
    Some(if q == 0.0 { [0.0, 0.0] } else { [q / a, c / q] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_sphere() -> QuadricOfRevolution {
        QuadricOfRevolution::new([-1.0, 0.0, 1.0], 0.0, [-1.0, 1.0], 1.0)
    }

    fn cone() -> QuadricOfRevolution {
        QuadricOfRevolution::new([1.0, 0.0, 0.0], 1.0, [0.0, 1.0], 1.0)
    }

    #[test]
    fn sphere_from_a_million_radii_is_hit_where_it_is() {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        let origin = DVec3::new(0.0, 0.5, 0.0) - direction * 1e6;
        let [Some(first), Some(second)] = unit_sphere().crossings(&Ray::new(origin, direction)) else {
            panic!("two roots")
        };
        // Half the chord at height 1/2 is sqrt(3)/2; the origin rounds to 1e-10.
        let half_chord = 0.75_f64.sqrt();
        assert!((first.t - (1e6 - half_chord)).abs() < 3e-10);
        assert!((second.t - (1e6 + half_chord)).abs() < 3e-10);
        assert!((first.p.length() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn every_line_steeper_than_a_cone_meets_it_even_through_the_apex() {
        for k in 0..1000 {
            // Directions with |horizontal| < |vertical|, apex at (0, 0, 1), one rounding away at most.
            let phi = f64::from(k) * 0.7;
            let d = DVec3::new(0.5 * phi.cos(), 0.7 * phi.sin(), -1.0 - 0.001 * f64::from(k));
            let origin = DVec3::Z - d * 1.7;
            let hits = cone().crossings(&Ray::new(origin, d));
            let hit = hits[0].expect("the apex");
            assert!((hit.p - DVec3::Z).length() < 1e-14, "{hit:?}");
        }
    }

    #[test]
    fn distant_ray_close_to_a_ruling_is_not_dropped() {
        // Its exact root, by rational arithmetic. The value at the origin is 1.5e-8 instead of less than 0.
        let origin = DVec3::new(2_507.112_853_978_076_6, -9_680.726_832_660_508, -9_999.104_343_014_389);
        let ray = Ray::new(origin, DVec3::new(-0.250_708_669_415_549_76, 0.968_062_582_212_474_9, 1.0));
        let hits: Vec<_> = cone().crossings(&ray).into_iter().flatten().collect();
        assert!(hits.iter().any(|hit| (hit.p.z - 0.973_886).abs() < 1e-3), "{hits:?}");
    }

    #[test]
    fn signs_dismiss_only_rays_without_crossings() {
        let hyperboloid = QuadricOfRevolution::new([0.5, 0.0, 1.0], 0.0, [-1.0, 1.0], 1.5_f64.sqrt());
        let paraboloid = QuadricOfRevolution::new([0.0, 1.0, 0.0], 0.0, [0.0, 1.0], 1.0);
        let mut dismissed = 0;
        for quadric in [unit_sphere(), cone(), hyperboloid, paraboloid] {
            for k in 0..100_000 {
                let wave = |a: f64| (a * f64::from(k)).sin();
                let target = DVec3::new(wave(0.31), wave(0.77), wave(1.13));
                let away = DVec3::new(wave(1.9), wave(2.3), wave(2.9));
                // From the surface, from near and from afar; half of them away from it.
                let distance = [1e-3, 1.0, 30.0, 1e4, 1e7][k as usize % 5];
                let direction = if k % 2 == 0 { away } else { -away };
                let ray = Ray::new(target + away * distance, direction);
                if quadric.is_left_by(&ray) {
                    dismissed += 1;
                    assert_eq!(quadric.roots_ahead(&ray).iter().flatten().count(), 0, "{ray:?}");
                }
            }
        }
        assert!(dismissed > 50_000, "{dismissed}");
    }

    #[test]
    fn ray_along_a_ruling_gives_no_nan() {
        let ruling = Ray::new(DVec3::new(1.0, 0.0, 0.0), DVec3::new(-1.0, 0.0, 1.0));
        for hit in cone().crossings(&ruling).into_iter().flatten() {
            assert!(hit.t > 0.0 && cone().value(hit.p).abs() < 1e-14);
        }
    }

    #[test]
    fn ray_that_turns_away_from_afar_is_dropped() {
        assert!(unit_sphere().crossings(&Ray::new(DVec3::X * 1e9, DVec3::X)).iter().all(Option::is_none));
        assert!(unit_sphere().crossings(&Ray::new(DVec3::X * 1e9, DVec3::Y)).iter().all(Option::is_none));
    }
}
