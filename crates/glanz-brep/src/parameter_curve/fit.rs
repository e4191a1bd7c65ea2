//! Projection of an edge onto a carrier by continuation, and cubic splines through projected points.

use glanz_math::{DVec2, DVec3};

use super::deviation::deviation;
use super::interval::largest;
use super::{EdgeParameterCurve, ParameterCurveSource};
use crate::carrier::Carrier;
use crate::error::BrepError;
use crate::model::SplineCurve;

/// Part of the tolerance that a fitted curve may be off the projection of the edge.
const FIT_SHARE: f64 = 0.25;

/// Part of the distance of the edge from the carrier that matters as little.
const STRAY_SHARE: f64 = 1.0 / 16.0;

/// Ratio of deviation and distance of the edge from the carrier at which a better curve is not worth a search.
const ATTAINED: f64 = 1.05;

/// Fewest steps between sampled points; less than a quarter of a turn each on an edge of one turn.
const MIN_STEPS: usize = 9;

/// Steps that are taken if they are not more per piece of the edge than its degree and one: edges may have several turns.
const STEPS: usize = 96;

/// Largest number of halvings of a piece.
const MAX_HALVINGS: u32 = 12;

/// Largest number of pieces.
const MAX_PIECES: usize = 2048;

/// An edge and the carrier onto which it is projected.
pub(super) struct EdgeProjector<'a> {
    pub(super) carrier: &'a Carrier,
    pub(super) edge: &'a SplineCurve<DVec3>,
    pub(super) tolerance: f64,
    /// Projections of points of the edge, from its start to its end.
    pub(super) samples: Vec<DVec2>,
    /// The largest distance of these points from the edge, metres. No curve on the carrier deviates less, as far as they are the nearest
    /// points: on a spline they are local minima, of which others may be nearer.
    pub(super) stray: f64,
}

/// A cubic piece under construction.
struct PieceBuilder {
    knots: Vec<f64>,
    points: Vec<DVec2>,
}

impl<'a> EdgeProjector<'a> {
    pub(super) fn new(carrier: &'a Carrier, edge: &'a SplineCurve<DVec3>, tolerance: f64) -> Self {
        let mut projector = Self { carrier, edge, tolerance, samples: Vec::new(), stray: 0.0 };
        let at = steps(edge);
        // Poles may be at the ends, thus from the inside.
        let mut inner: Vec<DVec2> = Vec::with_capacity(at.len());
        for &t in at.get(1..at.len() - 1).unwrap_or(&[]) {
            inner.push(projector.project(t, inner.last().copied()));
        }
        let [from, to] = edge.domain();
        let first = projector.project(from, inner.first().copied());
        let last = projector.project(to, inner.last().copied());
        projector.samples = std::iter::once(first).chain(inner).chain([last]).collect();
        let distances = projector.samples.iter().zip(&at);
        projector.stray = largest(distances.map(|(uv, t)| carrier.point(*uv).distance(edge.point(*t))));
        projector
    }

    /// The deviation at which a curve is good enough, metres: the tolerance, or little more than the best curve has.
    pub(super) fn limit(&self) -> f64 {
        self.tolerance.max(ATTAINED * self.stray)
    }

    /// The parameters nearest to the point of the edge at `t`, continued from `near`.
    pub(super) fn project(&self, t: f64, near: Option<DVec2>) -> DVec2 {
        let point = self.edge.point(t);
        let found = self.carrier.parameters(point, near);
        let (Carrier::Spline(spline), Some(near), true) = (self.carrier, near, found.distance > self.limit())
        else {
            return found.uv;
        };
        // A local minimum that is not on the edge: perhaps there is a nearer one.
        let sampled = spline.sampled_minimum(point, near);
        if sampled.distance < found.distance { sampled.uv } else { found.uv }
    }

    /// The pole in which the point of the edge at `t` lies, as the number of the fixed parameter and its value.
    pub(super) fn pole(&self, t: f64) -> Option<(usize, f64)> {
        let point = self.edge.point(t);
        let poles = self.carrier.poles();
        let pole = poles.iter().find(|pole| pole.point.distance(point) <= self.tolerance)?;
        Some((pole.axis, pole.value))
    }

    /// The projected points at thirds of [from, to], where `start` is that of `from` if it is known. In a pole the other parameter is
    /// extrapolated.
    pub(super) fn thirds(&self, [from, to]: [f64; 2], start: Option<DVec2>) -> [DVec2; 4] {
        let at = |i: f64| if i == 3.0 { to } else { from + (to - from) * (i / 3.0) };
        let first = self.project(at(1.0), start);
        let second = self.project(at(2.0), Some(first));
        let mut points = [start.unwrap_or(first), first, second, second];
        let poles = [from, to].map(|t| self.pole(t));
        if start.is_none() {
            points[0] = match poles[0] {
                Some(pole) => extrapolated(pole, &[first, second]),
                None => self.project(from, Some(first)),
            };
        }
        points[3] = match poles[1] {
            Some(pole) if poles[0].is_some() => extrapolated(pole, &[second, first]),
            Some(pole) => extrapolated(pole, &[second, first, points[0]]),
            None => self.project(to, Some(second)),
        };
        if let (Some(pole), None, None) = (poles[0], poles[1], start) {
            points[0] = extrapolated(pole, &[first, second, points[3]]);
        }
        points
    }

