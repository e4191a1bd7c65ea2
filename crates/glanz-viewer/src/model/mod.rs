//! From a scene to the bytes that the page draws; `docs/viewer.md` describes them.
//!
//! A [`Model`] holds every surface of the scene as the graphics card can evaluate it: rational Bézier patches with the parts of trimming
//! curves that are near each of them, polynomials, and triangles for flat surfaces. `surfaces` turns surfaces into these, `region`
//! trimming; `tree` traverses the scene as it was written and numbers its *leaves*: shapes as reached through one chain of instances.

mod appearance;
mod blocks;
mod cad;
mod dimensions;
mod edges;
mod error;
mod head;
mod hidden;
mod lights;
mod lux;
mod map;
mod mesh;
mod outer_walls;
mod patches;
mod region;
mod surfaces;
#[cfg(test)]
mod tests;
mod tree;
mod view;
mod visible_patches;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{Bounds3, DVec3};
use glanz_scene::{Description, Light, ParametricPoint, PlacedSurface, Scene};

use self::blocks::Blocks;
use self::cad::CadModelFacts;
pub use self::cad::PartMeasures;
pub use self::dimensions::SurfaceDimensions;
use self::edges::ModelEdges;
pub use self::error::ModelError;
use self::head::ModelHead;
pub use self::hidden::without;
pub use self::lux::{LuxCell, LuxLookup, LuxReading};
pub use self::map::MapLabel;
use self::surfaces::{BuiltSurface, Surfaces};
use self::tree::{ModelTree, TreeLeaf};

/// A scene as the page draws it.
#[derive(Clone, Debug)]
pub struct Model {
    head: ModelHead,
    blocks: Blocks,
    leaves: Vec<TreeLeaf>,
    /// For each surface of [`Scene::placed_surfaces`] its objects, as (first face, object), by ascending faces.
    objects: Vec<Vec<(u32, u32)>>,
    /// Cache of the areas of leaves.
    areas: Arc<Mutex<HashMap<u32, Option<f64>>>>,
    /// Of a CAD file.
    cad: Option<CadModelFacts>,
    lux: Option<Arc<dyn LuxLookup>>,
}

impl Model {
    /// The model of `scene`, which `description` was resolved to.
    ///
    /// `name`: name on the page; `file_names`: names of the description's files for messages.
    ///
    /// # Errors
    /// [`ModelError::TooMany`] for a scene of more shapes, with copies, than a page can list, or of more numbers than can be counted.
    pub fn try_new(
        name: &str,
        description: &Description,
        scene: &Scene,
        file_names: &[String],
    ) -> Result<Self, ModelError> {
        let tree = ModelTree::try_new(name, description, file_names)?;
        let placed = scene.placed_surfaces();
        let mut objects = Objects::default();
        for (surface, parts) in placed.iter().zip(tree.leaves_of(&placed)) {
            objects.add(description, scene, surface, &parts, &tree.leaves)?;
        }
        let mut surfaces = objects.surfaces;
        let edges = ModelEdges::of(description, &mut surfaces.blocks);
        let mut notes = surfaces.notes;
        let (lights, left_out) = lights::lights(scene, &placed);
        if left_out {
            notes.push("the page is lit by the brightest lights only".to_owned());
        }
        notes.extend(view::note(&description.camera));
        notes.sort();
        notes.dedup();
        let camera = view::camera(description, scene);
        let bounds = scene.bounds();
        let bounds = if bounds.is_empty() { Bounds3 { min: -DVec3::ONE, max: DVec3::ONE } } else { bounds };
        let head = ModelHead {
            name: name.to_owned(),
            up: view::up(&camera),
            bounds: [bounds.min.to_array(), bounds.max.to_array()],
            aspect: view::aspect(description),
            camera,
            surfaces: surfaces.head,
            regions: surfaces.regions,
            objects: objects.head,
            materials: objects.materials,
            lights,
            tree: tree.root,
            length_unit: None,
            edges: edges.edges,
            edge_copies: edges.copies,
            maps: Vec::new(),
            notes,
        };
        Ok(Self {
            head,
            blocks: surfaces.blocks,
            leaves: tree.leaves,
            objects: objects.by_surface,
            areas: Arc::default(),
            cad: None,
            lux: None,
        })
    }

    /// The model with one more note for the page.
    #[must_use]
    pub fn with_note(mut self, note: String) -> Self {
        self.head.notes.push(note);
        self
    }

