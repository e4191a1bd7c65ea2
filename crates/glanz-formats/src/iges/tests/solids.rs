//! Solids whose faces share their edges.

use super::*;

/// A tetrahedron of edge 1 at the origin: planes (190) through its faces, straight edges, normals outwards.
pub(super) fn tetrahedron() -> Vec<(u32, u32, String)> {
    let mut entities = vec![
        (186, 0, "3,1,0".to_owned()),
        (514, 1, "4,5,1,7,1,9,1,11,1".to_owned()),
        (510, 1, "13,1,1,21".to_owned()),
        (510, 1, "15,1,1,23".to_owned()),
        (510, 1, "17,1,1,25".to_owned()),
        (510, 1, "19,1,1,27".to_owned()),
        (190, 0, "29,33".to_owned()),
        (190, 0, "29,35".to_owned()),
        (190, 0, "29,37".to_owned()),
        (190, 0, "31,39".to_owned()),
        // Edges from the first list: 1: 1-2, 2: 1-3, 3: 1-4, 4: 2-3, 5: 3-4, 6: 4-2.
        (508, 1, "3,0,41,2,1,0,0,41,4,0,0,0,41,1,0,0".to_owned()),
        (508, 1, "3,0,41,1,1,0,0,41,6,0,0,0,41,3,0,0".to_owned()),
        (508, 1, "3,0,41,3,1,0,0,41,5,0,0,0,41,2,0,0".to_owned()),
        (508, 1, "3,0,41,4,1,0,0,41,5,1,0,0,41,6,1,0".to_owned()),
        (116, 0, "0.,0.,0.".to_owned()),
        (116, 0, "1.,0.,0.".to_owned()),
        (123, 0, "0.,0.,-1.".to_owned()),
        (123, 0, "0.,-1.,0.".to_owned()),
        (123, 0, "-1.,0.,0.".to_owned()),
        (123, 0, "1.,1.,1.".to_owned()),
        (
            504,
            1,
            "6,45,43,1,43,2,47,43,1,43,3,49,43,1,43,4,51,43,2,43,3,53,43,3,43,4,55,43,4,43,2".to_owned(),
        ),
        (502, 1, "4,0.,0.,0.,1.,0.,0.,0.,1.,0.,0.,0.,1.".to_owned()),
    ];
    for line in [
        "0.,0.,0.,1.,0.,0.",
        "0.,0.,0.,0.,1.,0.",
        "0.,0.,0.,0.,0.,1.",
        "1.,0.,0.,0.,1.,0.",
        "0.,1.,0.,0.,0.,1.",
        "0.,0.,1.,1.,0.,0.",
    ] {
        entities.push((110, 0, line.to_owned()));
    }
    entities
}

pub(super) fn entities(list: &[(u32, u32, String)]) -> Vec<EntityText<'_>> {
    list.iter().map(|(kind, form, parameters)| entity(*kind, *form, parameters)).collect()
}

#[test]
fn solid_has_closed_shell_with_shared_edges() {
    let list = tetrahedron();
    let file = clean(&entities(&list));
    let model = &file.model;
    assert_eq!((model.faces.len(), model.edges.len(), model.vertices.len()), (4, 6, 4));
    let body = &model.parts[0].bodies[0];
    assert!(body.solid && body.shells[0].closed && body.entity == id(1));
    let areas = areas(&file);
    areas[..3].iter().for_each(|area| assert_close(*area, 0.5));
    assert_close(areas[3], 0.75_f64.sqrt());
    let trimmed = trimmed_faces(model);
    let volume: f64 = trimmed
        .faces
        .iter()
        .flatten()
        .map(|face| {
            let volume = face.measure(1e-9).volume;
            if face.reversed { -volume } else { volume }
        })
        .sum();
    assert!((volume.abs() - 1.0 / 6.0).abs() < 1e-9, "{volume}");
}

#[test]
fn senses_of_faces_and_shells_turn_them() {
    let mut list = tetrahedron();
    list[0].2 = "3,0,0".to_owned();
    list[1].2 = "4,5,1,7,0,9,1,11,1".to_owned();
    let file = clean(&entities(&list));
    let reversed: Vec<bool> =
        file.model.parts[0].bodies[0].shells[0].faces.iter().map(|face| face.1).collect();
    assert_eq!(reversed, [true, false, true, true]);
}

