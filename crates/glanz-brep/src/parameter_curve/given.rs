//! Parameter curves of files.

use glanz_math::glam::DAffine2;
use glanz_math::{DVec2, DVec3};

use super::deviation::deviation;
use super::{EdgeParameterCurve, ParameterCurveSource};
use crate::carrier::Carrier;
use crate::curve::{AffineMap, EdgeCurve, local_minimum};
use crate::model::{Curve, SplineCurve};

/// The part of a given curve that belongs to the edge, with its deviation; `None` if it has no such part.
pub(super) fn parameter_curve(
    carrier: &Carrier,
    edge: &EdgeCurve,
    spline: &SplineCurve<DVec3>,
    given: &Curve<DVec2>,
    map: DAffine2,
    tolerance: f64,
) -> Option<EdgeParameterCurve> {
    let curve = AffineMap::new(|p: DVec2| map.matrix2 * p, map.translation).curve(given)?;
    let ends_meet = |[from, to]: [f64; 2]| {
        let gap = |t: f64, fraction: f64| carrier.point(curve.point(t)).distance(edge.point(fraction));
        gap(from, 0.0) <= tolerance
            && gap(to, 1.0) <= tolerance
            && gap(0.5 * (from + to), 0.5) <= edge_size(edge)
    };
    // The parameters of the edge, as most files have them; else the nearest points.
    let range = [edge.range()].into_iter().find(|range| within(&curve, *range) && ends_meet(*range));
    let range = range.or_else(|| searched(carrier, edge, &curve, tolerance))?;
    let part = curve.to_spline(range).ok()?;
    let deviation = deviation(carrier, &part, spline, false, tolerance);
    Some(EdgeParameterCurve { curve: part, deviation, source: ParameterCurveSource::Given })
}

/// A length that no two points of the edge exceed much.
fn edge_size(edge: &EdgeCurve) -> f64 {
    let middle = edge.point(0.5);
    [0.0, 0.25, 0.75, 1.0]
        .map(|fraction| edge.point(fraction).distance(middle))
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether a range lies in the domain of a curve, up to rounding.
fn within(curve: &Curve<DVec2>, range: [f64; 2]) -> bool {
    let [start, end] = curve.domain();
    let slack = f64::EPSILON.sqrt() * (end - start).abs();
    let slack = if slack.is_finite() { slack } else { 0.0 };
    range.iter().all(|t| *t >= start - slack && *t <= end + slack) || matches!(curve, Curve::Ellipse { .. })
}

/// The parameters of the points of the curve that are nearest to the ends of the edge on the carrier.
fn searched(carrier: &Carrier, edge: &EdgeCurve, curve: &Curve<DVec2>, tolerance: f64) -> Option<[f64; 2]> {
    let [start, end] = curve.domain();
    if !(end - start).is_finite() {
        let found = [0.0, 1.0].map(|fraction| {
            let near = carrier.parameters(edge.point(fraction), Some(curve.point(edge.parameter(fraction))));
            curve.closest_parameter(near.uv, Some(edge.parameter(fraction)))
        });
        return (found[0] != found[1]).then_some(found);
    }
    let at = |t: f64| {
        let (uv, d) = (curve.point(t), curve.derivatives(t, 1).get(1).copied().unwrap_or(DVec2::ZERO));
        let [point, du, dv] = carrier.point_and_tangents(uv);
        [point, du * d.x + dv * d.y, DVec3::ZERO]
    };
    let whole = at(start)[0].distance(at(end)[0]) <= tolerance;
    if whole || edge.is_closed() {
        // Of a closed edge the direction is that in which its first quarter lies.
        let quarter = edge.point(0.25);
        let forward = at(start + 0.25 * (end - start))[0].distance(quarter);
        let backward = at(end - 0.25 * (end - start))[0].distance(quarter);
        return Some(if forward <= backward { [start, end] } else { [end, start] });
    }
    let samples = curve.samples([start, end]);
    let found = [0.0, 1.0].map(|fraction| {
        let point = edge.point(fraction);
        let nearest =
            samples.iter().map(|t| (at(*t)[0].distance(point), *t)).min_by(|a, b| a.0.total_cmp(&b.0));
        let guess = nearest.map_or(start, |(_, t)| t);
        local_minimum(at, point, guess, [start, end]).0
    });
    (found[0] != found[1]).then_some(found)
}
