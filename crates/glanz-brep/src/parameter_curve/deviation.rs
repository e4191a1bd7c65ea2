//! A certified bound on the distance between an edge and a curve on a carrier.
//!
//! The edge is C(s), a rational spline; the curve on the carrier is S(c(t)). A monotone map s(t) from all of c to all of C makes each point of
//! one correspond to a point of the other, so that `max over t of |S(c(t)) - C(s(t))|` bounds the distance of any point of either curve from
//! the other (it bounds their Fréchet distance). Any monotone map gives a valid bound; a good one makes it sharp:
//!
//! 1. t is divided at the knots of c and where s(t) passes a knot of C. At the former s(t) is a parameter of the point of the edge nearest to S(c(t)); where both curves have the same
//!    parameter, their common knots correspond. In between, s(t) is a polynomial from one end to the other: one step of Newton's method from
//!    the straight line towards `(S(c(t)) - C(s(t))) . C'(s(t)) = 0`, in Taylor coefficients, if it is monotone, which the Bernstein
//!    coefficients of its derivative tell; else the straight line.
//! 2. On an interval, with t linear in x in [-1, 1], the difference D(x) is a smooth function. Its Taylor coefficients at 0 and bounds on the
//!    coefficient of order n over the interval (`jet`) give `|D(x)| <= |p(x)| + r`, with the polynomial p of degree n - 1 and the remainder r,
//!    which falls with the n-th power of the length. |p| is at most the length of its longest Bernstein point, evaluated on eighths.
//! 3. The jets need polynomial pieces. Where c crosses a knot line of a spline carrier, intervals are divided, too; the rest d by which c still passes the knot line, of the size of rounding, or more where c runs along it,
//!    adds `3 L d`, where L bounds the speed of S: both the piece continued over its knot and the true surface move by little more than
//!    `L d` from their common point. (Outside [-1, 1] a polynomial of degree p grows as the Chebyshev polynomial: its derivative by less than
//!    the factor 2 up to `1 + 1 / (2 p^2)`; longer continuations are divided.) Until then, and where weights have no inverse, the distance in
//!    the middle and the farthest that control points and Lipschitz constants let both curves stray from there bound that of any two points.
//! 4. The interval with the largest bound is halved until that exceeds the largest distance of samples by a quarter at most, or the limit of
//!    steps is reached; the bound stays valid.
//!
//! All this is exact arithmetic; a bound on rounding is added: the coordinates of both points come from less than 2^8 operations each
//! on numbers up to the `size` of what is evaluated.

use std::cell::LazyCell;
use std::collections::BinaryHeap;

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::interval::{CurvePair, DeviationInterval, ParameterPair, largest};
use super::size::{OPERATIONS, evaluation_size, spline_size};
use crate::carrier::Carrier;
use crate::curve::local_minimum;
use crate::model::{Curve, SplineCurve};

/// Ratio of bound and sampled distance at which the search ends.
pub(super) const SHARPNESS: f64 = 1.25;

/// Part of the tolerance below which a bound is small enough.
pub(super) const ENOUGH: f64 = 1.0 / 1024.0;

/// Divisions besides those at knots.
const MAX_DIVISIONS: usize = 256;

/// Bound on the distance between the edge and the curve on the carrier, metres. `same_parameter`: whether knots of both
/// correspond. The search ends early below a small part of `tolerance` (metres).
pub(super) fn deviation(
    carrier: &Carrier,
    curve: &SplineCurve<DVec2>,
    edge: &SplineCurve<DVec3>,
    same_parameter: bool,
    tolerance: f64,
) -> f64 {
    let pair = CurvePair { carrier, curve, edge, same_parameter };
    let rounding = gamma(OPERATIONS) * evaluation_size(carrier, curve, spline_size(edge));
    let nodes = pair.with_edge_knots(&pair.nodes(tolerance));
    let mut intervals: BinaryHeap<DeviationInterval> =
        nodes.windows(2).map(|ends| pair.interval([ends[0], ends[1]])).collect();
    let mut sampled = largest(intervals.iter().map(|interval| interval.sampled));
    // Divisions at knot lines are needed before there is anything to sharpen.
    let mut forced_left = MAX_DIVISIONS + 2 * pair.knot_count();
    let mut left = MAX_DIVISIONS + intervals.len();
    let mut result = f64::INFINITY;
    while let Some(widest) = intervals.peek() {
        result = widest.bound + rounding;
        let counter = if widest.forced { &mut forced_left } else { &mut left };
        if *counter == 0 || result <= (SHARPNESS * sampled).max(rounding + ENOUGH * tolerance) {
            break;
        }
        *counter -= 1;
        let DeviationInterval { ends: [from, to], division, .. } = *widest;
        let inside = |pair: &ParameterPair| pair.curve > from.curve && pair.curve < to.curve;
        let halves =
            ParameterPair { curve: 0.5 * (from.curve + to.curve), edge: 0.5 * (from.edge + to.edge) };
        let Some(division) = [division, halves].into_iter().find(inside) else { break };
        let division = pair.closest(division, [from, to]);
        intervals.pop();
        for ends in [[from, division], [division, to]] {
            let interval = pair.interval(ends);
            sampled = sampled.max(interval.sampled);
            intervals.push(interval);
        }
    }
    result
}

