//! The tree, and what belongs to which of its leaves.

use std::collections::BTreeSet;

use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;

use super::super::{ModelError, without};
use super::*;

fn description() -> Description {
    Description { materials: vec![MaterialKind::diffuse(0.5).into()], ..Description::default() }
}

/// A shape at `x`, which shines if asked to: a ball, a triangle, or two bilinear patches.
fn shape(kind: u32, x: f64, shines: bool) -> ShapeDescription {
    let shape = match kind % 3 {
        0 => ShapeDescription::sphere(0.1),
        1 => ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1], vec![[0, 1, 2]]),
        _ => GeometryDescription::Bilinear {
            positions: [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1)]
                .map(|(i, j)| DVec3::new(f64::from(i), f64::from(j), 0.0) * 0.1)
                .to_vec(),
            indices: vec![[0, 1, 2, 3], [1, 4, 3, 5]],
        }
        .into(),
    };
    let shape = shape.translated([x, 0.0, 0.0]);
    if shines { shape.emitting(0.5) } else { shape }
}

fn instance(group: usize, x: f64) -> InstanceDescription {
    InstanceDescription {
        name: String::new(),
        group,
        to_parent: DMat4::from_translation(DVec3::X * x),
        location: None,
    }
}

/// Groups in groups, some shapes of which shine: decimals of x say which copy it is. With the x of every leaf by the order of the walk.
fn nested() -> (Description, Vec<f64>) {
    let mut description = description();
    let group = |shapes, instances| GroupDescription {
        name: "group".into(),
        shapes,
        instances,
        ..GroupDescription::default()
    };
    let inner: Vec<_> = (0..4).map(|k| shape(k, f64::from(k), k % 2 == 1)).collect();
    let middle = vec![shape(2, 0.0, true), shape(0, 1.0, false)];
    description.groups = vec![
        group(inner, vec![]),
        group(middle, vec![instance(0, 10.0), instance(0, 20.0)]),
        group(vec![], vec![instance(1, 200.0)]),
    ];
    description.world = group(
        vec![shape(1, -5.0, false), shape(0, -3.0, true), shape(2, -1.0, false)],
        vec![instance(1, 1000.0), instance(0, 2000.0), instance(2, 3000.0), instance(1, 4000.0)],
    );
    let inner = |x: f64| (0..4).map(move |k| x + f64::from(k));
    let middle = |x: f64| [x, x + 1.0].into_iter().chain(inner(x + 10.0)).chain(inner(x + 20.0));
    let world = [-5.0, -3.0, -1.0].into_iter().chain(middle(1000.0)).chain(inner(2000.0));
    (description, world.chain(middle(3200.0)).chain(middle(4000.0)).collect())
}

fn modelled(description: &Description) -> (Model, File, Scene) {
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let model = Model::try_new("test", description, &scene, &[]).unwrap();
    let file = File::read(&model.to_bytes().unwrap());
    (model, file, scene)
}

#[test]
fn objects_belong_to_the_leaf_at_their_place() {
    let (description, expected) = nested();
    let (model, file, scene) = modelled(&description);
    let mut seen = vec![0; expected.len()];
    for object in file.list("objects") {
        let (leaf, x) = (number(&object["leaf"]), numbers(&object["toWorld"])[9]);
        // Everything is less than 0.3 m large, leaves are a metre apart.
        assert!((x - expected[leaf]).abs() < 0.3, "leaf {leaf} at {x} instead of {}", expected[leaf]);
        seen[leaf] += 1;
    }
    let kinds: Vec<&Value> = file.list("objects").iter().map(|o| &o["kind"]).collect();
    let lists = kinds.iter().filter(|kind| **kind == "bilinearmesh").count();
    // Each leaf is one object, lists of two patches are two.
    assert!(seen.iter().all(|&n| n == 1 || n == 2));
    assert_eq!((seen.len(), lists), (expected.len(), 2 * seen.iter().filter(|&&n| n == 2).count()));
    // Rays find the object, and with it the leaf, at the same place.
    for (leaf, x) in (0..).zip(&expected) {
        let ray = Ray::new(DVec3::new(x + 0.02, 0.02, 5.0), -DVec3::Z);
        let (_, place) = scene.intersect_parametric(&ray, f64::INFINITY).unwrap();
        assert_eq!(model.leaf_of(model.object_of(&place).unwrap()), Some(leaf));
    }
}

