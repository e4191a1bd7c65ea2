//! Outer walls of rooms.

use super::*;

/// Outer sides of the objects, by the names of their materials, which are `f`, `b` or `-` for the front, the back and none.
fn assert_sides(shapes: &str) {
    let materials = ["f", "b", "-"]
        .map(|name| format!("MakeNamedMaterial \"{name}\" \"string type\" \"diffuse\"\n"))
        .concat();
    let (description, scene) = load(&format!("WorldBegin\n{materials}\n{shapes}"));
    let model = Model::try_new("test", &description, &scene, &description.files).unwrap();
    let file = File::read(&model.with_outer_sides(&scene).to_bytes().unwrap());
    assert!(!file.list("objects").is_empty());
    for (number, object) in file.list("objects").iter().enumerate() {
        let expected = match file.list("materials")[number_of(object)]["name"].as_str().unwrap() {
            "f" => "front".into(),
            "b" => "back".into(),
            _ => Value::Null,
        };
        assert_eq!(object["outside"], expected, "object {number}: {object}");
    }
}

fn number_of(object: &Value) -> usize {
    number(&object["material"])
}

/// A room of 4 m x 3 m x 2.5 m; floor and wall at y = 0 face inwards, ceiling and the wall at y = 3 outwards, the others are meshes of triangles, of which the
/// second faces outwards. A light hangs below the ceiling.
const ROOM: &str = r#"
    LightSource "point" "point3 from" [2 1.5 2.2]
    NamedMaterial "b"
    Shape "bilinearmesh" "point3 P" [0 0 0  4 0 0  0 3 0  4 3 0]
    Shape "bilinearmesh" "point3 P" [4 0 0  0 0 0  4 0 2.5  0 0 2.5]
    Shape "trianglemesh" "point3 P" [0 0 0  0 3 0  0 3 2.5  0 0 2.5] "integer indices" [0 1 2  0 2 3]
    NamedMaterial "f"
    Shape "bilinearmesh" "point3 P" [0 0 2.5  4 0 2.5  0 3 2.5  4 3 2.5]
    Shape "bilinearmesh" "point3 P" [4 3 0  0 3 0  4 3 2.5  0 3 2.5]
    Shape "trianglemesh" "point3 P" [4 0 0  4 3 0  4 3 2.5  4 0 2.5] "integer indices" [0 1 2  0 2 3]"#;

#[test]
fn walls_are_left_out_from_outside_whichever_way_they_face() {
    assert_sides(ROOM);
}

#[test]
fn rooms_are_found_by_lights_that_are_too_dark_to_light_the_page() {
    let bright =
        |i: i32| format!("LightSource \"point\" \"point3 from\" [{i} 0 50] \"float power\" 1000000\n");
    let others: String = (0..40).map(bright).collect();
    assert_sides(&format!("{others}{ROOM}"));
}

#[test]
fn furniture_and_pictures_on_walls_are_no_walls() {
    assert_sides(&format!(
        r#"{ROOM}
        NamedMaterial "-"
        Shape "box" "point3 min" [1 1 0] "point3 max" [2 2 0.7]
        Shape "bilinearmesh" "point3 P" [1 0.01 1  0.5 0.01 1  1 0.01 1.5  0.5 0.01 1.5]
        Translate 3 2 0.7
        Shape "cylinder" "float radius" 0.1 "float zmin" 0 "float zmax" 0.3"#
    ));
}

#[test]
fn solids_and_open_things_alone_are_no_walls() {
    assert_sides(
        r#"NamedMaterial "-"
        Shape "sphere"
        Translate 9 0 0  Shape "cylinder"
        Translate 9 0 0  Shape "box"
        Translate 0 9 0  Shape "disk"
        Translate 0 9 0  Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0  0 0 1] "integer indices" [0 2 1  0 1 3  0 3 2  1 2 3]"#,
    );
}

#[test]
fn a_room_of_one_mesh_that_faces_inwards_is_left_out_from_outside() {
    // The box of eight corners, each triangle with its normal to the inside.
    assert_sides(
        r#"NamedMaterial "b"
        Shape "trianglemesh" "point3 P" [0 0 0  4 0 0  4 3 0  0 3 0  0 0 2  4 0 2  4 3 2  0 3 2]
            "integer indices" [0 1 2  0 2 3   4 6 5  4 7 6   0 5 1  0 4 5   3 2 6  3 6 7   0 3 7  0 7 4   1 5 6  1 6 2]"#,
    );
}

