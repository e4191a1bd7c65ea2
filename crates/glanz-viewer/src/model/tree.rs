//! The tree of groups and shapes as the scene file has it, and the surfaces of each shape.

use glanz_scene::description::{GeometryDescription, GroupDescription, ShapeDescription};
use glanz_scene::{Description, Location, PlacedSurface};

use super::dimensions::SurfaceDimensions;
use super::error::ModelError;
use super::head::TreeNode;

/// Largest number of leaves, or surfaces, of a model: each has a line of text in it.
const MOST_LEAVES: u64 = 1 << 18;

/// Result of the traversal of the description.
pub(super) struct ModelTree {
    pub(super) root: TreeNode,
    /// By number.
    pub(super) leaves: Vec<TreeLeaf>,
    /// The leaves that are copies of each shape, by its number, in the order of the traversal.
    copies: Vec<Vec<u32>>,
}

/// A shape as reached through one chain of instances.
#[derive(Clone, Debug)]
pub(super) struct TreeLeaf {
    pub(super) name: String,
    /// Name of its surface in scene files.
    pub(super) what: &'static str,
    /// Whether it is trimmed along edges that other shapes share.
    pub(super) shared: bool,
    /// Number of its shape: those of the groups in their order, then those of the world.
    pub(super) shape: usize,
    /// Lengths and angles of its surface, in the frame of its group.
    pub(super) dimensions: SurfaceDimensions,
}

/// State of the traversal.
struct TreeBuilder<'a> {
    description: &'a Description,
    file_names: &'a [String],
    /// Number of the first shape of each group; the world is the last.
    first_shape: Vec<usize>,
    leaves: Vec<TreeLeaf>,
    copies: Vec<Vec<u32>>,
}

impl ModelTree {
    /// The tree under a root called `name`. The world's shapes come first, then its instances, and so on inwards.
    ///
    /// # Errors
    /// [`ModelError::TooMany`] leaves.
    pub(super) fn try_new(
        name: &str,
        description: &Description,
        file_names: &[String],
    ) -> Result<Self, ModelError> {
        check_size(description)?;
        let groups = description.groups.iter().chain([&description.world]);
        let mut shapes = 0;
        let mut first_shape = Vec::new();
        for group in groups {
            first_shape.push(shapes);
            shapes += group.shapes.len();
        }
        let copies = vec![Vec::new(); shapes];
        let mut builder = TreeBuilder { description, file_names, first_shape, leaves: Vec::new(), copies };
        let children = builder.children(&description.world, description.groups.len());
        let root = TreeNode::Group { name: name.to_owned(), place: String::new(), children };
        Ok(Self { root, leaves: builder.leaves, copies: builder.copies })
    }

