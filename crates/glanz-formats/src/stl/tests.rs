use super::*;
use crate::registry::{Options, load};

const TETRAHEDRON: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, -0.0, 3.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn text() -> String {
    let mut text = "solid a name with facet in it\n".to_owned();
    for face in FACES {
        text += "facet normal nan 0 0\n outer loop\n";
        for [x, y, z] in face.map(|i| TETRAHEDRON[i]) {
            text += &format!("  vertex {x} {y:e} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid a name with facet in it\n"
}

fn binary() -> Vec<u8> {
    // A header that begins like a text.
    let mut bytes = b"solid of a program".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|&i| TETRAHEDRON[i]).flat_map(f32::to_le_bytes));
        bytes.extend([7, 7]);
    }
    bytes
}

#[test]
fn corners_in_the_same_place_are_one_vertex_in_text_and_binary() {
    let mesh = read(&binary()).unwrap();
    // In the order of the first face 0 2 1, then 3; the signed zero is no other vertex.
    assert_eq!(mesh.positions, [0, 2, 1, 3].map(|i| DVec3::from(TETRAHEDRON[i].map(f64::from))));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]]);
    assert_eq!(read(text().as_bytes()).unwrap(), mesh);
    assert_eq!(read(text().to_uppercase().replace('\n', "\r\n").as_bytes()).unwrap(), mesh);
}

#[test]
fn several_solids_are_one_mesh() {
    let twice = text() + "\n" + &text();
    let mesh = read(twice.as_bytes()).unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 8));
}

#[test]
fn both_forms_are_recognised_and_other_texts_are_not() {
    assert!(is_stl(&binary()) && is_stl(text().as_bytes()));
    assert!(is_stl(b"  solid\nendsolid\n"));
    for other in [&b"solid"[..], b"solid colour\nShape \"sphere\"\n", b"Shape \"sphere\"", b"facet", b""] {
        assert!(!is_stl(other), "{}", String::from_utf8_lossy(other));
    }
    assert!(!is_stl(&[0; 84]), "a file without facets may be anything");
}

#[test]
fn errors_name_line_and_column() {
    let message = |bytes: &[u8]| {
        let error = read(bytes).unwrap_err();
        let place = error.place.map(|(line, column)| format!("{line}:{column}: ")).unwrap_or_default();
        format!("{place}{error}")
    };
    let changed = |from: &str, to: &str| message(text().replacen(from, to, 1).as_bytes());
    assert_eq!(changed("vertex 0 0e0 0", "vertex 0 zero 0"), "4:12: \"zero\" is not a finite number");
    assert_eq!(changed("vertex 0 0e0 0", "vertex 0 1e999 0"), "4:12: \"1e999\" is not a finite number");
    assert_eq!(
        changed("endloop", "vertex 1 2 3"),
        "7:2: \"vertex\" is not expected here; the format needs \"endloop\""
    );
    assert_eq!(
        changed("endfacet\nfacet", "endfacet\nface"),
        "9:1: \"face\" is not expected here; the format needs \"facet\" or \"endsolid\""
    );
    let cut = text().replace("endsolid a name with facet in it\n", "");
    assert_eq!(message(cut.as_bytes()), "29:9: the file ends within a solid; it may be incomplete");
    let mut bytes = binary();
    bytes[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(message(&bytes), "a corner of facet 1 is not finite");
    let incomplete = "the file has 283 bytes for 4 facets, which need 284; it may be incomplete";
    assert_eq!(message(&binary()[..283]), incomplete);
    assert_eq!(message(b"short"), "the file has 5 bytes for 0 facets, which need 84; it may be incomplete");
}

#[test]
fn a_scene_reads_a_binary_file_with_bytes_after_its_facets() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("m.stl", &[binary().as_slice(), b"end"].concat());
    write("m.pbrt", b"WorldBegin\nShape \"stl\" \"string filename\" \"m.stl\"\n");
    let loaded = load(&folder.path().join("m.pbrt"), &Options::default()).unwrap();
    assert_eq!(loaded.description.world.shapes.len(), 1);
}
