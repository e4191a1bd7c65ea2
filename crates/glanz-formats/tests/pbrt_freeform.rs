//! Freeform surfaces and trimming: what scenes say against what their descriptions hold, and what bad ones are told.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;

use glanz_formats::{Options, load, load_str};
use glanz_scene::description::{
    BezierPatchesDescription, GeometryDescription, NurbsDescription, ShapeDescription, TrimCurveDescription,
    TrimDescription,
};

/// The only shape of a scene that must not even cause a warning.
fn shape(text: &str) -> ShapeDescription {
    let text = format!("WorldBegin Shape {text}");
    let loaded = load_str("test.pbrt", &text, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded.description.world.shapes[0].clone()
}

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

fn trim(text: &str) -> TrimDescription {
    shape(&format!("\"sphere\" {text}")).trim.unwrap()
}

/// The only curve of the only loop.
fn curve(text: &str) -> TrimCurveDescription {
    let mut trim = trim(text);
    assert_eq!((trim.loops.len(), trim.loops[0].curves.len()), (1, 1));
    trim.loops.remove(0).curves.remove(0)
}

/// All messages as a user sees them.
fn messages(text: &str) -> String {
    load_str("bad.pbrt", text, &Options::default()).expect_err(text).to_string()
}

/// The first error's `line:column: message`.
fn error(text: &str) -> String {
    let errors = load_str("bad.pbrt", text, &Options::default()).expect_err(text);
    let first = errors.iter().next().unwrap();
    let location = first.location.unwrap();
    format!("{}:{}: {}", location.line, location.column, first.message)
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
            .ends_with("shape \"nurbs\": \"u0\" is 1.5, the knots \"uknots\" go from 2 to 4")
    );
}

#[test]
fn a_bezier_patch_is_bicubic_unless_it_says_otherwise_and_may_be_several() {
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
fn the_teapot_has_thirty_two_patches() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/teapot.pbrt");
    let loaded =
        load(&path, &Options { strict: true, ..Options::default() }).unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    assert_eq!(loaded.description.film.resolution, [960, 540]);
    let patches: Vec<_> = loaded
        .description
        .world
        .shapes
        .iter()
        .filter_map(|s| match &s.geometry {
            GeometryDescription::BezierPatches(b) => Some(b),
            _ => None,
        })
        .collect();
    assert_eq!((patches.len(), patches[0].patches.len()), (1, 32));
    // The rim begins at (1.4, 0, 2.4), and all of it stands on z = 0, 3.15 high.
    assert_eq!(patches[0].patches[0][0], [1.4, 0.0, 2.4, 1.0]);
    let z = || patches[0].patches.iter().flatten().map(|p| p[2]);
    assert_eq!((z().fold(f64::INFINITY, f64::min), z().fold(0.0, f64::max)), (0.0, 3.15));
}