impl CurvePair<'_> {
    /// The knots of the curve with the corresponding parameters of the edge, both ascending.
    pub(super) fn nodes(&self, tolerance: f64) -> Vec<ParameterPair> {
        let ([start, end], [first, last]) = (self.curve.domain(), self.edge.domain());
        let scale = (last - first) / (end - start);
        let knots = self.edge.knots().knots();
        let is_common =
            |t: f64| self.same_parameter && knots.get(knots.partition_point(|k| *k < t)) == Some(&t);
        let breaks = self.curve.knots().breaks();
        let whole = LazyCell::new(|| Curve::Spline(self.edge.clone()));
        // No node lies beyond the next common knot, else that one would run back.
        let mut limit = last;
        let limits: Vec<f64> = breaks
            .iter()
            .rev()
            .map(|t| {
                if is_common(*t) {
                    limit = t.clamp(first, last);
                }
                limit
            })
            .collect();
        let mut before = first;
        let node = |(t, limit): (f64, f64)| {
            before = if t == start {
                first
            } else if t == end {
                last
            } else if is_common(t) {
                before.max(limit)
            } else {
                let point = self.point(t);
                let (guess, range) = (first + (t - start) * scale, [before, limit.max(before)]);
                let (near, distance) = local_minimum(|s| second_order(self.edge, s), point, guess, range);
                if distance <= tolerance { near } else { whole.closest_in(point, range) }
            };
            ParameterPair { curve: t, edge: before }
        };
        breaks.into_iter().zip(limits.into_iter().rev()).map(node).collect()
    }

    /// The nodes with those at the knots of the edge between them.
    fn with_edge_knots(&self, nodes: &[ParameterPair]) -> Vec<ParameterPair> {
        let mut all: Vec<ParameterPair> = nodes.first().copied().into_iter().collect();
        for ends in nodes.windows(2) {
            let [mut from, to] = [ends[0], ends[1]];
            while let Some(knot) = self.edge_knot([from, to]) {
                if knot.curve <= from.curve || knot.curve >= to.curve {
                    break;
                }
                from = self.closest(knot, [from, to]);
                all.push(from);
            }
            all.push(to);
        }
        all
    }

    /// The number of knots of both curves and of the carrier.
    fn knot_count(&self) -> usize {
        let of_carrier = match self.carrier {
            Carrier::Spline(spline) => {
                let surface = spline.surface();
                surface.knots_u().knots().len() + surface.knots_v().knots().len()
            }
            _ => 0,
        };
        of_carrier + self.curve.knots().knots().len() + self.edge.knots().knots().len()
    }

    /// A pair inside an interval whose points are nearest: of the edge to that of the curve, or of the curve to that at a knot of the edge.
    fn closest(&self, pair: ParameterPair, [from, to]: [ParameterPair; 2]) -> ParameterPair {
        if to.edge <= from.edge {
            return pair;
        }
        if self.edge.knots().knots().contains(&pair.edge) {
            let on_carrier = |t: f64| {
                let [point, along] = self.on_carrier(t);
                // Without the second derivative: steps of Gauss and Newton.
                [point, along, DVec3::ZERO]
            };
            let query = self.edge.point(pair.edge);
            let (curve, _) = local_minimum(on_carrier, query, pair.curve, [from.curve, to.curve]);
            let inside = curve > from.curve && curve < to.curve;
            return if inside { ParameterPair { curve, ..pair } } else { pair };
        }
        let point = self.point(pair.curve);
        let (edge, _) = local_minimum(|s| second_order(self.edge, s), point, pair.edge, [from.edge, to.edge]);
        ParameterPair { edge, ..pair }
    }
}

/// The point of a spline and its first two derivatives.
fn second_order(curve: &SplineCurve<DVec3>, t: f64) -> [DVec3; 3] {
    let d = curve.derivatives(t, 2);
    [0, 1, 2].map(|k| d.get(k).copied().unwrap_or(DVec3::ZERO))
}
