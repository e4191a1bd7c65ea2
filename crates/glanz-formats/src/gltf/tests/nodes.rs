//! The tree of nodes.

use super::*;

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

#[test]
fn what_shapes_of_a_file_lack_is_reported() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let meshes = json!([{ "primitives": [{ "attributes": { "POSITION": position }, "material": 0 }] }]);
    let volume =
        json!({ "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 0.5, 0.5] });
    let glass = json!({ "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": volume } });
    let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&data.bytes));
    let mut file = data.file(json!({ "meshes": meshes, "materials": [glass, {}], "nodes": [{ "mesh": 0 }] }));
    file["buffers"][0]["uri"] = json!(uri);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("glass.gltf"), file.to_string()).unwrap();
    file["meshes"][0]["primitives"][0]["material"] = json!(1);
    std::fs::write(folder.path().join("clay.gltf"), file.to_string()).unwrap();
    for (before, file, parameters, expected) in [
        ("", "glass", "", vec![]),
        ("MediumInterface \"fog\"", "clay", "", vec![]),
        ("MediumInterface \"fog\"", "glass", "", vec!["stand-in-medium"]),
        ("MediumInterface \"fog\" \"\"", "clay", "", vec!["stand-in-medium"]),
        ("", "clay", "\"float alpha\" .5", vec!["stand-in-alpha"]),
    ] {
        // Twice: the file is read once.
        let shape = format!("Shape \"gltf\" \"string filename\" \"{file}.gltf\" {parameters}\n").repeat(2);
        let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"";
        let path = folder.path().join("scene.pbrt");
        std::fs::write(&path, format!("WorldBegin {fog} {before}\n{shape}")).unwrap();
        let loaded = crate::load(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
        let kinds: Vec<_> = loaded.diagnostics.iter().map(|diagnostic| diagnostic.kind).collect();
        assert_eq!(kinds, expected.repeat(2), "{before} {file} {parameters}: {}", loaded.diagnostics);
    }
}

#[test]
fn instances_may_not_create_more_lights_than_a_scene_holds() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS[..9]);
    let indices = data.bytes(&[0, 1, 2].repeat(4096));
    let primitive = json!({ "attributes": { "POSITION": position }, "indices": indices, "material": 0 });
    let file = |nodes: usize, factor: u32| {
        data.file(json!({
            "meshes": [{ "primitives": [primitive] }], "nodes": vec![json!({ "mesh": 0 }); nodes],
            "materials": [{ "emissiveFactor": [factor, 0, 0] }],
        }))
    };
    // Beside the first one, 256 times 4096 triangles are 2^20.
    assert_eq!(load(&file(257, 1)).description.world.instances.len(), 257);
    assert_eq!(load(&file(258, 0)).description.world.instances.len(), 258, "without light");
    let error = message(&file(258, 1));
    assert!(
        error.contains("/nodes/257/mesh: instances create more than 1048576 copies of lights"),
        "{error}"
    );
}
