//! Edges along which one parameter is constant.

use glanz_geometry::spline::{KnotVector, ParameterDirection, polygon};
use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::deviation::{ENOUGH, SHARPNESS, deviation};
use super::fit::EdgeProjector;
use super::interval::largest;
use super::size::{OPERATIONS, spline_size};
use super::{EdgeParameterCurve, ParameterCurveSource};
use crate::carrier::Carrier;
use crate::model::SplineCurve;

/// The straight line of constant u or v that is the edge as nearly as the carrier allows; `None` if there is none. On borders the line is exactly there.
pub(super) fn parameter_curve(projector: &EdgeProjector<'_>) -> Option<EdgeParameterCurve> {
    let [first, inner @ .., last] = projector.samples.as_slice() else { return None };
    let poles = projector.edge.domain().map(|t| projector.pole(t));
    (0..2).find_map(|axis| {
        // In a pole the parameter that is not fixed there is not defined.
        let undefined = |pole: Option<(usize, f64)>| pole.is_some_and(|(fixed, _)| fixed != axis);
        let mut all = inner.to_vec();
        all.extend(
            [(*first, poles[0]), (*last, poles[1])]
                .into_iter()
                .filter(|(_, pole)| !undefined(*pole))
                .map(|(uv, _)| uv),
        );
        let value = constant(projector, &all, axis)?;
        let ends = [(*first, poles[0]), (*last, poles[1])].map(|(mut uv, pole)| {
            if let Some((fixed, value)) = pole {
                uv[fixed] = value;
            }
            uv[axis] = value;
            uv
        });
        let curve = SplineCurve::line(ends[0], ends[1], [0.0, 1.0]).ok()?;
        let ends = [ends[0][1 - axis], ends[1][1 - axis]];
        let deviation = piecewise_bound(projector, axis, value, ends).unwrap_or_else(|| {
            deviation(projector.carrier, &curve, projector.edge, false, projector.tolerance)
        });
        (deviation <= projector.limit()).then_some(EdgeParameterCurve {
            curve,
            deviation,
            source: ParameterCurveSource::Exact,
        })
    })
}

/// The value of a parameter that is the same at all points within the tolerance: that of a border if it is there, else the mean.
fn constant(projector: &EdgeProjector<'_>, points: &[DVec2], axis: usize) -> Option<f64> {
    let first = points.first()?[axis];
    let mean = first + points.iter().map(|uv| uv[axis] - first).sum::<f64>() / points.len() as f64;
    let speed = largest(points.iter().map(|uv| projector.carrier.tangents(*uv)[axis].length()));
    let near = |value: f64| points.iter().all(|uv| (uv[axis] - value).abs() * speed <= projector.limit());
    if !near(mean) {
        return None;
    }
    // Other surfaces have no border but their poles.
    let has_border = matches!(projector.carrier, Carrier::Spline(_))
        || projector.carrier.poles().iter().any(|pole| pole.axis == axis);
    if !has_border {
        return Some(mean);
    }
    // Of a seam, the side on which the points are.
    let [low, high] = projector.carrier.domain()[axis];
    let period = projector.carrier.periods()[axis].unwrap_or(0.0);
    let turns = if period > 0.0 { ((mean - low) / period).round() * period } else { 0.0 };
    Some([low + turns, high].into_iter().find(|border| border.is_finite() && near(*border)).unwrap_or(mean))
}

