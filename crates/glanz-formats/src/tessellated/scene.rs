//! Binary glTF 2.0 (@khr_gltf) with the tree of groups.

use std::collections::HashMap;

use glanz_math::{DMat4, DVec3};
use glanz_scene::description::GroupDescription;
use glanz_scene::tessellation::GroupMesh;
use serde_json::{Value, json};

use super::{MAX_INSTANCES, MeshMaterial, TessellatedError, TessellatedScene};
use crate::glb::{Buffer, file};

/// The bytes of a GLB file: a mesh per group, a node per instance with its name (that of its group, if it has none), materials by metallic and roughness.
/// Materials that let light pass have the extension `KHR_materials_transmission`.
///
/// # Errors
/// [`TessellatedError`].
pub fn write_glb(scene: &TessellatedScene<'_>) -> Result<Vec<u8>, TessellatedError> {
    let mut writer = GlbScene { scene, buffer: Buffer::default(), meshes: Vec::new(), nodes: Vec::new() };
    let groups = scene.description.groups.iter().zip(&scene.tessellation.groups);
    let numbers: Vec<Option<usize>> = groups.map(|(group, mesh)| writer.mesh(group, mesh)).collect();
    let world = writer.mesh(&scene.description.world, &scene.tessellation.world);
    let root = writer.node(scene.name, world, scene.to_file);
    writer.instances(root, &numbers)?;
    writer.finish()
}

struct GlbScene<'a> {
    scene: &'a TessellatedScene<'a>,
    buffer: Buffer,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

/// The vertices and triangles of one material.
#[derive(Default)]
struct PrimitiveLists {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

impl GlbScene<'_> {
    /// Adds the mesh of a group; `None` if it has no triangles.
    fn mesh(&mut self, group: &GroupDescription, mesh: &GroupMesh) -> Option<usize> {
        let mut order: Vec<usize> = Vec::new();
        let mut lists: HashMap<usize, PrimitiveLists> = HashMap::new();
        for (description, shape) in group.shapes.iter().zip(&mesh.shapes) {
            if shape.triangles.is_empty() {
                continue;
            }
            let list = lists.entry(description.material).or_insert_with(|| {
                order.push(description.material);
                PrimitiveLists::default()
            });
            let base = list.positions.len() as u32;
            let position = |i: u32| mesh.positions.get(i as usize).copied().unwrap_or_default();
            let vertices = &shape.vertices;
            list.positions
                .extend(vertices.iter().map(|vertex| position(vertex.position).as_vec3().to_array()));
            let normal = |normal: DVec3| normal.normalize_or(DVec3::Z).as_vec3().to_array();
            list.normals.extend(vertices.iter().map(|vertex| normal(vertex.normal)));
            list.indices.extend(shape.triangles.iter().map(|corners| corners.map(|i| base + i)));
        }
        if order.is_empty() {
            return None;
        }
        let primitives: Vec<Value> = order
            .into_iter()
            .filter_map(|material| {
                let list = lists.remove(&material)?;
                let attributes = json!({
                    "POSITION": self.buffer.vectors(&list.positions, true),
                    "NORMAL": self.buffer.vectors(&list.normals, false),
                });
                let indices = self.buffer.indices(&list.indices);
                Some(json!({ "attributes": attributes, "indices": indices, "material": material }))
            })
            .collect();
        let name = if group.name.is_empty() { self.scene.name } else { &group.name };
        self.meshes.push(json!({ "name": name, "primitives": primitives }));
        Some(self.meshes.len() - 1)
    }

    fn node(&mut self, name: &str, mesh: Option<usize>, matrix: DMat4) -> usize {
        let mut node = json!({ "name": name });
        if let Some(mesh) = mesh {
            node["mesh"] = json!(mesh);
        }
        if matrix != DMat4::IDENTITY {
            node["matrix"] = json!(matrix.to_cols_array());
        }
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Adds a node below the root for each instance in the world, and those inside.
    fn instances(&mut self, root: usize, meshes: &[Option<usize>]) -> Result<(), TessellatedError> {
        let description = self.scene.description;
        let mut waiting = vec![(root, &description.world)];
        while let Some((parent, group)) = waiting.pop() {
            let mut children = Vec::with_capacity(group.instances.len());
            for instance in &group.instances {
                let Some(inner) = description.groups.get(instance.group) else { continue };
                if self.nodes.len() >= MAX_INSTANCES {
                    return Err(TessellatedError::Instances(MAX_INSTANCES));
                }
                let mesh = meshes.get(instance.group).copied().flatten();
                let name = if instance.name.is_empty() { &inner.name } else { &instance.name };
                let node = self.node(name, mesh, instance.to_parent);
                children.push(node);
                waiting.push((node, inner));
            }
            if let Some(node) = self.nodes.get_mut(parent).filter(|_| !children.is_empty()) {
                node["children"] = json!(children);
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Vec<u8>, TessellatedError> {
        let materials: Vec<Value> = self.scene.materials.iter().map(material).collect();
        let transmits = self.scene.materials.iter().any(|material| material.transmission > 0.0);
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("Glanz ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": self.nodes,
        });
        if transmits {
            document["extensionsUsed"] = json!(["KHR_materials_transmission"]);
        }
        // Empty lists are not allowed.
        let lists = [
            ("meshes", &self.meshes),
            ("materials", &materials),
            ("accessors", &self.buffer.accessors),
            ("bufferViews", &self.buffer.views),
        ];
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            document[name] = json!(list);
        }
        if !self.buffer.bytes.is_empty() {
            document["buffers"] = json!([{ "byteLength": self.buffer.bytes.len() }]);
        }
        file(document.to_string().into_bytes(), self.buffer.bytes).map_err(|_| TessellatedError::Size)
    }
}

fn material(material: &MeshMaterial) -> Value {
    let [r, g, b] = material.base;
    let mut value = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        },
        // Surfaces that enclose nothing are seen from both sides.
        "doubleSided": true,
    });
    if !material.name.is_empty() {
        value["name"] = json!(material.name);
    }
    if material.transmission > 0.0 {
        value["extensions"] =
            json!({ "KHR_materials_transmission": { "transmissionFactor": material.transmission } });
    }
    value
}
