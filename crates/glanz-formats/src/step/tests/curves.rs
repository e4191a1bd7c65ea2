//! Curves of edges and their parameter curves.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glanz_brep::model::Curve;
use glanz_math::{DVec2, DVec3};

use super::*;

/// A face on the plane #10 with one closed edge along the curve #20.
const ONE_EDGE: &str = "#1=ADVANCED_FACE('f',(#5),#10,.T.);#2=OPEN_SHELL('',(#1));#3=SHELL_BASED_SURFACE_MODEL('m',(#2));
    #4=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('r',(#3),#910);#5=FACE_BOUND('',#6,.T.);#6=EDGE_LOOP('',(#7));
    #7=ORIENTED_EDGE('',*,*,#8,.T.);#8=EDGE_CURVE('',#9,#9,#20,.T.);#9=VERTEX_POINT('',#31);#10=PLANE('',#30);
    #30=AXIS2_PLACEMENT_3D('',#31,#32,#33);#31=CARTESIAN_POINT('',(1.,2.,3.));#32=DIRECTION('',(2.,0.,0.));
    #33=DIRECTION('',(5.,1.,0.));#34=CARTESIAN_POINT('',(1.,2002.,3.));#35=CARTESIAN_POINT('',(1.,2.,2003.));";

const MM: DVec3 = DVec3::new(1e-3, 2e-3, 3e-3);

/// The point #34 in metres; 2.002 is one rounding away.
const POINT_34: DVec3 = DVec3::new(1e-3, 2002.0 * 1e-3, 3e-3);

fn curve(units: &str, data: &str) -> Curve<DVec3> {
    let file = clean(&format!("{units}{ONE_EDGE}{data}"));
    assert_eq!(file.model.edges[0].start, file.model.edges[0].end);
    file.model.edges[0].curve.clone().unwrap()
}

/// The range of a trimmed curve #20 with these two ends, whose basis is #21.
fn range(units: &str, basis: &str, ends: &str) -> [f64; 2] {
    match curve(units, &format!("#20=TRIMMED_CURVE('',#21,{ends});#21={basis};")) {
        Curve::Trimmed { range, same_sense: true, .. } => range,
        other => panic!("{other:?}"),
    }
}

fn assert_range(read: [f64; 2], expected: [f64; 2]) {
    assert!((0..2).all(|i| (read[i] - expected[i]).abs() < 1e-12), "{read:?} is not {expected:?}");
}

#[test]
fn elementary_curves_have_the_vectors_of_the_file() {
    let (y, z) = (DVec3::Y, DVec3::Z);
    for (data, expected) in [
        ("LINE('',#31,#40);#40=VECTOR('',#32,3000.)", Curve::Line { origin: MM, direction: DVec3::X * 3.0 }),
        ("CIRCLE('',#30,2000.)", Curve::Ellipse { center: MM, a: y * 2.0, b: z * 2.0 }),
        ("ELLIPSE('',#30,2000.,1000.)", Curve::Ellipse { center: MM, a: y * 2.0, b: z }),
        ("PARABOLA('',#30,1000.)", Curve::Parabola { apex: MM, a: y, b: z }),
        ("HYPERBOLA('',#30,2000.,1000.)", Curve::Hyperbola { center: MM, a: y * 2.0, b: z }),
        ("POLYLINE('',(#31,#31))", Curve::Polyline(vec![MM, MM])),
        (
            "SURFACE_CURVE('',#21,(#10),.CURVE_3D.);#21=CIRCLE('',#30,1000.)",
            Curve::Ellipse { center: MM, a: y, b: z },
        ),
    ] {
        assert_eq!(curve(MILLIMETRES, &format!("#20={data};")), expected);
    }
}

#[test]
fn parameters_of_circles_are_angles_and_those_of_lines_are_not() {
    let ends = "(PARAMETER_VALUE(90.)),(PARAMETER_VALUE(180.)),.T.,.PARAMETER.";
    assert_range(range(INCHES, "CIRCLE('',#30,1.)", ends), [FRAC_PI_2, PI]);
    assert_range(range(INCHES, "LINE('',#31,#40);#40=VECTOR('',#32,3.)", ends), [90.0, 180.0]);
    assert_range(range(INCHES, "HYPERBOLA('',#30,3.,1.)", ends), [90.0, 180.0]);
}