#[test]
fn hidden_leaves_are_gone_and_all_others_stay() {
    let (description, places) = nested();
    let count = places.len() as u32;
    // Single ones in copies of the same group, a whole copy, and one of the world.
    for hidden in [vec![], vec![1], vec![3, 8, 14, 26], (5..9).collect(), (0..count).step_by(2).collect()] {
        let hidden: BTreeSet<u32> = hidden.into_iter().collect();
        let (_, _, scene) = modelled(&without(&description, &hidden));
        for (leaf, x) in (0..).zip(&places) {
            let ray = Ray::new(DVec3::new(x + 0.02, 0.02, 5.0), -DVec3::Z);
            let met = scene.intersect(&ray, f64::INFINITY).is_some();
            assert_eq!(met, !hidden.contains(&leaf), "{leaf} of {hidden:?}");
        }
    }
    let nothing = without(&description, &(0..count).collect());
    assert!(Scene::resolve(nothing).unwrap().0.placed_surfaces().is_empty());
}

#[test]
fn copies_that_lose_the_same_share_a_group() {
    let (description, _) = nested();
    // The first leaf of the second and of the third copy of the innermost group.
    let hidden = BTreeSet::from([9, 13]);
    let left = without(&description, &hidden);
    let added = left.groups.len() - description.groups.len();
    // The rest of the group, and of the one with its second copy.
    assert_eq!(added, 2);
}

#[test]
fn tree_has_the_names_and_positions_of_groups_and_shapes() {
    let text = "WorldBegin
        ObjectBegin \"pair\"
          MakeNamedMaterial \"steel\" \"string type\" \"diffuse\"
          NamedMaterial \"steel\"
          Shape \"sphere\"
          Shape \"disk\"
        ObjectEnd
        Material \"diffuse\"
        Shape \"box\"
        Shape \"disk\" \"float height\" 2 \"string receiver\" \"table\"
        ObjectInstance \"pair\"";
    let (model, file, _) = model(text);
    let tree = &file.head["tree"];
    assert_eq!((&tree["kind"], &tree["name"]), (&"group".into(), &"test".into()));
    let world = tree["children"].as_array().unwrap();
    let pair = world[2]["children"].as_array().unwrap();
    let shapes = [&world[0], &world[1], &pair[0], &pair[1]];
    let expected = [("box", "box", 9), ("table", "disk", 10), ("steel", "sphere", 5), ("steel", "disk", 6)];
    for (leaf, (shape, (name, what, line))) in (0..).zip(shapes.into_iter().zip(expected)) {
        assert_eq!((&shape["kind"], &shape["leaf"]), (&"shape".into(), &leaf.into()));
        assert_eq!((&shape["name"], &shape["what"]), (&name.into(), &what.into()));
        assert_eq!(shape["place"], format!("test.pbrt:{line}"));
        assert_eq!(model.name_of(leaf), Some(name));
    }
    assert_eq!((&world[2]["name"], &world[2]["place"]), (&"pair".into(), &"test.pbrt:11".into()));
}

#[test]
fn joined_meshes_are_an_object_each() {
    let mut description = description();
    description.world.shapes = (0..5).map(|k| shape(1, f64::from(k), false)).collect();
    let (model, file, scene) = modelled(&description);
    assert_eq!((scene.placed_surfaces().len(), file.list("objects").len()), (1, 5));
    for face in 0..5 {
        let place = glanz_scene::ParametricPoint { surface: 0, face, back: false, uv: DVec2::ZERO };
        assert_eq!(model.object_of(&place).and_then(|object| model.leaf_of(object)), Some(face));
    }
    let nowhere = glanz_scene::ParametricPoint { surface: 1, face: 0, back: false, uv: DVec2::ZERO };
    assert_eq!((model.object_of(&nowhere), model.leaf_of(5)), (None, None));
}

