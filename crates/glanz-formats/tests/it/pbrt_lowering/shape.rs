//! Shapes.

use glanz_geometry::curve::CurveShading;

use super::*;

fn shape(text: &str) -> GeometryDescription {
    let loaded = read_clean(&format!("WorldBegin Shape {text}"));
    loaded.description.world.shapes[0].geometry.clone()
}

#[test]
fn quadrics_have_the_defaults_of_pbrt() {
    use GeometryDescription as G;
    assert!(matches!(
        shape("\"sphere\" \"float radius\" 2"),
        G::Sphere { radius: 2.0, z: [-2.0, 2.0], phi_max: TAU }
    ));
    assert!(matches!(shape("\"sphere\" \"float zmax\" -.5 \"float zmin\" .25 \"float phimax\" 90"),
        G::Sphere { radius: 1.0, z: [-0.5, 0.25], phi_max } if phi_max == FRAC_PI_2));
    assert!(matches!(shape("\"cylinder\""), G::Cylinder { radius: 1.0, z: [-1.0, 1.0], phi_max: TAU }));
    assert!(matches!(
        shape("\"cone\" \"float phimax\" 720"),
        G::Cone { radius: 1.0, height: 1.0, phi_max: TAU }
    ));
    assert!(matches!(shape("\"paraboloid\""), G::Paraboloid { radius: 1.0, z: [0.0, 1.0], phi_max: TAU }));
    assert!(matches!(
        shape("\"hyperboloid\""),
        G::Hyperboloid { p1: DVec3::ZERO, p2: DVec3::ONE, phi_max: TAU }
    ));
    assert!(matches!(
        shape("\"disk\" \"float innerradius\" .5"),
        G::Disk { height: 0.0, radius: 1.0, inner_radius: 0.5, phi_max: TAU }
    ));
}

#[test]
fn meshes_keep_points_corners_normals_and_coordinates() {
    let text = "\"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \
        \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1] \"float st\" [0 0 1 0 1 1 0 1]";
    let GeometryDescription::Triangles { positions, indices, normals, uvs } = shape(text) else { panic!() };
    assert_eq!((positions.len(), positions[2]), (4, DVec3::new(1.0, 1.0, 0.0)));
    assert_eq!(indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!((normals.unwrap()[3], uvs.unwrap()[1]), (DVec3::Z, DVec2::X));
    // Without indices three points are a triangle and four a bilinear patch.
    let GeometryDescription::Triangles { indices, .. } =
        shape("\"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0]")
    else {
        panic!()
    };
    assert_eq!(indices, [[0, 1, 2]]);
    let GeometryDescription::Bilinear { indices, .. } =
        shape("\"bilinearmesh\" \"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]")
    else {
        panic!()
    };
    assert_eq!(indices, [[0, 1, 2, 3]]);
}

#[test]
fn subdivided_meshes_have_four_triangles_per_level_and_normals() {
    let text = "\"loopsubdiv\" \"point P\" [1 1 1 -1 -1 1 -1 1 -1 1 -1 -1] \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]";
    for (levels, count) in
        [("", 256), ("\"integer nlevels\" 1", 16), ("\"integer levels\" 2 \"string scheme\" \"loop\"", 64)]
    {
        let GeometryDescription::Triangles { positions, indices, normals, .. } =
            shape(&format!("{text} {levels}"))
        else {
            panic!()
        };
        assert_eq!((indices.len(), positions.len()), (count, count / 2 + 2));
        // The limit of a corner of valence 3: 1 / (3 + 3 / (8 beta)) with beta = 3 / 16, that is 1/5 of each neighbour.
        assert!(positions[0].distance(DVec3::splat(0.4 - 0.2)) < 1e-12);
        // To the inside, from where the corners of this mesh are clockwise.
        assert!((normals.unwrap()[0].normalize() + DVec3::ONE.normalize()).length() < 1e-12);
    }
    // Two triangles that pass their common edge in the same direction.
    let broken = "\"point P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 0 1 3]";
    let loaded = read(&format!("WorldBegin Shape \"loopsubdiv\" {broken}"));
    let messages = loaded.diagnostics.to_string();
    assert!(messages.contains("the triangles around vertex 0 make no surface"), "{messages}");
    assert!(matches!(&loaded.description.world.shapes[0].geometry,
        GeometryDescription::Triangles { indices, .. } if *indices == [[0, 2, 1], [0, 3, 1]]));
}

fn curve(text: &str) -> (Vec<DVec3>, [f64; 2], CurveShading) {
    match shape(&format!("\"curve\" {text}")) {
        GeometryDescription::Curve { points, widths, shading } => (points, widths, shading),
        other => panic!("{other:?}"),
    }
}

#[test]
fn curves_of_both_bases_and_degrees_become_cubic_segments() {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let (points, widths, shading) =
        curve("\"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"float width0\" .5 \"integer splitdepth\" 2");
    assert_eq!((points.len(), points[2], widths, shading), (4, p(1.0, 1.0), [0.5, 1.0], CurveShading::Flat));
    let (points, widths, shading) = curve(
        "\"point P\" [0 0 0 3 3 0 6 0 0 9 -3 0 12 0 0] \"integer degree\" 2 \"float width\" .25 \"string type\" \"cylinder\"",
    );
    let expected =
        [p(0.0, 0.0), p(2.0, 2.0), p(4.0, 2.0), p(6.0, 0.0), p(8.0, -2.0), p(10.0, -2.0), p(12.0, 0.0)];
    assert_eq!((widths, shading, points.len()), ([0.25; 2], CurveShading::Cylinder, 7));
    assert!(points.iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-12), "{points:?}");
    // Uniform B-splines of points on a line at equal distances run along it evenly.
    for (degree, start) in [(2, 0.5), (3, 1.0)] {
        let text = format!(
            "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0] \"string basis\" \"bspline\" \"integer degree\" {degree}"
        );
        let (points, ..) = curve(&text);
        assert_eq!(points.len(), 3 * (5 - degree) + 1);
        let even = points
            .iter()
            .enumerate()
            .all(|(k, point)| point.distance(p(start + k as f64 / 3.0, 0.0)) < 1e-12);
        assert!(even, "{points:?}");
    }
    // A cubic one bends as its basis: (1, 4, 1) / 6 at knots.
    let (points, ..) = curve("\"point P\" [0 0 0 0 6 0 6 6 0 6 0 0] \"string basis\" \"bspline\"");
    assert!(points[0].distance(p(1.0, 5.0)) < 1e-12 && points[3].distance(p(5.0, 5.0)) < 1e-12);
}