/// Bound on the distance, metres, between an isoparametric curve of a spline and the edge, of which each piece corresponds to one of the other;
/// `None` where their numbers differ or the bound is not sharp. `value`: of the parameter `axis`; `ends`: of the other one.
fn piecewise_bound(projector: &EdgeProjector<'_>, axis: usize, value: f64, ends: [f64; 2]) -> Option<f64> {
    let Carrier::Spline(spline) = projector.carrier else { return None };
    // Beyond a seam the surface has no knots.
    let [first, last] = spline.domain()[axis];
    if !(first..=last).contains(&value) {
        return None;
    }
    let fixed = [ParameterDirection::U, ParameterDirection::V][axis];
    let line = spline.surface().isocurve(fixed, value).ok()?;
    let line = line.restrict([ends[0].min(ends[1]), ends[0].max(ends[1])]).ok()?;
    let edge = if ends[0] > ends[1] { &projector.edge.reversed().ok()? } else { projector.edge };
    let degree = line.knots().degree().max(edge.degree());
    let line = bezier(line.knots().clone(), line.control_points().to_vec(), degree)?;
    let edge = bezier(edge.knots().clone(), edge.control_points().to_vec(), degree)?;
    if line.len() != edge.len() {
        return None;
    }
    // Neighbours share a point.
    let pieces = |points: &[DVec4]| (0..points.len().saturating_sub(1)).step_by(degree);
    let bounds =
        pieces(&line).map(|i| Some(piece_bound(line.get(i..=i + degree)?, edge.get(i..=i + degree)?)));
    let bound = largest(bounds.collect::<Option<Vec<f64>>>()?);
    let rounding = gamma(OPERATIONS) * spline_size(projector.edge);
    let enough = (SHARPNESS * projector.stray).max(rounding + ENOUGH * projector.tolerance);
    (bound <= enough).then_some(bound + rounding)
}

/// The Bézier points of a curve when it has this degree.
fn bezier(knots: KnotVector, points: Vec<DVec4>, degree: usize) -> Option<Vec<DVec4>> {
    let curve = SplineCurve::<DVec3>::from_knots(knots, points).ok()?.elevated(degree).ok()?;
    Some(polygon::bezier(curve.knots(), curve.control_points()).ok()?.1)
}

/// Bound on the distance of two rational Bézier curves at corresponding parameters, metres.
///
/// Weights times c^i belong to the same curve with another parameter; with c, the last weights are in the same ratio as the first. With curves A / a and
/// B / b, the difference is `(A - B) / a - (B / b) (a - b) / a`, bounded by the Bézier points of its numerators.
///
/// # Source
/// @farin2002 section 13.5 (reparametrisation).
fn piece_bound(line: &[DVec4], edge: &[DVec4]) -> f64 {
    let ([first, .., last], [start, .., end]) = (line, edge) else { return f64::INFINITY };
    let ratio = ((last.w / first.w) / (end.w / start.w)).powf(((line.len() - 1) as f64).recip());
    let mut factor = first.w / start.w;
    let center = start.truncate() / start.w;
    let [mut apart, mut weights, mut reach, mut least]: [f64; 4] = [0.0, 0.0, 0.0, f64::INFINITY];
    for (a, b) in line.iter().zip(edge) {
        let b = *b * factor;
        factor *= ratio;
        let [from, to] = [a, &b].map(|p| p.truncate() - center * p.w);
        apart = largest([apart, from.distance(to)]);
        weights = largest([weights, (a.w - b.w).abs()]);
        reach = largest([reach, to.length() / b.w]);
        least = least.min(a.w);
    }
    (apart + reach * weights) / least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bound_of_arcs_with_other_parameters_is_their_distance() {
        // A quarter of the unit circle, and one of another radius whose weights are multiplied by 2 c^i.
        let corners = [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let middle = std::f64::consts::FRAC_1_SQRT_2;
        let arc = |radius: f64, weights: [f64; 3]| -> Vec<DVec4> {
            corners.iter().zip(weights).map(|(p, w)| (*p * (radius * w)).extend(w)).collect()
        };
        for (distance, c) in [(0.0, 3.0), (1e-3, 1.0), (1e-3, 0.25)] {
            let other = arc(1.0 + distance, [2.0, 2.0 * c * middle, 2.0 * c * c]);
            let bound = piece_bound(&arc(1.0, [1.0, middle, 1.0]), &other);
            // The corner of the control polygon is farther from its neighbour, and the least weight below 1.
            assert!((distance..=2.0 * distance + 1e-14).contains(&bound), "{bound} for {distance}");
        }
        let shifted = arc(1.0, [1.0, 0.9, 1.0]);
        // Another middle weight makes an ellipse: at 1/2, X + Y lies by the share w / (1 + w) from the chord.
        let depth = |w: f64| w / (1.0 + w) / 2.0_f64.sqrt();
        let bound = piece_bound(&arc(1.0, [1.0, middle, 1.0]), &shifted);
        assert!(bound >= depth(0.9) - depth(middle), "{bound}");
    }
}
