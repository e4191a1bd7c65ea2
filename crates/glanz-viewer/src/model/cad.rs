//! What a CAD file tells of the shapes of a model: the tree of its parts, the numbers of its faces, areas and volumes.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glanz_formats::cad::CadReport;
use glanz_math::DVec3;
use serde::Serialize;

use super::Model;
use super::dimensions::SurfaceDimensions;
use super::head::TreeNode;
use super::tree::TreeLeaf;

/// Relative difference of squares of lengths that are the same, and cosine of right angles, up to rounding.
const SAME_SCALE: f64 = 1e-9;

/// Measures of some leaves of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PartMeasures {
    /// Number of leaves.
    pub faces: usize,
    /// Sum of their areas, m^2; `None` if one of them has none.
    pub area: Option<f64>,
    /// Sum of the volumes of their bodies, m^3; `None` if there is a body that is no solid, or of which leaves are missing.
    pub volume: Option<f64>,
}

/// A CAD file that a model shows.
#[derive(Clone, Debug)]
pub(super) struct CadModelFacts {
    report: CadReport,
    /// The body of each face.
    bodies: HashMap<usize, usize>,
    /// An object of each leaf.
    objects: Vec<u32>,
}

impl CadModelFacts {
    /// The face that a leaf shows.
    fn face(&self, leaf: &TreeLeaf) -> Option<usize> {
        self.report.shapes.get(leaf.shape).copied()
    }

    /// The body that a leaf belongs to.
    fn body(&self, leaf: &TreeLeaf) -> Option<usize> {
        self.bodies.get(&self.face(leaf)?).copied()
    }

    /// Name and kind of a face; its number in the file, if it has no name.
    fn label(&self, face: usize) -> Option<(String, &'static str)> {
        let face = self.report.faces.get(face)?;
        let name = if face.name.is_empty() { face.entity.to_string() } else { face.name.clone() };
        Some((name, face.kind))
    }

    /// The children of a group with the names of their faces; where they belong to several bodies, with a group for each of these.
    fn named(&self, nodes: Vec<TreeNode>, leaves: &mut [TreeLeaf]) -> Vec<TreeNode> {
        let mut named: Vec<(Option<usize>, TreeNode)> = Vec::with_capacity(nodes.len());
        for node in nodes {
            named.push(match node {
                TreeNode::Shape { name, leaf, what, place } => {
                    let body = leaves.get(leaf as usize).and_then(|leaf| self.body(leaf));
                    let face = leaves.get(leaf as usize).and_then(|leaf| self.face(leaf));
                    let (name, what) = face.and_then(|face| self.label(face)).unwrap_or((name, what));
                    if let Some(leaf) = leaves.get_mut(leaf as usize) {
                        leaf.name.clone_from(&name);
                        leaf.what = what;
                    }
                    (body, TreeNode::Shape { name, leaf, what, place })
                }
                TreeNode::Group { name, place, children } => {
                    let children = self.named(children, leaves);
                    (None, TreeNode::Group { name, place, children })
                }
            });
        }
        let bodies: BTreeSet<usize> = named.iter().filter_map(|&(body, _)| body).collect();
        let mut children: Vec<(Option<usize>, TreeNode)> = Vec::new();
        for (body, node) in named {
            match (body.filter(|_| bodies.len() > 1), children.last_mut()) {
                (Some(body), Some((Some(last), TreeNode::Group { children, .. }))) if *last == body => {
                    children.push(node);
                }
                (Some(body), _) => {
                    let name = self.body_name(body);
                    let group = TreeNode::Group { name, place: String::new(), children: vec![node] };
                    children.push((Some(body), group));
                }
                (None, _) => children.push((None, node)),
            }
        }
        children.into_iter().map(|(_, node)| node).collect()
    }

    /// The nodes, those of the file in one group if the file is one part.
    fn in_whole(&self, nodes: Vec<TreeNode>, leaves: &[TreeLeaf]) -> Vec<TreeNode> {
        let is_own = |node: &TreeNode| match node {
            TreeNode::Shape { leaf, .. } => {
                leaves.get(*leaf as usize).is_some_and(|leaf| self.face(leaf).is_some())
            }
            TreeNode::Group { .. } => true,
        };
        let ends = (nodes.iter().position(is_own), nodes.iter().rposition(is_own));
        let (Some(name), (Some(first), Some(last))) = (&self.report.whole, ends) else { return nodes };
        let (before, others) = nodes.split_at(first);
        let (own, after) = others.split_at(last + 1 - first);
        if !own.iter().all(is_own) {
            // The ground is between shapes and instances, and leaves are numbered in the order of the tree.
            return nodes;
        }
        let whole = TreeNode::Group { name: name.clone(), place: String::new(), children: own.to_vec() };
        before.iter().cloned().chain([whole]).chain(after.iter().cloned()).collect()
    }

    fn body_name(&self, body: usize) -> String {
        let body = self.report.bodies.get(body);
        body.map_or_else(String::new, |body| {
            if body.name.is_empty() { format!("body {}", body.entity) } else { body.name.clone() }
        })
    }
}

