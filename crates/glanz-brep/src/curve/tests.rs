//! Curves against closed forms.

use std::f64::consts::{PI, SQRT_2, TAU};

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::BrepError;
use crate::model::{Curve, CurveVector, SplineCurve};

fn frame() -> [DVec3; 3] {
    let x = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let y = DVec3::new(2.0, 2.0, -1.0) / 3.0;
    [DVec3::new(0.3, -1.2, 0.7), x, y]
}

fn ellipse(a: f64, b: f64) -> Curve<DVec3> {
    let [center, x, y] = frame();
    Curve::Ellipse { center, a: x * a, b: y * b }
}

/// Four points of degree 3 with unequal weights and knots that are not clamped.
fn open_spline() -> SplineCurve<DVec2> {
    let points = [(0.0, 0.0, 1.0), (1.0, 2.0, 2.0), (3.0, -1.0, 0.5), (4.0, 1.0, 1.0), (5.0, 0.5, 1.5)];
    let points = points.map(|(x, y, w)| DVec2::new(x, y).extend(1.0) * w).to_vec();
    SplineCurve::try_new(3, vec![-2.0, -1.0, -0.5, 0.0, 1.0, 2.0, 3.0, 3.5, 5.0], points).unwrap()
}

/// A closed spline of degree 2 over [0, 4] with uniform knots, whose points repeat.
fn periodic_spline() -> SplineCurve<DVec2> {
    let square = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let points = (0..6).map(|i| DVec2::from(square[i % 4]).extend(1.0)).collect();
    SplineCurve::try_new(2, (-2..7).map(f64::from).collect(), points).unwrap()
}

fn samples([a, b]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=50).map(move |i| a + (b - a) * f64::from(i) / 50.0)
}

#[test]
fn rational_arcs_lie_on_their_conics() {
    let [center, x, y] = frame();
    for range in [[0.0, TAU], [1.0, 1.0 + TAU], [0.5, 0.6], [6.0, 9.0], [4.0, -1.0], [-PI, -PI - TAU]] {
        let curve = ellipse(2.0, 0.5).to_spline(range).unwrap();
        for t in samples(curve.domain()) {
            let p = curve.point(t) - center;
            let residual = (p.dot(x) / 2.0).powi(2) + (p.dot(y) / 0.5).powi(2) - 1.0;
            assert!(residual.abs() < 4e-15 && p.dot(x.cross(y)).abs() < 2e-15, "{range:?} {residual}");
        }
        assert!(curve.point(curve.domain()[0]).distance(ellipse(2.0, 0.5).point(range[0])) < 1e-15);
        assert!(curve.point(curve.domain()[1]).distance(ellipse(2.0, 0.5).point(range[1])) < 1e-14);
    }
    let parabola = Curve::Parabola { apex: center, a: x * 0.7, b: y * 0.7 };
    for range in [[-3.0, 2.0], [2.0, 1.0]] {
        let curve = parabola.to_spline(range).unwrap();
        for t in samples(curve.domain()) {
            let p = curve.point(t) - center;
            // y^2 = 4 f x.
            assert!((p.dot(y).powi(2) - 4.0 * 0.7 * p.dot(x)).abs() < 1e-13);
        }
    }
    let hyperbola = Curve::Hyperbola { center, a: x * 2.0, b: y * 0.5 };
    let curve = hyperbola.to_spline([-1.0, 3.0]).unwrap();
    for t in samples(curve.domain()) {
        let p = curve.point(t) - center;
        let (u, v) = (p.dot(x) / 2.0, p.dot(y) / 0.5);
        assert!((u * u - v * v - 1.0).abs() < 1e-14 * u * u && u > 0.0);
    }
}

#[test]
fn quarter_turns_are_exact() {
    let circle = Curve::Ellipse { center: DVec2::ZERO, a: DVec2::X, b: DVec2::Y };
    let curve = circle.to_spline([0.0, TAU]).unwrap();
    let corner = DVec3::ONE / SQRT_2;
    assert!((curve.control_points()[1] - corner).length() < 1e-15);
    let ends: Vec<DVec3> = curve.control_points().iter().copied().step_by(2).collect();
    let expected = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)];
    assert_eq!(ends, expected.map(|p| DVec2::from(p).extend(1.0)));
}

