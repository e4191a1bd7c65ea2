mod materials;

use std::sync::Arc;

use data_encoding::BASE64;
use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    CameraKind, DescriptionForm, FloatParameter, GeometryDescription, LightKind, MaterialKind,
    SpectrumParameter, SurfaceDetailDescription, TextureKind,
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
    let png = crate::image::write_srgb8(1, 2, &[[255, 0, 0], [0, 51, 102]]).unwrap();
    json!({ "uri": format!("data:image/png;base64,{}", BASE64.encode(&png)) })
}

#[test]
fn strips_and_fans_keep_their_orientation_and_unused_vertices_are_dropped() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS);
    let strip = data.bytes(&[0, 1, 2, 3]);
    let fan = data.bytes(&[1, 3, 2, 0]);
    let attributes = json!({ "POSITION": position });
    let primitive =
        |mode: u32, indices: usize| json!({ "attributes": attributes, "mode": mode, "indices": indices });
    let primitives = json!([primitive(5, strip), primitive(6, fan), primitive(1, fan)]);
    let loaded = load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })));
    let (positions, indices, normals, uvs) = triangles(&loaded, 0);
    assert_eq!(
        positions,
        [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0))
    );
    assert_eq!(indices, [[0, 1, 2], [1, 3, 2]]);
    assert!(normals.is_none() && uvs.is_none());
    assert_eq!(triangles(&loaded, 1).1, [[3, 2, 1], [2, 0, 1]]);
    assert_eq!(warnings(&loaded), "warning: m: /meshes/0/primitives/2: points and lines are left out\n");
}

#[test]
fn elements_may_be_interleaved_normalised_and_sparse() {
    let mut data = Data::default();
    // Two vertices of 3 x i16 normalised and 2 bytes of rest; the third is a sparse one.
    let bytes: Vec<u8> = [0_i16, 32767, -32768, 7, -32767, 0, 16384, 7, 0, 0, 0, 7]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 1, "componentType": 5121 },
        "values": { "bufferView": 2 },
    });
    let more = json!({ "normalized": true, "byteStride": 8, "sparse": sparse });
    let position = data.add((5122, "VEC3", 3), &bytes, more);
    data.bytes(&[2]);
    let values: Vec<u8> = [32767_i16, 32767, 32767].iter().flat_map(|x| x.to_le_bytes()).collect();
    data.add((5122, "VEC3", 1), &values, json!({}));
    let primitives = json!([{ "attributes": { "POSITION": position } }]);
    let loaded = load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })));
    let (positions, indices, ..) = triangles(&loaded, 0);
    // max(c / 32767, -1), by the specification.
    let half = 16384.0 / 32767.0;
    assert_eq!(positions, [DVec3::new(0.0, 1.0, -1.0), DVec3::new(-1.0, 0.0, half), DVec3::ONE]);
    assert_eq!(indices, [[0, 1, 2]]);
}

#[test]
fn children_are_placed_in_their_parents_and_shared_meshes_are_instances() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let mesh =
        |name: &str| json!({ "name": name, "primitives": [{ "attributes": { "POSITION": position } }] });
    // A quarter turn about z; 2 m up, then twice as large.
    let turn = [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()];
    let nodes = json!([
        { "children": [1, 2, 3], "rotation": turn, "translation": [0, 0, 7] },
        { "mesh": 0, "name": "left", "translation": [1, 0, 0] },
        { "mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 2, 1] },
        { "mesh": 1, "scale": [1, 1, 0] },
        { "mesh": 1, "scale": [1, -1, 1] },
    ]);
    let more =
        json!({ "meshes": [mesh("part"), mesh("other")], "nodes": nodes, "scenes": [{ "nodes": [4, 0] }] });
    let loaded = load(&data.file(more));
    let description = &loaded.description;
    let instances = &description.world.instances;
    assert_eq!((description.groups.len(), instances.len(), description.world.shapes.len()), (1, 2, 1));
    assert_eq!((description.groups[0].name.as_str(), instances[0].name.as_str()), ("part", "left"));
    let near = |matrix: &DMat4, from: [f64; 3], to: [f64; 3]| {
        let found = matrix.transform_point3(DVec3::from(from));
        assert!((found - DVec3::from(to)).length() < 1e-12, "{found}");
    };
    near(&instances[0].to_parent, [1.0, 0.0, 0.0], [0.0, 2.0, 7.0]);
    near(&instances[1].to_parent, [1.0, 0.0, 0.0], [0.0, 2.0, 9.0]);
    near(&description.world.shapes[0].to_parent, [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]);
}

