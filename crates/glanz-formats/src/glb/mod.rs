//! Models as binary glTF 2.0 (@khr_gltf): triangles, with pictures of the light on them.
//!
//! glTF has no light maps. Every viewer supports materials without shading (`KHR_materials_unlit`) whose base colour is a
//! picture; the coordinates of the picture are the second set, `TEXCOORD_1`, as is customary for light maps. Viewers without support for the
//! extension shade the base colour. The first set, `TEXCOORD_0`, contains the surface's own coordinates.

use serde_json::{Value, json};

mod camera;
#[cfg(test)]
mod tests;

pub use camera::{GlbCamera, Projection};

/// A model to write.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlbModel {
    /// Pictures, as the bytes of PNG files.
    pub pictures: Vec<Vec<u8>>,
    /// Named nodes.
    pub nodes: Vec<GlbNode>,
    /// The camera.
    pub camera: Option<GlbCamera>,
}

/// A node of a model: a named list of primitives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlbNode {
    /// Its name.
    pub name: String,
    /// Its primitives.
    pub parts: Vec<GlbPrimitive>,
}

/// Triangles with one material. All lists by vertex have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlbPrimitive {
    /// Index of its picture; without one it is black.
    pub picture: Option<usize>,
    /// Metres, y up.
    pub positions: Vec<[f32; 3]>,
    /// Unit length.
    pub normals: Vec<[f32; 3]>,
    /// The surface's own coordinates, and those in the picture, (0, 0) its upper left corner; without a picture the latter are not written.
    pub coordinates: [Vec<[f32; 2]>; 2],
    /// Triples of vertices, counterclockwise seen from the visible side.
    pub indices: Vec<[u32; 3]>,
}

/// Errors of writing a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// Lists by vertex of different lengths, or a triangle with a vertex that does not exist.
    #[error(
        "part {1} of \"{0}\" has lists of different lengths, or a triangle with a vertex that does not exist"
    )]
    Lists(String, usize),
    /// A picture that does not exist.
    #[error("part {1} of \"{0}\" refers to a picture that does not exist")]
    Picture(String, usize),
    /// A camera with an empty picture or range, or with an invalid position or rotation.
    #[error("the camera \"{0}\" has an empty picture or range, or no valid position and rotation")]
    Camera(String),
    /// More than the format can hold.
    #[error("the model has more than 4 GiB, which this format cannot hold")]
    Size,
}

/// Numbers of the format: kinds of components and of buffers, of filters and of borders.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINEAR: u32 = 9729;
const CLAMP_TO_EDGE: u32 = 33071;

/// The binary chunk with its views and accessors.
#[derive(Default)]
pub(crate) struct Buffer {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
}

impl Buffer {
    /// Adds bytes as a view of their own; returns its number.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, mut accessor: Value, view: usize) -> usize {
        accessor["bufferView"] = json!(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds vectors as an accessor; returns its number.
    pub(crate) fn vectors<const N: usize>(&mut self, list: &[[f32; N]], with_bounds: bool) -> usize {
        let bytes: Vec<u8> = list.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let mut accessor = json!({ "componentType": FLOAT, "count": list.len(), "type": format!("VEC{N}") });
        if with_bounds {
            let bound = |pick: fn(f32, f32) -> f32| {
                (0..N)
                    .map(|i| list.iter().map(|p| p[i]).reduce(pick).unwrap_or_default())
                    .collect::<Vec<f32>>()
            };
            accessor["min"] = json!(bound(f32::min));
            accessor["max"] = json!(bound(f32::max));
        }
        self.accessor(accessor, view)
    }

    /// Adds the corners of triangles as an accessor; returns its number.
    pub(crate) fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let count = 3 * triangles.len();
        self.accessor(json!({ "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR" }), view)
    }

    fn part(&mut self, part: &GlbPrimitive) -> Value {
        let position = self.vectors(&part.positions, true);
        let normal = self.vectors(&part.normals, false);
        let own = self.vectors(&part.coordinates[0], false);
        let mut attributes = json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": own });
        if part.picture.is_some() {
            attributes["TEXCOORD_1"] = json!(self.vectors(&part.coordinates[1], false));
        }
        let indices = self.indices(&part.indices);
        json!({
            "attributes": attributes,
            "indices": indices,
            // The first material is black.
            "material": part.picture.map_or(0, |picture| picture + 1),
        })
    }
}

