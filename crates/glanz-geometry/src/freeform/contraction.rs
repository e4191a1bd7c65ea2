//! The root of a map of the square that is certified to have one root at most.
//!
//! A certificate states that the simplified Newton step, with the Jacobian (a, b) of one point, contracts by q < 1. Clamped
//! to the square it still does, so that its fixed point is either the only root or proof that there is none
//! (@pumberger2010 theorem 3.2.3.1). Steps use the Jacobian of the current point as long as they converge faster;
//! where values take less work than derivatives, the last step uses that of the point before.

use glanz_math::DVec2;

use super::ray_space::cross;

/// Distance from the ray, in units of the noise, within which a point counts as hit: the noise of both leaves at a common border.
/// A proof that there is no root must leave the same room.
pub(super) const HIT_TOLERANCE: f64 = 2.0;

/// Relative error of the terms of a determinant and of a step computed from it.
pub(super) const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Steps shorter than rounding after which a point counts as not hit.
const STUCK: usize = 3;

/// A map of (s, t) in [-1, 1]^2 to the plane across a ray.
pub(super) trait PlanarMap {
    /// Whether `value` takes less work than `jet`.
    const HAS_VALUE: bool = false;

    /// Value and derivatives.
    fn jet(&mut self, x: DVec2) -> PlanarJet;
    /// The value.
    #[inline(always)]
    fn value(&mut self, x: DVec2) -> DVec2 {
        self.jet(x).f
    }
    /// The weight by which the value has been multiplied.
    fn weight(&self, x: DVec2) -> f64;
}

/// Value of a map and its derivatives by s and t.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarJet {
    pub(super) f: DVec2,
    pub(super) fs: DVec2,
    pub(super) ft: DVec2,
}

impl PlanarJet {
    /// The step that Newton's method subtracts.
    #[inline(always)]
    pub(super) fn newton_step(&self) -> DVec2 {
        DVec2::new(cross(self.f, self.ft), cross(self.fs, self.f)) * (1.0 / cross(self.fs, self.ft))
    }
}

/// The proof that the Newton step with the Jacobian (a, b) contracts by q, in the Euclidean or the maximum norm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certificate {
    pub(super) a: DVec2,
    pub(super) b: DVec2,
    pub(super) q: f64,
}

impl Certificate {
    /// Whether the jet at a point `x` of the square proves that the square has no root. The jet has been multiplied by `weight`;
    /// `per` is the inverse of the determinant of (a, b). The certificate must hold in the Euclidean norm, as those of leaves do.
    ///
    /// The simplified step from x ends within q |y - x| of a root y, so that |y - x| is at most its length / (1 - q). By Taylor's
    /// formula J (y - x) = -f - r with |r| <= c |y - x|^2, where c is the curvature bound: Newton's step ends within |J^-1 r| of the
    /// root. That gives a second bound on |y - x|, most often a smaller one. The last bound limits how far beyond the border a step
    /// towards a root of the square may lead.
    #[inline(always)]
    pub(super) fn excludes(
        &self,
        x: DVec2,
        jet: &PlanarJet,
        weight: f64,
        per: f64,
        bounds: &MapBounds,
    ) -> bool {
        let &Self { a, b, q } = self;
        let noise = HIT_TOLERANCE * bounds.noise * bounds.weights[1];
        let simple = DVec2::new(cross(jet.f, b), cross(a, jet.f)) * per;
        let unsure = ((a.x.abs() + a.y.abs()) + (b.x.abs() + b.y.abs())) * (noise * per.abs());
        let mut distance = (simple.length() + unsure) / (weight * (1.0 - q));
        let step = jet.newton_step();
        let per = 1.0 / cross(jet.fs, jet.ft);
        // Squares of the lengths of the rows of J^-1.
        let rows = DVec2::new(jet.ft.length_squared(), jet.fs.length_squared()) * (per * per);
        let (size, length) = ((rows.x + rows.y).sqrt(), step.length());
        let remainder = |distance: f64| bounds.curvature_bound * (distance * distance) + noise;
        for _ in 0..2 {
            let closer = length + size * remainder(distance);
            distance = if closer < distance { closer } else { distance };
        }
        let remainder = remainder(distance);
        let off = rows * (remainder * remainder);
        let beyond = (x - step).abs() - 1.0;
        (beyond.x > 0.0 && beyond.x * beyond.x > off.x) || (beyond.y > 0.0 && beyond.y * beyond.y > off.y)
    }

    /// Bound on the shift of a root by rounding.
    #[inline(always)]
    pub(super) fn uncertainty(&self, per: f64, bounds: &MapBounds) -> DVec2 {
        DVec2::new(self.b.length(), self.a.length()) * (2.0 * bounds.noise * bounds.weights[1] * per.abs())
    }
}