#[test]
fn instances_of_one_node_are_instances() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let translation = data.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let scale = data.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let attributes = json!({ "TRANSLATION": translation, "SCALE": scale });
    let extensions = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let meshes = json!([{ "primitives": [{ "attributes": { "POSITION": position } }] }]);
    let loaded =
        load(&data.file(json!({ "meshes": meshes, "nodes": [{ "mesh": 0, "extensions": extensions }] })));
    let placed = loaded.description.world.instances.iter().map(|i| i.to_parent.transform_point3(DVec3::ONE));
    assert_eq!(Vec::from_iter(placed), [DVec3::new(2.0, 1.0, 1.0), DVec3::new(2.0, 5.0, 2.0)]);
}

#[test]
fn a_camera_looks_along_minus_z_and_makes_the_picture_as_wide_as_it_is() {
    let file = |camera: Value| {
        let mut file = with_material(json!({}), json!({ "cameras": [camera] }));
        file["nodes"] = json!([{ "mesh": 0 }, { "camera": 0, "translation": [1, 2, 3], "scale": [5, 5, 5] }]);
        file
    };
    let loaded = load(&file(
        json!({ "type": "perspective", "perspective": { "yfov": 1.0, "aspectRatio": 0.5, "znear": 1 } }),
    ));
    let camera = &loaded.description.camera;
    // Half as wide as high: tan(w / 2) = tan(1 / 2) / 2.
    let CameraKind::Perspective { field_of_view } = camera.kind else { panic!() };
    assert!(((0.5 * field_of_view).tan() - 0.5 * 0.5_f64.tan()).abs() < 1e-12);
    // As many pixels as 1280 x 720: sqrt(921600 / 0.5) = 1357.6.
    assert_eq!(loaded.description.film.resolution, [679, 1358]);
    assert_eq!(camera.to_world.transform_vector3(DVec3::Z), DVec3::NEG_Z);
    assert_eq!(camera.to_world.transform_vector3(DVec3::X), DVec3::X);
    assert_eq!(camera.to_world.transform_point3(DVec3::Y), DVec3::new(1.0, 3.0, 3.0));
    let studio = loaded.studio.unwrap();
    assert!(studio.own_camera && !studio.own_light);
    let loaded = load(&file(
        json!({ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 1.5, "znear": 1, "zfar": 2 } }),
    ));
    assert_eq!(loaded.description.camera.screen_window, Some([-3.0, 3.0, -1.5, 1.5]));
    assert_eq!(loaded.description.camera.kind, CameraKind::Orthographic);
}

#[test]
fn lights_shine_along_minus_z_with_watts_of_their_lumens() {
    let lights = json!([
        { "type": "point", "intensity": 683, "color": [1, 0.5, 0] },
        { "type": "directional" },
        { "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
    ]);
    let mut file = with_material(json!({ "emissiveFactor": [1, 1, 1] }), json!({}));
    file["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    let light = |number: u32| json!({ "translation": [1, 2, 3], "extensions": { "KHR_lights_punctual": { "light": number } } });
    file["nodes"] = json!([{ "mesh": 0 }, light(0), light(1), light(2)]);
    let loaded = load(&file);
    assert!(loaded.studio.unwrap().own_light);
    let [point, directional, spot] = &loaded.description.lights[..] else { panic!() };
    assert_eq!(point.emission, SpectralDistribution::Rgb([683.0, 341.5, 0.0]));
    assert!((f64::from(point.scale) * 683.0 - 1.0).abs() < 1e-6, "683 lm are a watt of white");
    assert!(
        matches!(point.kind, LightKind::Point { from, range: None } if from == DVec3::new(1.0, 2.0, 3.0))
    );
    assert!(matches!(directional.kind, LightKind::Distant { from: DVec3::ZERO, to: DVec3::NEG_Z }));
    let LightKind::Spot { to, cone_angle: 0.5, inner_angle: 0.25, .. } = spot.kind else { panic!() };
    assert_eq!(to, DVec3::new(1.0, 2.0, 2.0));
    // In a file with lights, emission is in nits, too.
    let emission = loaded.description.world.shapes[0].emission.clone().unwrap();
    assert_eq!((emission.scale, emission.two_sided), (point.scale, false));
    // Lights that no node has do not count: the studio's stand in.
    file["nodes"] = json!([{ "mesh": 0 }]);
    let loaded = load(&file);
    assert_eq!(loaded.description.world.shapes[0].emission.clone().unwrap().scale, 1.0);
    assert!(!loaded.studio.unwrap().own_light);
}

#[test]
fn primitives_may_share_vertices_with_colours() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &[0.0; 3000]);
    let color = data.add((5121, "VEC4", 1000), &[255; 4000], json!({ "normalized": true }));
    let indices = data.bytes(&[0, 1, 2]);
    let gray = data.add(
        (5121, "VEC4", 1000),
        &[[255; 12].as_slice(), &[7; 3988]].concat(),
        json!({ "normalized": true }),
    );
    let primitive = |color: usize| json!({ "attributes": { "POSITION": position, "COLOR_0": color }, "indices": indices });
    // Each uses three vertices alone, which are white.
    let primitives = [vec![primitive(color); 200], vec![primitive(gray); 200]].concat();
    assert_eq!(warnings(&load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })))), "");
}

