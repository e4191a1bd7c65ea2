//! Surfaces.

use glanz_brep::model::{Curve, FaceSurface, Placement};
use glanz_math::DVec3;

use super::*;

/// The surface #10 of a file in some units.
fn surface(units: &str, data: &str) -> FaceSurface {
    let file = clean(&format!("{units}{ONE_FACE}{data}"));
    file.model.surfaces[file.model.faces[0].surface].surface.clone()
}

/// The reason against the surface #10.
fn refusal(data: &str) -> String {
    let file = file(&format!("{MILLIMETRES}{ONE_FACE}{data}"));
    assert_eq!((file.report.faces.refused, file.report.omissions.count()), (1, 1));
    omissions(&file).remove(0)
}

/// That of #30 at `origin`.
fn frame(origin: DVec3) -> Placement {
    Placement { origin, x: DVec3::Y, y: DVec3::Z, z: DVec3::X }
}

const MM: DVec3 = DVec3::new(1e-3, 2e-3, 3e-3);

#[test]
fn lengths_are_metres_and_angles_radians_whatever_the_units() {
    let cylinder = surface(INCHES, "#10=CYLINDRICAL_SURFACE('',#30,2.);");
    let FaceSurface::Cylinder { placement, radius } = cylinder else { panic!("{cylinder:?}") };
    assert!((radius - 0.0508).abs() < 1e-15);
    assert_near(placement.origin, DVec3::new(0.0254, 0.0508, 0.0762));
    let cone = surface(INCHES, "#10=CONICAL_SURFACE('',#30,2.,45.);");
    let FaceSurface::Cone { half_angle, .. } = cone else { panic!("{cone:?}") };
    assert!((half_angle - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    let file = clean(&format!("{INCHES}{ONE_FACE}#10=PLANE('',#30);"));
    assert!((file.model.uncertainty - 0.0127).abs() < 1e-15);
}

#[test]
fn elementary_surfaces_have_the_frame_and_the_radii_of_the_file() {
    let placement = frame(MM);
    for (data, expected) in [
        ("PLANE('',#30)", FaceSurface::Plane(placement)),
        ("CYLINDRICAL_SURFACE('',#30,2000.)", FaceSurface::Cylinder { placement, radius: 2.0 }),
        ("CONICAL_SURFACE('',#30,0.,0.5)", FaceSurface::Cone { placement, radius: 0.0, half_angle: 0.5 }),
        ("SPHERICAL_SURFACE('',#30,2000)", FaceSurface::Sphere { placement, radius: 2.0 }),
        (
            "TOROIDAL_SURFACE('',#30,2000.,1000.)",
            FaceSurface::Torus { placement, major_radius: 2.0, minor_radius: 1.0, select_outer: true },
        ),
        (
            "DEGENERATE_TOROIDAL_SURFACE('',#30,1000.,2000.,.F.)",
            FaceSurface::Torus { placement, major_radius: 1.0, minor_radius: 2.0, select_outer: false },
        ),
    ] {
        assert_eq!(surface(MILLIMETRES, &format!("#10={data};")), expected);
    }
}

#[test]
fn missing_axes_have_the_defaults_of_the_standard() {
    let plane = |placement: &str| surface(MILLIMETRES, &format!("#10=PLANE('',#40);#40={placement};"));
    let expected = |x, y, z| FaceSurface::Plane(Placement { origin: MM, x, y, z });
    assert_eq!(plane("AXIS2_PLACEMENT_3D('',#31,$,$)"), expected(DVec3::X, DVec3::Y, DVec3::Z));
    assert_eq!(plane("AXIS2_PLACEMENT_3D('',#31,#32,$)"), expected(DVec3::Y, DVec3::Z, DVec3::X));
    let parallel =
        file(&format!("{MILLIMETRES}{ONE_FACE}#10=PLANE('',#40);#40=AXIS2_PLACEMENT_3D('',#31,#32,#32);"));
    assert_eq!((parallel.report.repairs.count(), parallel.report.faces.read), (1, 1));
}

#[test]
fn cone_with_a_negative_angle_is_the_same_cone_turned_over() {
    let cone = surface(MILLIMETRES, "#10=CONICAL_SURFACE('',#30,1000.,-0.5);");
    let Placement { origin, x, y, z } = frame(MM);
    let placement = Placement { origin, x, y: -y, z: -z };
    assert_eq!(cone, FaceSurface::Cone { placement, radius: 1.0, half_angle: 0.5 });
}

#[test]
fn swept_surfaces_keep_the_parameter_of_their_curve() {
    let line = "#20=LINE('',#31,#21);#21=VECTOR('',#32,10.);";
    let swept = Curve::Line { origin: MM, direction: DVec3::new(0.01, 0.0, 0.0) };
    let revolution = surface(
        MILLIMETRES,
        &format!("{line}#10=SURFACE_OF_REVOLUTION('',#20,#22);#22=AXIS1_PLACEMENT('',#31,$);"),
    );
    let curve = Box::new(swept.clone());
    assert_eq!(revolution, FaceSurface::Revolution { curve, origin: MM, axis: DVec3::Z });
    let extrusion = surface(
        MILLIMETRES,
        &format!(
            "{line}#10=SURFACE_OF_LINEAR_EXTRUSION('',#20,#22);#22=VECTOR('',#23,7000.);#23=DIRECTION('',(0.,2.,0.));"
        ),
    );
    let direction = DVec3::new(0.0, 7.0, 0.0);
    assert_eq!(extrusion, FaceSurface::Extrusion { curve: Box::new(swept), direction });
}

#[test]
fn offset_and_trimmed_surfaces_contain_their_basis() {
    let basis = Box::new(FaceSurface::Cylinder { placement: frame(MM), radius: 2.0 });
    let cylinder = "#11=CYLINDRICAL_SURFACE('',#30,2000.);";
    let offset = surface(MILLIMETRES, &format!("{cylinder}#10=OFFSET_SURFACE('',#11,-5.,.F.);"));
    assert_eq!(offset, FaceSurface::Offset { basis: basis.clone(), distance: -0.005 });
    let trimmed = surface(
        MILLIMETRES,
        &format!("{cylinder}#10=RECTANGULAR_TRIMMED_SURFACE('',#11,0.5,1.,3.,-4.,.T.,.F.);"),
    );
    let ranges = [[0.5, 1.0], [0.003, -0.004]];
    assert_eq!(trimmed, FaceSurface::Rectangular { basis, ranges, same_sense: [true, false] });
}

/// Points of a bilinear net (0, 0) to (1, 1) metres, numbered from 41 in the order of the rows.
const NET: &str = "#41=CARTESIAN_POINT('',(0.,0.,0.));#42=CARTESIAN_POINT('',(0.,1000.,0.));
    #43=CARTESIAN_POINT('',(1000.,0.,0.));#44=CARTESIAN_POINT('',(1000.,1000.,0.));";

#[test]
fn spline_surfaces_of_all_forms_are_read() {
    let common = "'',1,1,((#41,#42),(#43,#44)),.UNSPECIFIED.,.F.,.F.,.F.";
    for data in [
        format!("B_SPLINE_SURFACE_WITH_KNOTS({common},(2,2),(2,2),(0.,1.),(0.,1.),.UNSPECIFIED.)"),
        format!("QUASI_UNIFORM_SURFACE({common})"),
        format!("BEZIER_SURFACE({common})"),
        format!("UNIFORM_SURFACE({common})"),
    ] {
        let FaceSurface::Spline(spline) = surface(MILLIMETRES, &format!("{NET}#10={data};")) else {
            panic!()
        };
        assert!(spline.knots_u().is_clamped() && spline.is_polynomial());
        assert_near(spline.point(0.25, 0.5), DVec3::new(0.25, 0.5, 0.0));
    }
}

#[test]
fn rational_surface_is_weighted() {
    let data = "#10=(BOUNDED_SURFACE()B_SPLINE_SURFACE(1,1,((#41,#42),(#43,#44)),.UNSPECIFIED.,.F.,.F.,.F.)
        B_SPLINE_SURFACE_WITH_KNOTS((2,2),(2,2),(0.,1.),(0.,2.),.UNSPECIFIED.)GEOMETRIC_REPRESENTATION_ITEM()
        RATIONAL_B_SPLINE_SURFACE(((1.,3.),(1.,3.)))REPRESENTATION_ITEM('')SURFACE());";
    let FaceSurface::Spline(spline) = surface(MILLIMETRES, &format!("{NET}{data}")) else { panic!() };
    // Half of the weight 1 against half of the weight 3.
    assert_near(spline.point(0.0, 1.0), DVec3::new(0.0, 0.75, 0.0));
}

#[test]
fn double_points_at_a_knot_are_one_and_gaps_are_refused() {
    let spline = |columns: &str| {
        format!(
            "{NET}#45=CARTESIAN_POINT('',(500.,0.,0.));#46=CARTESIAN_POINT('',(500.,1000.,0.));
             #10=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#41,#42),{columns},(#43,#44)),.UNSPECIFIED.,.F.,.F.,.F.,(2,2,2),(2,2),
             (0.,1.,2.),(0.,1.),.UNSPECIFIED.);"
        )
    };
    let FaceSurface::Spline(read) = surface(MILLIMETRES, &spline("(#45,#46),(#45,#46)")) else { panic!() };
    assert_eq!(read.counts(), (3, 2));
    assert_near(read.point(1.5, 0.0), DVec3::new(0.75, 0.0, 0.0));
    assert_eq!(refusal(&spline("(#45,#46),(#45,#44)")), "#1: #10: the surface has a gap at a knot");
}

