//! Bounds on curves and edges at which the correspondence or the arithmetic is difficult.

use super::*;
use crate::parameter_curve::interval::CurvePair;

#[test]
fn the_correspondence_never_runs_back_on_a_hairpin() {
    // One leg lies above the cylinder, the other one on it, nearer to the projection of the first than that itself.
    let at = |phi: f64, r: f64, z: f64| DVec3::new(r * phi.cos(), r * phi.sin(), z);
    let mut points: Vec<DVec3> = samples([0.0, 1.0], 12).map(|phi| at(phi, 0.5003, 0.0)).collect();
    points.extend(samples([1.0, 0.0], 12).map(|phi| at(phi, 0.5, 1e-4)));
    let (edge, carrier) = (through(&points), cylinder().carrier);
    for tolerance in [1e-5, 1e-7] {
        let found = edge_on_carrier(&cylinder(), &edge, None, tolerance).unwrap().remove(0);
        let measured = measured(&carrier, &found.curve, &edge);
        assert!(found.deviation >= measured, "{} of {measured}", found.deviation);
        let spline = edge.to_spline().unwrap();
        let pair = CurvePair { carrier: &carrier, curve: &found.curve, edge: &spline, same_parameter: true };
        let nodes = pair.nodes(tolerance);
        assert!(nodes.windows(2).all(|ends| ends[0].edge <= ends[1].edge), "{nodes:?}");
    }
}

/// A square of degree 2 with 400 spans each way and a wave.
fn wave() -> NurbsSurface {
    let count = 402;
    let step = |i: usize| i as f64 / (count - 1) as f64;
    let points: Vec<DVec3> = (0..count * count)
        .map(|i| (step(i / count), step(i % count)))
        .map(|(x, y)| DVec3::new(x, y, 0.02 * (5.0 * x).sin() * (4.0 * y).cos()))
        .collect();
    let mut knots: Vec<f64> = samples([0.0, 1.0], 400).collect();
    knots.splice(0..0, [0.0; 2]);
    knots.extend([1.0; 2]);
    NurbsSurface::try_from_points([2, 2], [knots.clone(), knots], &points, None).unwrap()
}

#[test]
fn bounds_hold_over_hundreds_of_knots() {
    use glanz_geometry::spline::ParameterDirection::U;
    let conversion = conversion(FaceSurface::Spline(wave()));
    let border = wave().isocurve(U, 0.0).unwrap();
    let border = SplineCurve::from_knots(border.knots().clone(), border.control_points().to_vec()).unwrap();
    let found = check(&conversion, &part(&Curve::Spline(border), [0.0, 1.0]), 1e-6);
    assert!(found.source == ParameterCurveSource::Exact && found.deviation < 1e-9, "{}", found.deviation);
    // A straight line in the parameters, which crosses knot lines of both directions, against a cubic through its points.
    let [[_, across], [_, along]] = conversion.carrier.domain();
    let at = |s: f64| DVec2::new(s * across, (0.1 + 0.7 * s) * along);
    let points: Vec<DVec3> = samples([0.0, 1.0], 60).map(|s| conversion.carrier.point(at(s))).collect();
    let edge = through(&points).to_spline().unwrap();
    let line = SplineCurve::line(at(0.0), at(1.0), [0.0, 1.0]).unwrap();
    let deviation = deviation::deviation(&conversion.carrier, &line, &edge, false, 1e-6);
    let measured = measured(&conversion.carrier, &line, &through(&points));
    assert!(measured <= deviation + 1e-12 && deviation <= 3.0 * measured + 1e-8, "{deviation} of {measured}");
}

#[test]
fn numbers_that_are_none_stay() {
    assert!(largest([1.0, f64::NAN, 2.0]).is_nan() && largest([f64::NAN]).is_nan());
    assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
}

#[test]
fn rounding_is_relative_to_all_that_is_added() {
    // A circle that starts and ends in the origin.
    let latitude = arc(DVec3::X * 0.5, DVec3::X * -0.5, DVec3::Y * 0.5, [0.0, TAU]);
    let away = |origin: DVec3, radius: f64| {
        conversion(FaceSurface::Cylinder { placement: Placement { origin, ..FRAME }, radius })
    };
    let found = check(&away(DVec3::X * 0.5, 0.5), &latitude, 1e-9);
    assert!(is_exact(&found) && found.deviation > f64::EPSILON, "{}", found.deviation);
    // A millimetre at the origin, of a cylinder whose axis is a kilometre away.
    let carrier = away(DVec3::X * 1000.0, 1000.0);
    let ruling = part(&Curve::Line { origin: DVec3::ZERO, direction: DVec3::Z }, [0.0, 1e-3]);
    let found = check(&carrier, &ruling, 1e-6);
    assert!(found.deviation > 1e-13 && found.deviation < 1e-9, "{}", found.deviation);
    let bow: Vec<DVec3> = samples([0.0, 1.0], 20)
        .map(|s| carrier.carrier.point(DVec2::new(PI + 1e-6 * s, 1e-3 * s * s)))
        .collect();
    let found = check(&carrier, &through(&bow), 1e-6);
    assert!(found.deviation > 1e-13, "{}", found.deviation);
}