#[test]
fn what_is_not_read_is_reported_with_its_place() {
    let material = json!({
        "extensions": {
            "KHR_materials_iridescence": {}, "KHR_materials_pbrSpecularGlossiness": {},
            "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 0 } },
            "KHR_materials_volume": { "attenuationDistance": 1 }
        }
    });
    let mut file = with_material(
        material,
        json!({ "animations": [{}], "skins": [{}], "scenes": [{ "nodes": [0] }, {}] }),
    );
    file["nodes"][0]["skin"] = json!(0);
    file["meshes"][0]["primitives"][0]["targets"] = json!([{}]);
    let found = warnings(&load(&file));
    for part in [
        "m: animations are not read",
        "m: the file has 2 scenes; scene 0 is read",
        "m: /nodes/0: skins",
        "m: /materials/0: iridescence",
        "m: /materials/0: KHR_materials_pbrSpecularGlossiness is not available",
        "m: /materials/0: clearcoatNormalTexture of KHR_materials_clearcoat is not available",
        "m: /materials/0: attenuationDistance of KHR_materials_volume is not available",
        "m: /meshes/0/primitives/0: morph targets",
    ] {
        assert!(found.contains(part), "{part}: {found}");
    }
    let options = Options { strict: true, ..Options::default() };
    let strict = load_str("m", &file.to_string(), &options).unwrap_err().to_string();
    assert!(strict.contains("error: m: /materials/0: iridescence"), "{strict}");
}

#[test]
fn errors_name_the_place_by_a_json_pointer() {
    let file = with_material(json!({}), json!({ "scenes": [{ "nodes": [0] }] }));
    let changed = |pointer: &str, value: Value| {
        let mut file = file.clone();
        let (parent, name) = pointer.rsplit_once('/').unwrap();
        match file.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(name.to_owned(), value)),
            list => list[name.parse::<usize>().unwrap()] = value,
        }
        message(&file)
    };
    for (pointer, value, expected) in [
        (
            "/asset",
            json!({ "version": "1.0" }),
            "/asset/version: version \"1.0\" of glTF is not read, only 2.0",
        ),
        ("/scenes", json!([{ "nodes": [7] }]), "element 7 of \"nodes\" does not exist; it has 1"),
        ("/nodes/0/mesh", json!(4), "/nodes/0/mesh: element 4 of \"meshes\" does not exist; it has 1"),
        (
            "/nodes/0/mesh",
            json!("x"),
            "/nodes/0/mesh: this is a text; the format needs a whole number of at least 0",
        ),
        ("/nodes/0/children", json!([0]), "/nodes/0: the node has two parents, or is its own ancestor"),
        (
            "/nodes/0/matrix",
            json!([1]),
            "/nodes/0/matrix: this is a list; the format needs a list of 16 numbers",
        ),
        ("/meshes/0/primitives/0/mode", json!(7), "/meshes/0/primitives/0/mode: the mode 7 is unknown"),
        (
            "/meshes/0/primitives/0/indices",
            json!(0),
            "/accessors/0/type: the type is \"VEC3\"; SCALAR is needed here",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({ "POSITION": 1 }),
            "/accessors/1/type: the type is \"VEC2\"; VEC3 is needed here",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({ "POSITION": 0, "NORMAL": 9 }),
            "/meshes/0/primitives/0/attributes/NORMAL: element 9",
        ),
        (
            "/accessors/0/count",
            json!(4),
            "/accessors/0: 4 elements of 12 bytes, every 12 bytes from 0 on, do not fit in the 36 bytes of the buffer view",
        ),
        ("/accessors/0/count", json!(u64::MAX), "/accessors/0/count: "),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            "/accessors/0: 3 elements of 12 bytes, every 12 bytes from 18446744073709551615 on",
        ),
        ("/accessors/0/componentType", json!(5124), "/accessors/0/componentType: the type 5124 is unknown"),
        (
            "/bufferViews/0/byteLength",
            json!(1_u64 << 40),
            "/bufferViews/0: 1099511627776 bytes from 0 on are more than buffer 0 has",
        ),
        ("/bufferViews/0/buffer", json!(1), "/bufferViews/0/buffer: buffer 1 does not exist; there are 1"),
        (
            "/buffers/0/byteLength",
            json!(1000),
            "/buffers/0: the buffer has 60 bytes instead of 1000; it may be incomplete",
        ),
        ("/buffers/0/uri", json!("data:;base64,~"), "/buffers/0/uri: the data is not base 64"),
        (
            "/buffers/0/uri",
            json!("https://x/y"),
            "/buffers/0/uri: addresses with \"https\" are not read; save the file beside the model",
        ),
        ("/buffers/0/uri", json!("a%20b.bin"), "/buffers/0/uri: file \"a b.bin\" is not there"),
        (
            "/extensionsRequired",
            json!(["KHR_texture_transform", "X_y"]),
            "/extensionsRequired: the file requires extensions that are not read: X_y",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "compression by Draco is not read; convert the file first: gltf-transform copy",
        ),
        (
            "/materials/0/pbrMetallicRoughness",
            json!({ "metallicFactor": 2 }),
            "/materials/0/pbrMetallicRoughness/metallicFactor: 2 is not between 0 and 1",
        ),
        (
            "/materials/0/pbrMetallicRoughness",
            json!({ "baseColorTexture": { "index": 0 } }),
            "element 0 of \"textures\" does not exist; it has 0",
        ),
    ] {
        let found = changed(pointer, value);
        assert!(found.contains(expected), "{pointer}: {found} instead of {expected}");
    }
    let syntax = "{ \"asset\": { \"version\": \"2.0\" },\n  \"nodes\" [] }";
    let error = load_str("m", syntax, &Options::default()).unwrap_err().to_string();
    assert!(error.starts_with("error: m:2:11: the file is not valid JSON: expected `:`"), "{error}");
    let error = load_str("m", "{}", &Options::default()).unwrap_err().to_string();
    assert_eq!(error, "error: m: \"asset\" is missing; this is not a glTF file\n");
}