#[test]
fn refused_surfaces_have_a_reason() {
    for (data, reason) in [
        ("PLANE('',#99)", "#1: #10: #99 does not exist"),
        ("PLANE('')", "#1: #10: attribute 2 is missing"),
        ("PLANE('',#31)", "#1: #31: CARTESIAN_POINT is no placement that can be read"),
        ("SPHERICAL_SURFACE('',#30,0.)", "#1: #10: the radius is 0; it must be positive and finite"),
        (
            "CONICAL_SURFACE('',#30,1.,2.)",
            "#1: #10: the half angle is 2 radians; it must be between 0 and pi / 2",
        ),
        ("OFFSET_SURFACE('',#10,1.,.F.)", "#1: #10: geometry is nested deeper than 16 levels"),
        (
            "CURVE_BOUNDED_SURFACE('',#30,(),.F.)",
            "#1: #10: CURVE_BOUNDED_SURFACE is no surface that can be read",
        ),
        ("HELICOID('',#30)", "#1: #10: HELICOID is no surface that can be read"),
        (
            "B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#31,#31),(#31,#31)),.U.,.F.,.F.,.F.,(2,3),(2,2),(0.,1.),(0.,1.),.U.)",
            "#1: #10: the multiplicities add up to 5; 4 knots are needed",
        ),
    ] {
        assert_eq!(refusal(&format!("#10={data};")), reason);
    }
}