#[test]
fn a_list_of_patches_that_is_wrong_is_told_with_the_place_in_it() {
    let folder = std::env::temp_dir().join(format!("glanz-formats-{}-newell", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("a.txt"), format!("1\n{}2\n1\n0,0,0\n", "1,".repeat(15))).unwrap();
    let scene = folder.join("scene.pbrt");
    std::fs::write(&scene, "WorldBegin\nShape \"patchmesh\" \"string filename\" \"a.txt\"\n").unwrap();
    let found = load(&scene, &Options::default()).unwrap_err().to_string();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(
        found.replace(&format!("{}/", folder.display()), ""),
        "error: scene.pbrt:2:37: shape \"patchmesh\": a.txt:2:31: patch 1 refers to point 2, there are 1, counted from 1\n  \
           2 | Shape \"patchmesh\" \"string filename\" \"a.txt\"\n    \
             |                                     ^^^^^^^\n"
    );
}

#[test]
fn a_hole_runs_clockwise_and_a_border_counterclockwise() {
    let hole = curve("\"float trimpolygon\" [0 0  1 0  1 1]");
    assert_eq!((hole.degree, hole.knots), (1, vec![0.0, 0.0, 1.0, 2.0, 3.0, 3.0]));
    assert_eq!(hole.points, [[0., 0., 1.], [1., 1., 1.], [1., 0., 1.], [0., 0., 1.]]);
    let border = [[0., 0., 1.], [1., 0., 1.], [1., 1., 1.], [0., 0., 1.]];
    assert_eq!(curve("\"float trimpolygon\" [0 0  1 0  1 1] \"string trimside\" \"inside\"").points, border);
    // Whichever way round it is given, and closed or not.
    let turned = curve("\"point2 trimpolygon\" [0 0  1 1  1 0  0 0] \"string trimside\" \"inside\"");
    assert_eq!(turned.points, border);
}

#[test]
fn rectangles_have_their_corners_in_any_order() {
    let corners = [[0.25, 0.75, 1.0], [0.25, 0.5, 1.0], [0.0, 0.5, 1.0], [0.0, 0.75, 1.0], [0.25, 0.75, 1.0]];
    let found = curve("\"float trimrectangle\" [.25 .75 0 .5]").points;
    assert_eq!(found, corners);
    let mut inside = curve("\"float trimrectangle\" [.25 .75 0 .5] \"string trimside\" \"inside\"").points;
    inside.reverse();
    assert_eq!(inside, corners);
}

#[test]
fn an_ellipse_is_four_exact_quarters() {
    let c = curve("\"float trimellipse\" [.5 .25 .5 .125] \"string trimside\" \"inside\"");
    assert_eq!(c.degree, 2);
    assert_eq!(c.knots, [0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.]);
    let w = FRAC_1_SQRT_2;
    let expected = [
        [1.0, 0.25, 1.0],
        [w, w * 0.375, w],
        [0.5, 0.375, 1.0],
        [0.0, w * 0.375, w],
        [0.0, 0.25, 1.0],
        [0.0, w * 0.125, w],
        [0.5, 0.125, 1.0],
        [w, w * 0.125, w],
        [1.0, 0.25, 1.0],
    ];
    assert_eq!(c.points, expected);
    // Half way along the first quarter: the mean of corner and ends with weights 1/4, w/2, 1/4 lies on the ellipse.
    let at = |k: usize| (c.points[0][k] + 2.0 * c.points[1][k] + c.points[2][k]) / 4.0;
    let (u, v) = ((at(0) / at(2) - 0.5) / 0.5, (at(1) / at(2) - 0.25) / 0.125);
    assert!((u * u + v * v - 1.0).abs() < 1e-14);
    let hole = curve("\"float trimellipse\" [.5 .25 .5 .125]").points;
    assert!(hole.iter().eq(expected.iter().rev()));
}

#[test]
fn outlines_may_be_many_and_given_more_than_once() {
    let t = trim(
        "\"float trimellipse\" [0 0 1 1  2 2 1 1] \"float trimpolygon\" [0 0 1 0 1 1] \
         \"float trimpolygon\" [5 5 6 5 6 6] \"float trimrectangle\" [0 0 1 1]",
    );
    let degrees: Vec<usize> = t.loops.iter().map(|l| l.curves[0].degree).collect();
    assert_eq!(degrees, [1, 1, 1, 2, 2]);
    assert_eq!(t.loops[1].curves[0].points[0], [5.0, 5.0, 1.0]);
    assert!(shape("\"sphere\"").trim.is_none());
}

const HALF_DISC: &str = "\"integer trimloops\" [2 1] \"integer trimorders\" [3 2 2] \"integer trimcounts\" [3 2 4] \
    \"float trimknots\" [0 0 0 1 1 1  0 0 1 1  3 3 4 5 6 6] \
    \"float trimpoints\" [1 0 1  0 2 2  -1 0 1   -1 0 1  1 0 1   0 .1 1  0 .2 1  .1 .2 1  0 .1 1]";

#[test]
fn loops_of_curves_are_cut_from_common_lists() {
    let t = trim(HALF_DISC);
    assert_eq!(t.loops.len(), 2);
    let [a, b] = &t.loops[0].curves[..] else { panic!() };
    assert_eq!((a.degree, &a.knots[..]), (2, &[0., 0., 0., 1., 1., 1.][..]));
    assert_eq!(a.points, [[1., 0., 1.], [0., 2., 2.], [-1., 0., 1.]]);
    assert_eq!((b.degree, &b.knots[..]), (1, &[0., 0., 1., 1.][..]));
    assert_eq!(b.points, [[-1., 0., 1.], [1., 0., 1.]]);
    let [c] = &t.loops[1].curves[..] else { panic!() };
    assert_eq!((c.degree, &c.knots[..]), (1, &[3., 3., 4., 5., 6., 6.][..]));
    assert_eq!(c.points[3], [0.0, 0.1, 1.0]);
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
fn wrong_surfaces_are_told_with_their_place() {
    let sheet = format!("WorldBegin\nShape \"nurbs\" {SHEET}\n{SHEET_POINTS}");
    let changed = |from: &str, to: &str| {
        assert!(sheet.contains(from));
        sheet.replace(from, to)
    };
    for (text, message) in [
        (changed("\"integer nu\" 4", ""), "2:1: shape \"nurbs\" has no \"integer nu\""),
        (changed("\"integer vorder\" 2", ""), "2:1: shape \"nurbs\" has no \"integer vorder\""),
        (changed("\"float uknots\" [0 0 0 1 2 2 2]", ""), "2:1: shape \"nurbs\" has no \"float uknots\""),
        (changed("\"integer nu\" 4", "\"integer nu\" 1"), "2:28: shape \"nurbs\": \"nu\" is 1, it must be at least 2"),
        (changed("order\" 3", "order\" 1"), "2:62: shape \"nurbs\": \"uorder\" is 1, it must be at least 2"),
        (
            changed("order\" 3", "order\" 5"),
            "2:28: shape \"nurbs\": \"nu\" is 4, an order \"uorder\" of 5 needs at least 5",
        ),
        (
            changed("[0 0 0 1 2 2 2]", "[0 0 0 2 2 2]"),
            "2:99: shape \"nurbs\": parameter \"uknots\" has 6 values, 7 are needed",
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
            "3:13: shape \"nurbs\": parameter \"Pw\" has 3 values, a multiple of 4 is needed",
        ),
        (
            changed(SHEET_POINTS, "\"float Pw\" [1 2 3 1 1 2 3 0]"),
            "3:27: shape \"nurbs\": a weight in \"Pw\" is 0.0, it must be positive",
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
            "3:12: shape \"nurbs\": \"u1\" is 3, the knots \"uknots\" go from 0 to 2",
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
            "1:50: shape \"bezierpatch\": \"udegree\" is 0, it must be at least 1",
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
            "1:104: shape \"beziertriangle\": a weight in \"weights\" is -2.0, it must be positive",
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
    ] {
        assert_eq!(error(&text), message);
    }
}

#[test]
fn wrong_trimming_is_told_with_its_place() {
    let whole = format!("WorldBegin Shape \"disk\"\n{HALF_DISC}");
    let changed = |from: &str, to: &str| {
        assert!(whole.contains(from));
        whole.replace(from, to)
    };
    let simple = |text: &str| format!("WorldBegin Shape \"disk\" {text}");
    for (text, message) in [
        (
            changed("\"integer trimcounts\" [3 2 4]", ""),
            "2:22: shape \"disk\": \"trimloops\" is given without \"trimcounts\"",
        ),
        (changed("[2 1]", "[2 0]"), "2:24: shape \"disk\": \"trimloops\" has 0, it must be at least 1"),
        (
            changed("[2 1]", "[2 2]"),
            "2:49: shape \"disk\": \"trimloops\" has 4 curves in all, \"trimorders\" is given for 3",
        ),
        (
            changed("[3 2 4]", "[3 2]"),
            "2:78: shape \"disk\": \"trimloops\" has 3 curves in all, \"trimcounts\" is given for 2",
        ),
        (changed("[3 2 2]", "[3 2 1]"), "2:53: shape \"disk\": \"trimorders\" has 1, it must be at least 2"),
        (
            changed("[3 2 2]", "[3 3 2]"),
            "2:80: shape \"disk\": trimming curve 1 has 2 points, its order 3 needs at least 3",
        ),
        (
            changed("3 3 4 5 6 6", "3 3 4 5 6"),
            "2:104: shape \"disk\": parameter \"trimknots\" has 15 values, 16 are needed",
        ),
        (
            changed("3 3 4 5 6 6", "3 3 4 3 6 6"),
            "2:132: shape \"disk\": knot vector \"trimknots\" must not decrease",
        ),
        (
            changed("  0 .1 1]", "]"),
            "2:159: shape \"disk\": parameter \"trimpoints\" has 8 points, 9 are needed",
        ),
        (
            changed("0 2 2", "0 2 0"),
            "2:170: shape \"disk\": a weight in \"trimpoints\" is 0.0, it must be positive",
        ),
        (
            simple("\"float trimpolygon\" [0 0 1]"),
            "1:46: shape \"disk\": parameter \"trimpolygon\" has 3 values, a multiple of 2 is needed",
        ),
        (
            simple("\"float trimpolygon\" [0 0 1 1 2 2]"),
            "1:46: shape \"disk\": \"trimpolygon\" encloses no area",
        ),
        (simple("\"float trimpolygon\" []"), "1:25: shape \"disk\": \"trimpolygon\" encloses no area"),
        (
            simple("\"float trimrectangle\" [0 0 1 1  2 2 2 3]"),
            "1:57: shape \"disk\": \"trimrectangle\" encloses no area",
        ),
        (
            simple("\"float trimellipse\" [0 0 1 1  0 0 1 -1]"),
            "1:61: shape \"disk\": a radius in \"trimellipse\" is -1, it must be positive",
        ),
        (
            simple("\"float trimellipse\" [1e308 0 1e308 1]"),
            "1:46: shape \"disk\": an ellipse in \"trimellipse\" is out of range",
        ),
        (
            simple("\"float trimellipse\" [0 0 1 1] \"string trimside\" \"in\""),
            "1:73: shape \"disk\": \"trimside\" is \"in\"",
        ),
    ] {
        assert_eq!(error(&text), message);
    }
}

#[test]
fn a_side_without_an_outline_is_not_used() {
    let text = "WorldBegin Shape \"disk\" \"string trimside\" \"inside\"";
    let loaded = load_str("odd.pbrt", text, &Options::default()).unwrap();
    assert!(loaded.diagnostics.to_string().contains("parameter \"trimside\" is not used by shape \"disk\""));
    let text = "WorldBegin Shape \"disk\" \"float trimelipse\" [0 0 1 1]";
    let loaded = load_str("odd.pbrt", text, &Options::default()).unwrap();
    assert!(loaded.diagnostics.to_string().contains("did you mean \"trimellipse\"?"));
}