#[test]
fn parameters_are_those_of_the_standard() {
    let [center, x, y] = frame();
    assert!(
        ellipse(2.0, 0.5).point(0.3).distance(center + x * 2.0 * 0.3_f64.cos() + y * 0.5 * 0.3_f64.sin())
            < 1e-15
    );
    let parabola = Curve::Parabola { apex: center, a: x, b: y };
    assert!(parabola.point(0.5).distance(center + x * 0.25 + y) < 1e-15);
    let hyperbola = Curve::Hyperbola { center, a: x, b: y };
    assert!(hyperbola.point(0.5).distance(center + x * 0.5_f64.cosh() + y * 0.5_f64.sinh()) < 1e-15);
    let polyline = Curve::Polyline(vec![DVec2::ZERO, DVec2::X, DVec2::ONE]);
    assert_eq!(polyline.domain(), [0.0, 2.0]);
    assert_eq!(polyline.point(1.25), DVec2::new(1.0, 0.25));
    assert_eq!(polyline.derivatives(1.25, 2), [DVec2::new(1.0, 0.25), DVec2::Y, DVec2::ZERO]);
}

#[test]
fn derivatives_are_differences_of_the_order_below() {
    let [center, x, y] = frame();
    let arc = Curve::Trimmed { basis: Box::new(ellipse(2.0, 0.5)), range: [2.0, 0.5], same_sense: false };
    let rational = SplineCurve::elliptic_arc([center, x, y], [0.0, 2.0]).unwrap();
    let composite = Curve::Composite(vec![(arc.clone(), true), (Curve::Spline(rational.clone()), false)]);
    let curves = [
        ellipse(2.0, 0.5),
        Curve::Parabola { apex: center, a: x, b: y },
        Curve::Hyperbola { center, a: x, b: y * 0.3 },
        Curve::Spline(rational),
        arc,
        composite,
    ];
    for curve in curves {
        let [a, b] = curve.domain().map(|t| t.clamp(-2.0, 2.0));
        for i in 1..10 {
            let (t, h) = (a + (b - a) * (f64::from(i) + 0.1) / 10.3, 1e-6);
            let [low, at, high] = [t - h, t, t + h].map(|t| curve.derivatives(t, 3));
            for k in 1..=3 {
                let difference = (high[k - 1] - low[k - 1]) / (2.0 * h);
                assert!((at[k] - difference).length() < 1e-7, "{} at {t}, order {k}", curve.kind());
            }
        }
    }
}

#[test]
fn parts_of_splines_keep_their_points_and_parameters() {
    let (open, closed) = (open_spline(), periodic_spline());
    let check = |curve: &SplineCurve<DVec2>, range: [f64; 2], shift: f64| {
        let part = Curve::Spline(curve.clone()).to_spline(range).unwrap();
        let sign = if range[0] < range[1] { 1.0 } else { -1.0 };
        assert_eq!(part.domain(), range.map(|t| sign * t));
        assert!(part.knots().is_clamped());
        for t in samples(part.domain()) {
            let whole = sign * t;
            let [start, end] = curve.domain();
            let moved = if whole > end {
                whole - shift
            } else if whole < start {
                whole + shift
            } else {
                whole
            };
            assert!(part.point(t).distance(curve.point(moved)) < 1e-14, "{range:?} at {t}");
        }
    };
    for range in [[0.0, 2.0], [0.25, 1.5], [2.0, 0.0], [1.75, 0.5]] {
        check(&open, range, 0.0);
    }
    for range in [[0.0, 4.0], [1.5, 5.5], [3.0, 4.5], [2.0, -1.0], [0.5, 0.25], [5.0, 6.0]] {
        check(&closed, range, 4.0);
    }
}

