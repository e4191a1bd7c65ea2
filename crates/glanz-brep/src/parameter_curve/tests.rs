//! Parameter curves against closed forms, and their bounds against dense samples.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glanz_geometry::spline::{NurbsCurve, NurbsSurface};
use glanz_math::{Bounds3, DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::model::{FaceSurface, Placement};

mod bounds;

const FRAME: Placement = Placement { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

fn conversion(surface: FaceSurface) -> CarrierConversion {
    Carrier::try_from_surface(&surface, Bounds3::new(DVec3::NEG_ONE, DVec3::ONE), 1e-9).unwrap()
}

fn cylinder() -> CarrierConversion {
    conversion(FaceSurface::Cylinder { placement: FRAME, radius: 0.5 })
}

fn sphere() -> CarrierConversion {
    conversion(FaceSurface::Sphere { placement: FRAME, radius: 0.5 })
}

fn torus() -> CarrierConversion {
    conversion(FaceSurface::Torus {
        placement: FRAME,
        major_radius: 0.5,
        minor_radius: 0.2,
        select_outer: true,
    })
}

fn cone() -> CarrierConversion {
    conversion(FaceSurface::Cone { placement: FRAME, radius: 0.5, half_angle: FRAC_PI_4 })
}

/// The part of a curve between two of its parameters.
fn part(curve: &Curve<DVec3>, [from, to]: [f64; 2]) -> EdgeCurve {
    let vertices = [from, to].map(|t| curve.point(t));
    let closed = (to - from).abs() >= TAU - 1e-9;
    EdgeCurve::between(curve, vertices, closed, from < to, 1e-9).unwrap()
}

fn arc(center: DVec3, a: DVec3, b: DVec3, range: [f64; 2]) -> EdgeCurve {
    part(&Curve::Ellipse { center, a, b }, range)
}

/// A cubic through points, with chord length parameters.
fn through(points: &[DVec3]) -> EdgeCurve {
    let spline = NurbsCurve::interpolate(3, points).unwrap();
    let curve = Curve::Spline(
        SplineCurve::from_knots(spline.knots().clone(), spline.control_points().to_vec()).unwrap(),
    );
    EdgeCurve::between(&curve, [points[0], points[points.len() - 1]], false, true, 1e-12).unwrap()
}

/// The slow twin of the bound: the largest distance of dense samples of either curve from the other.
fn measured(carrier: &Carrier, curve: &SplineCurve<DVec2>, edge: &EdgeCurve) -> f64 {
    let count = 400;
    let on_carrier: Vec<DVec3> =
        samples(curve.domain(), count).map(|t| carrier.point(curve.point(t))).collect();
    let spline = edge.to_spline().unwrap();
    let on_edge: Vec<DVec3> = samples(spline.domain(), count).map(|t| spline.point(t)).collect();
    let whole = Curve::Spline(spline.clone());
    let from_edge = |p: &DVec3| spline.point(whole.closest_parameter(*p, None)).distance(*p);
    let forward = on_carrier.iter().map(from_edge).fold(0.0, f64::max);
    let from_carrier = |p: &DVec3| {
        let nearest = (0..=count)
            .min_by(|i, j| on_carrier[*i].distance(*p).total_cmp(&on_carrier[*j].distance(*p)))
            .unwrap();
        let [start, end] = curve.domain();
        let step = (end - start) / count as f64;
        let t = start + step * nearest as f64;
        let at = |t: f64| carrier.point(curve.point(t)).distance(*p);
        // Ternary search around the nearest sample.
        let (mut low, mut high) = ((t - step).max(start), (t + step).min(end));
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if at(a) < at(b) {
                high = b;
            } else {
                low = a;
            }
        }
        at(0.5 * (low + high)).min(on_carrier[nearest].distance(*p))
    };
    on_edge.iter().map(from_carrier).fold(forward, f64::max)
}

fn samples([a, b]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| if i == count { b } else { a + (b - a) * i as f64 / count as f64 })
}

