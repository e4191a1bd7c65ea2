//! The part of an offset surface on which a face lies.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::bounded_edge::{BoundedEdge, loop_points};
use crate::carrier::{Carrier, CarrierProjection};
use crate::model::{BoundaryLoop, Face, FaceSurface};

/// Parts into which samples divide an edge: a full circle rises half a percent of its radius above their chords.
const PARTS: u32 = 32;

/// Part of the range of the edges in a parameter by which the part goes on beyond them.
const MARGIN: f64 = 1.0 / 16.0;

/// Of an offset of a spline, the part beside the edges of a face; `None` where that is all of it, or the surface is another one. `tolerance`:
/// distance below which points coincide, metres.
///
/// CAD systems continue surfaces before they offset them, some to where the offset has no normal: over a fold, or up to the axis of a turned profile.
/// The face ends before that, and its edges tell where.
pub(super) fn offset_part(
    surface: &FaceSurface,
    edges: &[BoundedEdge],
    face: &Face,
    tolerance: f64,
) -> Option<FaceSurface> {
    let FaceSurface::Offset { basis, distance } = surface else { return None };
    let FaceSurface::Spline(spline) = basis.as_ref() else { return None };
    let conversion = Carrier::try_from_surface(basis, Bounds3::EMPTY, tolerance).ok()?;
    let to_surface = conversion.parameters?.inverse();
    let loops: Vec<Vec<DVec3>> = face
        .bounds
        .iter()
        .filter_map(|bound| match &bound.boundary {
            BoundaryLoop::Edges(oriented) => Some(loop_points(edges, oriented, PARTS)),
            _ => None,
        })
        .collect();
    // The nearest point of the basis is the one from which a point of the offset comes, unless the basis curves more than the offset is far.
    let feet = feet(&conversion.carrier, &loops, tolerance);
    let feet = feet.into_iter().map(|foot| to_surface.transform_point2(foot)).map(|at| [at, at]);
    let [low, high] = feet.reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])?;
    let (periods, poles) = (conversion.carrier.periods(), conversion.carrier.poles());
    let domain = [spline.knots_u().domain(), spline.knots_v().domain()];
    let part = [0, 1].map(|axis| {
        // A face may go around, or contain a pole.
        if periods[axis].is_some() || poles.iter().any(|pole| pole.axis == axis) {
            return domain[axis];
        }
        let margin = MARGIN * (high[axis] - low[axis]);
        [(low[axis] - margin).max(domain[axis][0]), (high[axis] + margin).min(domain[axis][1])]
    });
    if part == domain {
        return None;
    }
    let basis = Box::new(FaceSurface::Spline(spline.restrict(part).ok()?));
    Some(FaceSurface::Offset { basis, distance: *distance })
}

/// The points of the basis of an offset that are nearest to those of loops; where several are equally near, up to the tolerance, the one next to the
/// foot before it in the loop.
///
/// Where two offsets meet, points are as far from one side of the fold between them as from the other. A loop starts at the point nearest to the middle
/// of all.
fn feet(basis: &Carrier, loops: &[Vec<DVec3>], tolerance: f64) -> Vec<DVec2> {
    let nearest = |points: &Vec<DVec3>| points.iter().map(|point| basis.parameters(*point, None)).collect();
    let nearest: Vec<Vec<CarrierProjection>> = loops.iter().map(nearest).collect();
    let median = |axis: usize| {
        let mut values: Vec<f64> = nearest.iter().flatten().map(|foot| foot.uv[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let middle = DVec2::new(median(0), median(1));
    let mut feet = Vec::new();
    for (points, nearest) in loops.iter().zip(&nearest) {
        let distances = nearest.iter().map(|foot| foot.uv.distance_squared(middle)).enumerate();
        let start = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(start, _)| start);
        let mut before = nearest.get(start).map(|foot| foot.uv);
        let around = points.iter().zip(nearest);
        for (point, nearest) in around.clone().skip(start).chain(around.take(start)) {
            let beside = basis.parameters(*point, before);
            let is_near = beside.distance <= nearest.distance + tolerance;
            let foot = if is_near { beside.uv } else { nearest.uv };
            before = Some(foot);
            feet.push(foot);
        }
    }
    feet
}
