//! All real roots in an interval.

use std::ops::{ControlFlow, Deref};

use super::monotone::{decide, refine, solve};
use crate::rounding::gamma;

/// Largest degree [`roots`] is made for.
pub const MAX_DEGREE: usize = 8;

/// Room for the roots of all degrees up to [`MAX_DEGREE`] and for the two ends of the interval.
const CAPACITY: usize = MAX_DEGREE + 2;

/// Real roots in ascending order; a slice.
#[derive(Clone, Copy, Debug)]
pub struct Roots {
    pub(super) values: [f64; CAPACITY],
    pub(super) count: usize,
}

impl Roots {
    pub(super) const NONE: Self = Self { values: [0.0; CAPACITY], count: 0 };

    pub(super) fn push(&mut self, value: f64) {
        if let Some(place) = self.values.get_mut(self.count) {
            *place = value;
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
/// `coefficients`: N = degree + 1 values in ascending order, leading zeros allowed. The polynomial that is all zero
/// has no root here, and none are looked for if an argument is not finite or `low > high`.
///
/// *What is a root.* Where the exact polynomial with these coefficients changes sign, or is zero, as far as twice the
/// working precision can tell. Where that cannot, the value counts as zero, so that a root that only touches zero
/// appears, and appears once. Each root is found once.
///
/// *What is missed.* A pair of roots so close that the exact polynomial between them differs from zero by less than the
/// square of the unit roundoff, relative to `sum |c_i t^i|`, may come as one root. Critical points are known
/// to `u sum |c_i t^i| / |p''|` only, so that in clusters of three and more, pairs closer than about the square root of
/// the unit roundoff (1e-8 of the cluster's distance from 0) may come as one or not at all.
///
/// *Accuracy.* A root is right to 2 units in the last place, or to the distance over which the exact polynomial does
/// not rise above twice the working precision if that is more. It is a root of the coefficients as given: shift the
/// origin of t into the interval first, so that they carry the digits that matter.
///
/// *How.* The Bernstein coefficients bound the number of roots by their changes of sign. Pieces with none are dropped,
/// those with one hold one root, others are halved. Pieces that stay undecided for rounding are cut at the roots of
/// the derivatives. Roots are refined by Newton's step, kept in a bracket, the last time in twice the precision.
///
/// # Source
/// @lane1981 for the subdivision, @yuksel2022 for the cuts and the bracketed step, @graillat2009 for the precision;
/// departure: signs that plain arithmetic cannot tell are told by the compensated one.
#[must_use]
pub fn roots<const N: usize>(coefficients: &[f64; N], low: f64, high: f64) -> Roots {
    let mut found = Roots::NONE;
    let _: ControlFlow<()> = visit_roots(coefficients, low, high, |t| {
        found.push(t);
        ControlFlow::Continue(())
    });
    found
}

/// Hands the roots of [`roots`], one after the other, to `visit` until that breaks; what it broke with.
///
/// The digits of a root do not depend on whether the later ones are wanted.
pub fn visit_roots<const N: usize, B>(
    coefficients: &[f64; N],
    low: f64,
    high: f64,
    visit: impl FnMut(f64) -> ControlFlow<B>,
) -> ControlFlow<B> {
    const { assert!(N >= 1 && N <= MAX_DEGREE + 1) };
    let sound =
        low.is_finite() && high.is_finite() && low <= high && coefficients.iter().all(|c| c.is_finite());
    let Some(last) = coefficients.iter().rposition(|&c| c != 0.0).filter(|&last| sound && last > 0) else {
        return ControlFlow::Continue(());
    };
    let mut p = *coefficients;
    scale_to_one(&mut p);
    let (bernstein, error) = to_bernstein(&p, low, high);
    let mut search = Search { p, last, error, found: f64::NEG_INFINITY, visit };
    let ends = [low, high].map(|t| (t, decide(&search.p, t).sign()));
    search.piece(&bernstein, ends, MAX_SPLITS)
}

/// How often an interval is halved before the derivatives have to help.
const MAX_SPLITS: u32 = 16;

/// Bernstein coefficients of a polynomial on [low, high], and a bound on the error of each, also after
/// [`MAX_SPLITS`] halvings.
///
/// Shifting by Horner's steps, scaling and Pascal's sums pass fewer than 4 n + 8 roundings of a sum that is below
/// `sum |c_i| (|low| + high - low)^i`; halving adds n of the largest coefficient each time.
fn to_bernstein<const N: usize>(p: &[f64; N], low: f64, high: f64) -> ([f64; N], f64) {
    let (mut b, width) = (*p, high - low);
    let reach = low.abs() + width;
    let size = p.iter().rev().fold(0.0, |size, c| size * reach + c.abs());
    for m in 0..N {
        for l in (m..N - 1).rev() {
            b[l] += low * b[l + 1];
        }
    }
    // Over the binomials, so that Pascal's sums give the coefficients.
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

/// A point and the sign of the polynomial there.
type End = (f64, i8);

struct Search<const N: usize, F> {
    p: [f64; N],
    /// Degree.
    last: usize,
    /// Of a Bernstein coefficient.
    error: f64,
    /// The latest root.
    found: f64,
    visit: F,
}

impl<const N: usize, B, F: FnMut(f64) -> ControlFlow<B>> Search<N, F> {
    /// The roots between the two ends, of which `b` are the Bernstein coefficients.
    fn piece(&mut self, b: &[f64; N], [low, high]: [End; 2], splits: u32) -> ControlFlow<B> {
        if low.1 == 0 || high.1 == 0 {
            return self.by_derivatives(low.0, high.0);
        }
        let mut changes = 0;
        let mut crossing = 0;
        let mut sign = low.1;
        let mut sure = true;
        for (i, &c) in b.iter().enumerate().take(N - 1).skip(1) {
            sure &= c.abs() > self.error;
            let next = if c > 0.0 { 1 } else { -1 };
            if next != sign {
                (changes, crossing, sign) = (changes + 1, i - 1, next);
            }
        }
        if high.1 != sign {
            (changes, crossing) = (changes + 1, N - 2);
        }
        if sure && changes == 0 {
            return ControlFlow::Continue(());
        }
        if sure && changes == 1 {
            return self.single(b, [low, high], crossing);
        }
        if splits == 0 {
            return self.by_derivatives(low.0, high.0);
        }
        let middle = 0.5 * low.0 + 0.5 * high.0;
        let (left, right) = halve(b);
        let middle = (middle, decide(&self.p, middle).sign());
        self.piece(&left, [low, middle], splits - 1)?;
        self.piece(&right, [middle, high], splits - 1)
    }

    /// The only root of a piece, near where the control polygon crosses zero after the coefficient `crossing`.
    fn single(&mut self, b: &[f64; N], [low, high]: [End; 2], crossing: usize) -> ControlFlow<B> {
        let (before, after) = (b[crossing], b[(crossing + 1).min(N - 1)]);
        let share = (crossing as f64 + before / (before - after)) / (N - 1) as f64;
        let start = low.0 + (high.0 - low.0) * share;
        let start = if start > low.0 && start < high.0 { start } else { 0.5 * low.0 + 0.5 * high.0 };
        let p = self.p.get(..=self.last).unwrap_or(&[]);
        let t = refine(p, low.0, high.0, low.1, start, &decide);
        self.report(t)
    }

    fn by_derivatives(&mut self, low: f64, high: f64) -> ControlFlow<B> {
        let found = solve(self.p.get(..=self.last).unwrap_or(&[]), low, high);
        found.iter().try_for_each(|&t| self.report(t))
    }

    /// Pieces share their ends: what is found at one again within its last digits is the same root.
    fn report(&mut self, t: f64) -> ControlFlow<B> {
        if t <= self.found + 2.0 * f64::EPSILON * self.found.abs() {
            return ControlFlow::Continue(());
        }
        self.found = t;
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
    // In two steps: a single power of two cannot undo the smallest numbers.
    let half = exponent / 2;
    let (first, second) = (2.0_f64.powi(-half), 2.0_f64.powi(half - exponent));
    for c in coefficients {
        *c = *c * first * second;
    }
}

#[cfg(test)]
#[path = "isolate_tests.rs"]
mod tests;