/// Lays an edge onto a carrier and compares the bound with the slow twin.
fn check_all(
    conversion: &CarrierConversion,
    edge: &EdgeCurve,
    given: Option<&Curve<DVec2>>,
    tolerance: f64,
) -> Vec<EdgeParameterCurve> {
    let curves = edge_on_carrier(conversion, edge, given, tolerance).unwrap();
    let carrier = &conversion.carrier;
    let parts = edge.split(&pole_passages(carrier, edge, tolerance));
    assert_eq!(parts.len(), curves.len());
    for (part, found) in parts.iter().zip(&curves) {
        let kind = &format!("{carrier:?}")[..8];
        let measured = measured(carrier, &found.curve, part);
        let rounding = 1e-12;
        let facts = format!(
            "{kind}: {:?} {} of {measured}, {} points",
            found.source,
            found.deviation,
            found.curve.control_points().len()
        );
        assert!(measured <= found.deviation + rounding, "{facts}");
        // Mostly below 1.5; the distance of corresponding points may exceed that of nearest ones where the edge leaves the carrier.
        let largest = 3.0 * measured + tolerance / 512.0 + rounding;
        assert!(found.deviation <= largest, "{facts}");
        let [start, end] = found.curve.domain().map(|t| carrier.point(found.curve.point(t)));
        assert!(
            start.distance(part.point(0.0)) <= found.deviation
                && end.distance(part.point(1.0)) <= found.deviation
        );
    }
    curves
}

fn check(conversion: &CarrierConversion, edge: &EdgeCurve, tolerance: f64) -> EdgeParameterCurve {
    let mut curves = check_all(conversion, edge, None, tolerance);
    assert_eq!(curves.len(), 1);
    curves.pop().unwrap()
}

fn is_exact(found: &EdgeParameterCurve) -> bool {
    found.source == ParameterCurveSource::Exact && found.deviation < 1e-13
}

#[test]
fn curves_in_a_plane_are_projected_exactly() {
    let plane = conversion(FaceSurface::Plane(FRAME));
    let circle = arc(DVec3::new(0.1, 0.2, 0.0), DVec3::X, DVec3::Y, [1.0, -2.0]);
    let found = check(&plane, &circle, 1e-9);
    assert!(is_exact(&found));
    assert!(found.curve.point(-1.0).distance(DVec2::new(0.1 + 1.0_f64.cos(), 0.2 + 1.0_f64.sin())) < 1e-15);
    let above = check(&plane, &arc(DVec3::new(0.1, 0.2, 0.01), DVec3::X, DVec3::Y, [0.0, 2.0]), 1e-9);
    assert!((above.deviation - 0.01).abs() < 1e-13);
}

#[test]
fn rulings_latitudes_and_meridians_are_straight() {
    let on_cylinder = check(
        &cylinder(),
        &EdgeCurve::straight([DVec3::new(0.0, 0.5, 0.2), DVec3::new(0.0, 0.5, -0.7)]).unwrap(),
        1e-9,
    );
    assert!(is_exact(&on_cylinder) && on_cylinder.curve.degree() == 1);
    assert!(on_cylinder.curve.point(1.0).distance(DVec2::new(FRAC_PI_2, -0.7)) < 1e-15);
    let to_apex = EdgeCurve::straight([DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.0, 0.0, -0.5)]).unwrap();
    let on_cone = check(&cone(), &to_apex, 1e-9);
    assert!(is_exact(&on_cone) && on_cone.curve.point(1.0).distance(DVec2::new(FRAC_PI_2, -0.5)) < 1e-15);
    for range in [[0.5, 3.0], [3.0, 0.5], [5.0, 5.0 + TAU]] {
        let height = 0.3;
        for (conversion, radius, v) in
            [(cylinder(), 0.5, 0.3), (cone(), 0.8, 0.3), (sphere(), 0.4, (0.6_f64).asin())]
        {
            let circle = arc(DVec3::Z * height, DVec3::Y * radius, -DVec3::X * radius, range);
            let found = check(&conversion, &circle, 1e-9);
            assert!(is_exact(&found) && found.curve.degree() == 1, "{found:?}");
            let [start, end] = found.curve.domain().map(|t| found.curve.point(t));
            assert!((start.y - v).abs() < 1e-15 && (end.y - v).abs() < 1e-15);
            assert!((end.x - start.x - (range[1] - range[0])).abs() < 1e-14);
        }
        let [center, out] = [DVec3::Y * 0.5, DVec3::Y * 0.2];
        let meridian = check(&torus(), &arc(center, out, DVec3::Z * 0.2, range), 1e-9);
        assert!(is_exact(&meridian));
        let [start, end] = meridian.curve.domain().map(|t| meridian.curve.point(t));
        assert!((start.x - FRAC_PI_2).abs() < 1e-15 && (end.x - start.x).abs() < 1e-15);
        assert!((end.y - start.y - (range[1] - range[0])).abs() < 1e-14);
        let inner = DVec3::Z * 0.2;
        let latitude = check(&torus(), &arc(inner, DVec3::X * 0.5, DVec3::Y * 0.5, range), 1e-9);
        assert!(is_exact(&latitude) && (latitude.curve.point(0.3).y - FRAC_PI_2).abs() < 1e-15);
    }
}