#[test]
fn composite_curves_become_one_spline_of_the_highest_degree() {
    let quarter = Curve::Trimmed {
        basis: Box::new(Curve::Ellipse { center: DVec2::ZERO, a: DVec2::X, b: DVec2::Y }),
        range: [0.0, PI / 2.0],
        same_sense: true,
    };
    let line = Curve::Trimmed {
        basis: Box::new(Curve::Line { origin: DVec2::new(-1.0, 1.0), direction: DVec2::X }),
        range: [0.0, 1.0],
        same_sense: true,
    };
    let cubic = SplineCurve::try_new(
        3,
        [vec![5.0; 4], vec![6.0; 4]].concat(),
        [(-1.0, 1.0), (-2.0, 1.0), (-2.0, 0.0), (-1.0, 0.0)].map(|p| DVec2::from(p).extend(1.0)).to_vec(),
    )
    .unwrap();
    let composite =
        Curve::Composite(vec![(quarter, true), (line, false), (Curve::Spline(cubic.clone()), true)]);
    assert!((composite.domain()[1] - (PI / 2.0 + 2.0)).abs() < 1e-15);
    assert!(composite.point(PI / 2.0 + 0.25).distance(DVec2::new(-0.25, 1.0)) < 1e-15);
    let spline = composite.to_spline(composite.domain()).unwrap();
    assert_eq!(spline.degree(), 3);
    for t in samples([0.0, PI / 2.0]) {
        assert!((spline.point(t).length() - 1.0).abs() < 2e-15);
    }
    for t in samples([0.0, 1.0]) {
        assert!(spline.point(PI / 2.0 + t).distance(DVec2::new(-t, 1.0)) < 4e-15);
        assert!(spline.point(PI / 2.0 + 1.0 + t).distance(cubic.point(5.0 + t)) < 1e-14);
    }
    let part = composite.to_spline([3.0, 1.0]).unwrap();
    assert!(part.point(-3.0).distance(composite.point(3.0)) < 4e-15);
    assert!(part.point(-1.0).distance(composite.point(1.0)) < 4e-15);
}

#[test]
fn unbounded_parts_are_refused() {
    let line = Curve::Line { origin: DVec2::ZERO, direction: DVec2::X };
    assert!(matches!(line.to_spline(line.domain()), Err(BrepError::Range { curve: "line", .. })));
    assert!(matches!(line.to_spline([1.0, 1.0]), Err(BrepError::Range { .. })));
    let empty = Curve::<DVec2>::Composite(Vec::new());
    assert!(empty.to_spline([0.0, 1.0]).is_err());
    assert!(Curve::Polyline(vec![DVec2::ZERO]).to_spline([0.0, 1.0]).is_err());
}

proptest! {
    #[test]
    fn closest_parameter_is_not_farther_than_any_sample(x in -3.0..6.0, y in -3.0..3.0) {
        let query = DVec2::new(x, y);
        let curves = [
            Curve::Ellipse { center: DVec2::ZERO, a: DVec2::new(3.0, 0.2), b: DVec2::new(0.0, 1.0) },
            Curve::Parabola { apex: DVec2::ZERO, a: DVec2::X * 0.3, b: DVec2::Y * 0.3 },
            Curve::Hyperbola { center: DVec2::ZERO, a: DVec2::X, b: DVec2::Y * 0.4 },
            Curve::Spline(open_spline()),
            Curve::Spline(periodic_spline()),
            Curve::Polyline(vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::new(3.0, -2.0)]),
        ];
        for curve in curves {
            let t = curve.closest_parameter(query, None);
            let distance = curve.point(t).distance(query);
            let [a, b] = curve.domain().map(|t| t.clamp(-5.0, 7.0));
            for i in 0..=1000 {
                let other = curve.point(a + (b - a) * f64::from(i) / 1000.0).distance(query);
                prop_assert!(distance <= other * (1.0 + 1e-12) + 1e-12, "{} {}: {} {}", curve.kind(), i, distance, other);
            }
        }
    }
}

fn circle() -> Curve<DVec3> {
    Curve::Ellipse { center: DVec3::ZERO, a: DVec3::X, b: DVec3::Y }
}

