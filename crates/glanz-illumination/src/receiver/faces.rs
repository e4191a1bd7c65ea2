//! Receivers on curved meshes: every triangle is a cell.

use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::ReceiverPoint;

/// The triangles of a mesh.
#[derive(Clone, Debug)]
pub(super) struct FaceCells {
    /// In ascending order.
    faces: Vec<u32>,
}

impl FaceCells {
    pub(super) fn new(faces: &[u32]) -> Self {
        Self { faces: faces.to_vec() }
    }

    pub(super) fn len(&self) -> u32 {
        self.faces.len() as u32
    }

    pub(super) fn cell(&self, face: u32) -> Option<usize> {
        self.faces.binary_search(&face).ok()
    }

    /// Area per unit of a triangle's parameters is the same everywhere; the parameters fill half of the unit square.
    pub(super) fn measure(&self, surface: &PlacedSurface<'_>) -> (Vec<f64>, Vec<DVec3>) {
        let middle = DVec2::splat(1.0 / 3.0);
        let at = |&face: &u32| surface.at(face, middle, false);
        let areas = self.faces.iter().map(|face| at(face).map_or(0.0, |at| 0.5 * at.area_element)).collect();
        let position = |face| at(face).map_or(DVec3::ZERO, |at| at.at.point.position);
        (areas, self.faces.iter().map(position).collect())
    }

    pub(super) fn place(&self, surface: &PlacedSurface<'_>, cell: usize, at: DVec2) -> Option<ReceiverPoint> {
        let &face = self.faces.get(cell)?;
        // The square onto the triangle: (s, t) -> (s (1 - t), s t), of Jacobian s.
        let uv = DVec2::new(at.x * (1.0 - at.y), at.x * at.y);
        let found = surface.at(face, uv, false)?;
        let point = &found.at.point;
        let area_element = found.area_element * at.x;
        Some(ReceiverPoint { position: point.position, normal: point.normal, area_element })
    }
}
