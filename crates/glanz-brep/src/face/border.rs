//! Borders of faces where they have no edges: the range of a trimmed surface, or the border of a bounded one.

use glanz_math::{Bounds3, DVec2};

use super::geometry::metric;
use crate::boundary::BoundaryCurve;
use crate::carrier::{Carrier, CarrierConversion};
use crate::error::BrepError;
use crate::model::FaceSurface;

/// Part of a range by which it may miss a period or a pole, however small an uncertainty the file states: it gives ten digits or so.
const AROUND: f64 = 1e-9;

/// Part of a range by which it may miss a period or a pole at most, however large the uncertainty. What goes beyond a pole by no more,
/// as where an angle has few digits, ends there.
const LARGEST_GAP: f64 = 1e-4;

/// Samples per parameter of the extent of a range.
const SAMPLES: u32 = 16;

/// The ranges of u and v of a carrier.
type CarrierRanges = [[f64; 2]; 2];

/// A box around the part of a surface within its range, or within its domain. `extent`: one around the edges of the face.
///
/// # Errors
/// Those of [`Carrier::try_from_surface`] for the whole surface, and of [`ranges`].
pub(super) fn border_extent(
    surface: &FaceSurface,
    extent: Bounds3,
    tolerance: f64,
) -> Result<Bounds3, BrepError> {
    let whole = match surface {
        FaceSurface::Rectangular { basis, .. } => basis,
        _ => surface,
    };
    let mut conversion = Carrier::try_from_surface(whole, extent, tolerance)?;
    if let FaceSurface::Rectangular { same_sense, .. } = surface {
        conversion = conversion.turned(*same_sense);
    }
    let [u, v] = ranges(surface, &conversion, tolerance)?;
    let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(SAMPLES);
    let grid = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES).map(move |j| (i, j)));
    let points = grid.map(|(i, j)| conversion.carrier.point(DVec2::new(at(u, i), at(v, j))));
    Ok(points.fold(extent, Bounds3::including))
}

/// Metres per unit of the parameters of a carrier where they are longest, within a range of v.
fn scale(carrier: &Carrier, [_, high]: [f64; 2]) -> DVec2 {
    let reach = match carrier {
        Carrier::Cone { radius, half_angle, .. } => radius + high * half_angle.tan(),
        _ => 1.0,
    };
    metric(carrier, reach)
}

/// The difference up to which parameters are the same: that of points `tolerance` apart, at the given number of metres per unit.
fn slack(tolerance: f64, metres: f64, length: f64) -> f64 {
    (tolerance / metres).min(LARGEST_GAP * length).max(AROUND * length)
}

