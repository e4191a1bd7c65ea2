//! Bernstein polynomials in one variable: sums, derivatives, subdivision; shared by patches, splines and trimming curves.
//!
//! Two interpolations from `a` to `b` exist: `a + (b - a) t` in splines keeps equal weights equal, [`mix`] here gives the same
//! bits from both ends.

use std::ops::{Add, Mul, Range};

use glanz_math::glam::DVec4;

/// Largest degree, in one direction, of splines, trimming curves and patches for rays, whose rows of control points have a
/// fixed size. CAD kernels commonly have the same limit.
///
/// Up to this degree the coefficients of a product of two such polynomials, binomials of up to 50, are exact.
pub(crate) const ROW_DEGREE: usize = 25;

/// Largest degree, in one direction, of a patch that is only evaluated, split and converted.
///
/// It is larger than [`ROW_DEGREE`], since some conversions add the two degrees of a patch. The slope of a polynomial and its
/// rounding errors grow with the degree, and binomials overflow at 1030.
pub(crate) const NET_DEGREE: usize = 128;

/// A type of Bernstein coefficients: numbers, points of the plane or of space, homogeneous points.
pub(crate) trait BernsteinCoefficient: Copy + Add<Output = Self> + Mul<f64, Output = Self> {}

impl<T> BernsteinCoefficient for T where T: Copy + Add<Output = T> + Mul<f64, Output = T> {}

/// n over k, exact below 2^53.
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    // Every partial product is a binomial coefficient, so that the division has no remainder.
    (0..k.min(n - k)).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}

/// Row `n` of Pascal's triangle, n + 1 numbers.
pub(crate) fn binomials(n: usize) -> impl Iterator<Item = f64> {
    (0..=n).scan(1.0, move |next, i| {
        let value = *next;
        *next = value * (n - i) as f64 / (i + 1) as f64;
        Some(value)
    })
}

