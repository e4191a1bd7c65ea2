mod errors;
mod materials;
mod meshes;
mod nodes;
mod view;

use std::sync::Arc;

use data_encoding::BASE64;
use glanz_light::{SpectralDistribution, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    CameraKind, DescriptionForm, FloatParameter, GeometryDescription, LightKind, MaterialKind,
    SpectrumParameter, SurfaceDetailDescription, SurfaceMedia, TextureKind,
};
use glanz_shading::model::{PrincipledMaterial, Roughness, RoughnessScale};
use serde_json::{Value, json};

use crate::glb::{GlbModel, GlbNode, GlbPrimitive};
use crate::registry::{Loaded, Options, load_str};

/// A buffer with its views and accessors.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// Adds an accessor for `bytes`; `more`: its members besides those that are given.
    fn add(&mut self, (component, kind, count): (u32, &str, usize), bytes: &[u8], more: Value) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut accessor = json!({ "componentType": component, "type": kind, "count": count, "bufferView": self.views.len() });
        for (name, value) in more.as_object().unwrap() {
            match name.as_str() {
                "byteStride" => view[name] = value.clone(),
                _ => accessor[name] = value.clone(),
            }
        }
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 1,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add((5126, kind, numbers.len() / width), &bytes, json!({}))
    }

    fn bytes(&mut self, numbers: &[u8]) -> usize {
        self.add((5121, "SCALAR", numbers.len()), numbers, json!({}))
    }

    /// The text of a file with more members.
    fn file(&self, more: Value) -> Value {
        let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&self.bytes));
        let mut file = json!({
            "asset": { "version": "2.0" },
            "buffers": [{ "byteLength": self.bytes.len(), "uri": uri }],
            "bufferViews": self.views,
            "accessors": self.accessors,
            "nodes": [{ "mesh": 0 }],
        });
        for (name, value) in more.as_object().unwrap() {
            file[name] = value.clone();
        }
        file
    }
}

const CORNERS: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 1.0, 2.0, 0.0, 5.0, 5.0, 5.0];

fn load(file: &Value) -> Loaded {
    load_str("m", &file.to_string(), &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn message(file: &Value) -> String {
    load_str("m", &file.to_string(), &Options::default()).unwrap_err().to_string()
}

fn warnings(loaded: &Loaded) -> String {
    loaded.diagnostics.to_string()
}

/// Positions, triangles, normals and texture coordinates of a shape of the world.
#[allow(clippy::type_complexity)]
fn triangles(
    loaded: &Loaded,
    shape: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>, Option<Vec<DVec3>>, Option<Vec<DVec2>>) {
    match loaded.description.world.shapes[shape].geometry.clone() {
        GeometryDescription::Triangles { positions, indices, normals, uvs } => {
            (positions, indices, normals, uvs)
        }
        other => panic!("{other:?}"),
    }
}

/// A triangle with the material.
fn with_material(material: Value, more: Value) -> Value {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let uv = data.floats("VEC2", &[0.0, 0.25, 1.0, 0.0, 0.0, 1.0]);
    let attributes = json!({ "POSITION": position, "TEXCOORD_0": uv });
    let meshes = json!([{ "primitives": [{ "attributes": attributes, "material": 0 }] }]);
    let mut members = json!({ "meshes": meshes, "materials": [material] });
    for (name, value) in more.as_object().unwrap() {
        members[name] = value.clone();
    }
    data.file(members)
}

/// A picture of two pixels, red over black with green and blue of 1/5 and 2/5.
fn picture() -> Value {
    json!({ "uri": format!("data:image/png;base64,{}", BASE64.encode(&picture_bytes())) })
}

fn picture_bytes() -> Vec<u8> {
    crate::image::write_srgb8(1, 2, &[[255, 0, 0], [0, 51, 102]]).unwrap()
}

#[test]
fn a_model_with_light_that_was_written_here_opens_again() {
    let part = |picture: Option<usize>| GlbPrimitive {
        picture,
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        coordinates: [vec![[0.5, 0.5]; 3], vec![[0.0, 0.0], [1.0, 0.25], [0.0, 1.0]]],
        indices: vec![[0, 1, 2]],
    };
    let png = crate::image::write_srgb8(1, 1, &[[255, 0, 0]]).unwrap();
    let node = GlbNode { name: "wall".to_owned(), parts: vec![part(Some(0)), part(None)] };
    let model = GlbModel { pictures: vec![png], nodes: vec![node], camera: None };
    let bytes: Arc<[u8]> = crate::glb::write(&model).unwrap().into();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    std::fs::write(&path, &bytes).unwrap();
    let loaded = crate::load(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    // The picture of light has the second set of coordinates.
    assert_eq!(triangles(&loaded, 0).3.unwrap(), [[0.0, 1.0], [1.0, 0.75], [0.0, 0.0]].map(DVec2::from));
    let kind =
        |shape: usize| &loaded.description.materials[loaded.description.world.shapes[shape].material].kind;
    for shape in 0..2 {
        assert!(matches!(kind(shape), MaterialKind::Diffuse(material) if material.reflectance == 0.0.into()));
    }
    let emission = |shape: usize| loaded.description.world.shapes[shape].emission.clone();
    let light = emission(0).unwrap();
    assert_eq!(
        (light.radiance, light.scale, light.image),
        (SpectralDistribution::Rgb([1.0; 3]), 1.0, Some(0))
    );
    assert!(emission(1).is_none() && warnings(&loaded).is_empty());
    // Cut anywhere, it is an error.
    for end in 4..bytes.len() {
        std::fs::write(&path, &bytes[..end]).unwrap();
        assert!(crate::load(&path, &Options::default()).is_err(), "{end}");
    }
}
