//! Splines and patches.

use super::*;

fn nurbs(text: &str) -> NurbsDescription {
    match shape(&format!("\"nurbs\" {text}")).geometry {
        GeometryDescription::Nurbs(nurbs) => nurbs,
        other => panic!("{other:?}"),
    }
}

fn patches(text: &str) -> BezierPatchesDescription {
    match shape(text).geometry {
        GeometryDescription::BezierPatches(patches) => patches,
        other => panic!("{other:?}"),
    }
}

/// All messages as a user sees them.
fn messages(text: &str) -> String {
    load_str("bad.pbrt", text, &Options::default()).expect_err(text).to_string()
}

/// A surface of degrees 2 and 1 on 4 x 2 points.
const SHEET: &str = "\"integer nu\" 4 \"integer nv\" 2 \"integer uorder\" 3 \"integer vorder\" 2 \
    \"float uknots\" [0 0 0 1 2 2 2] \"float vknots\" [5 5 7 7]";

const SHEET_POINTS: &str = "\"point P\" [0 0 0  1 0 0  2 0 0  3 0 0  0 1 0  1 1 0  2 1 0  3 1 0]";

#[test]
fn points_of_nurbs_run_along_u_in_the_file_and_along_v_in_the_description() {
    let n = nurbs(&format!("{SHEET} {SHEET_POINTS}"));
    assert_eq!((n.degree_u, n.degree_v), (2, 1));
    assert_eq!(n.knots_u, [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]);
    assert_eq!(n.knots_v, [5.0, 5.0, 7.0, 7.0]);
    // Point (i, j) is (i, j, 0): i from 0 to 3 along u, j from 0 to 1 along v, at i * 2 + j.
    let expected: Vec<[f64; 4]> = (0..8).map(|k| [f64::from(k / 2), f64::from(k % 2), 0.0, 1.0]).collect();
    assert_eq!(n.points, expected);
    assert_eq!(n.domain, None);
}

#[test]
fn homogeneous_points_of_nurbs_are_taken_as_they_are() {
    let n = nurbs(
        "\"integer nu\" 2 \"integer nv\" 2 \"integer uorder\" 2 \"integer vorder\" 2 \"float uknots\" [0 0 1 1] \
         \"float vknots\" [0 0 1 1] \"float Pw\" [0 0 0 1  2 0 0 2  0 3 0 3  4 4 0 4]",
    );
    assert_eq!(n.points, [[0., 0., 0., 1.], [0., 3., 0., 3.], [2., 0., 0., 2.], [4., 4., 0., 4.]]);
}

#[test]
fn a_part_of_the_domain_is_kept_where_it_is_not_the_whole() {
    let domain = |part: &str| nurbs(&format!("{SHEET} {SHEET_POINTS} {part}")).domain;
    assert_eq!(domain("\"float u0\" 0.5 \"float v1\" 6"), Some([[0.5, 2.0], [5.0, 6.0]]));
    // As pbrt's own scenes have it.
    assert_eq!(domain("\"float u0\" 0 \"float u1\" 2 \"float v0\" 5 \"float v1\" 7"), None);
}

#[test]
fn knots_that_do_not_begin_together_leave_the_domain_of_pbrt() {
    // Uniform, order 3: from knot number 3 to number 5, which are 2 and 4.
    let n = "\"integer nu\" 4 \"integer nv\" 2 \"integer uorder\" 3 \"integer vorder\" 2 \
        \"float uknots\" [0 1 2 3 4 5 6] \"float vknots\" [0 0 1 1]";
    assert_eq!(nurbs(&format!("{n} {SHEET_POINTS} \"float u0\" 2")).domain, None);
    assert!(
        error(&format!("WorldBegin Shape \"nurbs\" {n} {SHEET_POINTS} \"float u0\" 1.5"))
            .ends_with("shape \"nurbs\": \"u0\" is 1.5; the knots \"uknots\" go from 2 to 4")
    );
}

#[test]
fn bezier_patch_is_bicubic_by_default_and_may_be_several() {
    let points: Vec<String> = (0..32).map(|k| format!("{} {} {}", k % 4, k / 4 % 4, k / 16)).collect();
    let b = patches(&format!("\"bezierpatch\" \"point3 P\" [{}]", points.join(" ")));
    assert_eq!((b.degree_u, b.degree_v, b.patches.len()), (3, 3, 2));
    for (number, patch) in b.patches.iter().enumerate() {
        // Point (i, j) is (i, j, number of the patch), at i * 4 + j.
        let expected: Vec<[f64; 4]> =
            (0..16).map(|k| [f64::from(k / 4), f64::from(k % 4), number as f64, 1.0]).collect();
        assert_eq!(*patch, expected);
    }
}

