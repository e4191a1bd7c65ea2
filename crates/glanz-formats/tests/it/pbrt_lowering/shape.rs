//! Shapes.

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
