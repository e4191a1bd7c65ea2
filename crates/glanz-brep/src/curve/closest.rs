//! The parameter of the point of a curve that is nearest to a given point.

use std::f64::consts::TAU;

use glanz_math::rounding::UNIT_ROUNDOFF;

use crate::model::{Curve, CurveVector};

/// Largest number of Newton steps; from a good start, four are enough.
const MAX_STEPS: usize = 32;

/// Largest number of local minima of the sampled distance that are searched.
const MAX_MINIMA: usize = 8;

/// Samples of a conic.
const CONIC_SAMPLES: usize = 24;

/// A local minimum of the distance from `query` within a range, and that distance: Newton's method, each step halved until the distance
/// decreases. `curve` returns the point and its first two derivatives.
pub(crate) fn local_minimum<P: CurveVector>(
    curve: impl Fn(f64) -> [P; 3],
    query: P,
    start: f64,
    [low, high]: [f64; 2],
) -> (f64, f64) {
    let square = |p: P| (p - query).dot(p - query);
    let mut t = start.max(low).min(high);
    let mut at = curve(t);
    for _ in 0..MAX_STEPS {
        let r = at[0] - query;
        let (gradient, gauss) = (r.dot(at[1]), at[1].dot(at[1]));
        let newton = gauss + r.dot(at[2]);
        let curvature = if newton > 0.0 { newton } else { gauss };
        let outward = (t <= low && gradient > 0.0) || (t >= high && gradient < 0.0);
        if outward || gradient == 0.0 || curvature <= 0.0 {
            break;
        }
        let step = -gradient / curvature;
        let (before, distance2) = (t, r.dot(r));
        let shorter = (0..MAX_STEPS).find_map(|halvings| {
            let next = (t + step * 0.5_f64.powi(halvings as i32)).max(low).min(high);
            let there = curve(next);
            (square(there[0]) < distance2).then_some((next, there))
        });
        let Some(next) = shorter else { break };
        (t, at) = next;
        if (t - before).abs() <= UNIT_ROUNDOFF * t.abs() {
            break;
        }
    }
    (t, square(at[0]).sqrt())
}

/// The parameter of the nearest point of a polyline.
fn on_polyline<P: CurveVector>(points: &[P], query: P) -> f64 {
    let on_segment = |(i, ends): (usize, &[P])| {
        let direction = ends[1] - ends[0];
        let length2 = direction.dot(direction);
        let t =
            if length2 > 0.0 { ((query - ends[0]).dot(direction) / length2).clamp(0.0, 1.0) } else { 0.0 };
        (i as f64 + t, (ends[0] + direction * t).distance_to(query))
    };
    let nearest = points.windows(2).enumerate().map(on_segment).min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map_or(0.0, |(t, _)| t)
}

/// The parameter of the nearest point of a composite curve.
fn on_segments<P: CurveVector>(segments: &[(Curve<P>, bool)], query: P) -> f64 {
    let (mut best, mut start) = ((0.0, f64::INFINITY), 0.0);
    for (segment, same_sense) in segments {
        let [a, b] = segment.domain();
        let t = segment.closest_parameter(query, None);
        let distance = segment.point(t).distance_to(query);
        if distance < best.1 {
            best = (start + if *same_sense { t - a } else { b - t }, distance);
        }
        start += b - a;
    }
    best.0
}

impl<P: CurveVector> Curve<P> {
    /// The point and its first two derivatives.
    pub(crate) fn second_order(&self, t: f64) -> [P; 3] {
        let d = self.derivatives(t, 2);
        [0, 1, 2].map(|k| d.get(k).copied().unwrap_or(P::ZERO))
    }

