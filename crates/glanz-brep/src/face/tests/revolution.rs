//! Faces on turned curves that cross their axis.

use glanz_math::DVec2;

use super::super::bounded_edge::BoundedEdge;
use super::super::surface_part::part_with_edges;
use super::*;
use crate::model::ParameterCurve;

/// A face inside a rim of radius 1 at a height, on a curve in the plane y = 0 that is turned about the z axis; where v is given, the file says that the
/// rim is there.
fn inside_rim(profile: &Curve<DVec3>, height: f64, v: Option<f64>, same_sense: bool) -> TrimmedFace {
    let mut model = ModelBuilder::default();
    let rim = model.circle(1.0, height);
    let surface =
        FaceSurface::Revolution { curve: Box::new(profile.clone()), origin: DVec3::ZERO, axis: DVec3::Z };
    let at_rim = |v| Curve::Line { origin: DVec2::new(0.0, v), direction: DVec2::X };
    model.0.edges[rim].parameter_curves =
        v.map(|v| ParameterCurve { surface: 0, curve: at_rim(v) }).into_iter().collect();
    // From above, the inside is on the left.
    model.face(surface, same_sense, &[(rim, true)]);
    model.faces().remove(0)
}

/// Area of the paraboloid z = r^2 h up to the height h and radius 1.
fn paraboloid(h: f64) -> f64 {
    PI / (6.0 * h * h) * ((1.0 + 4.0 * h * h).powf(1.5) - 1.0)
}

#[test]
fn a_whole_parabola_makes_a_reflector_on_the_side_that_the_file_names() {
    // Focal length 1 / 2, z = r^2 / 2; the rim at v = 1 or -1.
    let profile = Curve::Parabola { apex: DVec3::ZERO, a: DVec3::Z * 0.5, b: DVec3::X * 0.5 };
    // Where the file names none, it is that on which the rim has the face on its left.
    for (v, same_sense) in [(Some(1.0), false), (Some(-1.0), true), (None, false), (None, true)] {
        let face = inside_rim(&profile, 0.5, v, same_sense);
        // Its normal is upwards, as one on the left of the rim requires: none of its edges is reversed.
        assert_close(face.measure(1e-9).area, paraboloid(0.5));
    }
}

#[test]
fn an_edge_on_the_curve_before_it_is_turned_tells_its_side() {
    // Half a turn of an ellipse, of which no end has a larger radius: two arcs from pole to pole, the first of which is the second part of the curve.
    let ellipse = Curve::Ellipse { center: DVec3::ZERO, a: DVec3::Z * 2.0, b: DVec3::NEG_X };
    let mut model = ModelBuilder::default();
    model.0.vertices.extend([DVec3::NEG_Z * 2.0, DVec3::Z * 2.0]);
    let arc = |b: DVec3| Some(Curve::Ellipse { center: DVec3::ZERO, a: DVec3::Z * 2.0, b });
    // Upwards over x = 1, and over y = 1 at a quarter turn.
    let (first, second) = (model.edge([0, 1], arc(DVec3::NEG_X)), model.edge([0, 1], arc(DVec3::NEG_Y)));
    let surface = FaceSurface::Revolution { curve: Box::new(ellipse), origin: DVec3::ZERO, axis: DVec3::Z };
    let forward = |edge, forward| OrientedEdge { edge, forward };
    // Upwards the surface has its normal outwards, and the quarter between is on the left of the downward arc at y = 1 and the upward arc at x = 1.
    model.bounded(
        surface,
        true,
        vec![BoundaryLoop::Edges(vec![forward(second, true), forward(first, false)])],
    );
    let face = model.faces().remove(0);
    let e = 0.75f64.sqrt();
    assert_close(face.measure(1e-9).area, 0.5 * PI * (1.0 + 2.0 * e.asin() / e));
}

