//! The part of an offset surface on which a face lies.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::bounded_edge::BoundedEdge;
use crate::carrier::Carrier;
use crate::model::{BoundaryLoop, Face, FaceSurface};

/// Parts of an edge between which its points are sampled: between them, an arc goes on by half a percent of its radius.
const SAMPLES: u32 = 32;

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
    // The nearest point of the basis is the one from which a point of the offset comes, unless the basis curves more than the offset is far.
    let feet = edge_points(edges, face)?
        .into_iter()
        .map(|point| to_surface.transform_point2(conversion.carrier.parameters(point, None).uv));
    let [low, high] =
        feet.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
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

/// Points of the boundary of a face; `None` where it has another one than edges.
fn edge_points(edges: &[BoundedEdge], face: &Face) -> Option<Vec<DVec3>> {
    let mut points = Vec::new();
    for bound in &face.bounds {
        let BoundaryLoop::Edges(oriented) = &bound.boundary else { return None };
        for oriented in oriented {
            let curve = edges.get(oriented.edge)?.curve.as_ref().ok()?;
            points.extend((0..=SAMPLES).map(|i| curve.point(f64::from(i) / f64::from(SAMPLES))));
        }
    }
    (!points.is_empty()).then_some(points)
}