#[test]
fn rings_that_are_off_the_carrier_have_that_deviation() {
    let ring = arc(DVec3::Z * 0.3, DVec3::X * 0.5001, DVec3::Y * 0.5001, [0.0, 2.0]);
    let found = check(&cylinder(), &ring, 1e-3);
    assert!(
        found.source == ParameterCurveSource::Exact
            && found.deviation < 2e-4
            && found.deviation >= 1e-4 - 1e-15
    );
    let far = check(&cylinder(), &ring, 1e-6);
    assert!((1e-4 - 1e-15..2e-4).contains(&far.deviation), "{far:?}");
}

#[test]
fn edges_through_poles_are_divided_there() {
    // A great circle over the north pole, in the plane of azimuth 0.3.
    let out = DVec3::new(0.3_f64.cos(), 0.3_f64.sin(), 0.0);
    let over = arc(DVec3::ZERO, out * 0.5, DVec3::Z * 0.5, [0.5, 2.8]);
    let curves = check_all(&sphere(), &over, None, 1e-9);
    assert_eq!(curves.len(), 2);
    let ends: Vec<DVec2> =
        curves.iter().flat_map(|found| found.curve.domain().map(|t| found.curve.point(t))).collect();
    assert!(curves.iter().all(is_exact));
    assert!(
        ends[0].distance(DVec2::new(0.3, 0.5)) < 1e-14 && ends[1].distance(DVec2::new(0.3, FRAC_PI_2)) < 1e-8
    );
    assert!(ends[2].distance(DVec2::new(0.3 + PI, FRAC_PI_2)) < 1e-8, "{ends:?}");
    assert!(ends[3].distance(DVec2::new(0.3 + PI, PI - 2.8)) < 1e-14);
    let whole =
        check_all(&sphere(), &arc(DVec3::ZERO, out * 0.5, DVec3::Z * 0.5, [0.5, 0.5 + TAU]), None, 1e-9);
    assert_eq!(whole.len(), 3);
}

#[test]
fn geodesics_that_are_splines_pass_poles_too() {
    let points: Vec<DVec3> =
        samples([0.5, 2.8], 200).map(|t| DVec3::new(0.6 * t.cos(), 0.8 * t.cos(), t.sin()) * 0.5).collect();
    let curves = check_all(&sphere(), &through(&points), None, 1e-6);
    assert_eq!(curves.len(), 2);
    assert!(curves.iter().all(|found| found.deviation <= 1e-6));
    // A curve of the cone that ends in the apex in the direction of azimuth 1.
    let spiral: Vec<DVec3> = samples([0.0, 0.5], 100)
        .map(|r| DVec3::new(r * (1.0 + r).cos(), r * (1.0 + r).sin(), r - 0.5))
        .collect();
    let found = check(&cone(), &through(&spiral), 1e-6);
    let start = found.curve.point(found.curve.domain()[0]);
    assert!(found.deviation <= 1e-6 && (start.x - 1.0).abs() < 0.02, "{start}");
}

#[test]
fn plane_sections_of_a_cylinder_are_cosines() {
    // z = 0.7 cos phi + 0.1.
    let section = |range| arc(DVec3::Z * 0.1, DVec3::new(0.5, 0.0, 0.7), DVec3::Y * 0.5, range);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        for range in [[0.0, TAU], [2.0, -1.0]] {
            let found = check(&cylinder(), &section(range), tolerance);
            assert!(found.source == ParameterCurveSource::Fitted && found.deviation <= tolerance);
            for t in samples(found.curve.domain(), 100) {
                let uv = found.curve.point(t);
                assert!((uv.y - (0.7 * uv.x.cos() + 0.1)).abs() < 2.0 * tolerance);
            }
            let [start, end] = found.curve.domain().map(|t| found.curve.point(t));
            assert!((end.x - start.x - (range[1] - range[0])).abs() < tolerance * 4.0, "{start} {end}");
        }
    }
}