#[test]
fn ribbons_are_spline_surfaces_per_segment() {
    let text = "WorldBegin Shape \"curve\" \"string type\" \"ribbon\" \"float width\" 2 \"integer degree\" 2 \
        \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0] \"normal N\" [0 0 1 0 0 1 0 0 1]";
    let shapes = read_clean(text).description.world.shapes;
    assert_eq!(shapes.len(), 2);
    let GeometryDescription::Nurbs(nurbs) = &shapes[1].geometry else { panic!() };
    assert_eq!((nurbs.degree_u, nurbs.degree_v, nurbs.points.len()), (3, 1, 8));
    let corners = [nurbs.points[0], nurbs.points[1], nurbs.points[6], nurbs.points[7]];
    assert_eq!(
        corners,
        [[2.0, -1.0, 0.0, 1.0], [2.0, 1.0, 0.0, 1.0], [4.0, -1.0, 0.0, 1.0], [4.0, 1.0, 0.0, 1.0]]
    );
}

#[test]
fn curves_with_wrong_counts_and_words_are_errors() {
    for (text, expected) in [
        ("", "has no points \"P\""),
        ("\"point P\" [0 0 0 1 0 0]", "2 points make no bezier curve of degree 3"),
        (
            "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"integer degree\" 4",
            "test.pbrt:1:79: shape \"curve\": the degree is 4",
        ),
        ("\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribon\"", "did you mean \"ribbon\"?"),
        ("\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribbon\"", "2 of them; there are 0"),
        ("\"point P\" [0 0 0 1 0 0] \"string basis\" \"bspline\"", "4 points or more"),
    ] {
        let text = format!("WorldBegin Shape \"curve\" {text}");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err().to_string();
        assert!(errors.contains(expected), "{text}: {errors}");
    }
}

#[test]
fn shapes_beyond_pbrt_are_read() {
    use GeometryDescription as G;
    assert!(matches!(
        shape("\"torus\" \"float majorradius\" 3 \"float minorradius\" 1"),
        G::Torus { major_radius: 3.0, minor_radius: 1.0, phi_max: TAU }
    ));
    assert!(matches!(
        shape("\"twosheetedhyperboloid\" \"float a\" 2 \"float c\" 3"),
        G::TwoSheetedHyperboloid { a: 2.0, c: 3.0, z: [-6.0, 6.0], phi_max: TAU }
    ));
    assert!(
        matches!(shape("\"plane\""), G::Plane { x, y } if x == [f64::NEG_INFINITY, f64::INFINITY] && x == y)
    );
    assert!(matches!(shape("\"plane\" \"float x\" [-1 2]"), G::Plane { x: [-1.0, 2.0], .. }));
    assert!(matches!(shape("\"box\" \"vector3 size\" [2 4 6]"),
        G::Cuboid { min, max } if min == DVec3::new(-1.0, -2.0, -3.0) && max == -min));
    assert!(matches!(shape("\"box\" \"point3 min\" [0 5 0] \"point3 max\" [1 1 1]"),
        G::Cuboid { min, max } if min == DVec3::new(0.0, 1.0, 0.0) && max == DVec3::new(1.0, 5.0, 1.0)));
    let G::Polyhedron { half_spaces } = shape("\"polyhedron\" \"normal N\" [1 0 0 0 1 0] \"float d\" [2 3]")
    else {
        panic!()
    };
    assert_eq!(half_spaces, [(DVec3::X, 2.0), (DVec3::Y, 3.0)]);
    // x^2 y z - 2 = 0
    let text = "\"algebraic\" \"integer exponents\" [2 1 1 0 0 0] \"float coefficients\" [1 -2] \
        \"point3 clip\" [3 3 3 -3 -3 -3]";
    let G::Algebraic { terms, clip } = shape(text) else { panic!() };
    assert_eq!(terms, [([2, 1, 1], 1.0), ([0, 0, 0], -2.0)]);
    assert_eq!(clip, [DVec3::splat(-3.0), DVec3::splat(3.0)]);
}
