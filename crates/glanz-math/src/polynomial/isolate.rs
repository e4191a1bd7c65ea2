//! Isolation of all real roots in an interval.

use std::ops::{ControlFlow, Deref};

use super::monotone::{adaptive_value, refine, solve};
use crate::rounding::gamma;

/// Largest degree of polynomials for [`roots`].
pub const MAX_DEGREE: usize = 8;

/// Largest number of roots plus the two ends of the interval.
const CAPACITY: usize = MAX_DEGREE + 2;

/// Real roots in ascending order, as a slice.
#[derive(Clone, Copy, Debug)]
pub struct Roots {
    pub(super) values: [f64; CAPACITY],
    pub(super) count: usize,
}

impl Roots {
    pub(super) const NONE: Self = Self { values: [0.0; CAPACITY], count: 0 };

    pub(super) fn push(&mut self, value: f64) {
        if let Some(next) = self.values.get_mut(self.count) {
            *next = value;
            self.count += 1;
        }
    }
}

impl Deref for Roots {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        self.values.get(..self.count).unwrap_or(&[])
    }
}

/// The roots of `sum c_i t^i` in the closed interval from `low` to `high`, ascending.
///
/// `coefficients`: N = degree + 1 values in ascending order, leading zeros allowed. The result is empty for the zero polynomial, if
/// an argument is not finite, and if `low > high`.
///
/// *Roots* are the points where the exact polynomial with these coefficients changes sign or is zero, as decided in twice the
/// working precision. Values whose sign is uncertain even then count as zero, so that a root where the polynomial only touches
/// zero is found. Each root is found once.
///
/// *Missed roots.* A pair of roots between which the exact polynomial is smaller than the square of the unit roundoff, relative to
/// `sum |c_i t^i|`, may be found as one root. Critical points are accurate only to `u sum |c_i t^i| / |p''|`, so that in clusters
/// of three and more roots, pairs closer than about the square root of the unit roundoff (1e-8 of the distance of the cluster
/// from 0) may be found as one root or not at all.
///
/// *Accuracy.* A root is accurate to 2 units in the last place, or to the distance over which the exact polynomial is below twice
/// the working precision if that is larger. It is a root of the given coefficients: shift the origin of t into the interval
/// first, so that their digits are significant.
///
/// *Method.* The sign changes of the Bernstein coefficients bound the number of roots. Intervals without sign changes are dropped,
/// those with one sign change have one root, others are halved. Intervals that stay undecided because of rounding are divided at
/// the roots of the derivatives. Roots are refined by Newton's method in a bracket, finally in twice the precision.
///
/// # Source
/// @lane1981 for the subdivision, @yuksel2022 for the division at critical points and the bracketed step, @graillat2009 for the
/// precision; departure: signs that are uncertain in working precision are decided by compensated arithmetic.
#[must_use]
pub fn roots<const N: usize>(coefficients: &[f64; N], low: f64, high: f64) -> Roots {
    let mut roots = Roots::NONE;
    let _: ControlFlow<()> = visit_roots(coefficients, low, high, |t| {
        roots.push(t);
        ControlFlow::Continue(())
    });
    roots
}

/// Passes the roots of [`roots`] to `visit` in ascending order until it breaks, and returns the break value.
///
/// The digits of a root do not depend on whether later ones are visited.
pub fn visit_roots<const N: usize, B>(
    coefficients: &[f64; N],
    low: f64,
    high: f64,
    visit: impl FnMut(f64) -> ControlFlow<B>,
) -> ControlFlow<B> {
    const { assert!(N >= 1 && N <= MAX_DEGREE + 1) };
    let valid =
        low.is_finite() && high.is_finite() && low <= high && coefficients.iter().all(|c| c.is_finite());
    let Some(last) = coefficients.iter().rposition(|&c| c != 0.0).filter(|&last| valid && last > 0) else {
        return ControlFlow::Continue(());
    };
    let mut p = *coefficients;
    scale_to_one(&mut p);
    let (bernstein, error) = to_bernstein(&p, low, high);
    let mut search = RootSearch { p, last, error, previous: f64::NEG_INFINITY, visit };
    let ends = [low, high].map(|t| (t, adaptive_value(&search.p, t).sign()));
    search.interval(&bernstein, ends, MAX_SPLITS)
}

/// Number of halvings of an interval before it is divided at critical points.
const MAX_SPLITS: u32 = 16;

/// Bernstein coefficients of a polynomial on [low, high], and a bound on the error of each, which is valid for [`MAX_SPLITS`]
/// halvings.
///
/// The shift by Horner's rule, scaling and Pascal's sums have fewer than 4 n + 8 roundings of sums below
/// `sum |c_i| (|low| + high - low)^i`; each halving adds n roundings of the largest coefficient.
fn to_bernstein<const N: usize>(p: &[f64; N], low: f64, high: f64) -> ([f64; N], f64) {
    let (mut b, width) = (*p, high - low);
    let reach = low.abs() + width;
    let size = p.iter().rev().fold(0.0, |size, c| size * reach + c.abs());
    for m in 0..N {
        for l in (m..N - 1).rev() {
            b[l] += low * b[l + 1];
        }
    }
    // Division by the binomials, after which Pascal's sums are the coefficients.
    let (mut power, mut binomial) = (1.0, 1.0);
    for (i, c) in b.iter_mut().enumerate() {
        *c *= power / binomial;
        power *= width;
        binomial *= (N - 1 - i) as f64 / (i + 1) as f64;
    }
    for j in 1..N {
        for k in (j..N).rev() {
            b[k] += b[k - 1];
        }
    }
    let roundings = (N as u32 - 1) * (4 + MAX_SPLITS) + 8;
    (b, gamma(roundings) * size)
}

