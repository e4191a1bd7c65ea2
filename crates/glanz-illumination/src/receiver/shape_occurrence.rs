//! Shapes of receivers where the scene places them.

use glanz_geometry::Surface;
use glanz_scene::PlacedSurface;

use super::faces::FaceCells;
use super::flat::FlatGrid;
use super::parameters::ParameterGrid;
use super::{FACES_LIMIT, ReceiverError, ReceiverLayout};

/// A placed shape, or a facet of one.
pub(super) struct ShapeOccurrence<'a> {
    pub(super) surface: PlacedSurface<'a>,
    pub(super) number: u32,
    pub(super) face: Option<u32>,
    /// Its faces.
    faces: Vec<u32>,
}

impl ShapeOccurrence<'_> {
    pub(super) fn layout(&self, name: &str, back: bool) -> Result<ReceiverLayout, ReceiverError> {
        if self.faces.is_empty() {
            return Err(ReceiverError::NoParameters(name.to_owned()));
        }
        if let Some(flat) = FlatGrid::try_new(&self.surface, &self.faces, back) {
            return Ok(ReceiverLayout::FlatGrid(flat));
        }
        if let Some(parameters) = ParameterGrid::try_new(&self.surface) {
            return Ok(ReceiverLayout::ParameterGrid(parameters));
        }
        if self.faces.len() > FACES_LIMIT {
            return Err(ReceiverError::TooMany { name: name.to_owned(), faces: self.faces.len() });
        }
        Ok(ReceiverLayout::FaceCells(FaceCells::new(&self.faces)))
    }
}

/// The receivers of a shape: one, or one per facet of a box or polyhedron, for each instance.
pub(super) fn shapes<'a>(placed: &[PlacedSurface<'a>], shape: u32) -> Vec<ShapeOccurrence<'a>> {
    let mut found = Vec::new();
    for (number, surface) in (0..).zip(placed) {
        let faces: Vec<u32> = (0..surface.faces()).filter(|&face| surface.shape(face) == shape).collect();
        if faces.is_empty() && surface.shape(0) != shape {
            continue;
        }
        let surface = surface.clone();
        if matches!(surface.surface(), Surface::Cuboid(_) | Surface::Polyhedron(_)) {
            let facet = |&face| ShapeOccurrence {
                surface: surface.clone(),
                number,
                face: Some(face),
                faces: vec![face],
            };
            found.extend(faces.iter().map(facet));
        } else {
            found.push(ShapeOccurrence { surface, number, face: None, faces });
        }
    }
    found
}
