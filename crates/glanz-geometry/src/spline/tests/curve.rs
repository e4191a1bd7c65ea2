//! Rational curves.

use super::*;

/// The unit circle in four arcs.
fn circle() -> NurbsCurve {
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points = corners.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0));
    let weights: Vec<f64> =
        (0..9).map(|i: usize| if i.is_multiple_of(2) { 1.0 } else { FRAC_1_SQRT_2 }).collect();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    NurbsCurve::try_from_points(2, knots, &points, Some(&weights)).unwrap()
}

#[test]
fn circle_is_round_with_exact_tangents_under_every_change() {
    let circle = circle();
    let (left, right) = circle.split(1.3).unwrap();
    let changed = [
        circle.clone(),
        circle.insert_knot(0.3, 2).unwrap(),
        circle.elevate().unwrap().elevate().unwrap(),
        circle.reversed().unwrap(),
        left,
        right,
    ];
    for curve in changed {
        for u in grid(curve.knots()) {
            let d = curve.derivatives(u, 2);
            assert!((d[0].length() - 1.0).abs() < 1e-14);
            assert!(d[0].dot(d[1]).abs() < 1e-13);
            // x . x'' + x' . x' = 0.
            assert!((d[0].dot(d[2]) + d[1].length_squared()).abs() < 1e-12);
        }
    }
    let arcs = circle.bezier_segments().unwrap();
    assert_eq!(arcs.len(), 4);
    for pair in arcs.windows(2) {
        assert!(pair[0].points.last() == pair[1].points.first() && pair[0].u[1] == pair[1].u[0]);
    }
    let (smooth, moved) = circle.insert_knot(0.5, 1).unwrap().remove_knot(0.5, 1e-14).unwrap();
    assert!(smooth.knots() == circle.knots() && moved <= 1e-14);
    assert!(matches!(circle.remove_knot(1.0, 1e-3), Err(SurfaceError::KnotNeeded { .. })));
}

#[test]
fn curve_derivatives_are_differences_of_the_order_below() {
    let curve = open().isocurve(ParameterDirection::V, 2.2).unwrap();
    let h = 1e-5;
    for u in [0.1, 0.35, 0.77, 1.5] {
        let (d, low, high) =
            (curve.derivatives(u, 5), curve.derivatives(u - h, 5), curve.derivatives(u + h, 5));
        for k in 0..5 {
            let difference = (high[k] - low[k]) / (2.0 * h);
            assert!(d[k + 1].distance(difference) < 1e-5 * (1.0 + difference.length()));
        }
    }
}
