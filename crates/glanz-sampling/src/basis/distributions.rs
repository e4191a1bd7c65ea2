//! Cumulative distribution functions of B-splines and their inversion.

use crate::basis::{BELOW_ONE, ORDER, UnitKnots};

/// Largest number of coefficients of a piece, whose degree is one above that of the B-splines.
const MAX_COEFFICIENTS: usize = ORDER + 1;

/// The distribution functions of all B-splines of a knot vector, each normalized by its integral.
///
/// On a segment they are polynomials of one degree more than the B-splines. Their Bernstein coefficients do not decrease, so that
/// they are monotone despite rounding.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SplineDistributions {
    /// Number of coefficients of a piece, degree + 2.
    count: usize,
    /// Number of pieces of a function, degree + 1; those on empty segments are constant.
    pieces: usize,
    /// Coefficients by function, piece and index.
    coefficients: Vec<f64>,
}

impl SplineDistributions {
    pub(crate) fn new(knots: &UnitKnots) -> Self {
        let d = knots.degree();
        let (count, pieces) = (d + 2, d + 1);
        let t = knots.knots();
        let mut coefficients = Vec::with_capacity(knots.count() * pieces * count);
        for j in 0..knots.count() {
            let begin = coefficients.len();
            let mut sum = 0.0;
            for m in j..=j + d {
                coefficients.push(sum);
                let (a, b) = (t[m], t[m + 1]);
                for k in 0..=d {
                    if a < b {
                        // Bernstein coefficient k of the B-spline: its blossom at d - k times a, k times b.
                        let value = knots.blossoms(m, |r| if r + k <= d { a } else { b })[j + d - m];
                        sum += (b - a) * value / (d + 1) as f64;
                    }
                    coefficients.push(sum);
                }
            }
            for c in &mut coefficients[begin..] {
                *c /= sum;
            }
        }
        Self { count, pieces, coefficients }
    }

    fn function(&self, j: usize) -> std::slice::ChunksExact<'_, f64> {
        let length = self.pieces * self.count;
        self.coefficients[j * length..(j + 1) * length].chunks_exact(self.count)
    }

    /// The point below which the fraction `xi` of function `j` lies, in its support.
    #[inline]
    pub(crate) fn invert(&self, knots: &[f64], j: usize, xi: f64) -> f64 {
        let xi = xi.clamp(0.0, BELOW_ONE);
        for (m, c) in self.function(j).enumerate() {
            if xi < c[self.count - 1] {
                let (a, b) = (knots[j + m], knots[j + m + 1]);
                let s = solve(c, xi);
                return (a + (b - a) * s).min(b.next_down());
            }
        }
        // The last coefficient is sum / sum = 1.
        knots[j + self.pieces].next_down()
    }

    /// The fraction of function `j` below `x`.
    #[inline]
    pub(crate) fn cumulative(&self, knots: &[f64], j: usize, x: f64) -> f64 {
        let mut below = 0.0;
        for (m, c) in self.function(j).enumerate() {
            let (a, b) = (knots[j + m], knots[j + m + 1]);
            if x <= a {
                break;
            }
            below = if x < b { value(c, (x - a) / (b - a)) } else { c[self.count - 1] };
        }
        below
    }
}

/// Value and derivative at `s` of the polynomial with the N Bernstein coefficients `c`.
#[inline]
fn de_casteljau<const N: usize>(c: &[f64; N], s: f64) -> (f64, f64) {
    let mut w = *c;
    for r in 1..N - 1 {
        for i in 0..N - r {
            w[i] += s * (w[i + 1] - w[i]);
        }
    }
    let difference = w[1] - w[0];
    (w[0] + s * difference, (N - 1) as f64 * difference)
}

/// The value of a polynomial with up to [`MAX_COEFFICIENTS`] Bernstein coefficients.
fn value(c: &[f64], s: f64) -> f64 {
    let mut w = [0.0; MAX_COEFFICIENTS];
    w[..c.len()].copy_from_slice(c);
    for r in 1..c.len() {
        for i in 0..c.len() - r {
            w[i] += s * (w[i + 1] - w[i]);
        }
    }
    w[0]
}

/// The point of [0, 1] where the increasing polynomial with Bernstein coefficients `c` equals `y`, for c first <= y < c last.
#[inline]
fn solve(c: &[f64], y: f64) -> f64 {
    match *c {
        [c0, c1] => (y - c0) / (c1 - c0),
        [c0, c1, c2] => {
            let (a, b, g) = (c2 - 2.0 * c1 + c0, c1 - c0, y - c0);
            // The form of the root without cancellation, since b is not negative.
            if g <= 0.0 { 0.0 } else { g / (b + (b * b + a * g).max(0.0).sqrt()) }
        }
        // Constant lengths, so that the loops can be unrolled.
        [_, _, _, _] => solve_by_newton::<4>(c, y),
        [_, _, _, _, _] => solve_by_newton::<5>(c, y),
        [_, _, _, _, _, _] => solve_by_newton::<6>(c, y),
        [_, _, _, _, _, _, _] => solve_by_newton::<7>(c, y),
        [_, _, _, _, _, _, _, _] => solve_by_newton::<8>(c, y),
        _ => solve_by_newton::<MAX_COEFFICIENTS>(c, y),
    }
}

/// Newton's method in a bracket that is halved where a step leaves it; `c` has N coefficients.
fn solve_by_newton<const N: usize>(c: &[f64], y: f64) -> f64 {
    let Ok(c) = <&[f64; N]>::try_from(c) else { return 0.0 };
    let rise = y - c[0];
    if rise <= 0.0 {
        return 0.0;
    }
    let whole = c[N - 1] - c[0];
    // The first piece of a function starts flat, as a power: this start is exact for the last function and right of the root for
    // the others.
    let mut s =
        if c[N - 2] - c[0] < 0.5 * whole { (rise / whole).powf(1.0 / (N - 1) as f64) } else { rise / whole };
    let (mut low, mut high) = (0.0, 1.0);
    // Newton's method takes about 5 steps; halving alone takes 53, and more for small s.
    for _ in 0..200 {
        let (value, slope) = de_casteljau(c, s);
        let error = value - y;
        let newton = s - error / slope;
        // The value is exact up to rounding. Where the function is flat, a further step would be dominated by rounding.
        if error.abs() <= f64::EPSILON * y {
            return s;
        }
        if error > 0.0 {
            high = s;
        } else {
            low = s;
        }
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - s).abs() <= f64::EPSILON * s {
            return next;
        }
        s = next;
    }
    s
}
