//! Bernstein polynomials in one variable, summed, differentiated and cut: the tools that patches, splines and trimming
//! curves have in common.
//!
//! Splines go from `a` to `b` by their own `a + (b - a) t`, which leaves equal weights as they are; [`mix`] here gives the
//! same bits from both ends.

use std::ops::{Add, Mul, Range};

use glanz_math::glam::DVec4;

/// Largest degree, in one direction, of what has its place in rows of a fixed size: splines, the patches that rays meet
/// and trimming curves. That of the common CAD kernels.
///
/// Up to here the coefficients of a product of two such polynomials, binomials of up to 50, are exact.
pub(crate) const ROW_DEGREE: usize = 25;

/// Largest degree, in one direction, of a patch that is only evaluated, cut and converted.
///
/// That needs no rows of a fixed size, and the degree must be more than [`ROW_DEGREE`] as some conversions add the two
/// of a patch. A limit there is all the same: the slope of a polynomial and its rounding grow with the degree, and
/// binomials leave the range of numbers at 1030.
pub(crate) const NET_DEGREE: usize = 128;

/// What control points can be made of: numbers, points of the plane or of space, homogeneous points.
pub(crate) trait Coefficient: Copy + Add<Output = Self> + Mul<f64, Output = Self> {}

impl<T> Coefficient for T where T: Copy + Add<Output = T> + Mul<f64, Output = T> {}

/// n over k, exact below 2^53.
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    // Every partial product is a binomial coefficient itself, so that the division leaves no rest.
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

/// n (n - 1) ... (n - k + 1).
pub(super) fn falling(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |f, i| f * n.saturating_sub(i) as f64)
}

/// The sum of `binomial(n, i) s^(n - i) t^i p_i`, point by point and without a buffer.
pub(super) struct BernsteinSum {
    degree: usize,
    s: f64,
    t: f64,
    count: usize,
    binomial: f64,
    power: f64,
    /// The sum, once degree + 1 points were pushed.
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

/// `a (1 - t) + b t`; exchanging a with b and t with 1 - t changes no bit where 1 - t is exact.
pub(crate) fn mix<P: Coefficient>(a: P, b: P, t: f64) -> P {
    a * (1.0 - t) + b * t
}

/// Control points of the parts of a curve before and after `t`.
///
/// # Source
/// @farin2002 section 4.3 (de Casteljau).
pub(crate) fn split<P: Coefficient>(points: &[P], t: f64) -> (Vec<P>, Vec<P>) {
    let (mut before, mut after) = (Vec::with_capacity(points.len()), points.to_vec());
    // What is finished of the later part stays at the end.
    for left in (0..points.len()).rev() {
        before.extend(after.first());
        for i in 0..left {
            after[i] = mix(after[i], after[i + 1], t);
        }
    }
    (before, after)
}

/// Replaces the control points `row` of a curve by those of its first half; `later` takes those of the second half and
/// must be as long.
///
/// The additions are symmetric, so that a row and its reverse give the same bits.
pub(crate) fn halve<P: Coefficient>(row: &mut [P], later: &mut [P]) {
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
/// The blossom at k starts and n - k ends of the range, k from 0 to n: parts that meet at a parameter have the same
/// bits there.
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

/// Control points of the same curve, one degree higher.
pub(super) fn elevate(points: &[DVec4]) -> Vec<DVec4> {
    let count = points.len();
    let point = |i: usize| points.get(i).copied().unwrap_or(DVec4::ZERO);
    (0..=count)
        .map(|i| {
            // The ends as they are, the others in an order that reversal keeps.
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

/// The mean of `value(m)` over all ways to mark i and j out of n things, m of them with both marks.
pub(super) fn mean_of_ways(n: usize, i: usize, j: usize, value: impl Fn(usize) -> DVec4) -> DVec4 {
    let ways = (i + j).saturating_sub(n)..=i.min(j);
    // Of a single term, as on the borders of a net, not even the last bit may change.
    if ways.start() == ways.end() {
        return value(*ways.start());
    }
    let sum: DVec4 = ways.map(|m| value(m) * (binomial(i, m) * binomial(n - i, j - m))).sum();
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
    fn halves_are_the_parts_before_and_after_the_middle_and_turn_round_with_the_row() {
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
