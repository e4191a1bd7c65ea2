//! The rational circle of the tests, and a vase that is turned along it.

use glanz_scene::description::{GeometryDescription, NurbsDescription, ShapeDescription};

/// Points and weights of the unit circle as four rational quadratic arcs, from +x counterclockwise; the last one is the first.
pub(crate) fn circle() -> [[f64; 3]; 9] {
    let half = 0.5_f64.sqrt();
    let corner = |x: f64, y: f64| [x, y, half];
    [
        [1.0, 0.0, 1.0],
        corner(1.0, 1.0),
        [0.0, 1.0, 1.0],
        corner(-1.0, 1.0),
        [-1.0, 0.0, 1.0],
        corner(-1.0, -1.0),
        [0.0, -1.0, 1.0],
        corner(1.0, -1.0),
        [1.0, 0.0, 1.0],
    ]
}

/// The vase of `scenes/rooms/vase.pbrt`, on the floor.
pub(crate) fn vase() -> ShapeDescription {
    let profile = [[0.1, 0.0], [0.2, 0.06], [0.29, 0.36], [0.05, 0.5], [0.09, 0.72], [0.15, 0.78]];
    let points = circle().into_iter().flat_map(|[x, y, weight]| {
        profile.map(|[r, z]| [r * x * weight, r * y * weight, z * weight, weight])
    });
    ShapeDescription::from(GeometryDescription::Nurbs(NurbsDescription {
        degree_u: 2,
        degree_v: 3,
        knots_u: vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0],
        knots_v: vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0],
        points: points.collect(),
        domain: None,
    }))
}