    /// The parameter of the point of the curve nearest to `query`: with `near` the local minimum found from there, else the least
    /// of those found from samples of the whole curve. On an ellipse it lies in [0, 2 pi], or within half a turn of `near`.
    #[must_use]
    pub fn closest_parameter(&self, query: P, near: Option<f64>) -> f64 {
        if let Self::Line { origin, direction } = self {
            return (query - *origin).dot(*direction) / direction.dot(*direction);
        }
        let range = self.search_range(query);
        if let Some(near) = near {
            let range = match self {
                Self::Ellipse { .. } => [near - 0.5 * TAU, near + 0.5 * TAU],
                _ => range,
            };
            return local_minimum(|t| self.second_order(t), query, near, range).0;
        }
        match self {
            Self::Polyline(points) => on_polyline(points, query),
            // Segment by segment: to find a point, all segments before it are passed.
            Self::Composite(segments) if range.iter().all(|end| end.is_finite()) => {
                on_segments(segments, query)
            }
            _ => self.closest_in(query, range),
        }
    }

    /// The least of the minima that are found from samples within a bounded range.
    pub(crate) fn closest_in(&self, query: P, range: [f64; 2]) -> f64 {
        let samples = self.samples(range);
        let distances: Vec<f64> = samples.iter().map(|t| self.point(*t).distance_to(query)).collect();
        let is_minimum = |i: &usize| {
            let at = |j: Option<usize>| j.and_then(|j| distances.get(j)).copied().unwrap_or(f64::INFINITY);
            distances[*i] <= at(i.checked_sub(1)) && distances[*i] <= at(Some(i + 1))
        };
        let mut minima: Vec<usize> = (0..samples.len()).filter(is_minimum).collect();
        minima.sort_by(|a, b| distances[*a].total_cmp(&distances[*b]));
        let mut best = (range[0], f64::INFINITY);
        for i in minima.into_iter().take(MAX_MINIMA) {
            if distances[i] < best.1 {
                best = (samples[i], distances[i]);
            }
            // Both sides of the sample, at which the curve may have a corner.
            for side in samples[i.saturating_sub(1)..samples.len().min(i + 2)].windows(2) {
                let middle = 0.5 * (side[0] + side[1]);
                let found = local_minimum(|t| self.second_order(t), query, middle, [side[0], side[1]]);
                if found.1 < best.1 {
                    best = found;
                }
            }
        }
        best.0
    }

    /// A bounded range that contains the parameter of the nearest point.
    fn search_range(&self, query: P) -> [f64; 2] {
        // The nearest point is not farther from the query than any point of the curve.
        let domain = self.domain();
        if domain.iter().all(|t| t.is_finite()) {
            domain
        } else {
            self.range_near(query, self.point(0.0).distance_to(query))
        }
    }

    /// Ascending parameters from the start to the end of a bounded range, with all corners and several on each piece.
    pub(crate) fn samples(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let mut inner = Vec::new();
        let divide = |ends: &[f64], parts: usize, inner: &mut Vec<f64>| {
            for pair in ends.windows(2) {
                inner.extend((0..parts).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / parts as f64));
                inner.push(pair[1]);
            }
        };
        match self {
            Self::Spline(spline) => divide(&spline.knots().breaks(), 4 * spline.degree(), &mut inner),
            Self::Polyline(points) => inner.extend((0..points.len()).map(|i| i as f64)),
            Self::Composite(segments) => {
                let mut start = 0.0;
                for (segment, sense) in segments {
                    let [a, b] = segment.domain();
                    let local = segment.samples([a, b]);
                    inner.extend(
                        local.into_iter().map(|t| if *sense { start + (t - a) } else { start + (b - t) }),
                    );
                    start += b - a;
                }
            }
            Self::Trimmed { basis, same_sense, .. } => {
                let sign = if *same_sense { 1.0 } else { -1.0 };
                let ends = if *same_sense { [from, to] } else { [-to, -from] };
                inner.extend(basis.samples(ends).into_iter().map(|t| sign * t));
            }
            _ => divide(&[from, to], CONIC_SAMPLES, &mut inner),
        }
        let [start, end] = self.domain();
        if (end - start).is_finite() && !matches!(self, Self::Ellipse { .. }) && (from < start || to > end) {
            let turn = end - start;
            inner = inner.iter().flat_map(|t| [t - turn, *t, t + turn]).collect();
        }
        inner.retain(|t| *t > from && *t < to);
        inner.extend([from, to]);
        inner.sort_by(f64::total_cmp);
        inner.dedup();
        inner
    }
}