#[test]
fn a_hyperbola_and_an_ellipse_end_at_their_axis() {
    let hyperbola = Curve::Hyperbola { center: DVec3::ZERO, a: DVec3::Z, b: DVec3::X };
    let face = inside_rim(&hyperbola, 2f64.sqrt(), Some(1f64.asinh()), false);
    // z^2 - r^2 = 1: the integral of 2 pi sqrt(1 + 2 s^2) s ds / sqrt(1 + s^2), by s = sinh t.
    let area = simpson(|t: f64| TAU * (1.0 + 2.0 * t.sinh().powi(2)).sqrt() * t.sinh(), 1f64.asinh());
    assert!((face.measure(1e-9).area - area).abs() < 1e-7 * area);
    // Half axes 2 along z and 1 across, from its highest point around; the rim at the equator. The part of v in 0 .. pi.
    let ellipse = Curve::Ellipse { center: DVec3::ZERO, a: DVec3::Z * 2.0, b: DVec3::X };
    for v in [0.5 * PI, 1.5 * PI] {
        // Downwards at the equator, as in the first half, the surface has its normal inwards.
        let face = inside_rim(&ellipse, 0.0, Some(v), v > PI);
        let e = 0.75f64.sqrt();
        assert_close(face.measure(1e-9).area, PI * (1.0 + 2.0 * e.asin() / e));
        // The half above, with its normal outwards.
        assert_close(face.measure(1e-9).volume, 4.0 / 3.0 * PI);
    }
}

/// The ellipse with the half axes 2 along z and 1 across, upwards from an eccentric anomaly above the equator on.
fn upright_ellipse(start: f64) -> Curve<DVec3> {
    let (sin, cos) = start.sin_cos();
    let [a, b] = [[cos, sin], [-sin, cos]].map(|[x, z]| DVec3::new(x, 0.0, 2.0 * z));
    Curve::Ellipse { center: DVec3::ZERO, a, b }
}

#[test]
fn the_part_of_a_closed_profile_with_its_seam_is_found_by_parameters_on_both_sides() {
    // Upwards from the equator, the seam is in the middle of the part with x > 0: the normal is outwards and the face above.
    for v in [0.0, TAU, -TAU] {
        let face = inside_rim(&upright_ellipse(0.0), 0.0, Some(v), true);
        assert_close(face.measure(1e-9).volume, 4.0 / 3.0 * PI);
    }
    for start in [-0.5, 0.5] {
        let face = inside_rim(&upright_ellipse(start), 0.0, Some(-start), true);
        assert_close(face.measure(1e-9).volume, 4.0 / 3.0 * PI);
    }
    // A ball.
    let circle = Curve::Ellipse { center: DVec3::ZERO, a: DVec3::X, b: DVec3::Z };
    let face = inside_rim(&circle, 0.0, Some(0.0), true);
    assert_close(face.measure(1e-9).area, TAU);
    assert_close(face.measure(1e-9).volume, TAU / 3.0);
    // The upper half of an apple: the circle of radius 3 / 4 about the point (1 / 4, 0) meets the axis at the cosine -1 / 3.
    let (c, r, end) = (0.25, 0.75, (-1.0f64 / 3.0).acos());
    let circle = Curve::Ellipse { center: DVec3::X * c, a: DVec3::X * r, b: DVec3::Z * r };
    let face = inside_rim(&circle, 0.0, Some(0.0), true);
    assert_close(face.measure(1e-9).area, TAU * r * (c * end + r * end.sin()));
    let volume = simpson(|t: f64| PI * (c + r * t.cos()).powi(2) * r * t.cos(), end);
    assert_close(face.measure(1e-9).volume, volume);
}

#[test]
fn a_profile_askew_to_its_axis_stays_whole() {
    // The hyperboloid r^2 = 1 + z^2 up to z = 3 and down to -3: the integral of 2 pi sqrt(1 + 2 z^2).
    let mut model = ModelBuilder::default();
    let (bottom, top) = (model.circle(10f64.sqrt(), -3.0), model.circle(10f64.sqrt(), 3.0));
    let line = Curve::Line { origin: DVec3::X, direction: DVec3::new(0.0, 1.0, 1.0) };
    let surface = FaceSurface::Revolution { curve: Box::new(line), origin: DVec3::ZERO, axis: DVec3::Z };
    model.face(surface, true, &[(bottom, true), (top, false)]);
    let area = TAU * (3.0 * 19f64.sqrt() + 18f64.sqrt().asinh() / 2f64.sqrt());
    assert_close(model.faces().remove(0).measure(1e-9).area, area);
}

