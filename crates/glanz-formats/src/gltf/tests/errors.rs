//! Errors, and reports of what is left out.

use super::*;

#[test]
fn what_is_not_read_is_reported_with_its_place() {
    let material = json!({
        "extensions": {
            "KHR_materials_iridescence": {}, "KHR_materials_pbrSpecularGlossiness": {},
            "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 0 } }
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
fn a_file_that_several_buffers_name_counts_once() {
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 100 });
    let mut file = with_material(json!({}), json!({}));
    file["accessors"][0] = zeros;
    file["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    let buffer = |name: &str| json!({ "byteLength": 60, "uri": name });
    file["buffers"] = json!([buffer("m.bin"), buffer("./m.bin"), buffer("%6d.bin")]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.bin"), [0; 60]).unwrap();
    std::fs::write(folder.path().join("m.gltf"), file.to_string()).unwrap();
    let error = crate::load(&folder.path().join("m.gltf"), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("100 zeros are more than the file can need"), "{error}");
}

#[test]
fn indices_have_no_sign() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let indices = data.add((5120, "SCALAR", 3), &[0, 1, 0xff], json!({}));
    let primitives = json!([{ "attributes": { "POSITION": position }, "indices": indices }]);
    let mut file = data.file(json!({ "meshes": [{ "primitives": primitives }] }));
    let expected = "componentType: indices are whole numbers without a sign";
    assert!(message(&file).contains(&format!("/accessors/1/{expected}")));
    // Of elements that replace others, too.
    let values = json!({ "bufferView": 0 });
    file["accessors"][0]["sparse"] =
        json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5126 }, "values": values });
    assert!(message(&file).contains(&format!("/accessors/0/sparse/indices/{expected}")));
}
