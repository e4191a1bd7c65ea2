//! Bernstein polynomials in one variable, summed, differentiated and cut.

use std::ops::Range;

use glanz_math::glam::DVec4;

/// n over k, exact below 2^53.
pub(super) fn binomial(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    // Every partial product is a binomial coefficient itself, so that the division leaves no rest.
    (0..k.min(n - k)).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
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
pub(super) fn mix(a: DVec4, b: DVec4, t: f64) -> DVec4 {
    a * (1.0 - t) + b * t
}

/// Control points of the parts of a curve before and after `t`.
pub(super) fn split(points: &[DVec4], t: f64) -> (Vec<DVec4>, Vec<DVec4>) {
    let mut rest = points.to_vec();
    let (mut before, mut after) = (Vec::with_capacity(rest.len()), Vec::with_capacity(rest.len()));
    while let (Some(first), Some(last)) = (rest.first(), rest.last()) {
        before.push(*first);
        after.push(*last);
        rest = rest.windows(2).map(|p| mix(p[0], p[1], t)).collect();
    }
    after.reverse();
    (before, after)
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