impl Model {
    /// The model with the parts, names and faces of the CAD file that `report` is about, whose shapes come first in the description.
    #[must_use]
    pub fn with_cad(mut self, report: CadReport) -> Self {
        let faces = report.bodies.iter().enumerate();
        let bodies = faces.flat_map(|(number, body)| body.faces.iter().map(move |&(face, _)| (face, number)));
        let mut objects = vec![u32::MAX; self.leaves.len()];
        for (number, object) in (0..).zip(&self.head.objects) {
            if let Some(slot) = objects.get_mut(object.leaf as usize) {
                *slot = number;
            }
        }
        let cad = CadModelFacts { bodies: bodies.collect(), objects, report };
        if let TreeNode::Group { children, .. } = &mut self.head.tree {
            let nodes = cad.named(std::mem::take(children), &mut self.leaves);
            *children = cad.in_whole(nodes, &self.leaves);
        }
        self.head.length_unit = cad.report.length_unit;
        self.cad = Some(cad);
        self
    }

    /// The number of the face that a leaf shows in its CAD file.
    #[must_use]
    pub fn entity_of(&self, leaf: u32) -> Option<String> {
        let cad = self.cad.as_ref()?;
        let face = cad.report.faces.get(cad.face(self.leaves.get(leaf as usize)?)?)?;
        Some(face.entity.to_string())
    }

    /// Lengths and angles of the surface of an object, in the world; `None` if it is not enlarged the same in all directions.
    #[must_use]
    pub fn dimensions_of(&self, object: u32) -> Option<SurfaceDimensions> {
        let leaf = self.leaves.get(self.leaf_of(object)? as usize)?;
        Some(leaf.dimensions.scaled(self.scale(object)?))
    }

    /// Area and volume of leaves that show faces of a CAD file. Calculated when first asked for.
    #[must_use]
    pub fn measures_of(&self, leaves: &BTreeSet<u32>) -> PartMeasures {
        let areas = leaves.iter().map(|&leaf| self.face_area(leaf));
        PartMeasures { faces: leaves.len(), area: areas.sum(), volume: self.volume_of(leaves) }
    }

    /// Area of the face that a leaf shows, m^2.
    pub(super) fn face_area(&self, leaf: u32) -> Option<f64> {
        let cad = self.cad.as_ref()?;
        let area = cad.report.face_area(cad.face(self.leaves.get(leaf as usize)?)?)?;
        Some(area * self.scale(*cad.objects.get(leaf as usize)?)?.powi(2))
    }

    /// Sum of the volumes of the bodies of leaves.
    fn volume_of(&self, leaves: &BTreeSet<u32>) -> Option<f64> {
        let cad = self.cad.as_ref()?;
        // All leaves of a copy of a body are enlarged the same: copies that are not are told apart by it.
        let mut found: BTreeMap<(usize, u32), (f64, HashMap<usize, usize>)> = BTreeMap::new();
        for &leaf in leaves {
            let shown = self.leaves.get(leaf as usize)?;
            let (face, body) = (cad.face(shown)?, cad.body(shown)?);
            let scale = self.scale(*cad.objects.get(leaf as usize)?)?;
            let copies = found.entry((body, (scale as f32).to_bits()));
            *copies.or_insert_with(|| (scale, HashMap::new())).1.entry(face).or_default() += 1;
        }
        let volumes = found.into_iter().map(|((body, _), (scale, counts))| {
            let faces = &cad.report.bodies.get(body)?.faces;
            // Copies are whole if no face is there more often than another.
            let copies = *counts.values().next()?;
            let copies = faces.iter().all(|(face, _)| counts.get(face) == Some(&copies)).then_some(copies)?;
            Some(cad.report.body_volume(body)? * scale.powi(3) * copies as f64)
        });
        volumes.sum()
    }

    /// The factor by which an object is enlarged; `None` if it is not the same in all directions.
    fn scale(&self, object: u32) -> Option<f64> {
        similarity_factor(&self.head.objects.get(object as usize)?.to_world)
    }
}

/// The factor by which a map enlarges, given by its columns; `None` if it is not the same in all directions.
fn similarity_factor(columns: &[f64; 12]) -> Option<f64> {
    let [x, y, z] = [0, 3, 6].map(|at| DVec3::new(columns[at], columns[at + 1], columns[at + 2]));
    let square = x.length_squared();
    let off = [y.length_squared() - square, z.length_squared() - square, x.dot(y), y.dot(z), z.dot(x)];
    off.iter().all(|off| off.abs() <= SAME_SCALE * square).then(|| square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::similarity_factor;

    #[test]
    fn only_similarities_have_a_factor() {
        let turned = [0.0, 2.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 5.0, 6.0, 7.0];
        assert_eq!(similarity_factor(&turned), Some(2.0));
        let mirrored = [-3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
        assert_eq!(similarity_factor(&mirrored), Some(3.0));
        let stretched = [2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        assert_eq!(similarity_factor(&stretched), None);
        // Columns of length 1 that are not at right angles.
        let sheared = [1.0, 0.0, 0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        assert_eq!(similarity_factor(&sheared), None);
    }
}
