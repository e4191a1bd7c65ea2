//! Surfaces compared with closed forms, and the messages for invalid files.

use glanz_math::glam::DVec4;

use super::*;

/// A file with every supported request, written for these tests.
const SAMPLE: &str = r#"##RenderMan RIB-Structure 1.0
version 3.03
Display "a.tif" "file" "rgba" # comments end with the line: Patch
Projection "perspective" "fov" [ 30 ]
Translate 0 0 100
WorldBegin
  LightSource "pointlight" 1 "string names" ["a \"b\"" "c"] "intensity" 5
  AttributeBegin
    Color [ 1 0 0 ]
    Basis "b-spline" 1 "b-spline" 1
    PatchMesh "bicubic" 5 "nonperiodic" 4 "nonperiodic" "vertex point P" [
      0 0 0  1 0 0  2 0 0  3 0 0  4 0 0   0 1 0  1 1 0  2 1 0  3 1 0  4 1 0
      0 2 0  1 2 0  2 2 0  3 2 0  4 2 0   0 3 0  1 3 0  2 3 0  3 3 0  4 3 0 ]
  AttributeEnd
  TransformBegin
    ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  10 20 30 1]
    Scale 2 2 2
    Rotate 90 0 0 1
    Patch "bilinear" "P" [1 0 0  0 1 0  0 0 1  1 1 1]
  TransformEnd
  NuPatch 3 3 [0 0 0 1 1 1] 0 1  2 2 [0 0 1 1] 0 0.5  "Pw" [1 0 0 1  1 1 0 1  0 2 0 2  1 0 2 1  1 1 2 1  0 2 4 2]
  Color 0 1 0
WorldEnd
"#;

fn patches(text: &str) -> Vec<BezierPatchesDescription> {
    read(text.as_bytes()).unwrap_or_else(|e| panic!("{e}: {text}")).patches
}

/// The message for an invalid file.
fn message(text: &str) -> String {
    read(text.as_bytes()).expect_err(text).to_string()
}

fn numbers(numbers: impl Iterator<Item = f64>) -> String {
    numbers.map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
}

/// A point of a Bézier patch by de Casteljau's algorithm; `patch` as in a description.
fn point(patch: &[[f64; 4]], count_v: usize, u: f64, v: f64) -> DVec4 {
    let casteljau = |mut row: Vec<DVec4>, t: f64| {
        while row.len() > 1 {
            row = row.windows(2).map(|p| p[0].lerp(p[1], t)).collect();
        }
        row[0]
    };
    let row = |points: &[[f64; 4]]| points.iter().map(|p| DVec4::from_array(*p)).collect();
    casteljau(patch.chunks(count_v).map(|points| casteljau(row(points), v)).collect(), u)
}

