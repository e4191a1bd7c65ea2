//! The surface of a face, where the file may mean another one or ends the face with it.

use glanz_math::DVec3;

use super::outcome::FaceRepair;
use crate::model::{BoundaryLoop, BrepModel, Face, FaceSurface, Placement};

/// Part of the size of a face up to which its edges may be off its surface.
pub(super) const STRAYING: f64 = 0.05;

/// Whether a face ends where its surface does: without edges on a surface with a range, or because it says so.
pub(super) fn ends_at_border(surface: &FaceSurface, face: &Face) -> bool {
    let has_range = matches!(surface, FaceSurface::Rectangular { .. });
    let says_so = face.bounds.iter().any(|bound| matches!(bound.boundary, BoundaryLoop::Border));
    says_so || has_range && face.bounds.is_empty()
}

/// The plane of a face between polygons that are far from the plane in the file or run clockwise about its normal, and the repair.
///
/// Polygons agree with those of the neighbours, whose corners they share; a plane may be one for all faces.
pub(super) fn plane_of_polygons(
    surface: &FaceSurface,
    model: &BrepModel,
    face: &Face,
    size: f64,
    tolerance: f64,
) -> Option<(Placement, FaceRepair)> {
    let FaceSurface::Plane(given) = *surface else { return None };
    let polygons = face.bounds.iter().map(|bound| model.polygon(&bound.boundary));
    let polygons: Vec<Vec<DVec3>> = polygons.collect::<Option<_>>()?;
    let distance =
        |plane: Placement| polygons.iter().flatten().map(|&p| plane.to_local(p).z.abs()).fold(0.0, f64::max);
    let plane = Placement::of_polygons(&polygons)?;
    let (off, is_flat) = (distance(given), distance(plane) <= tolerance);
    if off > STRAYING * size {
        return is_flat.then_some((plane, FaceRepair::PolygonPlane { distance: off }));
    }
    let is_opposite = plane.z.dot(given.z) < 0.0;
    if is_opposite != face.same_sense {
        return None;
    }
    // Of polygons in no plane the given one holds, on the side around which they run.
    let side = if is_opposite { Placement { y: -given.y, z: -given.z, ..given } } else { given };
    Some((if is_flat { plane } else { side }, FaceRepair::TurnedPlane))
}