#[test]
fn edges_run_from_vertex_to_vertex_in_their_sense() {
    let vertices = [DVec3::X, -DVec3::Y];
    let edge = |same_sense| EdgeCurve::between(&circle(), vertices, false, same_sense, 1e-9).unwrap();
    assert!(edge(true).point(0.5).distance(DVec3::new(-1.0, 1.0, 0.0) / SQRT_2) < 1e-15);
    assert!(edge(false).point(0.5).distance(DVec3::new(1.0, -1.0, 0.0) / SQRT_2) < 1e-15);
    let back = EdgeCurve::between(&circle(), [vertices[1], vertices[0]], false, true, 1e-9).unwrap();
    assert!((back.range()[1] - back.range()[0] - PI / 2.0).abs() < 1e-15);
    let whole = EdgeCurve::between(&circle(), [DVec3::Y; 2], true, false, 1e-9).unwrap();
    assert!((whole.range()[0] - whole.range()[1] - TAU).abs() < 1e-15);
    assert!(whole.point(0.25).distance(DVec3::X) < 1e-15);
    assert!(whole.vertex_gap() < 1e-15);
}

#[test]
fn edges_on_closed_splines_pass_the_seam() {
    let spline = periodic_spline();
    let points = spline.control_points().iter().map(|p| DVec4::new(p.x, p.y, 0.0, p.z)).collect();
    let curve = Curve::Spline(SplineCurve::<DVec3>::from_knots(spline.knots().clone(), points).unwrap());
    let [a, b] = [3.5, 0.5].map(|t| curve.point(t));
    let edge = EdgeCurve::between(&curve, [a, b], false, true, 1e-9).unwrap();
    assert!((edge.range()[0] - 3.5).abs() < 1e-12 && (edge.range()[1] - 4.5).abs() < 1e-12);
    assert!(edge.point(0.5).distance(curve.point(0.0)) < 1e-12);
    let seam = curve.point(0.0);
    let from_seam = EdgeCurve::between(&curve, [seam, b], false, true, 1e-9).unwrap();
    assert!(from_seam.range()[0].abs() < 1e-9 && (from_seam.range()[1] - 0.5).abs() < 1e-12);
    let to_seam = EdgeCurve::between(&curve, [a, seam], false, true, 1e-9).unwrap();
    assert!((to_seam.range()[1] - 4.0).abs() < 1e-9);
    let against = EdgeCurve::between(&curve, [seam, a], false, false, 1e-9).unwrap();
    assert!((against.range()[0] - 4.0).abs() < 1e-9 && (against.range()[1] - 3.5).abs() < 1e-12);
}

#[test]
fn trimmed_curves_of_edges_are_cut_again_by_the_vertices() {
    let half = Curve::Trimmed { basis: Box::new(circle()), range: [PI, 0.0], same_sense: false };
    let edge = EdgeCurve::between(&half, [-DVec3::X, DVec3::X], false, true, 1e-9).unwrap();
    assert!(edge.point(0.5).distance(DVec3::Y) < 1e-15);
    assert!(edge.point(0.0).distance(-DVec3::X) < 1e-15);
}

fn part(basis: Curve<DVec2>, range: [f64; 2], same_sense: bool) -> Curve<DVec2> {
    Curve::Trimmed { basis: Box::new(basis), range, same_sense }
}