#[test]
fn more_elements_than_the_file_warrants_are_refused() {
    let mut file = with_material(json!({}), json!({}));
    file["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000_u32 });
    assert!(message(&file).contains("/accessors/0/count: 4000000000 zeros are more than the file can need"));
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let indices = data.bytes(&[0, 1, 2].repeat(1000));
    let primitive = json!({ "attributes": { "POSITION": position }, "indices": indices });
    let meshes = json!([{ "primitives": vec![primitive; 1000] }]);
    let found = message(&data.file(json!({ "meshes": meshes })));
    assert!(found.contains("/indices: the elements of the file are used too often"), "{found}");
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

#[test]
fn a_scene_places_a_file_with_its_own_materials_and_without_its_camera() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let meshes = json!([{ "primitives": [{ "attributes": { "POSITION": position }, "material": 0 }] }]);
    let materials = json!([{ "name": "lamp", "emissiveFactor": [1, 1, 1] }]);
    let cameras = json!([{ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 1.5, "znear": 1, "zfar": 2 } }]);
    let mut file =
        data.file(json!({ "meshes": meshes, "materials": materials, "cameras": cameras, "nodes": [{ "mesh": 0, "camera": 0 }] }));
    file["buffers"][0]["uri"] = json!("m.bin");
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/m.bin"), &data.bytes).unwrap();
    std::fs::write(folder.path().join("parts/m.gltf"), file.to_string()).unwrap();
    let shape = "Shape \"gltf\" \"string filename\" \"parts/m.gltf\"\n";
    let scene = format!("WorldBegin\nShape \"sphere\"\nTranslate 1 2 3\n{shape}Translate 1 0 0\n{shape}");
    std::fs::write(folder.path().join("scene.pbrt"), scene).unwrap();
    let options = Options { confined: true, ..Options::default() };
    let loaded =
        crate::load(&folder.path().join("scene.pbrt"), &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&loaded), "");
    let description = &loaded.description;
    let placed = description.world.instances.iter().map(|i| (i.group, i.to_parent.w_axis.truncate()));
    assert_eq!(Vec::from_iter(placed), [(0, DVec3::new(1.0, 2.0, 3.0)), (0, DVec3::new(2.0, 2.0, 3.0))]);
    let lamp = &description.groups[0].shapes[0];
    assert_eq!(description.materials[lamp.material].name, "lamp");
    assert!(lamp.emission.is_some() && description.world.shapes.len() == 1);
    assert!(matches!(description.camera.kind, CameraKind::Perspective { .. }));
    assert_eq!(loaded.sources.paths().len(), 3, "the scene, the file and its buffer");
}