/// The part of a carrier within the range of its surface, or within its domain.
///
/// `tolerance`: distance of points that coincide, metres. Ends in descending order that are a period apart bound a whole one.
///
/// # Errors
/// [`BrepError::UnappliedRange`] if the parameters of the surface are not those of the carrier up to scale;
/// [`BrepError::RangeBeyondPole`] if the range goes on behind an apex or a pole; [`BrepError::DegenerateSurface`] if it is empty;
/// [`BrepError::UnboundedExtent`] if there is no end.
pub(super) fn ranges(
    surface: &FaceSurface,
    conversion: &CarrierConversion,
    tolerance: f64,
) -> Result<CarrierRanges, BrepError> {
    let carrier = &conversion.carrier;
    let (domain, periods) = (carrier.domain(), carrier.periods());
    let mut found = domain;
    if let FaceSurface::Rectangular { ranges, same_sense, .. } = surface {
        let map = conversion.parameters.ok_or(BrepError::UnappliedRange)?;
        if map.matrix2.x_axis.y != 0.0 || map.matrix2.y_axis.x != 0.0 {
            return Err(BrepError::UnappliedRange);
        }
        let signs = same_sense.map(|same| if same { 1.0 } else { -1.0 });
        let end =
            |i: usize| map.transform_point2(DVec2::new(signs[0] * ranges[0][i], signs[1] * ranges[1][i]));
        let ends = [end(0), end(1)];
        // The metres of u depend on the range of v.
        for axis in [1, 0] {
            let metres = scale(carrier, found[1])[axis];
            let runs_along = map.matrix2.col(axis)[axis] > 0.0;
            let [from, to] = if runs_along { [0, 1] } else { [1, 0] }.map(|i: usize| ends[i][axis]);
            found[axis] = match periods[axis] {
                // The seam may lie inside.
                Some(period) if to < from => {
                    let length = (to - from).rem_euclid(period);
                    let is_whole = length <= slack(tolerance, metres, period);
                    [from, from + if is_whole { period } else { length }]
                }
                Some(period) => [from, to.min(from + period)],
                None => {
                    let [low, high] = [from.min(to), from.max(to)];
                    let beyond = beyond_poles(carrier, axis, [low, high]);
                    if beyond > LARGEST_GAP * (high - low) {
                        return Err(BrepError::RangeBeyondPole(beyond * metres));
                    }
                    [low.max(domain[axis][0]), high.min(domain[axis][1])]
                }
            };
        }
    }
    let is_empty = |[low, high]: &&[f64; 2]| high.is_nan() || low.is_nan() || high <= low;
    if let Some([low, high]) = found.iter().find(is_empty) {
        let reason = "the range of a parameter is empty";
        return Err(BrepError::DegenerateSurface { reason, value: high - low });
    }
    if found.iter().flatten().any(|end| end.is_infinite()) {
        return Err(BrepError::UnboundedExtent);
    }
    Ok(found)
}

/// The length of a range of a cone or a sphere on the shorter side of a pole inside of it; 0 without one. Splines end at their poles.
fn beyond_poles(carrier: &Carrier, axis: usize, [low, high]: [f64; 2]) -> f64 {
    let poles = if matches!(carrier, Carrier::Spline(_)) { Vec::new() } else { carrier.poles() };
    let inside = poles.iter().filter(|pole| pole.axis == axis);
    inside.map(|pole| (pole.value - low).min(high - pole.value)).fold(0.0, f64::max)
}

/// Loops around a part of a carrier in its parameters, the part on their left; none where it goes around or ends in a pole.
///
/// `tolerance`: distance of points that coincide, metres.
pub(super) fn border(carrier: &Carrier, ranges: CarrierRanges, tolerance: f64) -> Vec<Vec<BoundaryCurve>> {
    let (metres, periods, poles) = (scale(carrier, ranges[1]), carrier.periods(), carrier.poles());
    let whole = |axis: usize| {
        let [low, high] = ranges[axis];
        periods[axis].filter(|period| period - (high - low) <= slack(tolerance, metres[axis], *period))
    };
    let is_pole = |axis: usize, value: f64| {
        let [low, high] = ranges[axis];
        let slack = slack(tolerance, metres[axis], high - low);
        poles.iter().any(|pole| pole.axis == axis && (pole.value - value).abs() <= slack)
    };
    // What goes around closes without a gap.
    let [u, v] =
        [0, 1].map(|axis| whole(axis).map_or(ranges[axis], |p| [ranges[axis][0], ranges[axis][0] + p]));
    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]: [usize; 2]| DVec2::new(u[i], v[j]));
    // Sides in the order of the loop, each with the fixed parameter and its value.
    let sides = [(a, b, 1, v[0]), (b, c, 0, u[1]), (c, d, 1, v[1]), (d, a, 0, u[0])];
    match [whole(0).is_some(), whole(1).is_some()] {
        [true, true] => Vec::new(),
        [false, false] => vec![sides.iter().map(|&(from, to, ..)| BoundaryCurve::line(from, to)).collect()],
        [around_u, _] => {
            let fixed = usize::from(around_u);
            let ends = sides.iter().filter(|&&(_, _, axis, value)| axis == fixed && !is_pole(axis, value));
            ends.map(|&(from, to, ..)| vec![BoundaryCurve::line(from, to)]).collect()
        }
    }
}