/// The first `N` rows of Pascal's triangle, for tables of constants.
pub(crate) const fn pascal_triangle<const N: usize>() -> [[f64; N]; N] {
    let mut rows = [[0.0; N]; N];
    let mut n = 0;
    while n < N {
        rows[n][0] = 1.0;
        let mut k = 1;
        while k <= n {
            rows[n][k] = rows[n - 1][k - 1] + rows[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    rows
}

/// The falling factorial n (n - 1) ... (n - k + 1).
pub(super) fn falling(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |f, i| f * n.saturating_sub(i) as f64)
}

/// The sum of `binomial(n, i) s^(n - i) t^i p_i`, accumulated point by point.
pub(super) struct BernsteinSum {
    degree: usize,
    s: f64,
    t: f64,
    count: usize,
    binomial: f64,
    power: f64,
    /// The sum, after degree + 1 points were pushed.
    pub(super) sum: DVec4,
}

impl BernsteinSum {
    pub(super) fn new(degree: usize, s: f64, t: f64) -> Self {
        Self { degree, s, t, count: 0, binomial: 1.0, power: 1.0, sum: DVec4::ZERO }
    }

    pub(super) fn push(&mut self, point: DVec4) {
        self.sum = self.sum * self.s + point * (self.binomial * self.power);
        self.binomial *= self.degree.saturating_sub(self.count) as f64;
        self.count += 1;
        self.binomial /= self.count as f64;
        self.power *= self.t;
    }
}

/// The curve with these control points at `t`.
pub(super) fn curve_point(points: &[DVec4], t: f64) -> DVec4 {
    let mut sum = BernsteinSum::new(points.len().saturating_sub(1), 1.0 - t, t);
    points.iter().for_each(|p| sum.push(*p));
    sum.sum
}

/// Derivatives of orders 0 to `order` of the curve with these control points.
pub(super) fn curve_derivatives(points: &[DVec4], t: f64, order: usize) -> Vec<DVec4> {
    let degree = points.len().saturating_sub(1);
    let mut differences = points.to_vec();
    (0..=order)
        .map(|k| {
            let value = curve_point(&differences, t) * falling(degree, k);
            differences = differences.windows(2).map(|p| p[1] - p[0]).collect();
            value
        })
        .collect()
}

/// Linear interpolation `a (1 - t) + b t`; exchanging a with b and t with 1 - t changes no bit where 1 - t is exact.
pub(crate) fn mix<P: BernsteinCoefficient>(a: P, b: P, t: f64) -> P {
    a * (1.0 - t) + b * t
}

/// Control points of the parts of a curve before and after `t`.
///
/// # Source
/// @farin2002 section 4.3 (de Casteljau).
pub(crate) fn split<P: BernsteinCoefficient>(points: &[P], t: f64) -> (Vec<P>, Vec<P>) {
    let (mut before, mut after) = (Vec::with_capacity(points.len()), points.to_vec());
    // Finished points of the second part stay at the end of `after`.
    for left in (0..points.len()).rev() {
        before.extend(after.first());
        for i in 0..left {
            after[i] = mix(after[i], after[i + 1], t);
        }
    }
    (before, after)
}

/// Replaces the control points `row` of a curve by those of its first half, and `later`, of the same length, by those of
/// its second half.
///
/// The additions are symmetric, so that a row and its reverse give the same bits.
pub(crate) fn halve<P: BernsteinCoefficient>(row: &mut [P], later: &mut [P]) {
    let last = row.len().saturating_sub(1);
    for (done, end) in later.iter_mut().rev().enumerate() {
        *end = row[last];
        for i in (done + 1..=last).rev() {
            row[i] = (row[i - 1] + row[i]) * 0.5;
        }
    }
}

/// Control points of the part of a curve over `range`.
///
/// The blossom at k starts and n - k ends of the range, k from 0 to n. Parts have the same bits at a common end.
pub(super) fn part(points: &[DVec4], range: &Range<f64>) -> Vec<DVec4> {
    let mut from_start = points.to_vec();
    let mut part = Vec::with_capacity(points.len());
    while !from_start.is_empty() {
        let mut rest = from_start.clone();
        for _ in 1..from_start.len() {
            rest = rest.windows(2).map(|p| mix(p[0], p[1], range.end)).collect();
        }
        part.extend(rest.first());
        from_start = from_start.windows(2).map(|p| mix(p[0], p[1], range.start)).collect();
    }
    part.reverse();
    part
}

/// Control points of the same curve with its degree raised by one.
pub(super) fn elevate(points: &[DVec4]) -> Vec<DVec4> {
    let count = points.len();
    let point = |i: usize| points.get(i).copied().unwrap_or(DVec4::ZERO);
    (0..=count)
        .map(|i| {
            // The ends stay, the others are summed in an order that does not change with reversal.
            if i == 0 {
                return point(0);
            }
            if i == count {
                return point(count - 1);
            }
            (point(i - 1) * i as f64 + point(i) * (count - i) as f64) / count as f64
        })
        .collect()
}

/// The mean of `value(m)` over all pairs of subsets of i and of j out of n elements, with m elements in common.
pub(super) fn mean_over_subsets(n: usize, i: usize, j: usize, value: impl Fn(usize) -> DVec4) -> DVec4 {
    let common = (i + j).saturating_sub(n)..=i.min(j);
    // A single term, as on the borders of a net, must keep its bits.
    if common.start() == common.end() {
        return value(*common.start());
    }
    let sum: DVec4 = common.map(|m| value(m) * (binomial(i, m) * binomial(n - i, j - m))).sum();
    sum / binomial(n, j)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_pascals_triangle_are_their_binomials_exactly() {
        for n in 0..=2 * ROW_DEGREE {
            let row: Vec<f64> = binomials(n).collect();
            assert_eq!(row, (0..=n).map(|k| binomial(n, k)).collect::<Vec<_>>());
            assert_eq!(row.iter().sum::<f64>(), 2.0_f64.powi(n as i32));
        }
    }

    #[test]
    fn rows_of_a_fixed_size_are_large_enough_everywhere() {
        let limits = [crate::freeform::MAX_DEGREE, crate::spline::MAX_DEGREE, crate::trim::MAX_DEGREE];
        assert_eq!(limits, [ROW_DEGREE; 3]);
    }

    #[test]
    fn halves_agree_with_split_and_with_those_of_the_reversed_row() {
        let row = [0.1, 0.7, -0.3, 0.9, 0.2];
        let (mut first, mut second) = (row, [0.0; 5]);
        halve(&mut first, &mut second);
        assert_eq!((first.to_vec(), second.to_vec()), split(&row, 0.5));
        let (mut turned, mut rest) = (row, [0.0; 5]);
        turned.reverse();
        halve(&mut turned, &mut rest);
        turned.reverse();
        rest.reverse();
        assert_eq!((rest, turned), (first, second));
    }
}