#[test]
fn furniture_in_the_mesh_of_a_room_counts_by_its_area() {
    // The same box below a table top of 3200 small triangles.
    let grid = |count: usize| (0..=count).flat_map(move |j| (0..=count).map(move |i| (i, j)));
    let points: String = grid(40)
        .map(|(i, j)| format!("{} {} 0.7 ", 1.0 + 0.025 * i as f64, 1.0 + 0.025 * j as f64))
        .collect();
    let corner = |i: usize, j: usize| 8 + 41 * j + i;
    let triangles: String = grid(39)
        .map(|(i, j)| {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
            format!("{a} {b} {c} {a} {c} {d} ")
        })
        .collect();
    assert_sides(&format!(
        r#"NamedMaterial "b"
        Shape "trianglemesh" "point3 P" [0 0 0  4 0 0  4 3 0  0 3 0  0 0 2  4 0 2  4 3 2  0 3 2 {points}] "integer indices" [{triangles}
            0 1 2  0 2 3   4 6 5  4 7 6   0 5 1  0 4 5   3 2 6  3 6 7   0 3 7  0 7 4   1 5 6  1 6 2]"#,
    ));
}

/// A box of six quadrilaterals that face outwards, or inwards.
fn six_sides([x, y, z]: [f64; 3], [width, depth, height]: [f64; 3], inwards: bool) -> String {
    let corner = |i: usize| {
        let at = |bit: usize, size: f64| if i & bit > 0 { size } else { 0.0 };
        format!("{} {} {}", x + at(1, width), y + at(2, depth), z + at(4, height))
    };
    let sides = [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let side = |[a, b, c, d]: [usize; 4]| {
        let [b, c] = if inwards { [c, b] } else { [b, c] };
        let corners = [a, b, c, d].map(corner).join("  ");
        format!("Shape \"bilinearmesh\" \"point3 P\" [{corners}]\n")
    };
    sides.map(side).concat()
}

#[test]
fn floors_and_ceilings_of_wide_rooms_are_walls() {
    // 5 % of the diagonal are more than the height.
    for (inwards, name) in [(true, "b"), (false, "f")] {
        let room = six_sides([0.0; 3], [50.0, 40.0, 3.0], inwards);
        let light = "LightSource \"point\" \"point3 from\" [20 25 2.7]";
        assert_sides(&format!("{light}\nNamedMaterial \"{name}\"\n{room}"));
    }
    // Without a light, the floor alone is known to be in a room.
    assert_sides(
        r#"NamedMaterial "-"
        Shape "bilinearmesh" "point3 P" [0 0 3  0 40 3  50 0 3  50 40 3]
        NamedMaterial "b"
        Shape "bilinearmesh" "string receiver" "floor" "point3 P" [0 0 0  50 0 0  0 40 0  50 40 0]"#,
    );
}

#[test]
fn plinths_of_single_surfaces_are_no_walls() {
    let floor = "Shape \"bilinearmesh\" \"point3 P\" [-10 -10 0  10 -10 0  -10 10 0  10 10 0]";
    for light in ["", "LightSource \"point\" \"point3 from\" [1 0 5]"] {
        for inwards in [false, true] {
            let plinth = six_sides([0.0; 3], [1.0, 1.0, 1.2], inwards);
            assert_sides(&format!("{light}\nNamedMaterial \"-\"\n{floor}\n{plinth}"));
        }
    }
    // Without its bottom, its sides and its top see the floor.
    let plinth = six_sides([0.0; 3], [1.0, 1.0, 2.0], false);
    let open = plinth.split_once('\n').unwrap().1;
    assert_sides(&format!(
        "LightSource \"point\" \"point3 from\" [1 0 5]\nNamedMaterial \"-\"\n{floor}\n{open}"
    ));
}

#[test]
fn open_crates_on_a_wide_floor_are_no_walls() {
    // The scene is as low as the crate, but its sides are nearer to each other than 5 % of the diagonal.
    let floor = "Shape \"bilinearmesh\" \"point3 P\" [-10 -10 0  10 -10 0  -10 10 0  10 10 0]";
    let light = "LightSource \"point\" \"point3 from\" [0.5 0.5 5]";
    for inwards in [false, true] {
        let crate_sides = six_sides([0.0; 3], [1.0, 1.0, 0.5], inwards);
        // Without its bottom and its top.
        let crate_sides = crate_sides.splitn(3, '\n').nth(2).unwrap();
        assert_sides(&format!("{light}\nNamedMaterial \"-\"\n{floor}\n{crate_sides}"));
    }
}

#[test]
fn tables_in_a_room_without_a_ceiling_are_no_walls() {
    let is_ceiling = |line: &&str| line.contains("[0 0 2.5  4 0 2.5");
    let walls: Vec<&str> = ROOM.lines().filter(|line| !is_ceiling(line)).collect();
    // A floor below the open sky has nothing to be looked at from below.
    let floor = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  4 0 0  0 3 0  4 3 0]";
    let room = walls.join("\n").replace(floor, &format!("NamedMaterial \"-\" {floor} NamedMaterial \"b\""));
    let top = six_sides([1.0, 1.0, 0.7], [1.0, 1.0, 0.04], false);
    let sheet = "Shape \"bilinearmesh\" \"point3 P\" [2.5 1 0.7  3.5 1 0.7  2.5 2 0.7  3.5 2 0.7]";
    let leg = "Shape \"box\" \"point3 min\" [1.4 1.4 0] \"point3 max\" [1.5 1.5 0.7]";
    assert_sides(&format!("{room}\nNamedMaterial \"-\"\n{top}\n{sheet}\n{leg}"));
}

