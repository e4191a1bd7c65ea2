//! Surfaces with their parameters.

use std::f64::consts::PI;

use super::*;

/// The area of the first face, which may lack a boundary.
fn first_area(file: &BrepFile) -> f64 {
    trimmed_faces(&file.model).faces[0].as_ref().unwrap().measure(1e-9).area
}

#[test]
fn whole_surfaces_end_at_their_borders() {
    // A quarter of a cylinder of radius 2 and height 3, as a tabulated cylinder.
    let tabulated = [entity(100, 0, "0.,0.,0.,2.,0.,0.,2."), entity(122, 0, "1,2.,0.,3.")];
    assert_close(areas(&clean(&tabulated))[0], 3.0 * PI);
    // A third of a cone from radius 1 to 2 over the height 1.
    let turned = |angles: &str, line: &str| {
        let parameters = format!("3,5,{angles}");
        let entities =
            [entity(120, 0, &parameters), entity(110, 0, "0.,0.,-1.,0.,0.,2."), entity(110, 0, line)];
        areas(&clean(&entities))[0]
    };
    let cone = PI * 3.0 * 2.0_f64.sqrt();
    assert_close(turned("0.,2.0943951023931953", "1.,0.,0.,2.,0.,1."), cone / 3.0);
    assert_close(turned("0.5,6.783185307179586", "1.,0.,0.,2.,0.,1."), cone);
    // Files round the turn, up or down.
    assert_close(turned("0.,6.28319", "1.,0.,0.,2.,0.,1."), cone);
    assert_close(turned("0.,6.28318", "1.,0.,0.,2.,0.,1."), cone);
    // To the apex, where the border is a point.
    assert_close(turned("1.,2.", "0.,0.,0.,1.,0.,1."), 0.5 * 2.0_f64.sqrt());
}

#[test]
fn part_of_a_spline_is_its_range() {
    let half = BILINEAR.strip_suffix("0.,1.,0.,1.").unwrap().to_owned() + "0.,0.5,0.,1.";
    assert_close(areas(&clean(&[entity(128, 0, &half)]))[0], 0.5);
}

#[test]
fn ruled_surface_between_lines_is_their_rectangle() {
    // A rectangle of 2 x 3 between two lines, in both forms, the second line turned.
    let line = entity(110, 0, "0.,0.,0.,2.,0.,0.");
    let flat = [line, entity(110, 0, "0.,3.,0.,2.,3.,0."), entity(118, 0, "1,3,0,0")];
    let file = file(&flat);
    assert_eq!((file.report.faces.read, file.report.omissions.count()), (1, 0));
    assert_close(first_area(&file), 6.0);
    let turned = [line, entity(110, 0, "2.,3.,0.,0.,3.,0."), entity(118, 1, "1,3,1,0")];
    assert_close(first_area(&super::file(&turned)), 6.0);
    let bent = [entity(100, 0, "0.,0.,0.,1.,0.,0.,1."), line, entity(118, 0, "1,3,0,0")];
    assert!(omissions(&super::file(&bent))[0].contains("between a conic and another curve"));
    let chain = [entity(106, 11, "1,3,0.,0.,0.,1.,0.,1.,1."), line, entity(118, 0, "1,3,0,0")];
    assert!(omissions(&super::file(&chain))[0].contains("neither straight nor circular"));
}

#[test]
fn ruled_surface_from_a_point_is_a_triangle() {
    let sides = [entity(110, 0, "0.,0.,0.,2.,0.,0."), entity(110, 0, "0.,3.,0.,0.,3.,0.")];
    for form in [0, 1] {
        let file = file(&[sides[0], sides[1], entity(118, form, "1,3,0,0")]);
        assert_eq!((omissions(&file), file.report.faces.read), (Vec::new(), 1));
        assert_close(first_area(&file), 3.0);
    }
}

#[test]
fn ruled_surface_between_arcs_is_a_cone() {
    // Quarters of circles of radius 1 and 2, at heights 0 and 1.
    let arcs = [entity(100, 0, "0.,0.,0.,1.,0.,0.,1."), entity(100, 0, "1.,0.,0.,2.,0.,0.,2.")];
    for form in [0, 1] {
        let file = clean(&[arcs[0], arcs[1], entity(118, form, "1,3,0,0")]);
        assert_close(first_area(&file), 0.75 * PI * 2.0_f64.sqrt());
    }
    let half = [arcs[0], entity(100, 0, "1.,0.,0.,2.,0.,-2.,0."), entity(118, 1, "1,3,0,0")];
    assert!(omissions(&file(&half))[0].contains("or one of another angle"));
}

