//! Lights that instances create.

use glanz_scene::description::{GeometryDescription, ShapeDescription};

/// Largest number of lights that instances may create, beside those of the first instance of each group.
pub(crate) const MAX_LIGHT_COPIES: usize = 1 << 20;

/// Number of lights of the shapes of a group: every triangle, and every other face, of one that emits light.
pub(crate) fn light_count(shapes: &[ShapeDescription]) -> usize {
    let emitting = shapes.iter().filter(|shape| shape.emission.is_some());
    emitting.map(|shape| face_count(&shape.geometry)).fold(0, usize::saturating_add)
}

/// Number of faces of a surface, each of which is a light.
pub(crate) fn face_count(geometry: &GeometryDescription) -> usize {
    match geometry {
        GeometryDescription::Triangles { indices, .. } => indices.len(),
        GeometryDescription::Bilinear { indices, .. } => indices.len(),
        GeometryDescription::BezierPatches(patches) => patches.patches.len(),
        GeometryDescription::BezierTriangles(patches) => patches.patches.len(),
        _ => 1,
    }
}