#[test]
fn points_trim_curves_at_their_parameters() {
    // The frame #30 is at (1, 2, 3) with the axes y and z; #34 and #35 are 2000 along them.
    let ends = "(#34),(#35),.T.,.CARTESIAN.";
    assert_range(range(MILLIMETRES, "CIRCLE('',#30,2000.)", ends), [0.0, FRAC_PI_2]);
    // The same point twice is a full turn.
    let full = "#20=TRIMMED_CURVE('',#21,(#34),(#34),.T.,.CARTESIAN.);#21=ELLIPSE('',#30,2000.,1000.);";
    assert_eq!(curve(MILLIMETRES, full).domain(), [0.0, TAU]);
    let to_line = "(#31),(#34),.T.,.CARTESIAN.";
    let line = "LINE('',#31,#40);#40=VECTOR('',#41,500.);#41=DIRECTION('',(0.,1.,0.))";
    assert_range(range(MILLIMETRES, line, to_line), [0.0, 4.0]);
    // y = 4 f and z = 4 f at the parameter 2 of a parabola.
    let parabola = "PARABOLA('',#30,500.);#42=CARTESIAN_POINT('',(1.,2002.,2003.))";
    assert_range(range(MILLIMETRES, parabola, "(#31),(#42),.T.,.CARTESIAN."), [0.0, 2.0]);
    assert_range(range(MILLIMETRES, "POLYLINE('',(#31,#34,#35))", "(#34),(#35),.T.,.CARTESIAN."), [1.0, 2.0]);
    let spline = "B_SPLINE_CURVE_WITH_KNOTS('',2,(#31,#34,#35),.U.,.F.,.F.,(3,3),(0.,1.),.U.);
        #42=CARTESIAN_POINT('',(1.,1002.,503.))";
    assert_range(range(MILLIMETRES, spline, "(#31),(#42),.T.,.CARTESIAN."), [0.0, 0.5]);
}

#[test]
fn preferred_trim_counts() {
    let ends = |master: &str| format!("(#34,PARAMETER_VALUE(1.)),(PARAMETER_VALUE(2.),#35),.T.,.{master}.");
    let circle = "CIRCLE('',#30,2000.)";
    assert_range(range(MILLIMETRES, circle, &ends("CARTESIAN")), [0.0, FRAC_PI_2]);
    assert_range(range(MILLIMETRES, circle, &ends("PARAMETER")), [1.0, 2.0]);
    assert_range(range(MILLIMETRES, circle, &ends("UNSPECIFIED")), [1.0, 2.0]);
}

#[test]
fn composite_curve_contains_its_segments_with_their_senses() {
    let data = "#20=COMPOSITE_CURVE('',(#21,#22),.F.);#21=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#23);
        #22=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.F.,#23);#23=POLYLINE('',(#31,#34));";
    let line = Curve::Polyline(vec![MM, POINT_34]);
    assert_eq!(curve(MILLIMETRES, data), Curve::Composite(vec![(line.clone(), true), (line, false)]));
}

#[test]
fn spline_curves_of_all_forms_have_their_knots() {
    let points = "(#31,#34,#35,#31,#34)";
    let common = format!("{points},.UNSPECIFIED.,.F.,.F.");
    for (data, knots) in [
        (format!("B_SPLINE_CURVE_WITH_KNOTS('',2,{common},(3,1,1,3),(0.,1.,4.,5.),.U.)"), vec![0., 0., 0., 1., 4., 5., 5., 5.]),
        (format!("UNIFORM_CURVE('',2,{common})"), vec![-2., -1., 0., 1., 2., 3., 4., 5.]),
        (format!("QUASI_UNIFORM_CURVE('',2,{common})"), vec![0., 0., 0., 1., 2., 3., 3., 3.]),
        (format!("BEZIER_CURVE('',2,{common})"), vec![0., 0., 0., 1., 1., 2., 2., 2.]),
        (format!("BEZIER_CURVE('',4,{common})"), vec![0., 0., 0., 0., 0., 1., 1., 1., 1., 1.]),
        (
            format!(
                "(BOUNDED_CURVE()B_SPLINE_CURVE(2,{common})CURVE()GEOMETRIC_REPRESENTATION_ITEM()QUASI_UNIFORM_CURVE()
                 RATIONAL_B_SPLINE_CURVE((1.,2.,1.,2.,1.))REPRESENTATION_ITEM(''))"
            ),
            vec![0., 0., 0., 1., 2., 3., 3., 3.],
        ),
    ] {
        let Curve::Spline(spline) = curve(MILLIMETRES, &format!("#20={data};")) else { panic!() };
        assert_eq!(spline.knots().knots(), knots);
        let weight = if data.contains("RATIONAL") { 2.0 } else { 1.0 };
        assert_eq!(spline.control_points()[1], (POINT_34 * weight).extend(weight));
    }
}

#[test]
fn refused_curves_have_a_reason() {
    for (data, reason) in [
        ("OFFSET_CURVE_3D('',#21,1.,.F.,#32)", "#1: #20: OFFSET_CURVE_3D is no curve that can be read"),
        ("CIRCLE('',#30,-1.)", "#1: #20: a length of the conic is -1; it must be positive"),
        (
            "COMPOSITE_CURVE('',(#21),.F.);#21=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#20)",
            "#1: #20: geometry is nested deeper than 16 levels",
        ),
        (
            "BEZIER_CURVE('',3,(#31,#34,#35,#31,#34),.U.,.F.,.F.)",
            "#1: #20: 5 control points make no Bézier segments of degree 3",
        ),
        (
            "BEZIER_CURVE('',3000000000,(#31,#34),.U.,.F.,.F.)",
            "#1: #20: the degree is 3000000000; it must be from 1 to 25",
        ),
        (
            "B_SPLINE_CURVE_WITH_KNOTS('',1,(#31,#34),.U.,.F.,.F.,(2,4294967295),(0.,1.),.U.)",
            "#1: #20: the multiplicities add up to 4294967297; 4 knots are needed",
        ),
        ("POLYLINE('',(#31))", "#1: #20: there are fewer than 2 points"),
    ] {
        let file = file(&format!("{MILLIMETRES}{ONE_EDGE}#20={data};"));
        assert_eq!((omissions(&file), file.report.faces.refused), (vec![reason.to_owned()], 1));
    }
}

