//! The JSON text of the model, field by field as `docs/viewer.md` has it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::outer_walls::OuterSide;

/// Content of the JSON text without the positions of the blocks.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelHead {
    pub(super) name: String,
    pub(super) up: [f64; 3],
    pub(super) bounds: [[f64; 3]; 2],
    pub(super) aspect: f64,
    pub(super) camera: ModelCamera,
    pub(super) surfaces: Vec<ModelSurface>,
    pub(super) regions: Vec<ModelRegion>,
    pub(super) objects: Vec<ModelObject>,
    pub(super) materials: Vec<ModelMaterial>,
    pub(super) lights: Vec<ModelLight>,
    pub(super) tree: TreeNode,
    pub(super) length_unit: Option<f64>,
    pub(super) edges: Vec<ModelEdge>,
    pub(super) edge_copies: Vec<EdgeCopy>,
    pub(super) maps: Vec<ModelMap>,
    pub(super) notes: Vec<String>,
}

/// The JSON text with the positions of the blocks.
#[derive(Serialize)]
pub(super) struct ModelText<'a> {
    pub(super) blocks: &'a BTreeMap<String, BlockRange>,
    #[serde(flatten)]
    pub(super) head: &'a ModelHead,
}

/// Range of a block in bytes, counted from the start of the first block.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct BlockRange {
    pub(super) offset: usize,
    pub(super) length: usize,
}

/// A view of the scene; lengths are metres and angles radians.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelCamera {
    pub(super) kind: &'static str,
    pub(super) position: [f64; 3],
    pub(super) right: [f64; 3],
    pub(super) up: [f64; 3],
    pub(super) forward: [f64; 3],
    pub(super) field_of_view: f64,
    pub(super) height: f64,
    pub(super) distance: f64,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase", rename_all_fields = "camelCase")]
pub(super) enum ModelSurface {
    Patches {
        first: usize,
        count: usize,
        origin: [f64; 3],
        region: Option<usize>,
        mapping: Mapping,
    },
    Mesh {
        first_vertex: usize,
        vertices: usize,
        first_index: usize,
        indices: usize,
        origin: [f64; 3],
    },
    Algebraic {
        /// Exponents of x, y, z and the coefficient.
        terms: Vec<(u32, u32, u32, f64)>,
        min: [f64; 3],
        max: [f64; 3],
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Mapping {
    Patch,
    Revolution,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelRegion {
    pub(super) cells: [usize; 2],
    pub(super) first_cell: usize,
    pub(super) min: [f64; 2],
    pub(super) max: [f64; 2],
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelObject {
    pub(super) surface: usize,
    pub(super) to_world: [f64; 12],
    pub(super) material: usize,
    pub(super) leaf: u32,
    pub(super) kind: &'static str,
    pub(super) reversed: bool,
    pub(super) light: bool,
    pub(super) shared: bool,
    pub(super) map: Option<usize>,
    pub(super) outside: Option<OuterSide>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ModelMaterial {
    pub(super) name: String,
    pub(super) kind: &'static str,
    pub(super) base: [f32; 3],
    pub(super) metallic: f32,
    pub(super) roughness: f32,
    pub(super) opacity: f32,
    pub(super) specular: [f32; 3],
    pub(super) exponent: Option<f64>,
    pub(super) emission: [f32; 3],
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelLight {
    pub(super) kind: &'static str,
    pub(super) position: [f64; 3],
    pub(super) direction: [f64; 3],
    pub(super) intensity: [f32; 3],
    pub(super) cos_inner: f64,
    pub(super) cos_outer: f64,
    pub(super) range: Option<f64>,
}

/// A group or a shape of the scene.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(super) enum TreeNode {
    Group { name: String, place: String, children: Vec<TreeNode> },
    Shape { name: String, leaf: u32, what: &'static str, place: String },
}

/// A feature edge of a group; lengths in its frame.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ModelEdge {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) kind: &'static str,
    pub(super) radii: Vec<f64>,
    pub(super) length: f64,
    pub(super) angle: f64,
    /// Shapes that meet in it, counted from the first of the group.
    pub(super) shapes: Vec<usize>,
}

/// The edges of a copy of a group.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct EdgeCopy {
    pub(super) to_world: [f64; 12],
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) first_leaf: usize,
}

/// A map of values that the page draws on objects.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ModelMap {
    pub(super) unit: String,
    pub(super) block: String,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) sides: usize,
    /// Numbers of a texel: 1 or 3.
    pub(super) channels: usize,
    pub(super) largest: f32,
}
