//! Polygons as loops of edges.

use std::collections::HashMap;

use glanz_brep::model::{Edge, EntityId, OrientedEdge};
use glanz_math::DVec3;

use super::geometry::ENTITY_COST;
use super::lowering::StepReader;
use super::part21::Refusal;

/// The corners and sides of the polygons of a body, each once: loops name points, so that equal coordinates are what neighbours have in common.
#[derive(Default)]
pub(super) struct PolygonEdges {
    /// By the bits of the coordinates.
    vertices: HashMap<[u64; 3], usize>,
    /// By the vertices at the ends, the smaller one first.
    edges: HashMap<[usize; 2], usize>,
}

impl StepReader<'_> {
    /// The straight edges of a polygon, each of which other polygons with the same two corners share.
    pub(super) fn polygon_edges(
        &mut self,
        corners: &[DVec3],
        polygon: EntityId,
    ) -> Result<Vec<OrientedEdge>, Refusal> {
        let vertices: Vec<usize> =
            corners.iter().map(|&corner| self.polygon_vertex(corner, polygon)).collect::<Result<_, _>>()?;
        let mut edges = Vec::with_capacity(corners.len());
        for (&start, &end) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
            // Some files repeat corners, often the first one at the end.
            if start != end {
                let edge = self.polygon_edge([start.min(end), start.max(end)], polygon)?;
                edges.push(OrientedEdge { edge, forward: start < end });
            }
        }
        if edges.is_empty() { Err(Refusal::new(polygon, "the polygon is a point")) } else { Ok(edges) }
    }

    fn polygon_vertex(&mut self, point: DVec3, polygon: EntityId) -> Result<usize, Refusal> {
        // Both zeros are the same.
        let key = point.to_array().map(|x| (x + 0.0).to_bits());
        let next = self.model.vertices.len();
        let vertex = *self.polygons.vertices.entry(key).or_insert(next);
        if vertex == next {
            self.model.vertices.push(point);
            self.geometry.spend(polygon, 1)?;
        }
        Ok(vertex)
    }

    fn polygon_edge(&mut self, [start, end]: [usize; 2], polygon: EntityId) -> Result<usize, Refusal> {
        let next = self.model.edges.len();
        let edge = *self.polygons.edges.entry([start, end]).or_insert(next);
        if edge == next {
            let parameter_curves = Vec::new();
            let edge = Edge { start, end, curve: None, same_sense: true, parameter_curves, entity: polygon };
            self.model.edges.push(edge);
            self.geometry.spend(polygon, ENTITY_COST)?;
        }
        Ok(edge)
    }
}
