//! Cumulative distributions of B-splines, piece by piece, and their inversion.

use crate::basis::{BELOW_ONE, KnotVector, ORDER};

/// Most coefficients of a piece: one degree above the highest of the B-splines.
const MOST: usize = ORDER + 1;

/// The distribution functions of all B-splines of a knot vector, each divided by its integral.
///
/// On a segment they are polynomials of one degree more than the B-splines; in Bernstein form their coefficients do not
/// decrease, so that rounding cannot make them fall.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pieces {
    /// Coefficients of a piece, degree + 2.
    count: usize,
    /// Pieces of a function, degree + 1; those on empty segments are constant.
    pieces: usize,
    /// By function, piece, coefficient.
    coefficients: Vec<f64>,
}

impl Pieces {
    pub(crate) fn new(knots: &KnotVector) -> Self {
        let d = knots.degree();
        let (count, pieces) = (d + 2, d + 1);
        let t = knots.knots();
        let mut coefficients = Vec::with_capacity(knots.len() * pieces * count);
        for j in 0..knots.len() {
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

    /// The point of the support of function `j` up to which its share `xi` lies; below the end of the support.
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

    /// The share of function `j` that lies below `x`.
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

/// The value alone, of any number of coefficients up to the most.
fn value(c: &[f64], s: f64) -> f64 {
    let mut w = [0.0; MOST];
    w[..c.len()].copy_from_slice(c);
    for r in 1..c.len() {
        for i in 0..c.len() - r {
            w[i] += s * (w[i + 1] - w[i]);
        }
    }
    w[0]
}

/// Where in [0, 1] the rising polynomial with Bernstein coefficients `c` reaches `y`, for c first <= y < c last.
#[inline]
fn solve(c: &[f64], y: f64) -> f64 {
    match *c {
        [c0, c1] => (y - c0) / (c1 - c0),
        [c0, c1, c2] => {
            let (a, b, g) = (c2 - 2.0 * c1 + c0, c1 - c0, y - c0);
            // The root in the form that does not cancel: b is not negative.
            if g <= 0.0 { 0.0 } else { g / (b + (b * b + a * g).max(0.0).sqrt()) }
        }
        // By length, so that the loops have known ends.
        [_, _, _, _] => solve_by_newton::<4>(c, y),
        [_, _, _, _, _] => solve_by_newton::<5>(c, y),
        [_, _, _, _, _, _] => solve_by_newton::<6>(c, y),
        [_, _, _, _, _, _, _] => solve_by_newton::<7>(c, y),
        [_, _, _, _, _, _, _, _] => solve_by_newton::<8>(c, y),
        _ => solve_by_newton::<MOST>(c, y),
    }
}

/// Newton's method, kept between points on both sides of the root by bisection; `c` has N coefficients.
fn solve_by_newton<const N: usize>(c: &[f64], y: f64) -> f64 {
    let Ok(c) = <&[f64; N]>::try_from(c) else { return 0.0 };
    let rise = y - c[0];
    if rise <= 0.0 {
        return 0.0;
    }
    let whole = c[N - 1] - c[0];
    // Beginnings flat as a power are the first piece of a function: exact for the last function of all, right of the root
    // for the others.
    let mut s =
        if c[N - 2] - c[0] < 0.5 * whole { (rise / whole).powf(1.0 / (N - 1) as f64) } else { rise / whole };
    let (mut low, mut high) = (0.0, 1.0);
    // Newton's method takes about 5 steps; halving alone would take 53, and more where s is small.
    for _ in 0..200 {
        let (value, slope) = de_casteljau(c, s);
        let error = value - y;
        let newton = s - error / slope;
        // As near as the value can be known. No further step: where the function is flat, rounding would make it a long one.
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
