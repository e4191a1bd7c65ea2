//! Trimming.

use super::*;

fn trim(text: &str) -> TrimDescription {
    shape(&format!("\"sphere\" {text}")).trim.unwrap()
}

/// The only curve of the only loop.
fn curve(text: &str) -> TrimCurveDescription {
    let mut trim = trim(text);
    assert_eq!((trim.loops.len(), trim.loops[0].curves.len()), (1, 1));
    trim.loops.remove(0).curves.remove(0)
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
fn widths_scale_domain_and_solid_are_carried_over() {
    let plain = trim(HALF_DISC);
    assert_eq!((plain.scale, plain.domain), ([1.0; 2], None));
    assert!(plain.loops.iter().flat_map(|l| &l.curves).all(|curve| curve.width.is_none()));
    let text = format!(
        "\"sphere\" {HALF_DISC} \"float trimwidths\" [1e-3 0 2e-4] \"float trimscale\" [6.5 3] \
         \"float trimdomain\" [0 -1 1 .5] \"integer solid\" 7"
    );
    let shape = shape(&text);
    assert_eq!(shape.solid, Some(7));
    let trim = shape.trim.unwrap();
    assert_eq!((trim.scale, trim.domain), ([6.5, 3.0], Some([[0.0, -1.0], [1.0, 0.5]])));
    let widths: Vec<_> = trim.loops.iter().flat_map(|l| &l.curves).map(|curve| curve.width).collect();
    assert_eq!(widths, [Some(1e-3), Some(0.0), Some(2e-4)]);
}

#[test]
fn errors_of_trimming_have_a_position() {
    let whole = format!("WorldBegin Shape \"disk\"\n{HALF_DISC}");
    let changed = |from: &str, to: &str| replaced(&whole, from, to);
    let simple = |text: &str| format!("WorldBegin Shape \"disk\" {text}");
    check_errors(&[
        (
            changed("\"integer trimcounts\" [3 2 4]", ""),
            "2:22: shape \"disk\": \"trimloops\" is given without \"trimcounts\"",
        ),
        (changed("[2 1]", "[2 0]"), "2:24: shape \"disk\": \"trimloops\" has 0; it must be at least 1"),
        (
            changed("[2 1]", "[2 2]"),
            "2:49: shape \"disk\": \"trimloops\" has 4 curves in all, \"trimorders\" is given for 3",
        ),
        (
            changed("[3 2 4]", "[3 2]"),
            "2:78: shape \"disk\": \"trimloops\" has 3 curves in all, \"trimcounts\" is given for 2",
        ),
        (changed("[3 2 2]", "[3 2 1]"), "2:53: shape \"disk\": \"trimorders\" has 1; it must be at least 2"),
        (
            changed("[3 2 2]", "[3 3 2]"),
            "2:80: shape \"disk\": trimming curve 1 has 2 points; its order 3 needs at least 3",
        ),
        (
            changed("3 3 4 5 6 6", "3 3 4 5 6"),
            "2:104: shape \"disk\": parameter \"trimknots\" has 15 values; 16 are needed",
        ),
        (
            changed("3 3 4 5 6 6", "3 3 4 3 6 6"),
            "2:132: shape \"disk\": knot vector \"trimknots\" must not decrease",
        ),
        (
            changed("  0 .1 1]", "]"),
            "2:159: shape \"disk\": parameter \"trimpoints\" has 8 points; 9 are needed",
        ),
        (
            changed("0 2 2", "0 2 0"),
            "2:170: shape \"disk\": a weight in \"trimpoints\" is 0.0; it must be positive",
        ),
        (
            format!("{whole} \"float trimwidths\" [1 2]"),
            "2:251: shape \"disk\": parameter \"trimwidths\" has 2 values; 3 are needed",
        ),
        (
            format!("{whole} \"float trimwidths\" [1 2 -3]"),
            "2:255: shape \"disk\": \"trimwidths\" has -3; it must not be negative",
        ),
        (
            format!("{whole} \"integer trimedges\" [-1 -1 -1 3 -2 4 0 0 1]"),
            "2:263: shape \"disk\": \"trimedges\" has -2; numbers must be at least 0, or all three of a curve -1",
        ),
        (
            format!(
                "{whole} \"integer trimedges\" [0 0 1 0 0 1 0 0 1] \"float trimedgeranges\" [0 1 0 1.5 0 1]"
            ),
            "2:301: shape \"disk\": \"trimedgeranges\" has 1.5; it must be from 0 to 1",
        ),
        (
            format!("{whole} \"float trimscale\" [1 0]"),
            "2:250: shape \"disk\": \"trimscale\" has 0; it must be positive",
        ),
        (format!("{whole} \"float trimdomain\" [0 1 1 1]"), "2:251: shape \"disk\": \"trimdomain\" is empty"),
        (simple("\"integer solid\" -1"), "1:41: shape \"disk\": \"solid\" is -1; it must be at least 0"),
        (
            simple("\"float trimpolygon\" [0 0 1]"),
            "1:46: shape \"disk\": parameter \"trimpolygon\" has 3 values; a multiple of 2 is needed",
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
            "1:61: shape \"disk\": a radius in \"trimellipse\" is -1; it must be positive",
        ),
        (
            simple("\"float trimellipse\" [1e308 0 1e308 1]"),
            "1:46: shape \"disk\": an ellipse in \"trimellipse\" is out of range",
        ),
        (
            simple("\"float trimellipse\" [0 0 1 1] \"string trimside\" \"in\""),
            "1:73: shape \"disk\": \"trimside\" is \"in\"",
        ),
    ]);
}

#[test]
fn fractions_of_edges_without_edges_are_not_used() {
    let text = format!("WorldBegin Shape \"sphere\" {HALF_DISC} \"float trimedgeranges\" [0 1 0 1 0 1]");
    let loaded = load_str("odd.pbrt", &text, &Options::default()).unwrap();
    let warnings = loaded.diagnostics.to_string();
    assert!(warnings.contains("parameter \"trimedgeranges\" is not used by shape \"sphere\""), "{warnings}");
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