#[test]
fn weights_multiply_the_points_of_patches() {
    let b = patches(
        "\"bezierpatch\" \"integer udegree\" 2 \"integer vdegree\" 1 \
         \"point3 P\" [0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0] \"float weights\" [1 2 3 4 5 6]",
    );
    assert_eq!((b.degree_u, b.degree_v), (2, 1));
    let expected = [
        [0., 0., 0., 1.],
        [0., 4., 0., 4.],
        [2., 0., 0., 2.],
        [5., 5., 0., 5.],
        [6., 0., 0., 3.],
        [12., 6., 0., 6.],
    ];
    assert_eq!(b.patches, [expected]);
}

#[test]
fn points_of_a_bezier_triangle_keep_their_order() {
    let text = "\"beziertriangle\" \"integer degree\" 2 \"float weights\" [1 1 1 2 1 1] \
        \"point3 P\" [2 0 0  1 1 0  1 0 1  0 2 0  0 1 1  0 0 2]";
    let GeometryDescription::BezierTriangles(b) = shape(text).geometry else { panic!() };
    assert_eq!(b.degree, 2);
    // The points are the exponents (i, j, k) themselves, i descending, then j.
    let expected = [
        [2., 0., 0., 1.],
        [1., 1., 0., 1.],
        [1., 0., 1., 1.],
        [0., 4., 0., 2.],
        [0., 1., 1., 1.],
        [0., 0., 2., 1.],
    ];
    assert_eq!(b.patches, [expected]);
}

#[test]
fn patches_with_common_points_are_found_by_number() {
    let points: Vec<String> = (0..17).map(|k| format!("{k} 0 0")).collect();
    let second: Vec<String> = (1..17).rev().map(|k| k.to_string()).collect();
    let first: Vec<String> = (0..16).map(|k| k.to_string()).collect();
    let b = patches(&format!(
        "\"patchmesh\" \"point3 P\" [{}] \"integer indices\" [{} {}]",
        points.join(" "),
        first.join(" "),
        second.join(" ")
    ));
    assert_eq!((b.degree_u, b.degree_v, b.patches.len()), (3, 3, 2));
    // Row v = 0 is 0 1 2 3 in the file; in the description u = 0 comes first: 0 4 8 12.
    assert_eq!(b.patches[0][..5].iter().map(|p| p[0]).collect::<Vec<_>>(), [0.0, 4.0, 8.0, 12.0, 1.0]);
    assert_eq!(b.patches[1][..5].iter().map(|p| p[0]).collect::<Vec<_>>(), [16.0, 12.0, 8.0, 4.0, 15.0]);
}

#[test]
fn a_knot_that_decreases_is_pointed_at() {
    let text = format!("WorldBegin\nShape \"nurbs\" {SHEET} {SHEET_POINTS}")
        .replace("[0 0 0 1 2 2 2]", "[0 0 0\n  1 0.5 2 2]");
    assert_eq!(
        messages(&text),
        "error: bad.pbrt:3:5: shape \"nurbs\": knot vector \"uknots\" must not decrease\n  \
           3 |   1 0.5 2 2] \"float vknots\" [5 5 7 7] \"point P\" [0 0 0  1 0 0  2 0 0  3 0 0  0 1 0  1 1 0  2 1 0  3 ...\n    \
             |     ^^^\n  \
           help: sort the knots, or check a missing value between 1 and 0.5\n"
    );
}

