use glanz_scene::description::{InstanceDescription, MaterialDescription, MaterialKind, ShapeDescription};
use glanz_scene::tessellation::{TessellationProgress, TessellationSettings};
use serde_json::Value;

use super::*;
use crate::ply::read as read_ply;

/// A box in a group that occurs twice, as "left" and mirrored without a name, and a ball of another material in the world.
fn described() -> (Description, SceneTessellation) {
    let cuboid = ShapeDescription::cuboid([0.0; 3], [1.0, 2.0, 3.0]).bounding(0);
    let ball = ShapeDescription { material: 1, ..ShapeDescription::sphere(0.5) };
    let instance = |name: &str, matrix: DMat4| InstanceDescription {
        name: name.into(),
        group: 0,
        to_parent: matrix,
        location: None,
    };
    let description = Description {
        materials: vec![MaterialDescription::from(MaterialKind::diffuse(0.5)); 2],
        groups: vec![GroupDescription { name: "a box".into(), shapes: vec![cuboid], ..Default::default() }],
        world: GroupDescription {
            shapes: vec![ball],
            instances: vec![
                instance("left", DMat4::from_translation(DVec3::X * 5.0)),
                instance("", DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0))),
            ],
            ..Default::default()
        },
        ..Description::default()
    };
    let settings = TessellationSettings { deviation: 0.05, angle: 1.0 };
    let tessellation =
        SceneTessellation::try_new(&description, settings, &TessellationProgress::default()).unwrap();
    (description, tessellation)
}

fn materials() -> Vec<MeshMaterial> {
    let grey = MeshMaterial {
        name: "grey paint".into(),
        base: [0.5; 3],
        metallic: 0.0,
        roughness: 1.0,
        transmission: 0.0,
    };
    vec![
        grey.clone(),
        MeshMaterial { name: String::new(), base: [1.0, 0.0, 0.0], transmission: 0.75, ..grey },
    ]
}

fn with_scene<T>(write: impl FnOnce(&TessellatedScene<'_>) -> T) -> T {
    let (description, tessellation) = described();
    write(&TessellatedScene {
        name: "scene",
        description: &description,
        tessellation: &tessellation,
        materials: &materials(),
        to_file: DMat4::IDENTITY,
    })
}

/// Six times the volume that triangles enclose.
fn volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let corner = |i: u32| positions[i as usize];
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
}

#[test]
fn ply_files_hold_all_instances_with_their_fronts_outside() {
    let mesh = read_ply(&with_scene(|scene| write_ply(scene).unwrap())).unwrap();
    let found = volume(&mesh.positions, &mesh.triangles);
    // Two boxes and a ball, of which the triangles lack a little.
    assert!((12.0 + 0.35..12.0 + 0.53).contains(&found), "{found}");
    assert_eq!(mesh.skipped_faces, 0);
    let largest = mesh.positions.iter().copied().fold(DVec3::ZERO, DVec3::max);
    assert_eq!(largest, DVec3::new(6.0, 2.0, 3.0));
}

#[test]
fn ply_files_have_a_color_per_triangle() {
    let file = with_scene(|scene| write_ply(scene).unwrap());
    // The last triangles are those of a box: 50 % grey is byte 188.
    assert_eq!(file[file.len() - 3..], [188; 3]);
}

#[test]
fn obj_files_share_positions_and_name_their_materials() {
    let ObjFiles { obj, mtl, library } = with_scene(|scene| write_obj(scene, "a b.mtl").unwrap());
    assert_eq!(library, "a_b.mtl");
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for line in obj.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[0] {
            "v" => positions.push(DVec3::from_slice(&[1, 2, 3].map(|i| words[i].parse().unwrap()))),
            "f" => triangles.push([1, 2, 3].map(|i| {
                let (position, normal) = words[i].split_once("//").unwrap();
                assert!(normal.parse::<u32>().unwrap() >= 1);
                position.parse::<u32>().unwrap() - 1
            })),
            _ => {}
        }
    }
    let found = volume(&positions, &triangles);
    assert!((12.35..12.53).contains(&found), "{found}");
    for line in ["mtllib a_b.mtl", "o a_box.2", "o a_box.3", "usemtl grey_paint.1", "usemtl material.2"] {
        assert!(obj.lines().any(|known| known == line), "{line}");
    }
    assert!(mtl.contains("newmtl grey_paint.1\nKd 0.5 0.5 0.5\n"), "{mtl}");
    assert!(mtl.contains("newmtl material.2\nKd 1 0 0\n") && mtl.contains("\nd 0.25\n"), "{mtl}");
}