#[test]
fn work_planes_are_no_walls_and_hide_none() {
    let plane = "Shape \"bilinearmesh\" \"string receiver\" \"plane\" \"point3 P\" [0 0 0.8  4 0 0.8  0 3 0.8  4 3 0.8]";
    let above = plane.replace("0.8", "3");
    assert_sides(&format!(
        "MakeNamedMaterial \"air\" \"string type\" \"interface\"\n{ROOM}\nNamedMaterial \"air\"\n{plane}\n{above}"
    ));
}

#[test]
fn the_side_that_a_receiver_measures_is_shown() {
    // Light counts on top of the roof and on the inner side of the wall.
    let wall = "[4 3 0  0 3 0  4 3 2.5  0 3 2.5]";
    let roof = "[0 0 2.5  4 0 2.5  0 3 2.5  4 3 2.5]";
    let room = ROOM
        .replace(wall, &format!("{wall} \"string receiver\" \"wall\" \"string receiverside\" \"back\""))
        .replace(
            &format!("NamedMaterial \"f\"\n    Shape \"bilinearmesh\" \"point3 P\" {roof}"),
            &format!("NamedMaterial \"-\"\n    Shape \"bilinearmesh\" \"string receiver\" \"roof\" \"point3 P\" {roof}\n    NamedMaterial \"f\""),
        );
    assert!(room.contains("roof"));
    assert_sides(&room);
}

#[test]
fn receivers_are_in_rooms_where_no_light_is_in_sight() {
    assert_sides(
        r#"LightSource "point" "point3 from" [2 1.5 1.2]
        NamedMaterial "-"
        Shape "box" "point3 min" [1.9 1.4 1.1] "point3 max" [2.1 1.6 1.3]
        Shape "bilinearmesh" "point3 P" [0 0 2.5  4 0 2.5  0 3 2.5  4 3 2.5]
        NamedMaterial "b"
        Shape "bilinearmesh" "string receiver" "floor" "point3 P" [0 0 0  4 0 0  0 3 0  4 3 0]"#,
    );
}

#[test]
fn walls_of_scenes_that_are_lit_from_afar_see_something_that_faces_them() {
    // The floor sees the back of the ceiling.
    assert_sides(
        r#"LightSource "distant"
        NamedMaterial "-"
        Shape "bilinearmesh" "point3 P" [0 0 0  4 0 0  0 3 0  4 3 0]
        NamedMaterial "b"
        Shape "bilinearmesh" "point3 P" [4 0 0  0 0 0  4 0 2.5  0 0 2.5]
        NamedMaterial "f"
        Shape "bilinearmesh" "point3 P" [0 0 2.5  4 0 2.5  0 3 2.5  4 3 2.5]
        NamedMaterial "b"
        Shape "bilinearmesh" "point3 P" [0 3 0  4 3 0  0 3 2.5  4 3 2.5]"#,
    );
}