#[test]
fn frames_are_orthonormal_also_where_the_reference_is_along_the_axis() {
    let one = "1.,1.,1.";
    for (axis, reference, repairs) in [
        (one, Some(one), 1),
        (one, Some("-1.,-1.,-1.00000000000001"), 1),
        (one, Some("1.,1.,1.000001"), 0),
        ("49.,0.,0.", None, 0),
        ("49.,0.,0.", Some("49.,0.,0."), 1),
        ("1.,1.E-9,0.", None, 0),
    ] {
        let directions =
            format!("#41=DIRECTION('',({axis}));#42=DIRECTION('',({}));", reference.unwrap_or(one));
        let reference = if reference.is_some() { "#42" } else { "$" };
        let file = file(&format!(
            "{MILLIMETRES}{ONE_FACE}{directions}#10=PLANE('',#40);#40=AXIS2_PLACEMENT_3D('',#31,#41,{reference});"
        ));
        assert_eq!(file.report.repairs.count(), repairs, "{directions}");
        let FaceSurface::Plane(Placement { x, y, z, .. }) = file.model.surfaces[0].surface else { panic!() };
        for (a, b) in [(x, y), (y, z), (z, x)] {
            assert!(a.dot(b).abs() <= 4.0 * f64::EPSILON, "{directions}: {a} {b}");
            assert!((a.length() - 1.0).abs() <= 4.0 * f64::EPSILON, "{directions}: {a}");
        }
    }
}
