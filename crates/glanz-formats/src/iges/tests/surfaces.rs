//! Surfaces with their parameters.

use std::f64::consts::PI;

use super::*;

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
    let trimmed = trimmed_faces(&file.model);
    assert_close(trimmed.faces[0].as_ref().unwrap().measure(1e-9).area, 6.0);
    let turned = [line, entity(110, 0, "2.,3.,0.,0.,3.,0."), entity(118, 1, "1,3,1,0")];
    let turned = super::file(&turned);
    let trimmed = trimmed_faces(&turned.model);
    assert_close(trimmed.faces[0].as_ref().unwrap().measure(1e-9).area, 6.0);
    let bent = [entity(100, 0, "0.,0.,0.,1.,0.,0.,1."), line, entity(118, 0, "1,3,0,0")];
    assert!(omissions(&super::file(&bent))[0].contains("form 0 between curves that are not straight"));
}

#[test]
fn surfaces_of_the_types_190_to_198_have_their_measures() {
    let location = [entity(116, 0, "1.,2.,3."), entity(123, 0, "0.,0.,2.")];
    let whole = |kind: u32, parameters: &str| {
        let [point, direction] = location;
        areas(&clean(&[entity(kind, 0, parameters), point, direction]))[0]
    };
    assert_close(whole(196, "3,2.,5"), 16.0 * PI);
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
