//! Edges as curves in the parameters of carriers, with a bound on their deviation.
//!
//! [`edge_on_carrier`] lays an edge onto a carrier: exactly where surface and curve allow it (`exact`, `isoline`), by the curve that the file gives
//! if it holds (`given`), else by a cubic spline through projected points (`fit`). Whatever the source, a bound on the distance between
//! the edge and the curve on the carrier is derived (`deviation`; from control points where both are the same curve, `isoline`).

mod deviation;
mod exact;
mod expansion;
mod fit;
mod given;
mod interval;
mod isoline;
mod jet;
mod size;
#[cfg(test)]
mod tests;

use glanz_math::DVec2;

use self::fit::EdgeProjector;
pub(crate) use self::interval::largest;
use crate::carrier::{Carrier, CarrierConversion};
use crate::curve::EdgeCurve;
use crate::error::BrepError;
use crate::model::{Curve, SplineCurve};

/// The origin of a curve in the parameters of a carrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterCurveSource {
    /// The exact image of the edge, or an isoparametric line that is the edge within the tolerance.
    Exact,
    /// The file.
    Given,
    /// A spline through projected points of the edge.
    Fitted,
}

/// A curve in the parameters of a carrier that runs from the start of an edge to its end.
#[derive(Clone, Debug)]
pub struct EdgeParameterCurve {
    /// The curve: continuous and clamped; angles and other parameters with a period run on over the seam.
    pub curve: SplineCurve<DVec2>,
    /// Bound on the distance between the edge and the curve on the carrier, metres: each point of one has a point of the other within it,
    /// in the same order. It includes the distance of the edge from the carrier.
    pub deviation: f64,
    /// Its origin.
    pub source: ParameterCurveSource,
}

/// Lays an edge onto a carrier. An edge that passes through poles becomes several curves, each of which ends in the pole in which the next one
/// starts; else there is one.
///
/// `given`: the curve of the file in the parameters of the surface that was converted, which is used if it deviates by at most `tolerance`
/// (metres). The best curve is returned, even if its deviation exceeds the tolerance.
///
/// # Errors
/// [`BrepError::Range`] or [`BrepError::Surface`] if the edge has no rational form, or if there is no curve at all.
pub fn edge_on_carrier(
    conversion: &CarrierConversion,
    edge: &EdgeCurve,
    given: Option<&Curve<DVec2>>,
    tolerance: f64,
) -> Result<Vec<EdgeParameterCurve>, BrepError> {
    let carrier = &conversion.carrier;
    let parts = edge.split(&pole_passages(carrier, edge, tolerance));
    parts.iter().map(|part| part_on_carrier(conversion, part, given, tolerance)).collect()
}

fn part_on_carrier(
    conversion: &CarrierConversion,
    edge: &EdgeCurve,
    given: Option<&Curve<DVec2>>,
    tolerance: f64,
) -> Result<EdgeParameterCurve, BrepError> {
    let carrier = &conversion.carrier;
    let spline = edge.to_spline()?;
    let exact = exact::parameter_curve(carrier, edge, &spline);
    // In a plane no other curve is closer.
    let holds = |curve: &&EdgeParameterCurve| curve.deviation <= tolerance;
    let is_plane = matches!(carrier, Carrier::Plane(_));
    if let Some(exact) = exact.as_ref().filter(|exact| is_plane || holds(exact)) {
        return Ok(exact.clone());
    }
    let projector = EdgeProjector::new(carrier, &spline, tolerance);
    let isoline = isoline::parameter_curve(&projector);
    if let Some(isoline) = isoline.as_ref().filter(holds) {
        return Ok(isoline.clone());
    }
    let given = given
        .zip(conversion.parameters)
        .and_then(|(given, map)| given::parameter_curve(carrier, edge, &spline, given, map, tolerance));
    let known = [given, exact, isoline].into_iter().flatten().filter(|curve| curve.deviation.is_finite());
    let known = known.min_by(|a, b| a.deviation.total_cmp(&b.deviation));
    match known {
        // No other curve is much closer.
        Some(known) if known.deviation <= projector.limit() => Ok(known),
        Some(known) => {
            Ok(projector.fit().ok().filter(|fitted| fitted.deviation <= known.deviation).unwrap_or(known))
        }
        None => projector.fit(),
    }
}

/// Parameters inside an edge at which it passes a pole within the tolerance, in its order.
fn pole_passages(carrier: &Carrier, edge: &EdgeCurve, tolerance: f64) -> Vec<f64> {
    let ([from, to], curve) = (edge.range(), edge.curve());
    let mut cuts = Vec::new();
    for pole in carrier.poles() {
        let ends = [from, to].map(|t| curve.point(t).distance(pole.point));
        if ends.iter().any(|distance| *distance <= tolerance) {
            continue;
        }
        let t = curve.closest_in(pole.point, [from.min(to), from.max(to)]);
        // Two poles may be one point.
        let is_found = cuts.iter().any(|cut| {
            let near = |s: f64| curve.point(s).distance(pole.point) <= tolerance;
            near(*cut) && near(0.5 * (*cut + t))
        });
        if is_found {
            continue;
        }
        if t != from && t != to && curve.point(t).distance(pole.point) <= tolerance {
            cuts.push(t);
        }
    }
    cuts.sort_by(|a, b| if from < to { a.total_cmp(b) } else { b.total_cmp(a) });
    cuts.dedup();
    cuts
}