#[test]
fn errors_of_surfaces_have_a_position() {
    let sheet = format!("WorldBegin\nShape \"nurbs\" {SHEET}\n{SHEET_POINTS}");
    let changed = |from: &str, to: &str| replaced(&sheet, from, to);
    check_errors(&[
        (changed("\"integer nu\" 4", ""), "2:1: shape \"nurbs\" has no \"integer nu\""),
        (changed("\"integer vorder\" 2", ""), "2:1: shape \"nurbs\" has no \"integer vorder\""),
        (changed("\"float uknots\" [0 0 0 1 2 2 2]", ""), "2:1: shape \"nurbs\" has no \"float uknots\""),
        (changed("\"integer nu\" 4", "\"integer nu\" 1"), "2:28: shape \"nurbs\": \"nu\" is 1; it must be at least 2"),
        (changed("order\" 3", "order\" 1"), "2:62: shape \"nurbs\": \"uorder\" is 1; it must be at least 2"),
        (
            changed("order\" 3", "order\" 5"),
            "2:28: shape \"nurbs\": \"nu\" is 4; an order \"uorder\" of 5 needs at least 5",
        ),
        (
            changed("[0 0 0 1 2 2 2]", "[0 0 0 2 2 2]"),
            "2:99: shape \"nurbs\": parameter \"uknots\" has 6 values; 7 are needed",
        ),
        (
            changed("[0 0 0 1 2 2 2]", "[0 0 0 0 2 2 2]"),
            "2:105: shape \"nurbs\": knot vector \"uknots\" has 0 more than 3 times",
        ),
        (
            changed("[5 5 7 7]", "[4 5 5 7]"),
            "2:134: shape \"nurbs\": knot vector \"vknots\" leaves nothing of the domain",
        ),
        (
            changed("0 0 0 1 2", "0 0 1e999 1 2"),
            "2:103: \"1e999\" is too large for a number",
        ),
        (changed("  3 1 0]", "]"), "3:12: shape \"nurbs\": \"P\" has 7 points, \"nu\" times \"nv\" is 8"),
        (changed(SHEET_POINTS, ""), "2:1: shape \"nurbs\" has neither points \"P\" nor \"float Pw\""),
        (
            changed(SHEET_POINTS, "\"float Pw\" [1 2 3]"),
            "3:13: shape \"nurbs\": parameter \"Pw\" has 3 values; a multiple of 4 is needed",
        ),
        (
            changed(SHEET_POINTS, "\"float Pw\" [1 2 3 1 1 2 3 0]"),
            "3:27: shape \"nurbs\": a weight in \"Pw\" is 0.0; it must be positive",
        ),
        (
            changed(SHEET_POINTS, "\"float Pw\" [1 2 3 1e-310]"),
            "3:19: shape \"nurbs\": the weight 1e-310 in \"Pw\" puts its point out of range",
        ),
        (
            changed(SHEET_POINTS, &format!("{SHEET_POINTS} \"float Pw\" [1 2 3 1]")),
            "3:80: shape \"nurbs\": give either \"P\" or \"Pw\"",
        ),
        (
            changed(SHEET_POINTS, &format!("\"float u1\" 3 {SHEET_POINTS}")),
            "3:12: shape \"nurbs\": \"u1\" is 3; the knots \"uknots\" go from 0 to 2",
        ),
        (
            changed(SHEET_POINTS, &format!("\"float u0\" 1 \"float u1\" 1 {SHEET_POINTS}")),
            "3:25: shape \"nurbs\": from \"u0\" = 1 to \"u1\" = 1 nothing of the surface is left",
        ),
        (
            "WorldBegin Shape \"bezierpatch\"".to_owned(),
            "1:12: shape \"bezierpatch\" has no points \"P\"",
        ),
        (
            "WorldBegin Shape \"bezierpatch\" \"point3 P\" [0 0 0]".to_owned(),
            "1:44: shape \"bezierpatch\": there are 1 points \"P\", a patch of degrees 3 and 3 has 16",
        ),
        (
            "WorldBegin Shape \"bezierpatch\" \"point3 P\" [] \"integer udegree\" 2147483647".to_owned(),
            "1:32: shape \"bezierpatch\": there are 0 points \"P\", a patch of degrees 2147483647 and 3 has 8589934592",
        ),
        (
            "WorldBegin Shape \"bezierpatch\" \"integer udegree\" 0".to_owned(),
            "1:50: shape \"bezierpatch\": \"udegree\" is 0; it must be at least 1",
        ),
        (
            "WorldBegin Shape \"beziertriangle\" \"integer degree\" 1 \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]".to_owned(),
            "1:66: shape \"beziertriangle\": there are 4 points \"P\", a triangle of degree 1 has 3",
        ),
        (
            "WorldBegin Shape \"beziertriangle\" \"integer degree\" 1 \"point3 P\" [0 0 0 1 0 0 0 1 0] \"float weights\" [1 1]"
                .to_owned(),
            "1:102: shape \"beziertriangle\": there are 3 points \"P\" and 2 weights \"weights\"",
        ),
        (
            "WorldBegin Shape \"beziertriangle\" \"integer degree\" 1 \"point3 P\" [0 0 0 1 0 0 0 1 0] \"float weights\" [1 -2 1]"
                .to_owned(),
            "1:104: shape \"beziertriangle\": a weight in \"weights\" is -2.0; it must be positive",
        ),
        (
            "WorldBegin Shape \"beziertriangle\" \"integer degree\" 1 \"point3 P\" [0 0 0 1e300 0 0 0 1 0] \"float weights\" [1 1e10 1]"
                .to_owned(),
            "1:108: shape \"beziertriangle\": the weight 10000000000.0 in \"weights\" puts its point out of range",
        ),
        (
            "WorldBegin Shape \"patchmesh\"".to_owned(),
            "1:12: shape \"patchmesh\" has neither \"string filename\" nor points \"P\"",
        ),
        (
            "WorldBegin Shape \"patchmesh\" \"string filename\" \"a.txt\"".to_owned(),
            "1:48: shape \"patchmesh\": file \"a.txt\" is not there",
        ),
        (
            "WorldBegin Shape \"patchmesh\" \"string filename\" \"a.txt\" \"point3 P\" [0 0 0]".to_owned(),
            "1:48: shape \"patchmesh\": give either \"filename\" or \"P\"",
        ),
        (
            "WorldBegin Shape \"patchmesh\" \"point3 P\" [0 0 0] \"integer indices\" []".to_owned(),
            "1:12: shape \"patchmesh\" has no patches",
        ),
    ]);
}
