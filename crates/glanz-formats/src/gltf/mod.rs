//! glTF 2.0, as text and binary (@khr_gltf): meshes, materials, textures, the camera and lights.
//!
//! `container` divides a file, `json` finds values and tells their places, `buffers` and `accessor` check lists before anything is
//! allocated; `nodes` walks the tree of the default scene, `mesh`, `material`, `principled`, `texture` and `view` make the description of what its nodes
//! name. What is only named is not read. Messages name the place by a JSON pointer (RFC 6901).
//!
//! Memory is in proportion to the size of the file: elements of accessors may be used [`ELEMENTS_PER_BYTE`] times per byte, a node once, pictures as
//! many times as [`ModelReader::picture`] allows.

mod accessor;
mod buffers;
mod container;
mod error;
mod json;
mod material;
mod mesh;
mod nodes;
mod principled;
#[cfg(test)]
mod tests;
mod texture;
mod view;

use std::collections::BTreeMap;

use buffers::Buffers;
use error::GltfError;
use glanz_scene::Severity;
use json::Document;
use material::GltfMaterial;
use texture::PictureKey;

use crate::model::ModelReader;

pub(crate) use container::is_gltf;

/// Extensions that a file may require.
const READ: [&str; 16] = [
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_iridescence",
    "KHR_materials_anisotropy",
    "KHR_materials_dispersion",
    "KHR_materials_diffuse_transmission",
];

/// Elements of accessors that may be used, per byte of the file and its buffers, and in any case.
const ELEMENTS_PER_BYTE: usize = 4;
const FREE_ELEMENTS: usize = 10_000;

/// Bytes of a parsed object, and of a value in a list or an object, which grows.
const JSON_OBJECT: u64 = 700;
const JSON_VALUE: u64 = 96;

/// State of the reader.
struct GltfReader<'a, 'b> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    reader: &'b mut ModelReader,
    /// The materials by their numbers; `None`: the default one.
    materials: BTreeMap<Option<usize>, GltfMaterial>,
    /// Index of each picture that was read; `None`: it cannot be read.
    pictures: BTreeMap<PictureKey, Option<usize>>,
    /// Elements of accessors that may still be used.
    elements_left: usize,
    /// Radiance of one unit of emission, W/(m^2 sr): one lumen where the scene has lights, else that of a white surface in the light of
    /// the studio.
    radiance_unit: f32,
}

/// Adds a file to the description.
pub(crate) fn read(bytes: &[u8], reader: &mut ModelReader) {
    if let Err(error) = read_file(bytes, reader) {
        reader.error("gltf", error.place, error.error.to_string());
    }
}

/// An error with line and column, if it is one of the syntax of a text.
struct PlacedError {
    place: Option<(u32, u32)>,
    error: GltfError,
}

impl From<GltfError> for PlacedError {
    fn from(error: GltfError) -> Self {
        Self { place: None, error }
    }
}

fn read_file(bytes: &[u8], reader: &mut ModelReader) -> Result<(), PlacedError> {
    let parts = container::split(bytes)?;
    let budget = reader.finder.budget.clone();
    let _reserved =
        budget.reserve(json_memory(parts.json)).map_err(|end| GltfError::of_file(end.to_string()))?;
    let document = Document::parse(parts.json, &budget).map_err(|error| {
        let in_text = parts.json.len() == bytes.len();
        let place = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).max(1);
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        PlacedError {
            place: in_text.then(|| (place(error.line()), place(error.column()))),
            error: GltfError::of_file(format!("the file is not valid JSON: {message}")),
        }
    })?;
    check(&document, reader)?;
    let buffers = match Buffers::read(&document, parts.binary, reader) {
        Err(error) if reader.finder.lists => {
            return Ok(buffers::name_files(&document, reader).map_err(|_| error)?);
        }
        buffers => buffers?,
    };
    let size = bytes.len().saturating_add(buffers.size());
    let mut gltf = GltfReader {
        document: &document,
        buffers: &buffers,
        reader,
        materials: BTreeMap::new(),
        pictures: BTreeMap::new(),
        elements_left: size.saturating_mul(ELEMENTS_PER_BYTE).saturating_add(FREE_ELEMENTS),
        radiance_unit: 1.0,
    };
    gltf.scene()?;
    let world = &reader.description.world;
    if world.shapes.is_empty() && world.instances.is_empty() {
        return Err(GltfError::of_file("the default scene of the file has no triangles").into());
    }
    Ok(())
}

/// Bytes of the parsed text.
fn json_memory(text: &[u8]) -> u64 {
    let of_byte = |&byte: &u8| match byte {
        b'{' => JSON_OBJECT + JSON_VALUE,
        b',' | b':' | b'[' => JSON_VALUE,
        _ => 0,
    };
    text.iter().map(of_byte).fold(text.len() as u64, u64::saturating_add)
}

/// Checks version and required extensions, and reports what is not read.
fn check(document: &Document, reader: &mut ModelReader) -> Result<(), GltfError> {
    let root = document.root()?;
    root.object("asset", |asset| {
        let asset =
            asset.ok_or_else(|| GltfError::of_file("\"asset\" is missing; this is not a glTF file"))?;
        let needed = asset.text("minVersion")?.or(asset.text("version")?).unwrap_or_default();
        match needed.split('.').next() {
            Some("2") => Ok(()),
            _ => Err(asset.error("version", format!("version {needed:?} of glTF is not read, only 2.0"))),
        }
    })?;
    let path = root.path().name("extensionsRequired");
    let required = root.list("extensionsRequired")?.iter().filter_map(|name| name.as_str());
    let unknown: Vec<&str> = required.filter(|name| !READ.contains(name)).collect();
    if !unknown.is_empty() {
        let help = |name: &str| match name {
            "KHR_draco_mesh_compression" => Some(mesh::DRACO_HELP),
            "EXT_meshopt_compression" => Some(buffers::MESHOPT_HELP),
            _ => None,
        };
        let names = unknown.join(", ");
        let message = format!("the file requires extensions that are not read: {names}");
        let help =
            unknown.iter().find_map(|name| help(name)).map(|help| format!("; {help}")).unwrap_or_default();
        return Err(path.error(message + &help));
    }
    if document.length("animations") > 0 {
        let message = "animations are not read; the scene at rest stands in".to_owned();
        reader.report(Severity::Warning, "gltf-animation", None, message);
    }
    Ok(())
}
