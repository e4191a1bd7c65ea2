//! The one root of a map of the square that is certified to have one at most.
//!
//! A certificate says that the simplified Newton step, with the Jacobian (a, b) of one place, contracts by q < 1.
//! Projected on the square it still does, so that its fixed point is the only root, or proof that there is none
//! (@pumberger2010 theorem 3.2.3.1). Steps are taken with the true Jacobian as long as they do better.

use glanz_math::DVec2;

use super::search::cross;

/// Times the noise that a place with the ray within rounding may be beside it: that of both leaves that have a border
/// there.
const MET: f64 = 2.0;

/// Relative error of a determinant's terms and of what is made of it.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Moves by less than rounding before a place is believed not to be met.
const STUCK: usize = 3;

/// A map of (s, t) in [-1, 1]^2 to the plane across a ray.
pub(super) trait Map {
    /// Value and derivatives.
    fn jet(&self, x: DVec2) -> Jet;
    /// Weight that the value has been multiplied by.
    fn weight(&self, x: DVec2) -> f64;
}

/// Value of a map and its derivatives by s and t.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) f: DVec2,
    pub(super) fs: DVec2,
    pub(super) ft: DVec2,
}

impl Jet {
    /// What Newton's method subtracts.
    #[inline(always)]
    pub(super) fn newton_step(&self) -> DVec2 {
        DVec2::new(cross(self.f, self.ft), cross(self.fs, self.f)) / cross(self.fs, self.ft)
    }
}

/// That the step with the Jacobian (a, b) contracts by q, in the Euclidean or the maximum norm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certificate {
    pub(super) a: DVec2,
    pub(super) b: DVec2,
    pub(super) q: f64,
}

impl Certificate {
    /// Whether the value `f` at `x`, a place of the square, proves that there is no root in it. `f` has been multiplied by
    /// `weight`; `per` is the inverse of the determinant.
    #[inline(always)]
    pub(super) fn excludes(&self, x: DVec2, f: DVec2, weight: f64, per: f64, limits: &Limits) -> bool {
        let f = f / weight;
        let simple = DVec2::new(cross(f, self.b), cross(self.a, f)) * per;
        let blur = self.blur(per, limits) / weight;
        // The root lies in a ball of that radius around the end of the simplified step.
        let ball = simple.length() * self.q / (1.0 - self.q);
        (x - simple).abs().max_element() > 1.0 + ball + blur.max_element()
    }

    /// By how much rounding may move a root.
    #[inline(always)]
    pub(super) fn blur(&self, per: f64, limits: &Limits) -> DVec2 {
        DVec2::new(self.b.length(), self.a.length()) * (2.0 * limits.noise * limits.weights[1] * per.abs())
    }
}

/// What is known about the values of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Metres that rounding may move a point of the surface across the ray.
    pub(super) noise: f64,
    /// A linear step of length h is off by at most `bend` h^2.
    pub(super) bend: f64,
    /// Bounds on the weight.
    pub(super) weights: [f64; 2],
    /// Steps after which it gives up.
    pub(super) steps: usize,
}

impl Limits {
    /// Whether the end of a step needs no look: its errors by curvature and by rounding are below the noise. `unit` is the
    /// half size of the square that `bend` is about, by the parameters of the step.
    #[inline(always)]
    pub(super) fn end_with(&self, step: DVec2, unit: DVec2, jet: &Jet) -> bool {
        let noise = self.noise * self.weights[0];
        let (length_squared, det) = (step.length_squared(), cross(jet.fs, jet.ft));
        let (s2, t2) = (jet.fs.length_squared(), jet.ft.length_squared());
        // Seen edge-on, the determinant cancels: what is left of its digits is what the step is worth.
        let rounded = ROUNDED * ROUNDED * s2 * t2 * (s2 + t2) * length_squared;
        self.bend * (step / unit).length_squared() <= noise && rounded <= noise * noise * det * det
    }
}

/// A root in (s, t), and by how much rounding may move it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: DVec2,
    pub(super) blur: DVec2,
}

/// The steps did not end.
#[derive(Debug)]
pub(super) struct GaveUp;

/// The root of a certified map, if it has one.
#[inline(always)]
pub(super) fn contract(
    map: &impl Map,
    certificate: &Certificate,
    limits: &Limits,
    start: DVec2,
) -> Result<Option<Place>, GaveUp> {
    let &Certificate { a, b, q } = certificate;
    let per = 1.0 / cross(a, b);
    let ball = q / (1.0 - q);
    let blur = certificate.blur(per, limits);
    let found = |at: DVec2| Ok(Some(Place { at, blur }));
    let mut x = start.clamp(DVec2::NEG_ONE, DVec2::ONE);
    let mut last = f64::INFINITY;
    let mut trusted = true;
    let mut stuck = 0;
    for _ in 0..limits.steps {
        let jet = map.jet(x);
        let simple = DVec2::new(cross(jet.f, b), cross(a, jet.f)) * per;
        let length = simple.length();
        // The root lies in a ball of that radius around the end of the simplified step.
        if (x - simple).abs().max_element() > 1.0 + length * ball + blur.max_element() {
            return Ok(None);
        }
        let newton = jet.newton_step();
        // Once a step has not contracted, only simplified ones, which must: taken in turn they may go round.
        trusted &= length < 0.75 * last && newton.is_finite();
        last = length;
        let step = if trusted { newton } else { simple };
        let next = (x - step).clamp(DVec2::NEG_ONE, DVec2::ONE);
        if trusted && next == x - step && limits.end_with(step, DVec2::ONE, &jet) {
            return found(next);
        }
        if (next - x).abs().cmpgt(blur).any() {
            x = next;
            continue;
        }
        // As near as rounding tells, or held by the border.
        if is_met(map, limits, x) {
            return found(x);
        }
        let far = simple.abs().cmpgt(blur * (2.0 / (1.0 - q))).any();
        if !far {
            // Seen edge-on, a root that rounding puts beyond the border is beside it by much more than across it.
            let nearest = nearest_on_border(map, x, jet);
            if is_met(map, limits, nearest) {
                return found(nearest);
            }
            stuck += 1;
            if next != x && stuck < STUCK {
                x = next;
                continue;
            }
        }
        // Newton's method may be held where the contraction is not.
        let next = (x - simple).clamp(DVec2::NEG_ONE, DVec2::ONE);
        if (next - x).abs().cmple(blur).all() {
            return Ok(None);
        }
        x = next;
        trusted = false;
    }
    Err(GaveUp)
}