/// Bounds on the values of a map, and on the number of steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapBounds {
    /// Bound on the rounding error of a point of the surface across the ray, metres.
    pub(super) noise: f64,
    /// A linear step of length h is off by at most `curvature_bound` h^2.
    pub(super) curvature_bound: f64,
    /// Bounds on the weight.
    pub(super) weights: [f64; 2],
    /// Largest number of steps.
    pub(super) steps: usize,
}

impl MapBounds {
    /// Whether the end of a step needs no evaluation, since its errors by curvature and by rounding are below the noise.
    /// `unit` is half the size of the square to which `curvature_bound` refers, in the parameters of the step.
    #[inline(always)]
    pub(super) fn end_with(&self, step: DVec2, unit: DVec2, jet: &PlanarJet) -> bool {
        let curved = self.curvature_bound * (step / unit).length_squared();
        self.is_below_noise(curved, step, jet)
    }

    /// The same for a step in (s, t) with the derivatives of a point at the distance `away`: they differ by at most
    /// 2 `curvature_bound` `away`.
    #[inline(always)]
    fn ends_from(&self, step: DVec2, away: f64, jet: &PlanarJet) -> bool {
        let length = step.length();
        let curved = self.curvature_bound * (length * (length + 2.0 * away));
        self.is_below_noise(curved, step, jet)
    }

    /// Whether the error `curved` of a step by curvature, and that by rounding, are below the noise.
    #[inline(always)]
    fn is_below_noise(&self, curved: f64, step: DVec2, jet: &PlanarJet) -> bool {
        let noise = self.noise * self.weights[0];
        let (length_squared, det) = (step.length_squared(), cross(jet.fs, jet.ft));
        let (s2, t2) = (jet.fs.length_squared(), jet.ft.length_squared());
        // In an edge-on view the determinant cancels, and the step has only the digits that remain.
        let rounded = ROUNDED * ROUNDED * s2 * t2 * (s2 + t2) * length_squared;
        curved <= noise && rounded <= noise * noise * det * det
    }

    /// Whether the step after this one is expected to be the last, with the same derivatives: its length is at most c h^2 |J^-1|, and
    /// its error at most 2 c h times that.
    #[inline(always)]
    fn next_ends(&self, step: DVec2, jet: &PlanarJet) -> bool {
        let noise = self.noise * self.weights[0];
        let (length_squared, det) = (step.length_squared(), cross(jet.fs, jet.ft));
        let per = jet.fs.length_squared() + jet.ft.length_squared();
        let curved = 2.0 * (self.curvature_bound * self.curvature_bound);
        let error = curved * curved * (length_squared * length_squared) * length_squared * per;
        error <= noise * noise * (det * det)
    }
}

/// A root in (s, t), and the bound on its shift by rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRoot {
    pub(super) at: DVec2,
    pub(super) uncertainty: DVec2,
}

/// Failure of an iteration: too many steps or cells.
#[derive(Debug)]
pub(super) struct NoConvergence;

/// The root of a certified map, if it has one.
#[inline(always)]
pub(super) fn contract<M: PlanarMap>(
    map: &mut M,
    certificate: &Certificate,
    bounds: &MapBounds,
    start: DVec2,
) -> Result<Option<LocalRoot>, NoConvergence> {
    let &Certificate { a, b, q } = certificate;
    let per = 1.0 / cross(a, b);
    let ball = q / (1.0 - q);
    let uncertainty = certificate.uncertainty(per, bounds);
    let found = |at: DVec2| Ok(Some(LocalRoot { at, uncertainty }));
    let mut x = start.clamp(DVec2::NEG_ONE, DVec2::ONE);
    let mut last = f64::INFINITY;
    let mut trusted = true;
    let mut stuck = 0;
    // The point whose derivatives serve for the next step as well.
    let mut old: Option<(DVec2, PlanarJet)> = None;
    for _ in 0..bounds.steps {
        let from = old.take();
        let jet = match from {
            Some((_, jet)) => PlanarJet { f: map.value(x), ..jet },
            None => map.jet(x),
        };
        let simple = DVec2::new(cross(jet.f, b), cross(a, jet.f)) * per;
        let length = simple.length();
        // The root lies in a ball of this radius around the end of the simplified step.
        if (x - simple).abs().max_element() > 1.0 + length * ball + uncertainty.max_element() {
            return Ok(None);
        }
        let newton = jet.newton_step();
        // After a step that did not contract only simplified ones are taken, which must; in alternation they may cycle.
        trusted &= length < 0.75 * last && newton.is_finite();
        last = length;
        let step = if trusted { newton } else { simple };
        let next = (x - step).clamp(DVec2::NEG_ONE, DVec2::ONE);
        if trusted && next == x - step {
            let away = from.map_or(0.0, |(at, _)| x.distance(at));
            if bounds.ends_from(step, away, &jet) {
                return found(next);
            }
        }
        if (next - x).abs().cmpgt(uncertainty).any() {
            let is_new = M::HAS_VALUE && from.is_none() && trusted && next == x - step;
            old = (is_new && bounds.next_ends(step, &jet)).then_some((x, jet));
            x = next;
            continue;
        }
        // Converged to within rounding, or stopped at the border.
        if is_met(&*map, bounds, x, &jet) {
            return found(x);
        }
        let far = simple.abs().cmpgt(uncertainty * (2.0 / (1.0 - q))).any();
        if !far {
            // In an edge-on view a root that rounding moves beyond the border moves much farther along the border.
            let (nearest, there) = nearest_on_border(map, x, jet);
            if is_met(&*map, bounds, nearest, &there) {
                return found(nearest);
            }
            stuck += 1;
            if next != x && stuck < STUCK {
                x = next;
                continue;
            }
        }
        // Newton's method may stop at the border where the contraction does not.
        let next = (x - simple).clamp(DVec2::NEG_ONE, DVec2::ONE);
        if (next - x).abs().cmple(uncertainty).all() {
            return Ok(None);
        }
        x = next;
        trusted = false;
    }
    Err(NoConvergence)
}

