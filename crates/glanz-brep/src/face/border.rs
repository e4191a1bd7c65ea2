//! Borders of faces where they have no edges: the range of a trimmed surface, or the border of a bounded one.

use glanz_math::{Bounds3, DVec2};

use crate::boundary::BoundaryCurve;
use crate::carrier::{Carrier, CarrierConversion};
use crate::error::BrepError;
use crate::model::FaceSurface;

/// Part of a range by which it may miss a period or a pole.
const AROUND: f64 = 1e-9;

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
    let [u, v] = ranges(surface, &conversion)?;
    let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(SAMPLES);
    let grid = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES).map(move |j| (i, j)));
    let points = grid.map(|(i, j)| conversion.carrier.point(DVec2::new(at(u, i), at(v, j))));
    Ok(points.fold(extent, Bounds3::including))
}

/// The part of a carrier within the range of its surface, or within its domain.
///
/// # Errors
/// [`BrepError::UnappliedRange`] if the parameters of the surface are not those of the carrier up to scale, or the range is empty;
/// [`BrepError::UnboundedExtent`] if there is no end.
pub(super) fn ranges(
    surface: &FaceSurface,
    conversion: &CarrierConversion,
) -> Result<CarrierRanges, BrepError> {
    let (domain, periods) = (conversion.carrier.domain(), conversion.carrier.periods());
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
        for axis in 0..2 {
            let runs_along = map.matrix2.col(axis)[axis] > 0.0;
            let [from, to] = if runs_along { [0, 1] } else { [1, 0] }.map(|i: usize| ends[i][axis]);
            found[axis] = match periods[axis] {
                // The seam may lie inside.
                Some(period) if to <= from => [from, to + ((from - to) / period).ceil() * period],
                Some(period) => [from, to.min(from + period)],
                None => [from.min(to).max(domain[axis][0]), from.max(to).min(domain[axis][1])],
            };
        }
    }
    if found.iter().any(|[low, high]| high.is_nan() || low.is_nan() || high <= low) {
        return Err(BrepError::UnappliedRange);
    }
    if found.iter().flatten().any(|end| end.is_infinite()) {
        return Err(BrepError::UnboundedExtent);
    }
    Ok(found)
}

/// Loops around a part of a carrier in its parameters, the part on their left; none where it goes around or ends in a pole.
pub(super) fn border(carrier: &Carrier, [u, v]: CarrierRanges) -> Vec<Vec<BoundaryCurve>> {
    let ranges = [u, v];
    let periods = carrier.periods();
    let is_around = |axis: usize| {
        let [low, high] = ranges[axis];
        periods[axis].is_some_and(|period| high - low >= period * (1.0 - AROUND))
    };
    let poles = carrier.poles();
    let is_pole = |axis: usize, value: f64| {
        let [low, high] = ranges[axis];
        poles.iter().any(|pole| pole.axis == axis && (pole.value - value).abs() <= AROUND * (high - low))
    };
    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]: [usize; 2]| DVec2::new(u[i], v[j]));
    // Sides in the order of the loop, each with the fixed parameter and its value.
    let sides = [(a, b, 1, v[0]), (b, c, 0, u[1]), (c, d, 1, v[1]), (d, a, 0, u[0])];
    match [is_around(0), is_around(1)] {
        [true, true] => Vec::new(),
        [false, false] => vec![sides.iter().map(|&(from, to, ..)| BoundaryCurve::line(from, to)).collect()],
        [around_u, _] => {
            let fixed = usize::from(around_u);
            let ends = sides.iter().filter(|&&(_, _, axis, value)| axis == fixed && !is_pole(axis, value));
            ends.map(|&(from, to, ..)| vec![BoundaryCurve::line(from, to)]).collect()
        }
    }
}