    /// The leaf of every shape of every placed surface, as (first face, leaf), by ascending faces.
    ///
    /// A scene lists the copies of a shape in the order of the traversal, whether they shine or not. A list of patches is as many
    /// surfaces, one after the other in each copy.
    pub(super) fn leaves_of(&self, placed: &[PlacedSurface<'_>]) -> Vec<Vec<(u32, u32)>> {
        let parts: Vec<Vec<(u32, u32)>> = placed.iter().map(shapes_of).collect();
        let mut totals = vec![0_usize; self.copies.len()];
        for &(_, shape) in parts.iter().flatten() {
            if let Some(total) = totals.get_mut(shape as usize) {
                *total += 1;
            }
        }
        let mut seen = vec![0_usize; self.copies.len()];
        let mut leaf_of = |shape: u32| {
            let shape = shape as usize;
            let copies = self.copies.get(shape)?;
            let per_copy = totals.get(shape)?.checked_div(copies.len())?;
            let count = seen.get_mut(shape)?;
            *count += 1;
            copies.get((*count - 1).checked_div(per_copy)?).copied()
        };
        let of_parts = |parts: Vec<(u32, u32)>| {
            parts.into_iter().filter_map(|(face, shape)| Some((face, leaf_of(shape)?))).collect()
        };
        parts.into_iter().map(of_parts).collect()
    }
}

/// The shapes of a surface as (first face, shape).
fn shapes_of(placed: &PlacedSurface<'_>) -> Vec<(u32, u32)> {
    let mut parts = vec![(0, placed.shape(0))];
    for face in 1..placed.faces() {
        let shape = placed.shape(face);
        if parts.last().is_some_and(|&(_, last)| last != shape) {
            parts.push((face, shape));
        }
    }
    parts
}

/// Checks that the copies of groups do not add up to more than can be drawn: a few lines may describe a million million.
fn check_size(description: &Description) -> Result<(), ModelError> {
    let surfaces = |shape: &ShapeDescription| match &shape.geometry {
        GeometryDescription::Bilinear { indices, .. } => indices.len().max(1) as u64,
        _ => 1,
    };
    let mut sizes: Vec<u64> = Vec::with_capacity(description.groups.len());
    let size = |group: &GroupDescription, sizes: &[u64]| {
        let own: u64 = group.shapes.iter().map(surfaces).sum();
        let copied = group.instances.iter().filter_map(|instance| sizes.get(instance.group));
        // An instance without shapes is a node, too.
        copied.fold(own, |sum, size| sum.saturating_add(*size).saturating_add(1))
    };
    for group in &description.groups {
        sizes.push(size(group, &sizes));
    }
    let count = size(&description.world, &sizes);
    if count > MOST_LEAVES {
        return Err(ModelError::TooMany { what: "shapes and copies of shapes", count, most: MOST_LEAVES });
    }
    Ok(())
}

impl TreeBuilder<'_> {
    /// The shapes and instances of the group number `index`.
    fn children(&mut self, group: &GroupDescription, index: usize) -> Vec<TreeNode> {
        let first = self.first_shape.get(index).copied().unwrap_or_default();
        let mut nodes = Vec::with_capacity(group.shapes.len() + group.instances.len());
        for (number, shape) in (first..).zip(&group.shapes) {
            nodes.push(self.shape(shape, number));
        }
        let description = self.description;
        for instance in &group.instances {
            // Groups contain earlier groups only, so the recursion ends.
            let inner = description.groups.get(instance.group).filter(|_| instance.group < index);
            if let Some(inner) = inner {
                let children = self.children(inner, instance.group);
                let place = self.place(instance.location);
                let name = match instance.name.as_str() {
                    "" => inner.name.clone(),
                    name if inner.name.is_empty() || name == inner.name => name.to_owned(),
                    name => format!("{} ({name})", inner.name),
                };
                nodes.push(TreeNode::Group { name, place, children });
            }
        }
        nodes
    }

    fn shape(&mut self, shape: &ShapeDescription, number: usize) -> TreeNode {
        let what = shape.geometry.name();
        let receiver = shape.receiver.as_ref().map(|receiver| receiver.name.as_str());
        let material = self.description.materials.get(shape.material).map(|m| m.name.as_str());
        let named = [receiver, material].into_iter().flatten().find(|name| !name.is_empty());
        let name = named.unwrap_or(what).to_owned();
        let leaf = self.leaves.len() as u32;
        let mut curves = shape.trim.iter().flat_map(|trim| &trim.loops).flat_map(|l| &l.curves);
        let shared = curves.any(|curve| curve.edge.is_some());
        let dimensions = SurfaceDimensions::of(&shape.geometry);
        self.leaves.push(TreeLeaf { name: name.clone(), what, shared, shape: number, dimensions });
        if let Some(copies) = self.copies.get_mut(number) {
            copies.push(leaf);
        }
        TreeNode::Shape { name, leaf, what, place: self.place(shape.location) }
    }

    fn place(&self, location: Option<Location>) -> String {
        let file = |at: Location| self.file_names.get(at.file.0 as usize).map(|name| (name, at.line));
        location.and_then(file).map_or_else(String::new, |(name, line)| format!("{name}:{line}"))
    }
}
