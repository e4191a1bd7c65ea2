//! Trimmed and bounded surfaces.

use std::f64::consts::PI;

use glanz_brep::model::{BoundaryLoop, Curve};

use super::super::surface_curves::LIFTED;
use super::*;

/// The unit square with a round hole of radius 1/4, both with curves in parameters and in space; `hole`: the start and the end of the hole
/// in parameters, at a quarter of the circle around its centre and back.
fn square_with_hole<'a>(outer: &'a str, ends: [&'a str; 4]) -> Vec<EntityText<'a>> {
    vec![
        entity(128, 0, BILINEAR),
        entity(144, 0, "1,1,1,5,7"),
        entity(142, 0, "1,1,9,11,3"),
        entity(142, 0, "1,1,13,15,3"),
        entity(102, 0, outer),
        entity(102, 0, outer),
        entity(100, 0, "0.,0.5,0.5,0.75,0.5,0.75,0.5"),
        entity(100, 0, "0.,0.5,0.5,0.75,0.5,0.75,0.5"),
        entity(110, 0, ends[0]),
        entity(110, 0, ends[1]),
        entity(110, 0, ends[2]),
        entity(110, 0, ends[3]),
    ]
}

const COUNTERCLOCKWISE: [&str; 4] =
    ["0.,0.,0.,1.,0.,0.", "1.,0.,0.,1.,1.,0.", "1.,1.,0.,0.,1.,0.", "0.,1.,0.,0.,0.,0."];

const CLOCKWISE: [&str; 4] =
    ["0.,0.,0.,0.,1.,0.", "0.,1.,0.,1.,1.,0.", "1.,1.,0.,1.,0.,0.", "1.,0.,0.,0.,0.,0."];

#[test]
fn loops_in_any_direction_bound_the_same_face() {
    for ends in [COUNTERCLOCKWISE, CLOCKWISE] {
        let file = clean(&square_with_hole("4,17,19,21,23", ends));
        assert_close(areas(&file)[0], 1.0 - PI / 16.0);
        assert!(file.model.faces[0].same_sense);
        assert!(file.model.edges.iter().all(|edge| edge.parameter_curves.len() == 1));
        let [outer, hole] = file.model.faces[0].bounds.as_slice() else { panic!() };
        assert!(outer.outer && !hole.outer);
        // The circle of the file is counterclockwise, a hole is not.
        assert!(
            matches!(&hole.boundary, BoundaryLoop::Edges(edges) if edges.len() == 1 && !edges[0].forward)
        );
    }
}

#[test]
fn holes_in_a_whole_surface_are_within_its_border() {
    let mut entities = square_with_hole("4,17,19,21,23", COUNTERCLOCKWISE);
    entities[1] = entity(144, 0, "1,0,1,0,7");
    let file = file(&entities);
    assert_close(areas(&file)[0], 1.0 - PI / 16.0);
    assert_eq!(file.model.faces[0].bounds.len(), 2);
}

#[test]
fn bounded_surface_runs_through_its_curves_in_their_senses() {
    // The second and the last side run against the boundary.
    let entities = [
        entity(143, 0, "1,3,1,5"),
        entity(128, 0, BILINEAR),
        entity(141, 0, "1,0,3,4,7,1,1,7,9,2,1,11,13,1,1,13,15,2,1,17"),
        entity(110, 0, COUNTERCLOCKWISE[0]),
        entity(110, 0, "1.,1.,0.,1.,0.,0."),
        entity(110, 0, COUNTERCLOCKWISE[1]),
        entity(110, 0, COUNTERCLOCKWISE[2]),
        entity(110, 0, "0.,0.,0.,0.,1.,0."),
        entity(110, 0, COUNTERCLOCKWISE[3]),
    ];
    let file = clean(&entities);
    assert_close(areas(&file)[0], 1.0);
    let BoundaryLoop::Edges(edges) = &file.model.faces[0].bounds[0].boundary else { panic!() };
    let senses: Vec<bool> = edges.iter().map(|edge| edge.forward).collect();
    assert_eq!(senses, [true, false, true, false]);
}

#[test]
fn curves_in_parameters_are_those_of_the_surface_in_the_file() {
    // A quarter of a cylinder about z: the first parameter is that of the generatrix, from 0 to 1, the second the angle, here from 1 to 2.
    let entities = [
        entity(144, 0, "3,1,0,9"),
        entity(120, 0, "5,7,0.,3."),
        entity(110, 0, "0.,0.,0.,0.,0.,1."),
        entity(110, 0, "2.,0.,0.,2.,0.,3."),
        entity(142, 0, "1,3,11,13,3"),
        entity(102, 0, "4,15,17,19,21"),
        entity(102, 0, "4,23,25,27,29"),
        entity(110, 0, "0.,1.,0.,1.,1.,0."),
        entity(110, 0, "1.,1.,0.,1.,2.,0."),
        entity(110, 0, "1.,2.,0.,0.,2.,0."),
        entity(110, 0, "0.,2.,0.,0.,1.,0."),
        entity(110, 0, "1.0806046117362795,1.682941969615793,0.,1.0806046117362795,1.682941969615793,3."),
        entity(
            100,
            0,
            "3.,0.,0.,1.0806046117362795,1.682941969615793,-0.8322936730942848,1.8185948536513634",
        ),
        entity(110, 0, "-0.8322936730942848,1.8185948536513634,3.,-0.8322936730942848,1.8185948536513634,0."),
        EntityText {
            matrix: 31,
            ..entity(
                100,
                0,
                "0.,0.,0.,-0.8322936730942848,-1.8185948536513634,1.0806046117362795,-1.682941969615793",
            )
        },
        entity(124, 0, "1.,0.,0.,0.,0.,-1.,0.,0.,0.,0.,-1.,0."),
    ];
    let file = clean(&entities);
    assert_close(areas(&file)[0], 2.0 * 3.0);
    // The derivatives by u (up) and v (along the angle) have the inner side in front.
    let trimmed = trimmed_faces(&file.model);
    let volume = trimmed.faces[0].as_ref().unwrap().measure(1e-9).volume;
    assert!(volume.abs() > 1.0);
    let spline_edges = file.model.edges.iter().map(|edge| &edge.parameter_curves[0].curve);
    let first: Vec<_> = spline_edges.map(|curve| curve.point(curve.domain()[0])).collect();
    assert_eq!(
        first.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>(),
        [[1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 0.0]]
    );
}

/// What was mended.
fn repairs(file: &BrepFile) -> Vec<String> {
    file.report.repairs.notes().iter().map(ToString::to_string).collect()
}

#[test]
fn boundaries_in_parameters_alone_have_the_curves_of_their_surface() {
    let note = |number: u64| format!("{}: {LIFTED}", id(number));
    for ends in [COUNTERCLOCKWISE, CLOCKWISE] {
        let mut entities = square_with_hole("4,17,19,21,23", ends);
        entities[2] = entity(142, 0, "1,1,9,0,1");
        entities[3] = entity(142, 0, "1,1,13,0,1");
        let file = file(&entities);
        assert_close(areas(&file)[0], 1.0 - PI / 16.0);
        assert_eq!((file.report.faces.read, repairs(&file)), (1, vec![note(5), note(7)]));
        // All points of the circle, also those between the ones through which its curve runs.
        let circle = file.model.edges.last().unwrap().curve.as_ref().unwrap();
        let [from, to] = circle.domain();
        for i in 0..1000 {
            let point = circle.point(from + (to - from) * (f64::from(i) / 999.0));
            assert!((point.distance(DVec3::new(0.5, 0.5, 0.0)) - 0.25).abs() < 1e-8, "{point}");
        }
    }
    let bounded = [
        entity(143, 0, "1,3,1,5"),
        entity(128, 0, BILINEAR),
        entity(141, 0, "1,0,3,4,0,1,1,7,0,1,1,9,0,1,1,11,0,2,1,13"),
        entity(110, 0, COUNTERCLOCKWISE[0]),
        entity(110, 0, COUNTERCLOCKWISE[1]),
        entity(110, 0, COUNTERCLOCKWISE[2]),
        entity(110, 0, COUNTERCLOCKWISE[3]),
    ];
    let file = file(&bounded);
    assert_close(areas(&file)[0], 1.0);
    assert_eq!(repairs(&file), [note(5)]);
}

#[test]
fn curves_of_a_round_surface_are_arcs_and_lines_or_near_them() {
    // On a cylinder of radius 2, whose parameters are the height in thirds and the angle: a rectangle, and a triangle with a slanted side.
    let cylinder = [
        entity(144, 0, "3,1,0,9"),
        entity(120, 0, "5,7,0.,3."),
        entity(110, 0, "0.,0.,0.,0.,0.,1."),
        entity(110, 0, "2.,0.,0.,2.,0.,3."),
        entity(142, 0, "1,3,11,0,1"),
    ];
    let sides = ["0.,1.,0.,1.,1.,0.", "1.,1.,0.,1.,2.,0.", "1.,2.,0.,0.,2.,0.", "0.,2.,0.,0.,1.,0."];
    let mut rectangle = cylinder.to_vec();
    rectangle.push(entity(102, 0, "4,13,15,17,19"));
    rectangle.extend(sides.map(|side| entity(110, 0, side)));
    let mut triangle = cylinder.to_vec();
    triangle.push(entity(102, 0, "3,13,15,17"));
    triangle.extend([sides[0], sides[1], "1.,2.,0.,0.,1.,0."].map(|side| entity(110, 0, side)));
    for (entities, area) in [(&rectangle, 6.0), (&triangle, 3.0)] {
        let file = file(entities);
        assert_close(areas(&file)[0], area);
        let curves = file.model.edges.iter().map(|edge| edge.curve.as_ref().unwrap());
        let fitted = curves.filter(|curve| matches!(curve, Curve::Spline(_)));
        // Only the slanted side, a helix, is no line of a constant parameter.
        assert_eq!(fitted.count(), usize::from(area < 6.0));
    }
}

#[test]
fn boundary_without_any_curve_is_refused_by_number() {
    let neither = "there is neither a curve in space nor one in the parameters of its surface";
    let mut trimmed = square_with_hole("4,17,19,21,23", COUNTERCLOCKWISE);
    trimmed[2] = entity(142, 0, "1,1,0,0,1");
    let bounded = vec![entity(143, 0, "1,3,1,5"), entity(128, 0, BILINEAR), entity(141, 0, "1,0,3,1,0,1,0")];
    // A plane has no parameters.
    let plain = "there is no curve in space, and curves in the parameters of its surface are not read";
    let mut plane = square_with_hole("4,17,19,21,23", COUNTERCLOCKWISE);
    plane[0] = entity(108, 0, "0.,0.,1.,0.,0");
    plane[2] = entity(142, 0, "1,1,9,0,1");
    for (entities, face, reason) in [(&trimmed, 3, neither), (&bounded, 1, neither), (&plane, 3, plain)] {
        let file = file(entities);
        assert_eq!(omissions(&file)[0], format!("{}: #5: {reason}", id(face)));
        assert_eq!((file.report.faces.read, file.report.faces.refused), (0, 1));
    }
    // Twice as high as the surface.
    let mut beyond = square_with_hole("4,17,19,21,23", COUNTERCLOCKWISE);
    beyond[2] = entity(142, 0, "1,1,9,0,1");
    beyond[9] = entity(110, 0, "1.,0.,0.,1.,2.,0.");
    assert!(omissions(&file(&beyond))[0].contains("#5: the curve in parameters leaves its surface"));
}

#[test]
fn boundary_that_runs_back_through_a_seam_bounds_a_whole_turn() {
    // A sphere as a half circle turned about z, trimmed by its seam, once upwards and once downwards; the poles are points.
    let half = "0.,0.,0.,0.,-1.,0.,1.";
    let entities = [
        entity(144, 0, "3,1,0,9"),
        entity(120, 0, "5,7,0.,6.283185307179586"),
        entity(110, 0, "0.,0.,0.,0.,1.,0."),
        EntityText { matrix: 0, ..entity(100, 0, half) },
        entity(142, 0, "1,3,0,11,2"),
        entity(102, 0, "2,13,15"),
        entity(100, 0, half),
        EntityText { matrix: 17, ..entity(100, 0, half) },
        // Half a turn about x.
        entity(124, 0, "1.,0.,0.,0.,0.,-1.,0.,0.,0.,0.,-1.,0."),
    ];
    let file = clean(&entities);
    assert_eq!(file.model.edges.len(), 1);
    assert_close(areas(&file)[0], 4.0 * PI);
}

#[test]
fn boundary_of_a_plane_moves_with_it() {
    // The plane z = 0 becomes x = 5.
    let entities = [
        EntityText { matrix: 11, ..entity(108, 1, "0.,0.,1.,0.,3") },
        entity(102, 0, "3,5,7,9"),
        entity(110, 0, "0.,0.,0.,1.,0.,0."),
        entity(110, 0, "1.,0.,0.,1.,1.,0."),
        entity(110, 0, "1.,1.,0.,0.,0.,0."),
        entity(124, 0, "0.,0.,1.,5.,1.,0.,0.,0.,0.,1.,0.,0."),
    ];
    let file = clean(&entities);
    assert_close(areas(&file)[0], 0.5);
    assert!(file.model.vertices.iter().all(|vertex| vertex.x == 5.0));
}

#[test]
fn missing_parameter_curves_cost_no_face() {
    let mut trimmed = square_with_hole("4,17,19,21,23", COUNTERCLOCKWISE);
    trimmed[2] = entity(142, 0, "1,1,999,11,3");
    let bounded = [
        entity(143, 0, "1,3,1,5"),
        entity(128, 0, BILINEAR),
        entity(141, 0, "1,0,3,4,7,1,1,999,9,1,1,9,11,1,1,11,13,1,1,13"),
        entity(110, 0, COUNTERCLOCKWISE[0]),
        entity(110, 0, COUNTERCLOCKWISE[1]),
        entity(110, 0, COUNTERCLOCKWISE[2]),
        entity(110, 0, COUNTERCLOCKWISE[3]),
    ];
    for (entities, area) in [(trimmed.as_slice(), 1.0 - PI / 16.0), (&bounded, 1.0)] {
        let file = file(entities);
        assert_eq!((file.report.faces.read, file.report.repairs.count()), (1, 1));
        assert_close(trimmed_faces(&file.model).faces[0].as_ref().unwrap().measure(1e-9).area, area);
    }
}