#[test]
fn two_poles_in_one_point_are_one_passage() {
    // A circle turned about its tangent touches the axis once, with both ends of its meridians.
    let [center, a, b] = [DVec3::X * 0.5, DVec3::X * 0.5, DVec3::Z * 0.5];
    let circle = Curve::Ellipse { center, a: -a, b };
    let surface = FaceSurface::Revolution { curve: Box::new(circle), origin: DVec3::ZERO, axis: DVec3::Z };
    let carrier = conversion(surface).carrier;
    let meridian = arc(center, a, b, [FRAC_PI_2, 3.0 * FRAC_PI_2 + 0.1]);
    let cuts = pole_passages(&carrier, &meridian, 1e-7);
    assert!(cuts.len() == 1 && carrier.poles().len() == 2, "{cuts:?} {:?}", carrier.poles());
}

#[test]
fn a_circle_off_the_sphere_by_more_than_the_tolerance_keeps_its_exact_image() {
    let sphere = conversion(FaceSurface::Sphere { placement: FRAME, radius: 0.5 });
    // Along the normal, so that no curve on the sphere is closer.
    let off = 5e-11;
    let radius = (0.5 + off) * 0.7_f64.cos();
    let center = FRAME.origin + FRAME.z * ((0.5 + off) * 0.7_f64.sin());
    let edge = arc(center, FRAME.x * radius, FRAME.y * radius, [0.0, TAU]);
    let found = edge_on_carrier(&sphere, &edge, None, 1e-13).unwrap().remove(0);
    assert_eq!(found.source, ParameterCurveSource::Exact);
    assert!(found.deviation > 0.999 * off && found.deviation < 1.01 * off, "{}", found.deviation);
}

#[test]
fn an_edge_of_many_turns_in_few_pieces_keeps_to_its_turn() {
    // A ruled thread, of which the edge is off by a little along its axis, so that it is no isoparametric line.
    let (turns, rise) = (9, 0.15);
    let knots: Vec<f64> = std::iter::once(0.0)
        .chain((0..=turns).flat_map(|turn| std::iter::repeat_n(f64::from(turn) / f64::from(turns), 11)))
        .chain([1.0])
        .collect();
    let thread = |radius: f64, off: f64| -> Vec<DVec3> {
        let at =
            |phi: f64| DVec3::new(radius * phi.cos(), radius * phi.sin(), rise * phi / TAU + off * phi.sin());
        let turn = NurbsCurve::interpolate(11, &samples([0.0, TAU], 11).map(at).collect::<Vec<_>>()).unwrap();
        let points: Vec<DVec3> = turn.control_points().iter().map(|p| p.truncate()).collect();
        assert_eq!(points.len(), 12);
        let raised = |k: i32| points.iter().skip(1).map(move |p| *p + DVec3::Z * (rise * f64::from(k)));
        points.iter().copied().take(1).chain((0..turns).flat_map(raised)).collect()
    };
    let points = [thread(0.3, 0.0), thread(0.5, 0.0)].concat();
    let across = vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::try_from_points([1, 11], [across, knots.clone()], &points, None).unwrap();
    let off = 1e-5;
    let edge =
        SplineCurve::try_new(11, knots, thread(0.4, off).iter().map(|p| p.extend(1.0)).collect()).unwrap();
    let whole = part(&Curve::Spline(edge.clone()), edge.domain());
    let found =
        edge_on_carrier(&conversion(FaceSurface::Spline(surface)), &whole, None, 1e-7).unwrap().remove(0);
    assert!(found.deviation < 4.0 * off, "{}", found.deviation);
}

#[test]
fn fitted_curves_stay_within_the_ends_of_a_spline() {
    // A straight edge that enters a unit square over one of its sides: its projection runs along the side first, with a corner.
    let points = [DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::X + DVec3::Y];
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let square = NurbsSurface::try_from_points([1, 1], [knots(), knots()], &points, None).unwrap();
    let carrier = conversion(FaceSurface::Spline(square)).carrier;
    let edge = EdgeCurve::straight([DVec3::new(-1e-4, 0.1, 0.0), DVec3::new(1.3e-4, 0.9, 0.0)]).unwrap();
    let spline = edge.to_spline().unwrap();
    let found = EdgeProjector::new(&carrier, &spline, 1e-5).fit().unwrap();
    let [[low, high], _] = carrier.domain();
    let outside = found.curve.control_points().iter().map(|p| p.x / p.z).find(|u| !(low..=high).contains(u));
    assert_eq!(outside, None);
    let measured = measured(&carrier, &found.curve, &edge);
    assert!(
        measured <= found.deviation && found.deviation < 1.3 * measured,
        "{} of {measured}",
        found.deviation
    );
}