#[test]
fn a_profile_without_edges_is_turned_whole_but_no_surface_twice() {
    let whole = |curve: Curve<DVec3>, bounds: Vec<BoundaryLoop>| {
        let mut model = ModelBuilder::default();
        let surface = FaceSurface::Revolution { curve: Box::new(curve), origin: DVec3::ZERO, axis: DVec3::Z };
        model.bounded(surface, true, bounds);
        trimmed_faces(&model.0).faces.remove(0).unwrap().measure(1e-9).area
    };
    // Both nappes of a cone.
    let line = Curve::Polyline(vec![DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0)]);
    assert_close(whole(line, vec![BoundaryLoop::Border]), TAU * 2f64.sqrt());
    // Each half of the ellipse makes the whole ellipsoid.
    let e = 0.75f64.sqrt();
    for start in [0.0, 0.5] {
        assert_close(whole(upright_ellipse(start), Vec::new()), TAU * (1.0 + 2.0 * e.asin() / e));
    }
}

#[test]
fn of_parts_that_nothing_tells_apart_the_last_is_taken_wherever_the_profile_starts() {
    for i in 0..16 {
        // The second part is that with x > 0.
        let face = inside_rim(&upright_ellipse(f64::from(i) * PI / 32.0 - 0.25 * PI), 0.0, None, true);
        assert_close(face.measure(1e-9).volume, 4.0 / 3.0 * PI);
    }
}

#[test]
fn a_profile_that_crosses_its_axis_more_often_than_any_reflector_stays_whole() {
    // Teeth from one side to the other, at a distance y from the axis.
    let part = |count: u32, y: f64| {
        let point = |i: u32| DVec3::new(1.0 - f64::from(i % 2 * 2), y, f64::from(i));
        let curve = Box::new(Curve::Polyline((0..=count).map(point).collect()));
        let surface = FaceSurface::Revolution { curve, origin: DVec3::ZERO, axis: DVec3::Z };
        let mut model = ModelBuilder::default();
        let rim = model.circle(1.0, 0.0);
        model.face(surface.clone(), false, &[(rim, true)]);
        let edges = [BoundedEdge::new(&model.0, &model.0.edges[rim])];
        let mut repairs = Vec::new();
        let part = part_with_edges(&surface, &model.0, &edges, &model.0.faces[0], &mut repairs);
        ((part != surface).then_some(part), repairs)
    };
    for count in [4, 16] {
        // The cone up to the first crossing.
        let (Some(FaceSurface::Revolution { curve, .. }), repairs) = part(count, 0.0) else {
            panic!("not divided")
        };
        let domain = curve.domain();
        assert!(domain[0] == 0.0 && (domain[1] - 0.5).abs() < 1e-12, "{domain:?}");
        assert_eq!(repairs, []);
    }
    for count in [17, 100_000] {
        assert_eq!(part(count, 0.0), (None, vec![FaceRepair::WholeProfile]));
    }
    // Beside the axis there is nothing to divide.
    assert_eq!(part(17, 0.1), (None, Vec::new()));
    assert_eq!(part(100_000, 0.1), (None, vec![FaceRepair::WholeProfile]));
}

/// The integral of a smooth function from 0 to `end`.
fn simpson(f: impl Fn(f64) -> f64, end: f64) -> f64 {
    const N: u32 = 1000;
    let weight = |i: u32| if i == 0 || i == N { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=N).map(|i| weight(i) * f(end * f64::from(i) / f64::from(N))).sum::<f64>() * end
        / (3.0 * f64::from(N))
}
