//! The surface of a face, where the file may mean another one or ends the face with it.

use glanz_math::DVec3;

use super::bounded_edge::BoundedEdge;
use crate::model::{BoundaryLoop, BrepModel, Face, FaceSurface, Placement};

/// Part of the size of a face up to which its edges may be off its surface.
pub(super) const STRAYING: f64 = 0.05;

/// Whether a face ends where its surface does: without edges on a surface with a range, or because it says so.
pub(super) fn ends_at_border(surface: &FaceSurface, face: &Face) -> bool {
    let has_range = matches!(surface, FaceSurface::Rectangular { .. });
    let says_so = face.bounds.iter().any(|bound| matches!(bound.boundary, BoundaryLoop::Border));
    says_so || has_range && face.bounds.is_empty()
}

/// The plane of a face between polygons that are far from the plane in the file, and how far.
pub(super) fn plane_of_polygons(
    surface: &FaceSurface,
    face: &Face,
    size: f64,
    tolerance: f64,
) -> Option<(Placement, f64)> {
    let FaceSurface::Plane(given) = *surface else { return None };
    let mut corners: Vec<DVec3> = Vec::new();
    for bound in &face.bounds {
        let BoundaryLoop::Polygon(polygon) = &bound.boundary else { return None };
        corners.extend(polygon);
    }
    let distance = |plane: Placement| corners.iter().map(|&p| plane.to_local(p).z.abs()).fold(0.0, f64::max);
    let off = distance(given);
    if off <= STRAYING * size {
        return None;
    }
    let plane = Placement::of_polygons(&face.bounds)?;
    (distance(plane) <= tolerance).then_some((plane, off))
}

/// Of a torus whose tube meets the axis, the part on which the edges lie: files often give the other one.
pub(super) fn part_with_edges(
    surface: &FaceSurface,
    model: &BrepModel,
    edges: &[BoundedEdge],
    face: &Face,
) -> FaceSurface {
    let FaceSurface::Torus { placement, major_radius, minor_radius, .. } = *surface else {
        return surface.clone();
    };
    if minor_radius < major_radius {
        return surface.clone();
    }
    let oriented = face.bounds.iter().filter_map(|bound| match &bound.boundary {
        BoundaryLoop::Edges(oriented) => Some(oriented),
        _ => None,
    });
    let curves = oriented.flatten().filter_map(|oriented| edges.get(oriented.edge)?.curve.as_ref().ok());
    let points: Vec<DVec3> = curves.flat_map(|curve| [0.0, 0.5, 1.0].map(|at| curve.point(at))).collect();
    // The outer part is where the distance from the axis grows with that from the tube's circle on the near side.
    let outside = |point: &DVec3| {
        let p = *point - placement.origin;
        let (z, rho) = (p.dot(placement.z), (p - placement.z * p.dot(placement.z)).length());
        let outer = (rho - major_radius).hypot(z) - minor_radius;
        let inner = (rho + major_radius).hypot(z) - minor_radius;
        outer.abs() - inner.abs()
    };
    let balance = points.iter().map(outside).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    match balance {
        Some(balance) if balance.abs() > model.uncertainty => {
            FaceSurface::Torus { placement, major_radius, minor_radius, select_outer: balance < 0.0 }
        }
        _ => surface.clone(),
    }
}