/// Whether the ray passes the point `x`, with this jet, within rounding.
#[inline(always)]
fn is_met(map: &impl PlanarMap, bounds: &MapBounds, x: DVec2, jet: &PlanarJet) -> bool {
    jet.f.length() <= HIT_TOLERANCE * bounds.noise * map.weight(x)
}

/// The point of the border nearest to the projected ray, from `x` on that border; with its jet.
#[inline(always)]
fn nearest_on_border(map: &mut impl PlanarMap, mut x: DVec2, mut jet: PlanarJet) -> (DVec2, PlanarJet) {
    for _ in 0..2 {
        let shift = |f: DVec2, along: DVec2| f.dot(along) / along.length_squared();
        if x.x.abs() == 1.0 {
            x.y = (x.y - shift(jet.f, jet.ft)).clamp(-1.0, 1.0);
        } else if x.y.abs() == 1.0 {
            x.x = (x.x - shift(jet.f, jet.fs)).clamp(-1.0, 1.0);
        }
        jet = map.jet(x);
    }
    (x, jet)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x - p) + c (y^2, x^2) with the curvature c, whose Jacobian at the centre is 1.
    struct CurvedMap {
        root: DVec2,
        curvature: f64,
    }

    impl PlanarMap for CurvedMap {
        fn jet(&mut self, x: DVec2) -> PlanarJet {
            let curved = |x: DVec2| x + self.curvature * DVec2::new(x.y * x.y, x.x * x.x);
            PlanarJet {
                f: curved(x) - curved(self.root),
                fs: DVec2::new(1.0, 2.0 * self.curvature * x.x),
                ft: DVec2::new(2.0 * self.curvature * x.y, 1.0),
            }
        }

        fn weight(&self, _: DVec2) -> f64 {
            1.0
        }
    }

    fn weighted(jet: PlanarJet, weight: f64) -> PlanarJet {
        PlanarJet { f: jet.f * weight, fs: jet.fs * weight, ft: jet.ft * weight }
    }

    #[test]
    fn no_root_inside_is_excluded_whatever_the_weight() {
        let bounded = |curvature_bound: f64| MapBounds {
            noise: 1e-15,
            curvature_bound,
            weights: [0.25, 4.0],
            steps: 200,
        };
        for k in 0..20_000 {
            let turn = |a: f64| 2.0 * (f64::from(k) * a).fract() - 1.0;
            let (curvature, weight) = (0.2 * (1.0 + turn(0.377)), 4.0_f64.powf(turn(0.219)));
            // Some of them next to the border.
            let root = DVec2::new(1.0 - 1e-3 * (1.0 + turn(0.618)).powi(3), turn(0.733));
            let mut map = CurvedMap { root, curvature };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * curvature };
            let x = DVec2::new(turn(0.541), turn(0.127));
            let bounds = bounded(curvature * weight);
            let excluded = certificate.excludes(x, &weighted(map.jet(x), weight), weight, 1.0, &bounds);
            assert!(!excluded, "{root} {curvature} {weight} from {x}");
        }
        // From any point from which a step leaves the square, next to the border as well.
        for (x, curvature) in [(1.2, 0.05), (1.2, 0.25), (1.0 + 1e-9, 0.25)] {
            let mut map = CurvedMap { root: DVec2::new(x, 0.0), curvature };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * curvature };
            let bounds = bounded(3.0 * curvature);
            let jet = weighted(map.jet(DVec2::X), 3.0);
            assert!(certificate.excludes(DVec2::X, &jet, 3.0, 1.0, &bounds), "{x} {curvature}");
        }
    }

    #[test]
    fn root_inside_is_found_and_one_outside_is_not() {
        let bounds =
            MapBounds { noise: 1e-15, curvature_bound: f64::INFINITY, weights: [1.0; 2], steps: 200 };
        for curvature in [0.0, 0.1, 0.3, 0.42] {
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * curvature };
            for k in 0..400 {
                // For a root outside, the nearest point of the square is no root and must not be reported.
                let angle = 2.4 * f64::from(k);
                let root = 1.7 * f64::from(k) / 400.0 * DVec2::new(angle.cos(), angle.sin());
                let mut map = CurvedMap { root, curvature };
                let answer = contract(&mut map, &certificate, &bounds, DVec2::ZERO).unwrap();
                if root.abs().max_element() <= 1.0 {
                    assert!(answer.unwrap().at.distance(root) < 1e-14, "{root} {curvature}");
                } else {
                    assert!(answer.is_none(), "{root} {curvature}");
                }
            }
        }
    }

    /// A [`CurvedMap`] that counts values without derivatives.
    struct CountedMap {
        map: CurvedMap,
        values: usize,
    }

    impl PlanarMap for CountedMap {
        const HAS_VALUE: bool = true;

        fn jet(&mut self, x: DVec2) -> PlanarJet {
            self.map.jet(x)
        }

        fn value(&mut self, x: DVec2) -> DVec2 {
            self.values += 1;
            self.map.jet(x).f
        }

        fn weight(&self, _: DVec2) -> f64 {
            1.0
        }
    }

    #[test]
    fn a_last_step_with_old_derivatives_ends_within_the_noise_of_the_root() {
        let mut values = 0;
        for curvature in [0.01, 0.1, 0.3, 0.42] {
            let bounds =
                MapBounds { noise: 1e-15, curvature_bound: curvature, weights: [1.0; 2], steps: 200 };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * curvature };
            for k in 0..4000 {
                let turn = |a: f64| 2.0 * (f64::from(k) * a).fract() - 1.0;
                let (root, start) =
                    (DVec2::new(turn(0.618), turn(0.733)), DVec2::new(turn(0.541), turn(0.127)));
                let mut map = CountedMap { map: CurvedMap { root, curvature }, values: 0 };
                let found = contract(&mut map, &certificate, &bounds, start).unwrap().unwrap();
                // 1 / |J| of the map is at most 1 / (1 - q).
                assert!(
                    found.at.distance(root) < 4e-15 / (1.0 - certificate.q),
                    "{root} {curvature} from {start}"
                );
                values += map.values;
            }
        }
        assert!(values > 4000, "{values}");
    }

    #[test]
    fn steps_with_derivatives_of_another_point_end_within_the_noise() {
        let noise = 1e-6;
        let mut ended = 0;
        for k in 0..20_000 {
            let turn = |a: f64| 2.0 * (f64::from(k) * a).fract() - 1.0;
            let curvature = 0.2 * (1.0 + turn(0.377));
            let bounds = MapBounds { noise, curvature_bound: curvature, weights: [1.0; 2], steps: 1 };
            let root = 0.5 * DVec2::new(turn(0.618), turn(0.733));
            let around = |exponent: f64, angle: f64| {
                root + 10.0_f64.powf(exponent) * DVec2::from_angle(std::f64::consts::PI * angle)
            };
            let x = around(-3.5 + 1.5 * turn(0.541), turn(0.219));
            let at = around(-2.0 + turn(0.127), turn(0.917));
            let mut map = CurvedMap { root, curvature };
            let jet = PlanarJet { f: map.value(x), ..map.jet(at) };
            let step = jet.newton_step();
            if bounds.ends_from(step, x.distance(at), &jet) {
                ended += 1;
                // The map is quadratic, so that the bound holds up to rounding.
                assert!(map.value(x - step).length() <= noise * (1.0 + 1e-6), "{root} from {x} by {at}");
            }
        }
        assert!(ended > 5000, "{ended}");
    }

    #[test]
    fn root_on_the_border_is_found_whatever_rounding_does() {
        let bounds =
            MapBounds { noise: 1e-12, curvature_bound: f64::INFINITY, weights: [1.0; 2], steps: 200 };
        for off in [-1e-12, -1e-13, 0.0, 1e-13, 1e-12] {
            let mut map = CurvedMap { root: DVec2::new(1.0 + off, 0.3), curvature: 0.2 };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 0.4 };
            let place = contract(&mut map, &certificate, &bounds, DVec2::ZERO).unwrap().unwrap();
            assert!(place.at.distance(map.root) < 4e-12 && place.at.x <= 1.0);
        }
    }
}