    /// The file that the page loads.
    ///
    /// # Errors
    /// [`ModelError::Text`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, ModelError> {
        let (ranges, blocks) = self.blocks.layout();
        let text = serde_json::to_string(&head::ModelText { blocks: &ranges, head: &self.head })?;
        Ok(blocks::file(&text, &blocks))
    }

    /// The object at a point of the scene; `None` if there is no such point.
    #[must_use]
    pub fn object_of(&self, place: &ParametricPoint) -> Option<u32> {
        let parts = self.objects.get(place.surface as usize)?;
        let after = parts.partition_point(|&(first, _)| first <= place.face);
        parts.get(after.checked_sub(1)?).map(|&(_, object)| object)
    }

    /// The leaf of the tree that an object belongs to.
    #[must_use]
    pub fn leaf_of(&self, object: u32) -> Option<u32> {
        self.head.objects.get(object as usize).map(|object| object.leaf)
    }

    /// Name of an object's surface in scene files.
    #[must_use]
    pub fn kind_of(&self, object: u32) -> &'static str {
        self.head.objects.get(object as usize).map_or("", |object| object.kind)
    }

    /// Name of the material of an object, or its kind if it has none.
    #[must_use]
    pub fn material_of(&self, object: u32) -> &str {
        let material = self.head.objects.get(object as usize).map(|object| object.material);
        let material = material.and_then(|number| self.head.materials.get(number));
        material.map_or("", |material| if material.name.is_empty() { material.kind } else { &material.name })
    }

    /// True if an object is visible: interfaces are not, unless they emit light.
    #[must_use]
    pub fn is_seen(&self, object: u32) -> bool {
        let object = self.head.objects.get(object as usize);
        let material = object.and_then(|object| self.head.materials.get(object.material));
        material.is_some_and(|material| material.opacity > 0.0) || object.is_some_and(|object| object.light)
    }

    /// Area of a leaf, m^2, in the scene with the surfaces `placed`; `None` if it has none. Cached.
    #[must_use]
    pub fn area_of(&self, leaf: u32, placed: &[PlacedSurface<'_>]) -> Option<f64> {
        // That of a face is exact, that of a trimmed surface an estimate.
        if let Some(area) = self.face_area(leaf) {
            return Some(area);
        }
        let known = || self.areas.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&area) = known().get(&leaf) {
            return area;
        }
        let mut sum = None;
        for (object, surface, faces) in self.object_faces(placed) {
            if self.leaf_of(object) == Some(leaf) {
                sum = Some(sum.unwrap_or(0.0) + surface.area(faces)?);
            }
        }
        known().insert(leaf, sum);
        sum
    }

    /// Each object with its surface among `placed`, the surfaces of the scene, and its faces there.
    fn object_faces<'a, 's>(
        &'a self,
        placed: &'a [PlacedSurface<'s>],
    ) -> impl Iterator<Item = (u32, &'a PlacedSurface<'s>, Range<u32>)> {
        self.objects.iter().zip(placed).flat_map(|(parts, surface)| {
            let ends = parts.iter().skip(1).map(|&(end, _)| end).chain([surface.faces()]);
            parts.iter().zip(ends).map(move |(&(first, object), end)| (object, surface, first..end))
        })
    }

    /// Name of a leaf in the tree.
    #[must_use]
    pub fn name_of(&self, leaf: u32) -> Option<&str> {
        self.leaves.get(leaf as usize).map(|leaf| leaf.name.as_str())
    }
}

/// The objects of the model built so far.
#[derive(Default)]
struct Objects {
    head: Vec<head::ModelObject>,
    by_surface: Vec<Vec<(u32, u32)>>,
    materials: Vec<head::ModelMaterial>,
    /// Number in the model by number in the scene and the bits of the emission.
    known_materials: HashMap<(u32, [u32; 3]), usize>,
    surfaces: Surfaces,
}

impl Objects {
    /// The objects of one surface: one for each of `parts`, which are (first face, leaf).
    fn add(
        &mut self,
        description: &Description,
        scene: &Scene,
        placed: &PlacedSurface<'_>,
        parts: &[(u32, u32)],
        leaves: &[TreeLeaf],
    ) -> Result<(), ModelError> {
        let faces: Vec<u32> = parts.iter().map(|&(face, _)| face).collect();
        let built = self.surfaces.add(placed, &faces, scene.bounds())?;
        let mut own = Vec::with_capacity(parts.len());
        for (&(face, leaf), built) in parts.iter().zip(built) {
            own.push((face, error::number("objects", self.head.len())?));
            let material = self.material(description, scene, placed, face);
            self.head.push(head::ModelObject {
                surface: built.surface,
                to_world: to_world(placed, &built),
                material,
                leaf,
                kind: leaves.get(leaf as usize).map_or("", |leaf| leaf.what),
                reversed: placed.is_reversed(face),
                light: placed.light().is_some(),
                shared: leaves.get(leaf as usize).is_some_and(|leaf| leaf.shared),
                map: None,
                outside: None,
            });
        }
        self.by_surface.push(own);
        Ok(())
    }

    fn material(
        &mut self,
        description: &Description,
        scene: &Scene,
        placed: &PlacedSurface<'_>,
        face: u32,
    ) -> usize {
        let emission = match placed.light().and_then(|id| scene.light(id)) {
            Some(Light::Area(light)) => light.radiance(),
            _ => Spectrum::BLACK,
        };
        let number = placed.material(face);
        let shines = appearance::rgb(emission, &Wavelengths::default()).map(f32::to_bits);
        if let Some(&known) = self.known_materials.get(&(number, shines)) {
            return known;
        }
        let name = description.materials.get(number as usize).map_or("", |m| m.name.as_str());
        self.materials.push(appearance::material(scene, number, name, (placed, face), emission));
        self.known_materials.insert((number, shines), self.materials.len() - 1);
        self.materials.len() - 1
    }
}

/// Columns of the map from the model's surface to the world, then where its origin is.
fn to_world(placed: &PlacedSurface<'_>, built: &BuiltSurface) -> [f64; 12] {
    let map = placed.to_world();
    let axes = map.forward().matrix3 * built.unit;
    let columns = [axes.x_axis, axes.y_axis, axes.z_axis, map.point(built.origin)];
    let mut numbers = [0.0; 12];
    numbers.iter_mut().zip(columns.iter().flat_map(|c| c.to_array())).for_each(|(slot, x)| *slot = x);
    numbers
}