/// Whether the ray passes the place within rounding.
#[inline(always)]
fn is_met(map: &impl Map, limits: &Limits, x: DVec2) -> bool {
    map.jet(x).f.length() <= MET * limits.noise * map.weight(x)
}

/// The place on the border nearest to the ray, seen along it, from `x` on that border.
#[inline(always)]
fn nearest_on_border(map: &impl Map, mut x: DVec2, mut jet: Jet) -> DVec2 {
    for _ in 0..2 {
        let shift = |f: DVec2, along: DVec2| f.dot(along) / along.length_squared();
        if x.x.abs() == 1.0 {
            x.y = (x.y - shift(jet.f, jet.ft)).clamp(-1.0, 1.0);
        } else if x.y.abs() == 1.0 {
            x.x = (x.x - shift(jet.f, jet.fs)).clamp(-1.0, 1.0);
        }
        jet = map.jet(x);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x - p) + bend (y^2, x^2), whose Jacobian at the centre is 1.
    struct Bent {
        root: DVec2,
        bend: f64,
    }

    impl Map for Bent {
        fn jet(&self, x: DVec2) -> Jet {
            let bent = |x: DVec2| x + self.bend * DVec2::new(x.y * x.y, x.x * x.x);
            Jet {
                f: bent(x) - bent(self.root),
                fs: DVec2::new(1.0, 2.0 * self.bend * x.x),
                ft: DVec2::new(2.0 * self.bend * x.y, 1.0),
            }
        }

        fn weight(&self, _: DVec2) -> f64 {
            1.0
        }
    }

    #[test]
    fn no_root_inside_is_excluded_whatever_the_weight() {
        let limits = Limits { noise: 1e-15, bend: f64::INFINITY, weights: [0.25, 4.0], steps: 200 };
        for k in 0..20_000 {
            let turn = |a: f64| 2.0 * (f64::from(k) * a).fract() - 1.0;
            let (bend, weight) = (0.2 * (1.0 + turn(0.377)), 4.0_f64.powf(turn(0.219)));
            // Some of them next to the border.
            let root = DVec2::new(1.0 - 1e-3 * (1.0 + turn(0.618)).powi(3), turn(0.733));
            let map = Bent { root, bend };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * bend };
            let x = DVec2::new(turn(0.541), turn(0.127));
            let excluded = certificate.excludes(x, map.jet(x).f * weight, weight, 1.0, &limits);
            assert!(!excluded, "{root} {bend} {weight} from {x}");
        }
        let map = Bent { root: DVec2::new(1.2, 0.0), bend: 0.05 };
        let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 0.1 };
        assert!(certificate.excludes(DVec2::X, map.jet(DVec2::X).f * 3.0, 3.0, 1.0, &limits));
    }

    #[test]
    fn root_inside_is_found_and_one_outside_is_not() {
        let limits = Limits { noise: 1e-15, bend: f64::INFINITY, weights: [1.0; 2], steps: 200 };
        for bend in [0.0, 0.1, 0.3, 0.42] {
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 2.0 * bend };
            for k in 0..400 {
                // Outside, the nearest place of the square is no root: nothing may be invented.
                let angle = 2.4 * f64::from(k);
                let root = 1.7 * f64::from(k) / 400.0 * DVec2::new(angle.cos(), angle.sin());
                let map = Bent { root, bend };
                let answer = contract(&map, &certificate, &limits, DVec2::ZERO).unwrap();
                if root.abs().max_element() <= 1.0 {
                    assert!(answer.unwrap().at.distance(root) < 1e-14, "{root} {bend}");
                } else {
                    assert!(answer.is_none(), "{root} {bend}");
                }
            }
        }
    }

    #[test]
    fn root_on_the_border_is_found_whatever_rounding_does() {
        let limits = Limits { noise: 1e-12, bend: f64::INFINITY, weights: [1.0; 2], steps: 200 };
        for off in [-1e-12, -1e-13, 0.0, 1e-13, 1e-12] {
            let map = Bent { root: DVec2::new(1.0 + off, 0.3), bend: 0.2 };
            let certificate = Certificate { a: DVec2::X, b: DVec2::Y, q: 0.4 };
            let place = contract(&map, &certificate, &limits, DVec2::ZERO).unwrap().unwrap();
            assert!(place.at.distance(map.root) < 4e-12 && place.at.x <= 1.0);
        }
    }
}
