use super::*;

fn model() -> GlbModel {
    let part = GlbPrimitive {
        picture: Some(0),
        positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, -1.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        coordinates: [vec![[0.0, 0.0]; 3], vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]],
        indices: vec![[0, 1, 2]],
    };
    let dark = GlbPrimitive { picture: None, ..part.clone() };
    let nodes = vec![
        GlbNode { name: "a \"wall\"".into(), parts: vec![part, dark] },
        GlbNode { name: "nothing".into(), parts: vec![GlbPrimitive::default()] },
    ];
    GlbModel { pictures: vec![b"not really a picture".to_vec()], nodes, camera: None }
}

fn camera() -> GlbCamera {
    let projection = Projection::Perspective { field_of_view: 0.75, aspect: 1.5 };
    let half = 0.5_f32.sqrt();
    GlbCamera {
        name: "camera".into(),
        projection,
        range: [0.125, 100.0],
        position: [1.0, 2.0, 3.0],
        rotation: [0.0, half, 0.0, half],
    }
}

/// The parts of a file: its JSON and its bytes.
fn read(file: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&file[..4], b"glTF");
    assert_eq!((word(4), word(8)), (2, file.len()));
    let json = word(12);
    assert_eq!(&file[16..20], b"JSON");
    assert!(json % 4 == 0);
    let document = serde_json::from_slice(&file[20..20 + json]).unwrap();
    if file.len() == 20 + json {
        return (document, Vec::new());
    }
    let bytes = word(20 + json);
    assert_eq!(&file[24 + json..28 + json], b"BIN\0");
    assert_eq!(28 + json + bytes, file.len());
    (document, file[28 + json..].to_vec())
}

#[test]
fn written_models_are_read_by_the_rules_of_the_format() {
    let (document, bytes) = read(&write(&model()).unwrap());
    assert_eq!(document["asset"]["version"], "2.0");
    assert_eq!(document["nodes"].as_array().unwrap().len(), 1);
    assert_eq!(document["nodes"][0]["name"], "a \"wall\"");
    assert_eq!(document["buffers"][0]["byteLength"].as_u64().unwrap() as usize, bytes.len());
    let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!((&primitives[0]["material"], &primitives[1]["material"]), (&json!(1), &json!(0)));
    let has_place = |number: usize| primitives[number]["attributes"]["TEXCOORD_1"].is_number();
    assert!(has_place(0) && !has_place(1));
    let lit = &document["materials"][1];
    assert_eq!(lit["pbrMetallicRoughness"]["baseColorTexture"], json!({ "index": 0, "texCoord": 1 }));
    assert!(lit["extensions"]["KHR_materials_unlit"].is_object());

    let bytes_of = |view: &Value| {
        let view = &document["bufferViews"][view.as_u64().unwrap() as usize];
        let (from, length) =
            (view["byteOffset"].as_u64().unwrap() as usize, view["byteLength"].as_u64().unwrap());
        assert_eq!(from % 4, 0);
        &bytes[from..from + length as usize]
    };
    let accessor = |number: &Value| &document["accessors"][number.as_u64().unwrap() as usize];
    let position = accessor(&primitives[0]["attributes"]["POSITION"]);
    assert_eq!((&position["min"], &position["max"]), (&json!([0.0, 0.0, -1.0]), &json!([2.0, 3.0, 0.0])));
    assert_eq!((&position["count"], &position["type"]), (&json!(3), &json!("VEC3")));
    assert_eq!(bytes_of(&position["bufferView"])[12..16], 2.0_f32.to_le_bytes());
    let indices = accessor(&primitives[0]["indices"]);
    assert_eq!(bytes_of(&indices["bufferView"]), [0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(bytes_of(&document["images"][0]["bufferView"]), b"not really a picture");
}

#[test]
fn a_camera_is_a_node_of_the_scene() {
    for projection in [camera().projection, Projection::Orthographic([4.0, 3.0])] {
        let seen = GlbModel { camera: Some(GlbCamera { projection, ..camera() }), ..model() };
        let (document, _) = read(&write(&seen).unwrap());
        assert_eq!(document["scenes"][0]["nodes"], json!([0, 1]));
        let node = &document["nodes"][1];
        assert_eq!((&node["camera"], &node["translation"]), (&json!(0), &json!([1.0, 2.0, 3.0])));
        let camera = &document["cameras"][0];
        let kind = camera["type"].as_str().unwrap();
        let expected = match projection {
            Projection::Perspective { .. } => {
                json!({ "yfov": 0.75, "aspectRatio": 1.5, "znear": 0.125, "zfar": 100.0 })
            }
            Projection::Orthographic(_) => json!({ "xmag": 4.0, "ymag": 3.0, "znear": 0.125, "zfar": 100.0 }),
        };
        assert_eq!(camera[kind], expected);
    }
    let (document, _) = read(&write(&model()).unwrap());
    assert!(document["cameras"].is_null());
}

#[test]
fn an_empty_model_has_no_empty_lists() {
    let (document, bytes) = read(&write(&GlbModel::default()).unwrap());
    assert!(bytes.is_empty());
    for (name, value) in document.as_object().unwrap() {
        assert!(!value.as_array().is_some_and(Vec::is_empty), "{name}");
    }
}

#[test]
fn invalid_models_are_refused() {
    let mut wrong = model();
    wrong.nodes[0].parts[1].normals.pop();
    assert_eq!(write(&wrong), Err(GlbError::Lists("a \"wall\"".into(), 1)));
    let mut wrong = model();
    wrong.nodes[0].parts[0].indices.push([0, 1, 3]);
    assert_eq!(write(&wrong), Err(GlbError::Lists("a \"wall\"".into(), 0)));
    let mut wrong = model();
    wrong.pictures.clear();
    assert_eq!(write(&wrong), Err(GlbError::Picture("a \"wall\"".into(), 0)));
    let projection = Projection::Perspective { field_of_view: 3.2, aspect: 1.5 };
    for camera in [
        GlbCamera { projection, ..camera() },
        GlbCamera { projection: Projection::Orthographic([0.0, 1.0]), ..camera() },
        GlbCamera { range: [0.0, 1.0], ..camera() },
        GlbCamera { range: [1.0, 1.0], ..camera() },
        GlbCamera { rotation: [0.0, 1.0, 0.0, 1.0], ..camera() },
        GlbCamera { position: [0.0, f32::NAN, 0.0], ..camera() },
    ] {
        let wrong = GlbModel { camera: Some(camera), ..model() };
        assert_eq!(write(&wrong), Err(GlbError::Camera("camera".into())));
    }
}