#[test]
fn patches_of_a_mesh_of_b_splines_are_the_plane_of_its_points() {
    let file = read(SAMPLE.as_bytes()).unwrap();
    let cubic = &file.patches[0];
    assert_eq!((cubic.degree_u, cubic.degree_v, cubic.patches.len()), (3, 3, 2));
    // Uniform B-splines of degree 3 reproduce lines: the patch (m, 0) runs from 1 + m to 2 + m along x, from 1 to 2
    // along y, at constant speed.
    for (m, patch) in cubic.patches.iter().enumerate() {
        for (i, p) in patch.iter().enumerate() {
            let expected = [1.0 + m as f64 + (i / 4) as f64 / 3.0, 1.0 + (i % 4) as f64 / 3.0, 0.0, 1.0];
            assert!(p.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{p:?} {expected:?}");
        }
    }
    assert_eq!(cubic.patches[0][12..], cubic.patches[1][..4]);
}

#[test]
fn later_transformations_apply_first_and_end_with_their_block() {
    let file = read(SAMPLE.as_bytes()).unwrap();
    // Rotated: (x, y, z) to (-y, x, z); doubled; moved by (10, 20, 30). Transformations before the world have no effect.
    let expected = [[10., 22., 30., 1.], [10., 20., 32., 1.], [8., 20., 30., 1.], [8., 22., 32., 1.]];
    let found = &file.patches[1].patches[0];
    for (p, expected) in found.iter().zip(expected) {
        assert!(p.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
    }
    // After the block.
    assert_eq!(file.splines[0].points[0], [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_nu_patch_is_a_spline_with_its_range() {
    let spline = read(SAMPLE.as_bytes()).unwrap().splines.remove(0);
    assert_eq!((spline.degree_u, spline.degree_v), (2, 1));
    assert_eq!((spline.knots_u, spline.knots_v), (vec![0., 0., 0., 1., 1., 1.], vec![0., 0., 1., 1.]));
    // Of equal u side by side.
    let points = [[1., 0., 0., 1.], [1., 0., 2., 1.], [1., 1., 0., 1.], [1., 1., 2., 1.], [0., 2., 0., 2.]];
    assert_eq!(spline.points[..5], points);
    assert_eq!(spline.domain, Some([[0.0, 1.0], [0.0, 0.5]]));
}

#[test]
fn skipped_requests_are_reported_once_at_their_first_position() {
    let file = read(SAMPLE.as_bytes()).unwrap();
    let skipped: Vec<_> = file.skipped.iter().map(|s| (s.name.as_str(), s.line, s.column)).collect();
    assert_eq!(skipped, [("Display", 3, 1), ("Projection", 4, 1), ("LightSource", 7, 3), ("Color", 9, 5)]);
}

#[test]
fn bases_agree_with_their_polynomials() {
    // Along u the points are given by x, along v they rise on a line. `one`: values of four points for the constant 1.
    let along = [0.0, 1.0, 2.0, 3.0];
    let constant = [0.0, 0.0, 0.0, 1.0];
    for (basis, x, expected, one) in [
        // Power: coefficients of t^3, t^2, t and 1.
        ("\"power\" 4", [2.0, 0.0, -1.0, 5.0], [2.0, 0.0, -1.0, 5.0], [1.0; 4]),
        // Hermite: 0 at 0 with slope 1, 4 at 1 with slope 2; and 1 at both ends with slope 1.
        ("\"hermite\" 2", [0.0, 1.0, 4.0, 2.0], [-5.0, 8.0, 1.0, 0.0], [2.0, -3.0, 1.0, 1.0]),
        // Catmull-Rom through (-1)^2, 0, 1, 2^2 is t^2 itself.
        ("\"catmull-rom\" 1", [1.0, 0.0, 1.0, 4.0], [0.0, 1.0, 0.0, 0.0], constant),
        // B-splines: (1 + 0 + 1) / 6 = 1/3 above the squares of the points.
        ("\"b-spline\" 1", [1.0, 0.0, 1.0, 4.0], [0.0, 1.0, 0.0, 1.0 / 3.0], constant),
        // Bézier: 1 at one inner point is 3 t (1 - t)^2.
        ("\"bezier\" 3", [0.0, 1.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], constant),
        // The matrix of the power basis, its last two rows exchanged.
        ("[1 0 0 0 0 1 0 0 0 0 0 1 0 0 1 0] 4", [2.0, 0.0, 5.0, -1.0], [2.0, 0.0, -1.0, 5.0], [1.0; 4]),
    ] {
        let net = along.iter().flat_map(|y| x.iter().flat_map(move |x| [*x, 0.0, *y]));
        let text = format!("Basis {basis} \"bezier\" 3 Patch \"bicubic\" \"P\" [{}]", numbers(net));
        let found = patches(&text);
        for t in [0.0, 0.2, 0.7, 1.0] {
            let p = point(&found[0].patches[0], 4, t, 0.5);
            let value = |polynomial: [f64; 4]| polynomial.iter().fold(0.0, |sum, c| sum * t + c);
            let (x, z) = (value(expected), 1.5 * value(one));
            assert!((p.x - x).abs() < 1e-14 && (p.z - z).abs() < 1e-14, "{basis} {t}: {p} {x} {z}");
            assert_eq!(p.w, 1.0);
        }
    }
}

#[test]
fn periodic_meshes_are_closed() {
    // Twelve points around the axis, four along it: twelve patches, or four with Bézier points.
    let around = (0..4).flat_map(|j| {
        (0..12).flat_map(move |i| {
            let (sin, cos) = (f64::from(i) * 0.5).sin_cos();
            [cos, sin, f64::from(j)]
        })
    });
    let points = numbers(around);
    for (basis, count) in [("\"b-spline\" 1", 12), ("\"catmull-rom\" 1", 12), ("\"bezier\" 3", 4)] {
        let text = format!(
            "Basis {basis} \"bezier\" 3 PatchMesh \"bicubic\" 12 \"periodic\" 4 \"nonperiodic\" \"P\" [{points}]"
        );
        let found = patches(&text).remove(0).patches;
        assert_eq!(found.len(), count);
        for (a, b) in found.iter().zip(found.iter().cycle().skip(1)) {
            assert_eq!(a[12..], b[..4], "{basis}");
        }
    }
    let text = format!("PatchMesh \"bilinear\" 12 \"periodic\" 4 \"nonperiodic\" \"P\" [{points}]");
    assert_eq!(patches(&text)[0].patches.len(), 36);
}

#[test]
fn reflections_preserve_and_reversed_orientations_exchange_the_front() {
    let corners = "\"P\" [0 0 0  1 0 0  0 1 0  1 1 0]";
    let patch =
        |before: &str| patches(&format!("{before} Patch \"bilinear\" {corners}"))[0].patches[0].clone();
    let plain = patch("");
    assert_eq!(plain, [[0., 0., 0., 1.], [0., 1., 0., 1.], [1., 0., 0., 1.], [1., 1., 0., 1.]]);
    let turned = [[1., 0., 0., 1.], [1., 1., 0., 1.], [0., 0., 0., 1.], [0., 1., 0., 1.]];
    assert_eq!(patch("ReverseOrientation"), turned);
    assert_eq!(patch("Scale 1 1 -1").map_z(), turned);
    assert_eq!(patch("Scale 1 1 -1 ReverseOrientation").map_z(), plain);
    let spline = |before: &str| {
        let text = format!(
            "{before} NuPatch 3 2 [0 0 1 4 4] 1 4  2 2 [0 0 1 1] 0 1 \"P\" [0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0]"
        );
        read(text.as_bytes()).unwrap().splines.remove(0)
    };
    let reversed = spline("ReverseOrientation");
    assert_eq!(reversed.knots_u, [0.0, 0.0, 3.0, 4.0, 4.0]);
    assert_eq!(reversed.domain, Some([[0.0, 3.0], [0.0, 1.0]]));
    assert_eq!(reversed.points[..2], spline("").points[4..]);
}

/// Points with -0 as 0.
trait MapZ {
    fn map_z(self) -> Self;
}

impl MapZ for Vec<[f64; 4]> {
    fn map_z(self) -> Self {
        self.into_iter().map(|p| p.map(|x| x + 0.0)).collect()
    }
}

#[test]
fn errors_have_line_and_column() {
    let p4 = "[0 0 0 1 0 0 0 1 0 1 1 0]";
    let mut wrong = Vec::new();
    let nu = |text: &str| format!("NuPatch\n{text} \"P\" {p4}");
    for (text, expected) in [
        ("\u{2}".to_owned(), "1:1: expected a request, found \"\\u{2}\""),
        ("\u{e4}".to_owned(), "1:1: this is a binary or compressed file; only text is supported"),
        ("[1]".to_owned(), "1:1: expected a request, found \"[\""),
        ("\n Scale 1 1x 1".to_owned(), "2:10: expected an argument, found \"1x\""),
        ("Scale 1 1 1e999".to_owned(), "1:11: \"1e999\" is not finite"),
        ("Scale [1 nan 1]".to_owned(), "1:10: expected a number, found \"nan\""),
        ("Scale 1 1".to_owned(), "1:1: Scale has 2 numbers; 3 are needed"),
        ("Scale 1 1 \"1\"".to_owned(), "1:11: Scale needs a number"),
        ("Surface \"matte".to_owned(), "1:9: the text that begins here has no closing quote"),
        ("Color [1 0 0".to_owned(), "1:7: the array that begins here has no closing bracket"),
        ("X [\"a\" 1]".to_owned(), "1:8: expected another text, found \"1\""),
        ("AttributeBegin\nTransformBegin".to_owned(), "2:1: TransformBegin has no TransformEnd"),
        ("AttributeBegin TransformEnd".to_owned(), "1:16: TransformEnd closes AttributeBegin"),
        ("WorldEnd".to_owned(), "1:1: WorldEnd closes nothing"),
        ("TransformBegin ".repeat(1001), "1:15001: blocks are nested more than 1000 deep"),
        (
            "MotionBegin [0 1]".to_owned(),
            "1:1: MotionBegin is not supported; surfaces in it would have wrong positions",
        ),
        (
            "Transform [1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 1]".to_owned(),
            "1:1: the last numbers of the rows are [0.0, 0.0, 1.0, 1.0]; those of an affine transformation are 0 0 0 1",
        ),
        (
            "Basis \"cubic\" 1 \"bezier\" 3".to_owned(),
            "1:7: Basis needs sixteen numbers or \"bezier\", \"b-spline\", \
            \"catmull-rom\", \"hermite\" or \"power\"",
        ),
        ("Basis \"power\" 0 \"bezier\" 3".to_owned(), "1:15: Basis needs a step from 1 to 4"),
        ("Patch \"cubic\"".to_owned(), "1:7: Patch needs the type \"bicubic\" or \"bilinear\""),
        ("Patch \"bilinear\" \"Pz\" [1 2 3 4]".to_owned(), "1:1: Patch needs control points \"P\" or \"Pw\""),
        (format!("Patch \"bicubic\" \"P\" {p4}"), "1:21: Patch has 12 numbers in \"P\"; 48 are needed"),
        (
            "Patch \"bilinear\" \"Pw\" [0 0 0 1  1 0 0 1\n 0 1 0 -1  1 1 0 1]".to_owned(),
            "2:8: a weight of the control points is -1; it must be positive",
        ),
        (
            "Scale 1e300 1 1 Patch \"bilinear\" \"P\" [0 0 0  1 0 0  1e9 1 0  1 1 0]".to_owned(),
            "1:53: a control point is out of range once it is transformed",
        ),
        (
            "PatchMesh \"bicubic\" 5 \"nonperiodic\" 4 \"nonperiodic\" \"P\" []".to_owned(),
            "1:21: 5 points along u do not make a whole number of patches in steps of 3",
        ),
        (
            "PatchMesh \"bicubic\" 4 \"wrapped\"".to_owned(),
            "1:23: PatchMesh needs the wrap \"periodic\" or \"nonperiodic\"",
        ),
        ("PatchMesh \"bilinear\" 1.5".to_owned(), "1:22: PatchMesh needs a number of points of at least 2"),
        (nu("2 3 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1"), "1:1: NuPatch has 2 points along an axis; 3 are needed"),
        (nu("2 2 [0 0 1] 0 1 2 2 [0 0 1 1] 0 1"), "2:5: NuPatch has 3 knots; 4 are needed"),
        (nu("2 2 [0 0 1 .5] 0 1 2 2 [0 0 1 1] 0 1"), "2:12: knot 0.5 follows 1; knots must not decrease"),
        (
            nu("2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0.5 2"),
            "2:33: the range from 0.5 to 2 is empty or extends beyond the knots, which span 0 to 1",
        ),
    ] {
        let found = message(&text);
        if found != expected {
            wrong.push((text, found, expected));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn formats_of_surface_files_are_recognised_by_their_beginning() {
    assert!(is_rib(SAMPLE.as_bytes()) && is_rib(b"\n Patch") && is_rib(b"\x80binary"));
    assert!(!is_rib(b"32\n1,2") && !is_rib(b"") && !is_rib(b" -1"));
}
