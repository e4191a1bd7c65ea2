//! The rational circle of the tests.

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
