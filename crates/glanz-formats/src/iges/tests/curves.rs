//! Curves, as they appear in extrusions along z.

use std::f64::consts::{PI, TAU};

use glanz_brep::model::{Curve, FaceSurface};

use super::*;

/// The directrix of a tabulated cylinder.
fn curve(kind: u32, form: u32, parameters: &str) -> Curve<DVec3> {
    let file = file(&[entity(kind, form, parameters), entity(122, 0, "1,0.,0.,1.")]);
    let Some(entry) = file.model.surfaces.first() else { panic!("{:?}", omissions(&file)) };
    let FaceSurface::Extrusion { curve, .. } = &entry.surface else { panic!() };
    *curve.clone()
}

fn refusal(kind: u32, form: u32, parameters: &str) -> String {
    omissions(&file(&[entity(kind, form, parameters), entity(122, 0, "1,0.,0.,1.")]))[0].clone()
}

fn at(curve: &Curve<DVec3>, fraction: f64) -> DVec3 {
    let [from, to] = curve.domain();
    curve.point(from + (to - from) * fraction)
}

#[test]
fn arc_runs_counterclockwise_from_start_to_end() {
    // From (0, 2) over (-2, 0) and (0, -2) to (2, 0), about (1, 0, 5) moved.
    let arc = curve(100, 0, "5.,1.,0.,1.,2.,3.,0.");
    assert_eq!(arc.domain(), [0.5 * PI, TAU]);
    assert_near(at(&arc, 0.0), DVec3::new(1.0, 2.0, 5.0));
    assert_near(at(&arc, 1.0 / 3.0), DVec3::new(-1.0, 0.0, 5.0));
    assert_near(at(&arc, 1.0), DVec3::new(3.0, 0.0, 5.0));
    let circle = curve(100, 0, "0.,0.,0.,1.,0.,1.,0.");
    assert_eq!(circle.domain(), [0.0, TAU]);
    assert!(refusal(100, 0, "0.,1.,1.,1.,1.,1.,1.").contains("the radius of the arc is 0"));
}

#[test]
fn conic_arcs_fulfil_their_equations() {
    let value = |c: [f64; 6], p: DVec3| {
        c[0] * p.x * p.x + c[1] * p.x * p.y + c[2] * p.y * p.y + c[3] * p.x + c[4] * p.y + c[5]
    };
    // x^2 / 4 + y^2 = 1; the same about (1, 2); x^2 - y^2 = 1, both branches; y = x^2 + 1; 2 x y = 1, turned by 45 degrees.
    let r2 = std::f64::consts::SQRT_2;
    let cases: [([f64; 6], [f64; 4]); 6] = [
        ([0.25, 0.0, 1.0, 0.0, 0.0, -1.0], [2.0, 0.0, 0.0, 1.0]),
        ([0.25, 0.0, 1.0, -0.5, -4.0, 3.25], [3.0, 2.0, 1.0, 3.0]),
        ([1.0, 0.0, -1.0, 0.0, 0.0, -1.0], [-r2, 1.0, -r2, -1.0]),
        ([1.0, 0.0, -1.0, 0.0, 0.0, -1.0], [1.0, 0.0, r2, -1.0]),
        ([1.0, 0.0, 0.0, 0.0, -1.0, 1.0], [2.0, 5.0, -1.0, 2.0]),
        ([0.0, 2.0, 0.0, 0.0, 0.0, -1.0], [1.0, 0.5, 0.25, 2.0]),
    ];
    for (c, [x1, y1, x2, y2]) in cases {
        let numbers: Vec<String> =
            c.iter().chain(&[7.0, x1, y1, x2, y2]).map(|number| format!("{number:?}")).collect();
        let conic = curve(104, 0, &numbers.join(","));
        assert!(at(&conic, 0.0).distance(DVec3::new(x1, y1, 7.0)) < 1e-12, "{c:?}");
        assert!(at(&conic, 1.0).distance(DVec3::new(x2, y2, 7.0)) < 1e-12, "{c:?}");
        for i in 0..=8 {
            assert!(value(c, at(&conic, f64::from(i) / 8.0)).abs() < 1e-12, "{c:?}");
        }
    }
    assert!(refusal(104, 0, "0.,0.,0.,1.,1.,1.,0.,0.,-1.,-1.,0.").contains("not that of an ellipse"));
}

#[test]
fn rational_spline_is_the_circle_it_stands_for() {
    let weight = 0.5_f64.sqrt();
    let quarter = curve(
        126,
        0,
        &format!("2,2,1,0,0,0,0.,0.,0.,1.,1.,1.,1.,{weight:?},1.,1.,0.,0.,1.,1.,0.,0.,1.,0.,0.,1.,0.,0.,1."),
    );
    for i in 0..=8 {
        let p = at(&quarter, f64::from(i) / 8.0);
        assert!((p.length() - 1.0).abs() < 1e-14);
    }
    let part = curve(
        126,
        0,
        &format!("2,2,1,0,0,0,0.,0.,0.,1.,1.,1.,1.,{weight:?},1.,1.,0.,0.,1.,1.,0.,0.,1.,0.,0.,0.5"),
    );
    assert_near(at(&part, 1.0), DVec3::new(weight, weight, 0.0));
    assert!(refusal(126, 0, "9,2,1,0,0,0,0.").contains("too few parameters for 10 control points"));
}

#[test]
fn parametric_spline_has_its_polynomials() {
    // x = s, y = s^3 over [0, 1]; then x = 1 + s, y = 1 + 3 s over [1, 3].
    let spline = curve(
        112,
        0,
        "3,1,2,2,0.,1.,3.,0.,1.,0.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,1.,0.,0.,1.,3.,0.,0.,0.,0.,0.,0.",
    );
    assert_eq!(spline.domain(), [0.0, 3.0]);
    assert_near(spline.point(0.5), DVec3::new(0.5, 0.125, 0.0));
    assert_near(spline.point(2.0), DVec3::new(2.0, 4.0, 0.0));
}

#[test]
fn copious_data_and_composites_are_chains() {
    assert_eq!(
        curve(106, 11, "1,3,2.,0.,0.,1.,0.,1.,1."),
        Curve::Polyline(vec![
            DVec3::new(0.0, 0.0, 2.0),
            DVec3::new(1.0, 0.0, 2.0),
            DVec3::new(1.0, 1.0, 2.0)
        ])
    );
    assert!(
        matches!(curve(106, 12, "2,2,0.,0.,2.,3.,4.,5."), Curve::Polyline(points) if points[1] == DVec3::new(3.0, 4.0, 5.0))
    );
    let file = file(&[
        entity(102, 0, "2,5,7"),
        entity(122, 0, "1,0.,0.,1."),
        entity(110, 0, "0.,0.,0.,1.,0.,0."),
        entity(102, 0, "2,5,9"),
        entity(100, 0, "0.,1.,1.,1.,0.,2.,1."),
    ]);
    let FaceSurface::Extrusion { curve, .. } = &file.model.surfaces[0].surface else { panic!() };
    let Curve::Composite(segments) = curve.as_ref() else { panic!() };
    assert_eq!(segments.len(), 3);
}

#[test]
fn composites_that_contain_themselves_are_refused() {
    let file = file(&[entity(102, 0, "1,1"), entity(122, 0, "1,0.,0.,1.")]);
    assert_eq!(omissions(&file)[0], "#3: #1: curves are nested deeper than 16 levels");
}
