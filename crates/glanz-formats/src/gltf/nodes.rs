//! The tree of nodes: placements of meshes, the camera, lights.

use std::collections::BTreeMap;

use glanz_math::glam::DQuat;
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{GroupDescription, InstanceDescription, ShapeDescription};
use serde_json::Value;

use super::GltfReader;
use super::error::GltfError;
use super::json::{JsonObject, JsonPath};
use super::mesh::{VEC3, VEC4};
use super::view::WATTS_PER_LUMEN;
use crate::finder::entry_bytes;
use crate::model::{MAX_LIGHT_COPIES, light_count};

/// A use of a mesh by a node.
struct MeshPlacement {
    mesh: usize,
    to_world: DMat4,
    name: String,
    node: usize,
}

/// Placements in the order of the tree.
#[derive(Default)]
pub(super) struct Placements {
    meshes: Vec<MeshPlacement>,
}

fn number(value: &Value, path: &JsonPath<'_>) -> Result<usize, GltfError> {
    let number = value.as_u64().and_then(|n| usize::try_from(n).ok());
    number.ok_or_else(|| path.error("the format needs a whole number of at least 0"))
}

/// The transformation of a node to its parent.
fn local(node: &JsonObject<'_>) -> Result<DMat4, GltfError> {
    let matrix = match node.numbers::<16>("matrix")? {
        Some(columns) => DMat4::from_cols_array(&columns),
        None => {
            let translation = node.numbers("translation")?.unwrap_or([0.0; 3]).into();
            let rotation = node.numbers("rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            transformation(translation, rotation, node.numbers("scale")?.unwrap_or([1.0; 3]).into())
        }
    };
    if matrix.is_finite() { Ok(matrix) } else { Err(node.fault("the transformation is not finite")) }
}

/// Scaled, turned by a quaternion with its real part last, and moved.
fn transformation(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DMat4 {
    let rotation = DQuat::from_array(rotation);
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

impl GltfReader<'_, '_> {
    /// Adds the default scene.
    pub(super) fn scene(&mut self) -> Result<(), GltfError> {
        let mut placements = Placements::default();
        let mut visited = vec![false; self.document.length("nodes")];
        // The next node is the last one.
        let mut pending: Vec<(usize, DMat4)> =
            self.roots()?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
        let path = JsonPath::ROOT;
        while let Some((index, to_world)) = pending.pop() {
            self.spend(0, &path)?;
            let document = self.document;
            document.element("nodes", index, &path, |node| {
                if std::mem::replace(&mut visited[index], true) {
                    return Err(node.fault("the node has two parents, or is its own ancestor"));
                }
                let to_world = to_world * local(&node)?;
                self.node(&node, index, to_world, &mut placements)?;
                let children = node.path().name("children");
                for (i, child) in node.list("children")?.iter().enumerate().rev() {
                    pending.push((number(child, &children.index(i))?, to_world));
                }
                Ok(())
            })?;
        }
        if self.reader.own_light {
            self.radiance_unit = WATTS_PER_LUMEN;
        }
        self.place(placements)
    }

    /// The nodes of the default scene; without scenes those without a parent.
    fn roots(&mut self) -> Result<Vec<usize>, GltfError> {
        let (document, root) = (self.document, self.document.root()?);
        let scenes = document.length("scenes");
        if scenes == 0 {
            let mut is_root = vec![true; document.length("nodes")];
            for index in 0..is_root.len() {
                document.element("nodes", index, &JsonPath::ROOT, |node| {
                    for child in node.list("children")? {
                        let child =
                            child.as_u64().and_then(|child| is_root.get_mut(usize::try_from(child).ok()?));
                        child.into_iter().for_each(|is_root| *is_root = false);
                    }
                    Ok(())
                })?;
            }
            return Ok((0..is_root.len()).filter(|&i| is_root[i]).collect());
        }
        let default = root.count("scene")?.unwrap_or(0);
        if scenes > 1 {
            let message = format!("the file has {scenes} scenes; scene {default} is read");
            self.reader.report(glanz_scene::Severity::Warning, "gltf-scenes", None, message);
        }
        document.element("scenes", default, &root.path().name("scene"), |scene| {
            let path = scene.path().name("nodes");
            scene.list("nodes")?.iter().enumerate().map(|(i, node)| number(node, &path.index(i))).collect()
        })
    }

    fn node(
        &mut self,
        node: &JsonObject<'_>,
        index: usize,
        to_world: DMat4,
        placements: &mut Placements,
    ) -> Result<(), GltfError> {
        if let Some(camera) = node.count("camera")? {
            self.camera(camera, to_world, node)?;
        }
        node.extension("KHR_lights_punctual", |light| match light {
            Some(light) => self.light(light.required_count("light")?, to_world, &light),
            None => Ok(()),
        })?;
        if node.has("skin") {
            let message = format!("{}: skins are not read; the mesh as it is stands in", node.path());
            self.reader.stand_in("gltf-skin", None, message);
        }
        let Some(mesh) = node.count("mesh")? else { return Ok(()) };
        let name = node.own_name();
        let copies = node.extension("EXT_mesh_gpu_instancing", |found| {
            found.map(|instancing| self.copies(&instancing, name.len())).transpose()
        })?;
        for copy in copies.unwrap_or_else(|| vec![DMat4::IDENTITY]) {
            let to_world = to_world * copy;
            // A scale of 0 hides a node.
            if to_world.is_finite() && to_world.determinant() != 0.0 {
                placements.meshes.push(MeshPlacement { mesh, to_world, name: name.clone(), node: index });
            }
        }
        Ok(())
    }

    /// The transformations of the copies of a node, all of which get its name of `name_length` bytes.
    fn copies(&mut self, instancing: &JsonObject<'_>, name_length: usize) -> Result<Vec<DMat4>, GltfError> {
        instancing.object_or_empty("attributes", |attributes| {
            let mut count = None;
            for name in attributes.names().filter(|name| !name.starts_with('_')) {
                let needed = if name == "ROTATION" { VEC4 } else { VEC3 };
                let found = self.attribute(&attributes, name, needed)?.map(|accessor| accessor.count());
                if count.is_some_and(|count| Some(count) != found) {
                    return Err(
                        attributes.error(name, "attributes of instances have different numbers of elements")
                    );
                }
                count = found;
            }
            let count = count.unwrap_or(0);
            // Instances take more memory than corners of triangles: some 500 bytes beside their names.
            self.use_elements(count.saturating_mul(12 + name_length / 32), attributes.path())?;
            let mut copies = vec![(DVec3::ZERO, [0.0, 0.0, 0.0, 1.0], DVec3::ONE); count];
            if let Some(accessor) = self.attribute(&attributes, "TRANSLATION", VEC3)? {
                copies
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, copy)| copy.0 = accessor.vector(i, [0.0; 3]).into());
            }
            if let Some(accessor) = self.attribute(&attributes, "ROTATION", VEC4)? {
                copies.iter_mut().enumerate().for_each(|(i, copy)| copy.1 = accessor.vector(i, [0.0; 4]));
            }
            if let Some(accessor) = self.attribute(&attributes, "SCALE", VEC3)? {
                copies
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, copy)| copy.2 = accessor.vector(i, [0.0; 3]).into());
            }
            Ok(copies.into_iter().map(|(t, r, s)| transformation(t, r, s)).collect())
        })
    }

    /// Adds meshes: those used once as shapes of the world, others as groups with instances.
    fn place(&mut self, placements: Placements) -> Result<(), GltfError> {
        let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
        placements.meshes.iter().for_each(|placement| *uses.entry(placement.mesh).or_default() += 1);
        // The groups of meshes with the number of their lights.
        let mut groups: BTreeMap<usize, Option<(usize, usize)>> = BTreeMap::new();
        let mut lights = 0_usize;
        let (root, document) = (JsonPath::ROOT, self.document);
        let nodes = root.name("nodes");
        for MeshPlacement { mesh, to_world, name, node } in placements.meshes {
            let path = nodes.index(node);
            let path = path.name("mesh");
            if uses.get(&mesh) == Some(&1) {
                let shapes = self.mesh(mesh, &path)?.into_iter();
                let placed = shapes.map(|shape| ShapeDescription { to_parent: to_world, ..shape });
                self.reader.description.world.shapes.extend(placed);
                continue;
            }
            let group = match groups.get(&mesh) {
                Some(known) => *known,
                None => {
                    let shapes = self.mesh(mesh, &path)?;
                    let name = document.element("meshes", mesh, &path, |mesh| Ok(mesh.own_name()))?;
                    let next = self.reader.description.groups.len();
                    let group = (!shapes.is_empty()).then(|| (next, light_count(&shapes)));
                    if group.is_some() {
                        self.spend(entry_bytes::<GroupDescription>(&name), &path)?;
                        let group = GroupDescription { name, shapes, ..GroupDescription::default() };
                        self.reader.description.groups.push(group);
                    }
                    groups.insert(mesh, group);
                    // The first instance is no copy.
                    group.map(|(index, _)| (index, 0))
                }
            };
            let Some((group, emitting)) = group else { continue };
            lights = lights.saturating_add(emitting);
            if lights > MAX_LIGHT_COPIES {
                let message = format!(
                    "instances create more than {MAX_LIGHT_COPIES} copies of lights; let fewer nodes have an emissive mesh"
                );
                return Err(path.error(message));
            }
            let instance = InstanceDescription { name, group, to_parent: to_world, location: None };
            self.spend_object(instance.bytes(), &path)?;
            self.reader.description.world.instances.push(instance);
        }
        Ok(())
    }
}
