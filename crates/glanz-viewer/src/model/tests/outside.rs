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
/// second faces outwards.
const ROOM: &str = r#"
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