#[test]
fn shell_without_one_of_its_faces_is_open() {
    let mut list = tetrahedron();
    list[6].2 = "29,0".to_owned();
    let file = file(&entities(&list));
    let shell = &file.model.parts[0].bodies[0].shells[0];
    assert_eq!((shell.closed, shell.faces.len()), (false, 3));
    assert_eq!(omissions(&file)[0], "#5: #13: the surface has no axis");
    let faces = file.report.faces;
    assert_eq!((faces.total, faces.read, faces.refused), (4, 3, 1));
}

#[test]
fn items_that_lists_lack_are_refused() {
    let mut list = tetrahedron();
    list[10].2 = "3,0,41,2,1,0,0,41,9,0,0,0,41,1,0,0".to_owned();
    list[11].2 = "3,0,43,1,1,0,0,41,6,0,0,0,41,3,0,0".to_owned();
    let omissions = omissions(&file(&entities(&list)));
    assert_eq!(omissions[0], "#5: #41: item 9 of 6 does not exist");
    assert_eq!(omissions[1], "#7: #43: type 502 (vertex list), form 1, is not read as a list of edges");
}

#[test]
fn shell_by_itself_is_a_body_of_surfaces() {
    let mut list = tetrahedron();
    list[0] = (116, 0, "0.,0.,0.".to_owned());
    let file = file(&entities(&list));
    let body = &file.model.parts[0].bodies[0];
    assert!(!body.solid && body.shells[0].closed && body.entity == id(3));
    assert_eq!(omissions(&file), ["#1: 1 entity of type 116 (point) belongs to no face; it is not shown"]);
}

#[test]
fn solid_of_an_unused_subfigure_is_not_shown() {
    let mut list = tetrahedron();
    list.push((308, 0, "0,1Ha,1,1".to_owned()));
    let file = file(&entities(&list));
    assert_eq!((file.report.faces.unreachable, file.model.parts.len()), (4, 0));
}

#[test]
fn missing_parameter_curve_costs_no_face() {
    for (curve, repairs) in [("0", 0), ("999", 1)] {
        let mut list = tetrahedron();
        list[10].2 = format!("3,0,41,2,1,1,0,{curve},0,41,4,0,0,0,41,1,0,0");
        let report = file(&entities(&list)).report;
        assert_eq!((report.faces.read, report.repairs.count()), (4, repairs));
    }
}

/// A square as a shell of one face, whose edges have no curves in space; the second one runs from its end to its start in the loop.
fn square_without_curves(loop_of_edges: &str) -> Vec<(u32, u32, String)> {
    let mut list = vec![
        (514, 2, "1,3,1".to_owned()),
        (510, 1, "5,1,1,7".to_owned()),
        (128, 0, BILINEAR.to_owned()),
        (508, 1, loop_of_edges.to_owned()),
        (504, 1, "4,0,11,1,11,2,0,11,3,11,2,0,11,3,11,4,0,11,4,11,1".to_owned()),
        (502, 1, "4,0.,0.,0.,1.,0.,0.,1.,1.,0.,0.,1.,0.".to_owned()),
    ];
    for line in ["0.,0.,0.,1.,0.,0.", "1.,0.,0.,1.,1.,0.", "1.,1.,0.,0.,1.,0.", "0.,1.,0.,0.,0.,0."] {
        list.push((110, 0, line.to_owned()));
    }
    list
}

#[test]
fn edges_without_a_curve_in_space_take_it_from_their_surface() {
    let list = square_without_curves("4,0,9,1,1,1,0,13,0,9,2,0,1,0,15,0,9,3,1,1,0,17,0,9,4,1,1,0,19");
    let whole = file(&entities(&list));
    assert_eq!((whole.report.faces.read, whole.report.repairs.count()), (1, 4));
    assert_close(areas(&whole)[0], 1.0);
    // From the third vertex to the second, against the curve in parameters.
    let senses: Vec<bool> = whole.model.edges.iter().map(|edge| edge.same_sense).collect();
    assert_eq!(senses, [true, false, true, true]);
    // The first edge has none in parameters either.
    let list = square_without_curves("4,0,9,1,1,0,0,9,2,0,1,0,15,0,9,3,1,1,0,17,0,9,4,1,1,0,19");
    let refused = file(&entities(&list));
    let neither = "there is neither a curve in space nor one in the parameters of its surface";
    assert_eq!(omissions(&refused)[0], format!("#3: #9: {neither}"));
}