/// An end of an interval and the sign of the polynomial there.
type Endpoint = (f64, i8);

/// A search for roots by subdivision.
struct RootSearch<const N: usize, F> {
    p: [f64; N],
    /// Degree.
    last: usize,
    /// Error of a Bernstein coefficient.
    error: f64,
    /// The previous root.
    previous: f64,
    visit: F,
}

impl<const N: usize, B, F: FnMut(f64) -> ControlFlow<B>> RootSearch<N, F> {
    /// Visits the roots in an interval with the Bernstein coefficients `b`.
    fn interval(&mut self, b: &[f64; N], [low, high]: [Endpoint; 2], splits: u32) -> ControlFlow<B> {
        if low.1 == 0 || high.1 == 0 {
            return self.by_derivatives(low.0, high.0);
        }
        let mut changes = 0;
        let mut crossing = 0;
        let mut sign = low.1;
        let mut is_certain = true;
        for (i, &c) in b.iter().enumerate().take(N - 1).skip(1) {
            is_certain &= c.abs() > self.error;
            let next = if c > 0.0 { 1 } else { -1 };
            if next != sign {
                (changes, crossing, sign) = (changes + 1, i - 1, next);
            }
        }
        if high.1 != sign {
            (changes, crossing) = (changes + 1, N - 2);
        }
        if is_certain && changes == 0 {
            return ControlFlow::Continue(());
        }
        if is_certain && changes == 1 {
            return self.single(b, [low, high], crossing);
        }
        if splits == 0 {
            return self.by_derivatives(low.0, high.0);
        }
        let middle = 0.5 * low.0 + 0.5 * high.0;
        let (left, right) = halve(b);
        let middle = (middle, adaptive_value(&self.p, middle).sign());
        self.interval(&left, [low, middle], splits - 1)?;
        self.interval(&right, [middle, high], splits - 1)
    }

    /// Visits the only root of an interval, searched from the zero of the control polygon after the coefficient `crossing`.
    fn single(&mut self, b: &[f64; N], [low, high]: [Endpoint; 2], crossing: usize) -> ControlFlow<B> {
        let (before, after) = (b[crossing], b[(crossing + 1).min(N - 1)]);
        let fraction = (crossing as f64 + before / (before - after)) / (N - 1) as f64;
        let start = low.0 + (high.0 - low.0) * fraction;
        let start = if start > low.0 && start < high.0 { start } else { 0.5 * low.0 + 0.5 * high.0 };
        let p = self.p.get(..=self.last).unwrap_or(&[]);
        let t = refine(p, low.0, high.0, low.1, start, &adaptive_value);
        self.emit(t)
    }

    /// Visits the roots in an interval by dividing it at critical points.
    fn by_derivatives(&mut self, low: f64, high: f64) -> ControlFlow<B> {
        let roots = solve(self.p.get(..=self.last).unwrap_or(&[]), low, high);
        roots.iter().try_for_each(|&t| self.emit(t))
    }

    /// Visits the root `t`, unless it equals the previous one up to its last digits: neighbouring intervals share an end.
    fn emit(&mut self, t: f64) -> ControlFlow<B> {
        if t <= self.previous + 2.0 * f64::EPSILON * self.previous.abs() {
            return ControlFlow::Continue(());
        }
        self.previous = t;
        (self.visit)(t)
    }
}

/// Bernstein coefficients of both halves.
///
/// # Source
/// @farin2002 section 4.3 (de Casteljau).
fn halve<const N: usize>(b: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut left, mut right) = (*b, *b);
    for m in 1..N {
        left[m - 1] = right[0];
        for k in 0..N - m {
            right[k] = 0.5 * (right[k] + right[k + 1]);
        }
    }
    left[N - 1] = right[0];
    (left, right)
}

/// Multiplies all coefficients by the same power of two so that the largest lies in [1, 2).
///
/// Exact, and keeps products of them away from overflow and underflow.
fn scale_to_one(coefficients: &mut [f64]) {
    let largest = coefficients.iter().fold(0.0_f64, |a, c| a.max(c.abs()));
    let exponent = i32::try_from((largest.to_bits() >> 52) & 0x7ff).unwrap_or(0) - 1023;
    // In two steps: the power of two for the smallest numbers would overflow.
    let half = exponent / 2;
    let (first, second) = (2.0_f64.powi(-half), 2.0_f64.powi(half - exponent));
    for c in coefficients {
        *c = *c * first * second;
    }
}

#[cfg(test)]
#[path = "isolate_tests.rs"]
mod tests;