#[test]
fn ruled_surface_has_the_knots_of_both_curves() {
    let entities = [
        entity(126, 0, "2,1,1,0,1,0,0.,0.,0.25,1.,1.,1.,1.,1.,0.,0.,0.,0.25,0.,0.,1.,0.,0.,0.,1."),
        entity(126, 0, "2,1,1,0,1,0,0.,0.,0.5,1.,1.,1.,1.,1.,0.,1.,0.,0.5,1.,0.,1.,1.,0.,0.,1."),
        entity(118, 1, "1,3,0,0"),
    ];
    let file = clean(&entities);
    assert_close(first_area(&file), 1.0);
    let glanz_brep::model::FaceSurface::Spline(surface) = &file.model.surfaces[0].surface else { panic!() };
    assert_eq!(surface.knots_u().knots(), [0.0, 0.0, 0.25, 0.5, 1.0, 1.0]);
}

#[test]
fn ruled_surface_between_curves_of_many_different_knots_is_refused() {
    // Chains of 400 and 401 segments, as parts of [0, 1].
    let chain = |count: usize, y: f64| {
        let points: Vec<String> = (0..=count).map(|i| format!("{i}.,{y:?}")).collect();
        format!("1,{},0.,{}", count + 1, points.join(","))
    };
    let (first, second) = (chain(400, 0.0), chain(401, 1.0));
    let entities = [entity(106, 11, &first), entity(106, 11, &second), entity(118, 1, "1,3,0,0")];
    assert!(omissions(&file(&entities))[0].contains("more than 512 different knots"));
}

#[test]
fn ruled_surfaces_are_no_larger_than_their_budget() {
    // Between a chain of 150 segments and a spline of degree 15, which has 16 control points, they have 2 * 2251.
    let chain: Vec<String> = (0..=150).map(|i| format!("{i}.,0.")).collect();
    let chain = format!("1,151,0.,{}", chain.join(","));
    let points: Vec<String> = (0..16).map(|i| format!("{i}.,1.,0.")).collect();
    let knots = [["0."; 16], ["1."; 16]].concat().join(",");
    let spline =
        format!("15,15,1,0,1,0,{knots},{},{},0.,1.,0.,0.,1.", ["1."; 16].join(","), points.join(","));
    let mut entities = vec![entity(106, 11, &chain), entity(126, 0, &spline)];
    entities.extend([entity(118, 1, "1,3,0,0"); 4]);
    let file = file(&entities);
    let points = file.model.surfaces.iter().map(|entry| match &entry.surface {
        glanz_brep::model::FaceSurface::Spline(surface) => surface.control_points().len(),
        _ => 0,
    });
    let (points, size) = (points.sum::<usize>(), text(&entities).len());
    assert!((4502..=2 * size + 1000).contains(&points), "{points} control points from {size} bytes");
    assert!(omissions(&file)[0].contains("repeats its geometry too often"), "{:?}", omissions(&file));
}

#[test]
fn analytic_surface_that_is_stretched_is_refused() {
    let entities = [
        EntityText { matrix: 5, ..entity(196, 0, "3,2.") },
        entity(116, 0, "0.,0.,0."),
        entity(124, 0, "2.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,0."),
    ];
    assert_eq!(
        omissions(&file(&entities))[0],
        "#1: its transformation is neither a rotation nor a reflection"
    );
}

#[test]
fn surfaces_of_the_types_190_to_198_have_their_measures() {
    let location = [entity(116, 0, "1.,2.,3."), entity(123, 0, "0.,0.,2.")];
    let whole = |kind: u32, parameters: &str| {
        let [point, direction] = location;
        areas(&clean(&[entity(kind, 0, parameters), point, direction]))[0]
    };
    assert_close(areas(&clean(&[entity(196, 0, "3,2."), location[0]]))[0], 16.0 * PI);
    assert_close(whole(198, "3,5,3.,1."), 12.0 * PI * PI);
    let file = file(&[entity(192, 0, "3,5,3."), location[0], location[1]]);
    assert_eq!(omissions(&file)[0], "#1: the surface has no border");
}

#[test]
fn reflected_surface_of_revolution_turns_the_other_way() {
    // A quarter turn of the line (1, 0, z) about z, reflected in x.
    let entities = [
        EntityText { matrix: 7, ..entity(120, 0, "3,5,0.,1.5707963267948966") },
        entity(110, 0, "0.,0.,0.,0.,0.,1."),
        entity(110, 0, "1.,0.,0.,1.,0.,1."),
        entity(124, 1, "-1.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,0."),
        entity(144, 0, "1,0,0,0"),
    ];
    let file = clean(&entities);
    let trimmed = trimmed_faces(&file.model);
    let face = trimmed.faces[0].as_ref().unwrap();
    assert_close(face.measure(1e-9).area, 0.5 * PI);
    let vertices = &file.model.vertices;
    assert!(vertices.iter().all(|p| p.x <= 1e-9 && p.y >= -1e-9), "{vertices:?}");
}