#[test]
fn circles_of_villarceau_wind_around_both_periods_of_a_torus() {
    let tilt = (0.2 / 0.5_f64).asin();
    let along = DVec3::new(tilt.cos(), 0.0, tilt.sin());
    let circle = arc(DVec3::Y * 0.2, along * 0.5, DVec3::Y * 0.5, [0.0, TAU]);
    let found = check(&torus(), &circle, 1e-7);
    assert!(found.deviation <= 1e-7);
    let [start, end] = found.curve.domain().map(|t| found.curve.point(t));
    let turns = (end - start) / TAU;
    assert!((turns.x - 1.0).abs() < 1e-6 && (turns.y.abs() - 1.0).abs() < 1e-6, "{turns}");
}

#[test]
fn helices_run_on_over_the_seam() {
    let helix: Vec<DVec3> =
        samples([0.0, 3.0 * TAU], 300).map(|t| DVec3::new(0.5 * t.cos(), 0.5 * t.sin(), 0.02 * t)).collect();
    let found = check(&cylinder(), &through(&helix), 1e-5);
    assert!(found.deviation <= 1e-5);
    let [start, end] = found.curve.domain().map(|t| found.curve.point(t));
    assert!((end - start).distance(DVec2::new(3.0 * TAU, 0.06 * TAU)) < 1e-9);
}

/// A closed tube of degree 3 around the z axis, with a bump.
fn tube() -> NurbsSurface {
    let ring = [(1.0, 0.0), (1.0, 1.0), (-1.0, 1.1), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)];
    let points: Vec<DVec3> = ring
        .iter()
        .flat_map(|(x, y)| [(1.0, 0.0), (1.4, 0.5), (0.8, 2.0)].map(|(r, z)| DVec3::new(x * r, y * r, z)))
        .collect();
    let knots =
        [vec![5.0, 5.0, 5.0, 5.0, 6.0, 8.0, 9.0, 9.0, 9.0, 9.0], vec![-1.0, -1.0, -1.0, 2.0, 2.0, 2.0]];
    NurbsSurface::try_from_points([3, 2], knots, &points, None).unwrap()
}

fn isocurve(direction: glanz_geometry::spline::ParameterDirection, value: f64) -> Curve<DVec3> {
    let curve = tube().isocurve(direction, value).unwrap();
    Curve::Spline(SplineCurve::from_knots(curve.knots().clone(), curve.control_points().to_vec()).unwrap())
}

#[test]
fn isoparametric_edges_of_splines_are_straight_and_borders_exact() {
    use glanz_geometry::spline::ParameterDirection::{U, V};
    let conversion = conversion(FaceSurface::Spline(tube()));
    let [[_, around], [_, height]] = conversion.carrier.domain();
    let seam = check(&conversion, &part(&isocurve(U, 5.0), [-1.0, 2.0]), 1e-7);
    assert!(is_exact(&seam) && seam.curve.degree() == 1);
    let u = seam.curve.point(0.5).x;
    assert!(u == 0.0 || u == around);
    assert_eq!([0.0, 1.0].map(|t| seam.curve.point(t).y), [0.0, height]);
    let border = isocurve(V, 2.0);
    let closed = EdgeCurve::between(&border, [border.point(5.0); 2], true, false, 1e-9).unwrap();
    let found = check(&conversion, &closed, 1e-7);
    assert!(is_exact(&found) && found.curve.point(0.4).y == height);
    assert!((found.curve.point(0.0).x - found.curve.point(1.0).x - around).abs() < 1e-12);
    let inner = check(&conversion, &part(&isocurve(V, 0.3), [5.5, 8.2]), 1e-7);
    assert!(inner.source == ParameterCurveSource::Exact && inner.deviation < 1e-9, "{inner:?}");
}

#[test]
fn curves_across_knots_and_seam_of_a_spline_are_fitted() {
    let conversion = conversion(FaceSurface::Spline(tube()));
    let [[_, around], [_, height]] = conversion.carrier.domain();
    let points: Vec<DVec3> = samples([0.6, 1.4], 400)
        .map(|s| conversion.carrier.point(DVec2::new(s * around, height * (0.5 + 0.3 * (4.0 * s).sin()))))
        .collect();
    // A part of the tolerance is taken by the edge, which leaves the tube where its curvature jumps.
    let found = check(&conversion, &through(&points), 1e-4);
    assert!(found.source == ParameterCurveSource::Fitted && found.deviation <= 1e-4, "{}", found.deviation);
    let [start, end] = found.curve.domain().map(|t| found.curve.point(t));
    assert!((end.x - start.x - 0.8 * around).abs() < 1e-4);
}