/// The bytes of a file with the model; they depend on the model alone. Parts without triangles are left out.
///
/// # Errors
/// [`GlbError`].
pub fn write(model: &GlbModel) -> Result<Vec<u8>, GlbError> {
    let mut buffer = Buffer::default();
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    for node in &model.nodes {
        let mut primitives = Vec::new();
        for (number, part) in node.parts.iter().enumerate().filter(|(_, part)| !part.indices.is_empty()) {
            check(part, model).map_err(|error| error(node.name.clone(), number))?;
            primitives.push(buffer.part(part));
        }
        if !primitives.is_empty() {
            nodes.push(json!({ "name": node.name, "mesh": meshes.len() }));
            meshes.push(json!({ "name": node.name, "primitives": primitives }));
        }
    }
    let mut cameras = Vec::new();
    if let Some(camera) = &model.camera {
        if !camera.is_valid() {
            return Err(GlbError::Camera(camera.name.clone()));
        }
        let (camera, node) = camera.values(0);
        cameras.push(camera);
        nodes.push(node);
    }
    let unlit = |name: &str, base: Value| {
        let mut base = base;
        base["metallicFactor"] = json!(0.0);
        base["roughnessFactor"] = json!(1.0);
        json!({ "name": name, "pbrMetallicRoughness": base, "extensions": { "KHR_materials_unlit": {} } })
    };
    let mut materials = vec![unlit("dark", json!({ "baseColorFactor": [0.0, 0.0, 0.0, 1.0] }))];
    let (mut images, mut textures) = (Vec::new(), Vec::new());
    for (number, picture) in model.pictures.iter().enumerate() {
        let view = buffer.view(picture, None);
        images
            .push(json!({ "name": format!("light {number}"), "bufferView": view, "mimeType": "image/png" }));
        textures.push(json!({ "source": number, "sampler": 0 }));
        let texture = json!({ "baseColorTexture": { "index": number, "texCoord": 1 } });
        materials.push(unlit(&format!("light {number}"), texture));
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("Glanz ", env!("CARGO_PKG_VERSION")) },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{}],
        "materials": materials,
    });
    // Empty lists are not allowed.
    let lists = [
        ("nodes", &nodes),
        ("meshes", &meshes),
        ("accessors", &buffer.accessors),
        ("bufferViews", &buffer.views),
        ("images", &images),
        ("textures", &textures),
        ("cameras", &cameras),
    ];
    for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        document[name] = json!(list);
    }
    if !nodes.is_empty() {
        document["scenes"] = json!([{ "nodes": (0..nodes.len()).collect::<Vec<usize>>() }]);
    }
    if !textures.is_empty() {
        // No mipmaps: they would mix neighbouring charts of a picture, and light varies slowly enough without them.
        let sampler = json!({
            "magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE
        });
        document["samplers"] = json!([sampler]);
    }
    if !buffer.bytes.is_empty() {
        document["buffers"] = json!([{ "byteLength": buffer.bytes.len() }]);
    }
    file(document.to_string().into_bytes(), buffer.bytes)
}

fn check(part: &GlbPrimitive, model: &GlbModel) -> Result<(), fn(String, usize) -> GlbError> {
    let count = part.positions.len();
    let [own, light] = &part.coordinates;
    let fits = [part.normals.len(), own.len(), light.len()] == [count; 3];
    if !fits || part.indices.iter().flatten().any(|&i| i as usize >= count) {
        return Err(GlbError::Lists);
    }
    if part.picture.is_some_and(|picture| picture >= model.pictures.len()) {
        return Err(GlbError::Picture);
    }
    Ok(())
}

/// The bytes of a file with its header and chunks: JSON, padded with blanks, and the binary part, padded with zeros.
pub(crate) fn file(mut json: Vec<u8>, mut bytes: Vec<u8>) -> Result<Vec<u8>, GlbError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let with_bytes = !bytes.is_empty();
    let length = 12 + 8 + json.len() + if with_bytes { 8 + bytes.len() } else { 0 };
    let word = |n: usize| u32::try_from(n).map(u32::to_le_bytes).map_err(|_| GlbError::Size);
    let mut file = Vec::with_capacity(length);
    file.extend_from_slice(b"glTF");
    file.extend_from_slice(&2_u32.to_le_bytes());
    file.extend_from_slice(&word(length)?);
    file.extend_from_slice(&word(json.len())?);
    file.extend_from_slice(b"JSON");
    file.append(&mut json);
    if with_bytes {
        file.extend_from_slice(&word(bytes.len())?);
        file.extend_from_slice(b"BIN\0");
        file.append(&mut bytes);
    }
    Ok(file)
}