#[test]
fn a_million_copies_are_refused() {
    let mut description = description();
    let ten = |group| (0..10).map(|k| instance(group, f64::from(k))).collect::<Vec<_>>();
    let group = |shapes, instances| GroupDescription { shapes, instances, ..GroupDescription::default() };
    description.groups.push(group(vec![shape(0, 0.0, false)], vec![]));
    for level in 0..5 {
        description.groups.push(group(vec![], ten(level)));
    }
    description.world = group(vec![], ten(5));
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let error = Model::try_new("test", &description, &scene, &[]).unwrap_err();
    assert!(matches!(error, ModelError::TooMany { count, .. } if count > 1_000_000), "{error}");
}

/// The labels of a tree, with those of children in brackets.
fn outline(node: &Value) -> String {
    let name = node["name"].as_str().unwrap();
    match node["children"].as_array() {
        Some(children) => format!("{name}[{}]", children.iter().map(outline).collect::<Vec<_>>().join(" ")),
        None => name.to_owned(),
    }
}

fn cad_model(text: &str) -> File {
    let options = Options { edges: true, ..Options::default() };
    let loaded = load_str("a.step", text, &options).unwrap();
    let scene = Scene::resolve(loaded.description.clone()).unwrap().0;
    let model = Model::try_new("a.step", &loaded.description, &scene, &[]).unwrap();
    File::read(&model.with_cad(loaded.cad.unwrap()).to_bytes().unwrap())
}

#[test]
fn tree_of_a_cad_file_is_its_assembly() {
    let text = include_str!("../../../tests/discs.step");
    let file = cad_model(text);
    let faces = "[wall #50 #55]";
    let expected = format!("a.step[pair[disc (left){faces} disc (right){faces}]]");
    assert_eq!(outline(&file.head["tree"]), expected);
    // An occurrence without a name, and one with that of its part.
    let text = text.replace("'id','left'", "'',''").replace("'right'", "'disc'");
    assert_eq!(outline(&cad_model(&text).head["tree"]), format!("a.step[pair[disc{faces} disc{faces}]]"));
    assert_eq!(file.head["lengthUnit"], 0.001);
    assert!(file.list("objects").iter().all(|object| object["shared"] == true));
}

#[test]
fn bodies_of_a_part_are_groups_where_it_has_several() {
    // The top alone as a second body.
    let text = include_str!("../../../tests/discs.step");
    let text = text
        .replace("(#40,#50,#55)", "(#40,#55)")
        .replace("(#60,#10),#910", "(#60,#62,#10),#910")
        .replace("#61=", "#62=SHELL_BASED_SURFACE_MODEL('lid',(#63));#63=OPEN_SHELL('',(#50));\n#61=");
    let bodies = "[body[wall #55] lid[#50]]";
    let expected = format!("a.step[pair[disc (left){bodies} disc (right){bodies}]]");
    assert_eq!(outline(&cad_model(&text).head["tree"]), expected);
}

#[test]
fn edges_of_a_cad_file_are_placed_with_the_copies_of_their_part() {
    let file = cad_model(include_str!("../../../tests/discs.step"));
    // Bottom and top circle of the disc; the seam of its wall is no feature.
    let edges = file.list("edges");
    assert_eq!(edges.len(), 2);
    for edge in edges {
        assert_eq!(edge["kind"], "circle");
        assert!((numbers(&edge["radii"])[0] - 0.02).abs() < 1e-12, "{edge}");
        assert!((edge["length"].as_f64().unwrap() - 0.04 * std::f64::consts::PI).abs() < 1e-9, "{edge}");
        assert!((edge["angle"].as_f64().unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{edge}");
    }
    let copies = file.list("edgeCopies");
    let firsts: Vec<usize> = copies.iter().map(|copy| number(&copy["firstLeaf"])).collect();
    assert_eq!(firsts, [0, 3]);
    let points = file.floats("edgePoints");
    for (copy, middle) in copies.iter().zip([0.0, 0.06]) {
        let to_world = numbers(&copy["toWorld"]);
        for point in points.chunks_exact(3) {
            let x = to_world[0] * point[0] + to_world[9] - middle;
            let y = to_world[4] * point[1] + to_world[10];
            assert!((x.hypot(y) - 0.02).abs() < 1e-5, "{point:?}");
        }
    }
}