#[test]
fn parts_against_the_sense_of_their_curve_have_ascending_domains() {
    let line = Curve::Line { origin: DVec2::ZERO, direction: DVec2::X };
    let flat = Curve::Ellipse { center: DVec2::ZERO, a: DVec2::X, b: DVec2::Y };
    let open = Curve::Spline(open_spline());
    let closed = Curve::Spline(periodic_spline());
    let cases = [
        (&line, [5.0, 1.0], true, [1.0, 5.0]),
        (&line, [1.0, 5.0], false, [-5.0, -1.0]),
        (&flat, [0.5, 7.0], true, [0.5, 7.0 - TAU]),
        (&flat, [7.0, 0.5], true, [7.0, 0.5 + 2.0 * TAU]),
        (&flat, [0.0, 1.0], false, [0.0, TAU - 1.0]),
        (&flat, [0.5, 7.5], false, [-0.5, 2.0 * TAU - 7.5]),
        (&flat, [1.0, 1.0], true, [1.0, 1.0 + TAU]),
        (&flat, [0.0, 360.0 * 0.017_453_292_52], true, [0.0, TAU]),
        (&open, [1.5, 0.5], true, [0.5, 1.5]),
        (&closed, [3.0, 1.0], true, [3.0, 5.0]),
    ];
    for (basis, range, same_sense, expected) in cases {
        let curve = part(basis.clone(), range, same_sense);
        let [low, high] = curve.domain();
        assert!(
            (low - expected[0]).abs() < 1e-9 && (high - expected[1]).abs() < 1e-9,
            "{} {low} {high}",
            basis.kind()
        );
        let query = DVec2::new(0.3, 0.2);
        let found = curve.closest_parameter(query, None);
        assert!(found >= low && found <= high);
        assert!((low..=high).contains(&curve.closest_parameter(query, Some(low - 1.0))));
    }
}

#[test]
fn a_parabola_whose_size_is_lost_to_rounding_has_a_nearest_point() {
    let tiny = Curve::Parabola { apex: DVec2::ZERO, a: DVec2::X * 1e-200, b: DVec2::Y * 1e-200 };
    assert!(tiny.closest_parameter(DVec2::ONE, None).is_finite());
}

#[test]
fn an_edge_whose_end_is_before_its_start_by_rounding_is_not_a_whole_turn() {
    let vertices = [DVec3::X, DVec3::new(1.0, -1e-17, 0.0)];
    let edge = EdgeCurve::between(&circle(), vertices, false, true, 1e-30);
    assert!(matches!(edge, Err(BrepError::ShortEdge { .. })), "{edge:?}");
}

#[test]
fn edges_without_extent_and_closed_edges_on_open_curves_are_refused() {
    let line = Curve::Line { origin: DVec3::ZERO, direction: DVec3::X };
    assert!(matches!(EdgeCurve::straight([DVec3::X; 2]), Err(BrepError::ShortEdge { .. })));
    assert!(EdgeCurve::between(&line, [DVec3::X, DVec3::X + DVec3::Y], false, true, 1e-9).is_err());
    assert!(matches!(
        EdgeCurve::between(&line, [DVec3::X; 2], true, true, 1e-9),
        Err(BrepError::OpenCurve { .. })
    ));
    let reversed = EdgeCurve::between(&line, [DVec3::X, DVec3::ZERO], false, true, 1e-9).unwrap();
    assert!(reversed.sense_repaired() && reversed.range() == [1.0, 0.0]);
    assert!(DVec3::X.distance_to(DVec3::Y) == SQRT_2);
}

#[test]
fn nearest_point_of_a_composite_curve_is_that_of_the_nearest_segment() {
    let quarter = Curve::Trimmed {
        basis: Box::new(Curve::Ellipse { center: DVec2::ZERO, a: DVec2::X, b: DVec2::Y }),
        range: [0.0, PI / 2.0],
        same_sense: true,
    };
    // From (-1, 1) to (0, 1), which is run through backwards.
    let line = Curve::Polyline(vec![DVec2::new(-1.0, 1.0), DVec2::new(-0.5, 1.5), DVec2::Y]);
    let composite = Curve::Composite(vec![(quarter, true), (line, false)]);
    for query in [DVec2::new(2.0, 0.5), DVec2::new(-0.4, 2.0), DVec2::new(-2.0, 0.0), DVec2::new(0.3, 0.2)] {
        let found = composite.closest_parameter(query, None);
        let samples = (0..=100_000).map(|i| composite.domain()[1] * f64::from(i) / 1e5);
        let least = samples.map(|t| composite.point(t).distance(query)).fold(f64::INFINITY, f64::min);
        let distance = composite.point(found).distance(query);
        assert!((distance - least).abs() < 1e-4 && distance <= least + 1e-12, "{query}: {distance}, {least}");
    }
}
