//! Edges along which one parameter is constant.

use glanz_math::DVec2;

use super::deviation::deviation;
use super::fit::EdgeProjector;
use super::interval::largest;
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
        let deviation = deviation(projector.carrier, &curve, projector.edge, false, projector.tolerance);
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