/// The two parameter curves of a seam on the surface #10 with the curve `#29` in its parameters.
fn parameter_curve(units: &str, surface: &str, line: &str) -> Curve<DVec2> {
    let data = ONE_EDGE.replace("#10=PLANE('',#30);", "");
    let file = clean(&format!(
        "{units}{data}#10={surface};#20=SEAM_CURVE('',#21,(#22,#22),.PCURVE_S1.);#21=CIRCLE('',#30,1.);
         #22=PCURVE('',#10,#23);#23=DEFINITIONAL_REPRESENTATION('',(#29),#24);
         #24=(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''));
         #29={line};#26=CARTESIAN_POINT('',(1.,2.));#27=VECTOR('',#28,5.);#28=DIRECTION('',(3.,4.));
         #50=AXIS2_PLACEMENT_2D('',#26,$);"
    ));
    let curves = &file.model.edges[0].parameter_curves;
    assert_eq!(
        (curves.len(), curves[0].surface, curves[1].surface),
        (2, file.model.faces[0].surface, curves[0].surface)
    );
    curves[0].curve.clone()
}

#[test]
fn parameter_curves_are_scaled_as_the_surface_needs() {
    const INCH: f64 = 0.0254;
    let degree = PI / 180.0;
    for (surface, scale) in [
        ("PLANE('',#30)", [INCH, INCH]),
        ("CYLINDRICAL_SURFACE('',#30,1.)", [degree, INCH]),
        ("CONICAL_SURFACE('',#30,1.,45.)", [degree, INCH]),
        ("CONICAL_SURFACE('',#30,1.,-45.)", [-degree, -INCH]),
        ("SPHERICAL_SURFACE('',#30,1.)", [degree, degree]),
        ("TOROIDAL_SURFACE('',#30,2.,1.)", [degree, degree]),
        ("SURFACE_OF_REVOLUTION('',#60,#30);#60=LINE('',#31,#61);#61=VECTOR('',#32,1.)", [degree, 1.0]),
        ("SURFACE_OF_REVOLUTION('',#60,#30);#60=CIRCLE('',#30,1.)", [degree, degree]),
        (
            "SURFACE_OF_LINEAR_EXTRUSION('',#60,#61);#60=CIRCLE('',#30,1.);#61=VECTOR('',#32,1.)",
            [degree, 1.0],
        ),
        ("OFFSET_SURFACE('',#60,1.,.F.);#60=CYLINDRICAL_SURFACE('',#30,1.)", [degree, INCH]),
        ("BEZIER_SURFACE('',1,1,((#31,#34),(#35,#31)),.U.,.F.,.F.,.F.)", [1.0, 1.0]),
    ] {
        let Curve::Line { origin, direction } = parameter_curve(INCHES, surface, "LINE('',#26,#27)") else {
            panic!()
        };
        let near = |a: DVec2, b: DVec2| assert!(a.distance(b) < 1e-12, "{a} is not {b} on {surface}");
        near(origin, DVec2::new(scale[0], 2.0 * scale[1]));
        near(direction, DVec2::new(3.0 * scale[0], 4.0 * scale[1]));
    }
    let circle = parameter_curve(INCHES, "CYLINDRICAL_SURFACE('',#30,1.)", "CIRCLE('',#50,3.)");
    let Curve::Ellipse { center, a, b } = circle else { panic!() };
    let expected =
        [DVec2::new(degree, 2.0 * INCH), DVec2::new(3.0 * degree, 0.0), DVec2::new(0.0, 3.0 * INCH)];
    assert!([center, a, b].iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-12));
}

#[test]
fn parameter_curve_that_cannot_be_read_is_left_out_and_reported() {
    let file = file(&format!(
        "{MILLIMETRES}{ONE_EDGE}#20=SURFACE_CURVE('',#21,(#22),.PCURVE_S1.);#21=CIRCLE('',#30,1.);#22=PCURVE('',#10,#98);"
    ));
    assert_eq!((file.report.faces.read, file.report.repairs.count()), (1, 1));
    let note = file.report.repairs.notes()[0].to_string();
    assert_eq!(note, "#20: #22: #98 does not exist; the parameter curve is left out");
    assert_eq!(file.model.edges[0].parameter_curves.len(), 0);
}