#[test]
fn glb_files_have_the_tree_with_shared_meshes() {
    let file = with_scene(|scene| write_glb(scene).unwrap());
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    let names: Vec<_> = document["nodes"].as_array().unwrap().iter().map(|node| &node["name"]).collect();
    assert_eq!(names, ["scene", "left", "a box"]);
    assert_eq!(document["nodes"][0]["children"], serde_json::json!([1, 2]));
    assert_eq!(document["nodes"][1]["mesh"], document["nodes"][2]["mesh"]);
    assert_eq!(document["nodes"][1]["matrix"][12], 5.0);
    assert_eq!(document["meshes"].as_array().unwrap().len(), 2);
    let glass = &document["materials"][1];
    assert_eq!(glass["extensions"]["KHR_materials_transmission"]["transmissionFactor"], 0.75);
    assert_eq!(document["extensionsUsed"], serde_json::json!(["KHR_materials_transmission"]));
    assert!(document["materials"][0].get("extensions").is_none());
}

#[test]
fn instances_beyond_the_limit_are_refused() {
    let (mut description, _) = described();
    for group in 0..20 {
        let instance =
            InstanceDescription { name: String::new(), group, to_parent: DMat4::IDENTITY, location: None };
        let instances = vec![instance.clone(), instance];
        description.groups.push(GroupDescription { instances, ..Default::default() });
    }
    description.world.instances = vec![InstanceDescription {
        name: String::new(),
        group: 20,
        to_parent: DMat4::IDENTITY,
        location: None,
    }];
    let settings = TessellationSettings { deviation: 0.05, angle: 1.0 };
    let tessellation =
        SceneTessellation::try_new(&description, settings, &TessellationProgress::default()).unwrap();
    let scene = TessellatedScene {
        name: "doubled",
        description: &description,
        tessellation: &tessellation,
        materials: &materials(),
        to_file: DMat4::IDENTITY,
    };
    assert_eq!(write_ply(&scene), Err(TessellatedError::Instances(MAX_INSTANCES)));
    assert_eq!(write_glb(&scene), Err(TessellatedError::Instances(MAX_INSTANCES)));
}

#[test]
fn deep_groups_are_written() {
    const DEPTH: usize = 200_000;
    let (mut description, mut tessellation) = described();
    let instance = |group: usize| InstanceDescription {
        name: String::new(),
        group,
        to_parent: DMat4::IDENTITY,
        location: None,
    };
    for group in 0..DEPTH {
        description.groups.push(GroupDescription { instances: vec![instance(group)], ..Default::default() });
    }
    description.world.instances = vec![instance(DEPTH)];
    tessellation.groups.resize(DEPTH + 1, GroupMesh::default());
    let scene = TessellatedScene {
        name: "nested",
        description: &description,
        tessellation: &tessellation,
        materials: &materials(),
        to_file: DMat4::IDENTITY,
    };
    let file = write_glb(&scene).unwrap();
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    assert_eq!(document["nodes"].as_array().unwrap().len(), DEPTH + 2);
    assert_eq!(document["nodes"][DEPTH + 1]["mesh"], 0);
    assert!(write_ply(&scene).is_ok());
}

#[test]
fn copies_of_too_many_triangles_are_refused() {
    let (mut description, mut tessellation) = described();
    let instance = description.world.instances[0].clone();
    description.world.instances = vec![instance; 1 << 12];
    tessellation.groups[0].shapes[0].triangles.resize(1 << 15, [0, 1, 2]);
    let scene = TessellatedScene {
        name: "many",
        description: &description,
        tessellation: &tessellation,
        materials: &materials(),
        to_file: DMat4::IDENTITY,
    };
    let triangles = (1 << 27) + tessellation.world.shapes[0].triangles.len();
    let refused = TessellatedError::Triangles { triangles };
    assert_eq!(write_ply(&scene), Err(refused));
    assert_eq!(write_obj(&scene, "many.mtl"), Err(refused));
    assert!(write_glb(&scene).is_ok());
}