/// The oblique section of the cylinder with its parameter curve as a file would give it, off by `error` metres.
fn section_with_curve(error: f64) -> (EdgeCurve, Curve<DVec2>) {
    let section = arc(DVec3::Z * 0.1, DVec3::new(0.5, 0.0, 0.7), DVec3::Y * 0.5, [0.0, 2.0]);
    let points: Vec<DVec3> = samples([0.0, 2.0], 60)
        .map(|t| DVec3::new(t, 0.7 * t.cos() + 0.1 + error * (PI * t / 2.0).sin(), 0.0))
        .collect();
    let spline = NurbsCurve::interpolate(3, &points).unwrap();
    let flat = spline.control_points().iter().map(|p| DVec3::new(p.x, p.y, p.w)).collect();
    (section, Curve::Spline(SplineCurve::from_knots(spline.knots().clone(), flat).unwrap()))
}

#[test]
fn curves_of_the_file_are_used_if_they_hold_and_else_replaced() {
    let (edge, given) = section_with_curve(0.0);
    let found = check_all(&cylinder(), &edge, Some(&given), 1e-6).remove(0);
    assert!(found.source == ParameterCurveSource::Given && found.deviation <= 1e-6, "{found:?}");
    let (edge, given) = section_with_curve(1e-4);
    let found = check_all(&cylinder(), &edge, Some(&given), 1e-6).remove(0);
    assert!(found.source == ParameterCurveSource::Fitted && found.deviation <= 1e-6);
    let found = check_all(&cylinder(), &edge, Some(&given), 1e-3).remove(0);
    assert!(found.source == ParameterCurveSource::Given && found.deviation > 0.5e-4);
    // In the other direction, and longer than the edge.
    let reversed = part(edge.curve(), [1.5, 0.5]);
    let found = check_all(&cylinder(), &reversed, Some(&given), 1e-3).remove(0);
    assert!(
        found.source == ParameterCurveSource::Given && found.curve.point(found.curve.domain()[0]).x > 1.0
    );
}

#[test]
fn curves_of_the_file_are_mapped_to_the_parameters_of_the_carrier() {
    // A revolution whose line runs downwards with speed 2.
    let surface = FaceSurface::Revolution {
        curve: Box::new(Curve::Line { origin: DVec3::X * 0.5, direction: DVec3::Z * -2.0 }),
        origin: DVec3::ZERO,
        axis: DVec3::Z,
    };
    let conversion = conversion(surface);
    let (edge, given) = section_with_curve(0.0);
    let Curve::Spline(spline) = &given else { panic!() };
    let points = spline.control_points().iter().map(|p| DVec3::new(p.x, p.y * -0.5, p.z)).collect();
    let given = Curve::Spline(SplineCurve::from_knots(spline.knots().clone(), points).unwrap());
    let found = check_all(&conversion, &edge, Some(&given), 1e-6).remove(0);
    assert!(found.source == ParameterCurveSource::Given, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn bounds_are_never_below_the_true_deviation(
        a in -0.2..0.2_f64, b in -0.2..0.2_f64, c in -0.2..0.2_f64, d in -0.3..0.3_f64, exponent in 3..8_i32
    ) {
        let tolerance = 10.0_f64.powi(-exponent);
        for conversion in [cylinder(), sphere(), torus(), cone(), conversion(FaceSurface::Spline(tube()))] {
            let carrier = &conversion.carrier;
            // Around the point (1, 0.4) of the carrier, or a part of the domain of a spline.
            let scale = if matches!(carrier, Carrier::Spline(_)) { 2.0 } else { 1.0 };
            let at = |s: f64| DVec2::new(1.0 + s + a * (3.0 * s).sin(), 0.4 + b * s + c * (5.0 * s).cos() + d * s * s);
            // Where a fitted curve runs beyond the end of a spline, the bound counts that several times.
            let [_, [low, high]] = carrier.domain();
            let is_inside = |s: f64| (low + 0.02..high - 0.02).contains(&(at(s).y * scale));
            if matches!(carrier, Carrier::Spline(_)) && !samples([0.0, 1.0], 200).all(is_inside) {
                continue;
            }
            let points: Vec<DVec3> = samples([0.0, 1.0], 30).map(|s| carrier.point(at(s) * scale)).collect();
            check(&conversion, &through(&points), tolerance);
        }
    }
}
