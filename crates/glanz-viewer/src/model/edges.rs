//! Edges of CAD models: polylines, with what is known of their curves.

use std::collections::HashMap;

use glanz_math::{Bounds3, DMat4, DVec3};
use glanz_scene::Description;
use glanz_scene::description::{EdgeDescription, EdgeKind, GroupDescription};

use super::blocks::Blocks;
use super::head::{EdgeCopy, ModelEdge};

/// The feature edges of a description, in the order of the tree.
#[derive(Default)]
pub(super) struct ModelEdges {
    pub(super) edges: Vec<ModelEdge>,
    pub(super) copies: Vec<EdgeCopy>,
    /// First edge, number of edges and the origin of their points, by group.
    known: HashMap<usize, (usize, usize, DVec3)>,
}

impl ModelEdges {
    /// Adds the points to the blocks. The description has no more copies than a tree may have.
    pub(super) fn of(description: &Description, blocks: &mut Blocks) -> Self {
        let mut edges = Self::default();
        let world = (&description.world, description.groups.len());
        edges.add_group(description, world, DMat4::IDENTITY, &mut 0, blocks);
        edges
    }

    /// Adds a copy of a group. `leaf`: the number of its first leaf, then that of the leaf after it.
    fn add_group(
        &mut self,
        description: &Description,
        (group, index): (&GroupDescription, usize),
        to_world: DMat4,
        leaf: &mut usize,
        blocks: &mut Blocks,
    ) {
        let first_leaf = *leaf;
        *leaf += group.shapes.len();
        let known = self.known.get(&index).copied();
        let (first, count, origin) = known.unwrap_or_else(|| self.add_edges(index, group, blocks));
        if count > 0 {
            let axes = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|axis| axis.truncate());
            let columns = [axes[0], axes[1], axes[2], to_world.transform_point3(origin)];
            let mut numbers = [0.0; 12];
            let values = columns.iter().flat_map(|column| column.to_array());
            numbers.iter_mut().zip(values).for_each(|(slot, x)| *slot = x);
            self.copies.push(EdgeCopy { to_world: numbers, first, count, first_leaf });
        }
        for instance in &group.instances {
            // Groups contain earlier groups only, so the recursion ends.
            let inner = description.groups.get(instance.group).filter(|_| instance.group < index);
            if let Some(inner) = inner {
                let to_world = to_world * instance.to_parent;
                self.add_group(description, (inner, instance.group), to_world, leaf, blocks);
            }
        }
    }

    fn add_edges(
        &mut self,
        index: usize,
        group: &GroupDescription,
        blocks: &mut Blocks,
    ) -> (usize, usize, DVec3) {
        let features = || group.edges.iter().filter(|edge| edge.transition.is_feature());
        let bounds = Bounds3::from_points(features().flat_map(|edge| edge.points.iter().copied()));
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let first = self.edges.len();
        for edge in features() {
            let first_point = blocks.edge_points.len();
            let points = edge.points.iter().map(|&point| (point - origin).to_array().map(|x| x as f32));
            blocks.edge_points.extend(points);
            self.edges.push(model_edge(edge, first_point));
        }
        let added = (first, self.edges.len() - first, origin);
        self.known.insert(index, added);
        added
    }
}

fn model_edge(edge: &EdgeDescription, first: usize) -> ModelEdge {
    let (kind, radii) = match edge.kind {
        EdgeKind::Line => ("line", vec![]),
        EdgeKind::Circle { radius, .. } => ("circle", vec![radius]),
        EdgeKind::Ellipse { radii, .. } => ("ellipse", radii.to_vec()),
        _ => ("spline", vec![]),
    };
    let (count, shapes) = (edge.points.len(), edge.shapes.clone());
    ModelEdge { first, count, kind, radii, length: edge.length, angle: edge.angle, shapes }
}