    /// The spline over the knots of the edge that is nearest to its projection, with its deviation.
    pub(super) fn fit(&self) -> Result<EdgeParameterCurve, BrepError> {
        let mut builder = PieceBuilder { knots: Vec::new(), points: Vec::new() };
        let breaks = self.edge.knots().breaks();
        let mut waiting: Vec<([f64; 2], u32)> =
            breaks.windows(2).rev().map(|pair| ([pair[0], pair[1]], 0)).collect();
        let mut last = None;
        while let Some((range, halvings)) = waiting.pop() {
            let points = self.thirds(range, last);
            let control = interpolant(&points).map(|uv| self.inside(uv));
            let middle = 0.5 * (range[0] + range[1]);
            let full = halvings >= MAX_HALVINGS || builder.pieces() + waiting.len() >= MAX_PIECES;
            // Neighbours of numbers have none between them.
            let divisible = middle > range[0] && middle < range[1];
            if !full && divisible && !self.is_close(range, &control) {
                waiting.push(([middle, range[1]], halvings + 1));
                waiting.push(([range[0], middle], halvings + 1));
                continue;
            }
            builder.push(range[0], &control);
            last = control.last().copied();
        }
        let [_, end] = self.edge.domain();
        let curve = builder.finish(end)?;
        let deviation = deviation(self.carrier, &curve, self.edge, true, self.tolerance);
        Ok(EdgeParameterCurve { curve, deviation, source: ParameterCurveSource::Fitted })
    }

    /// The nearest point of the domain of a spline; beyond its ends, where the carrier stops, curves are bounded less sharply. Elsewhere
    /// domains end in poles or not at all.
    fn inside(&self, mut uv: DVec2) -> DVec2 {
        if let Carrier::Spline(spline) = self.carrier {
            let (domain, periods) = (self.carrier.domain(), spline.periods());
            for axis in (0..2).filter(|axis| periods[*axis].is_none()) {
                uv[axis] = uv[axis].clamp(domain[axis][0], domain[axis][1]);
            }
        }
        uv
    }

    /// Whether a cubic piece is near enough to the projection of the edge between the points through which it passes.
    fn is_close(&self, [from, to]: [f64; 2], control: &[DVec2; 4]) -> bool {
        let share = (FIT_SHARE * self.tolerance).max(STRAY_SHARE * self.stray);
        [1.0 / 6.0, 0.5, 5.0 / 6.0].into_iter().all(|s| {
            let uv = cubic(control, s);
            let point = self.carrier.point(uv);
            let projected = self.project(from + (to - from) * s, Some(uv));
            point.distance(self.carrier.point(projected)) <= share
        })
    }
}

/// Parameters from the start of an edge to its end, at equal steps in each of its pieces.
fn steps(edge: &SplineCurve<DVec3>) -> Vec<f64> {
    let breaks = edge.knots().breaks();
    let pieces = breaks.len().max(2) - 1;
    let parts = (STEPS / pieces).clamp(1, edge.degree() + 1).max(MIN_STEPS.div_ceil(pieces));
    let inner = breaks
        .windows(2)
        .flat_map(|ends| (0..parts).map(move |i| ends[0] + (ends[1] - ends[0]) * (i as f64 / parts as f64)));
    inner.chain(breaks.last().copied()).collect()
}

/// The point of a pole whose other parameter continues those of points at equal steps, the nearest one first.
fn extrapolated((axis, value): (usize, f64), steps: &[DVec2]) -> DVec2 {
    let mut point = match *steps {
        [a, b, c, ..] => (a - b) * 3.0 + c,
        [a, b] => a * 2.0 - b,
        [a] => a,
        [] => DVec2::ZERO,
    };
    point[axis] = value;
    point
}

/// Bézier points of the cubic through points at 0, 1/3, 2/3 and 1.
fn interpolant(&[a, b, c, d]: &[DVec2; 4]) -> [DVec2; 4] {
    [a, (b * 18.0 - a * 5.0 - c * 9.0 + d * 2.0) / 6.0, (c * 18.0 - d * 5.0 - b * 9.0 + a * 2.0) / 6.0, d]
}

fn cubic(&[a, b, c, d]: &[DVec2; 4], s: f64) -> DVec2 {
    let r = 1.0 - s;
    a * (r * r * r) + (b * r + c * s) * (3.0 * r * s) + d * (s * s * s)
}

impl PieceBuilder {
    /// The number of pieces, each of which adds three knots.
    fn pieces(&self) -> usize {
        self.knots.len() / 3
    }

    fn push(&mut self, from: f64, control: &[DVec2; 4]) {
        let skipped = usize::from(!self.points.is_empty());
        self.knots.extend(std::iter::repeat_n(from, 3));
        self.points.extend(control.iter().skip(skipped));
    }

    fn finish(mut self, end: f64) -> Result<SplineCurve<DVec2>, BrepError> {
        let first = self.knots.first().copied().unwrap_or(end);
        self.knots.insert(0, first);
        self.knots.extend([end; 4]);
        Ok(SplineCurve::try_new(3, self.knots, self.points.iter().map(|p| p.extend(1.0)).collect())?)
    }
}
