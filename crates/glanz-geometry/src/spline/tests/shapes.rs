//! Spheres, tori and interpolated points.

use glanz_math::DVec2;

use super::*;
use crate::spline::SurfaceCurvature;
use crate::trim::{TrimCurve, TrimRegion};

#[test]
fn curvature_by_derivatives_of_the_normal_is_that_of_a_torus() {
    let (major, minor) = (3.0, 0.5);
    for (phi, theta) in [(0.3, 0.4), (2.0, 1.7), (5.0, 3.0), (1.0, -1.2)] {
        let ((s, c), (sin, cos)) = (f64::sin_cos(phi), f64::sin_cos(theta));
        let (around, along) = (DVec3::new(-s, c, 0.0), DVec3::new(-sin * c, -sin * s, cos));
        let width = major + minor * cos;
        let tangents = [around * width, along * minor];
        let curvature = SurfaceCurvature::from_normal_derivatives(tangents, [around * cos, along]).unwrap();
        let expected = [-1.0 / minor, -cos / width];
        let [low, high] = curvature.principal;
        assert!((low - expected[0]).abs() < 1e-12 && (high - expected[1]).abs() < 1e-12, "{curvature:?}");
        assert!((curvature.gaussian - expected[0] * expected[1]).abs() < 1e-12);
        assert!((curvature.mean - 0.5 * (expected[0] + expected[1])).abs() < 1e-12);
    }
    let collapsed = [DVec3::ZERO, DVec3::X];
    assert_eq!(SurfaceCurvature::from_normal_derivatives(collapsed, collapsed), None);
}

#[test]
fn rational_octant_is_an_exact_sphere() {
    let sphere = octant();
    for u in grid(sphere.knots_u()) {
        for v in grid(sphere.knots_v()) {
            let p = sphere.point(u, v);
            assert!((p.length() - 1.0).abs() < 1e-15);
            // The pole v = 1 included, where dS/du is 0.
            assert!(sphere.normal(u, v).unwrap().distance(p) < 1e-14, "{u} {v}");
        }
    }
    for (u, v) in [(0.1, 0.2), (0.7, 0.9), (0.0, 0.0), (1.0, 0.5)] {
        let curvature = sphere.curvature(u, v).unwrap();
        assert!((curvature.gaussian - 1.0).abs() < 1e-12 && (curvature.mean + 1.0).abs() < 1e-13);
        // The square root of the rounding error in H^2 - K.
        assert!(curvature.principal.iter().all(|k| (k + 1.0).abs() < 1e-6));
    }
    assert_eq!(sphere.curvature(0.5, 1.0), None);
}

#[test]
fn area_of_a_sphere_octant_is_half_of_pi() {
    for tolerance in [1e-4, 1e-10] {
        let area = octant().area(tolerance).unwrap();
        assert!(area.error <= tolerance && (area.value - FRAC_PI_2).abs() <= tolerance, "{area:?}");
    }
    let parted = octant().insert_knot(ParameterDirection::U, 0.21, 2).unwrap();
    assert!((parted.area(1e-10).unwrap().value - FRAC_PI_2).abs() < 1e-10);
    assert!(octant().area(0.0).is_err() && octant().area(f64::NAN).is_err());
}

#[test]
fn kept_areas_are_those_of_loops_of_any_size() {
    let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let square = NurbsSurface::try_from_points([1, 1], knots, &corners, None).unwrap();
    let polygon = |corners: &[(f64, f64)]| {
        let corners: Vec<_> = corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        vec![TrimCurve::try_polygon(&corners).unwrap()]
    };
    let check = |loops: Vec<Vec<TrimCurve>>, expected: f64| {
        let region = TrimRegion::try_from_curves(loops).unwrap();
        let area = square.kept_area(&region, 1e-9).unwrap();
        assert!((area.value - expected).abs() <= area.error.max(1e-12), "{area:?}, {expected}");
        assert!(area.error <= 1e-9, "{area:?}");
    };
    for w in [0.4, 0.1, 0.01, 0.001, 1e-6] {
        check(vec![polygon(&[(0.537, 0.537), (0.537 + w, 0.537), (0.537, 0.537 + w)])], 0.5 * w * w);
    }
    let circle = |x, y, r| vec![TrimCurve::try_circle(DVec2::new(x, y), r).unwrap()];
    let hole = |x, y, r| vec![TrimCurve::try_circle(DVec2::new(x, y), r).unwrap().reversed()];
    check(vec![hole(0.3, 0.3, 0.2), hole(0.7, 0.7, 0.001)], 1.0 - PI * 0.040_001);
    // Parts beyond the domain do not count, nested loops count once, and the right half of this loop runs clockwise.
    check(vec![circle(0.0, 0.5, 0.25)], 0.5 * PI * 0.0625);
    check(vec![circle(0.5, 0.5, 0.25), circle(0.5, 0.5, 0.125)], PI * 0.0625);
    check(
        vec![polygon(&[(0.2, 0.2), (0.6, 0.6), (0.6, 0.2), (0.2, 0.6)]), circle(0.4, 0.4, 0.35)],
        PI * 0.1225 - 0.04,
    );
}

#[test]
fn kept_area_of_a_band_of_a_sphere_is_that_of_archimedes() {
    let sphere = octant();
    let height = |v: f64| sphere.point(0.5, v).z;
    let band = TrimCurve::try_rectangle(DVec2::new(0.0, 0.25), DVec2::new(1.0, 0.625)).unwrap();
    let region = TrimRegion::try_from_curves(vec![vec![band]]).unwrap();
    let area = sphere.kept_area(&region, 1e-10).unwrap();
    let expected = FRAC_PI_2 * (height(0.625) - height(0.25)).abs();
    assert!((area.value - expected).abs() < 1e-10 && area.error < 1e-10, "{area:?}, {expected}");
    assert!(sphere.kept_area(&region, f64::MIN_POSITIVE).is_ok() && sphere.kept_area(&region, -1.0).is_err());
}

#[test]
fn periodic_points_make_a_closed_torus() {
    // The circle of radius 1 from its 8 points, given once: the corner (1, -1), then (1, 0), ...
    let corners = [(1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1)];
    let weight = |i: usize| if i.is_multiple_of(2) { FRAC_1_SQRT_2 } else { 1.0 };
    let period = || vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0];
    let points = (0..8).flat_map(|i| {
        (0..8).map(move |j| {
            let (x, y) = (f64::from(corners[i].0), f64::from(corners[i].1));
            let (r, z) = (3.0 + f64::from(corners[j].0), f64::from(corners[j].1));
            DVec3::new(r * x, r * y, z).extend(1.0) * (weight(i) * weight(j))
        })
    });
    let points: Vec<DVec4> = points.collect();
    let torus =
        NurbsSurface::try_new_periodic([2, 2], [period(), period()], points.clone(), [true, true]).unwrap();
    assert_eq!((torus.counts(), torus.knots_u().domain()), ((9, 9), [0.0, 4.0]));
    for u in grid(torus.knots_u()) {
        for v in grid(torus.knots_v()) {
            let p = torus.point(u, v);
            let ring = p.truncate().length() - 3.0;
            assert!((ring.hypot(p.z) - 1.0).abs() < 1e-14);
            let curvature = torus.curvature(u, v).unwrap();
            // K = cos t / (r (R + r cos t)) with r = 1, R = 3 and cos t = ring.
            assert!((curvature.gaussian - ring / (3.0 + ring)).abs() < 1e-12);
            assert!((curvature.principal[0] + 1.0).abs() < 1e-12);
        }
        assert!(torus.point(u, 0.0) == torus.point(u, 4.0) && torus.point(0.0, u) == torus.point(4.0, u));
    }
    assert!((torus.area(1e-8).unwrap().value - 4.0 * PI * PI * 3.0).abs() < 1e-8);
    let wrong = NurbsSurface::try_new_periodic([2, 2], [period(), vec![0.0]], points, [true, true]);
    assert!(matches!(wrong, Err(SurfaceError::TooFew { .. })));
}

#[test]
fn periodic_points_without_double_knots_are_smooth_across_the_seam() {
    let points = (0..7).flat_map(|i| {
        let t = f64::from(i) * 2.0 * PI / 7.0;
        [0.0, 1.0].map(|z| DVec4::new(t.cos(), t.sin() * (1.0 + z), z, 1.0))
    });
    let knots = vec![0.0, 1.0, 1.5, 2.5, 4.0, 4.5, 6.0, 7.0];
    let pipe = NurbsSurface::try_new_periodic(
        [3, 1],
        [knots, vec![0.0, 0.0, 1.0, 1.0]],
        points.collect(),
        [true, false],
    )
    .unwrap();
    let (start, end) = (pipe.derivatives(0.0, 0.3, 2), pipe.derivatives(7.0, 0.3, 2));
    for k in 0..=2 {
        assert!(start.at(k, 0).distance(end.at(k, 0)) < 1e-12);
    }
    assert!(pipe.is_polynomial());
    assert_eq!(pipe.knots_u().breaks(), [0.0, 1.0, 1.5, 2.5, 4.0, 4.5, 6.0, 7.0]);
}

#[test]
fn interpolation_reproduces_polynomials_of_its_degree() {
    let f = |u: f64, v: f64| DVec3::new(u - 0.3 * v, 2.0 * v + u * v, u * u * u - u * v * v + 0.25);
    let knots_u = KnotVector::try_new(3, KNOTS_U.to_vec()).unwrap();
    let knots_v = KnotVector::try_new(2, KNOTS_V.to_vec()).unwrap();
    let (gu, gv) = (knots_u.greville(), knots_v.greville());
    let points: Vec<DVec3> = gu.iter().flat_map(|&u| gv.iter().map(move |&v| f(u, v))).collect();
    let surface = NurbsSurface::interpolate_at([knots_u, knots_v], [&gu, &gv], &points).unwrap();
    assert!(surface.is_polynomial());
    for u in grid(surface.knots_u()) {
        for v in grid(surface.knots_v()) {
            assert!(surface.point(u, v).distance(f(u, v)) < 1e-13);
        }
    }
}

#[test]
fn interpolation_passes_through_its_points_at_chord_length_parameters() {
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64 * 0.7, j as f64);
        DVec3::new(x + 0.1 * y.sin(), y * y * 0.2, (x * 1.3).sin() + y.cos())
    };
    let points: Vec<DVec3> = (0..9).flat_map(|i| (0..6).map(move |j| point(i, j))).collect();
    let surface = NurbsSurface::interpolate([3, 2], [9, 6], &points).unwrap();
    for p in &points {
        assert!(surface.closest_point(*p, 1e-9).unwrap().distance < 1e-9);
    }
    let row: Vec<DVec3> = (0..9).map(|i| point(i, 0)).collect();
    for degree in 1..=8 {
        let curve = NurbsCurve::interpolate(degree, &row).unwrap();
        let lengths: Vec<f64> = row.windows(2).map(|w| w[0].distance(w[1])).collect();
        let whole: f64 = lengths.iter().sum();
        let mut run = 0.0;
        for (i, p) in row.iter().enumerate() {
            assert!(curve.point(run / whole).distance(*p) < 1e-12, "{degree} {i}");
            run += lengths.get(i).copied().unwrap_or(0.0);
        }
    }
    assert!(NurbsCurve::interpolate(9, &row).is_err());
    assert!(NurbsCurve::interpolate(3, &[DVec3::X; 5]).is_err());
}

#[test]
fn interpolation_is_refused_where_a_basis_function_vanishes() {
    let knots = KnotVector::try_new(2, KNOTS_V.to_vec()).unwrap();
    let points = [DVec3::X; 5];
    // The last basis function is positive from 0.6 on.
    let crowded = NurbsCurve::interpolate_at(knots.clone(), &[0.0, 0.1, 0.4, 0.5, 0.6], &points);
    assert!(
        matches!(crowded, Err(SurfaceError::OutOfRange { value: 0.6, min: 0.6, max: 1.0, .. })),
        "{crowded:?}"
    );
    let twice = NurbsCurve::interpolate_at(knots.clone(), &[0.0, 0.4, 0.4, 0.7, 1.0], &points);
    assert!(matches!(twice, Err(SurfaceError::EmptyRange { .. })), "{twice:?}");
    assert!(NurbsCurve::interpolate_at(knots.clone(), &[0.0, 0.2, f64::NAN, 0.7, 1.0], &points).is_err());
    assert!(NurbsCurve::interpolate_at(knots, &[0.0, 0.2, 0.5, 0.7, 1.1], &points).is_err());
}

#[test]
fn closest_point_of_a_sphere_lies_under_the_query() {
    let sphere = octant();
    for (query, distance) in [(1.7, 0.7), (0.4, 0.6), (1.0, 0.0)] {
        let direction = DVec3::new(0.5, 0.3, 0.6).normalize();
        let found = sphere.closest_point(direction * query, 1e-9).unwrap();
        assert!(found.point.distance(direction) < 1e-9, "{found:?}");
        assert!((found.distance - distance).abs() < 1e-12 && found.distance - found.lower_bound <= 2e-9);
        assert!(sphere.point(found.u, found.v) == found.point);
    }
    // Past the border: the nearest point is the corner (1, 0, 0), and from below the pole's side the pole itself.
    let corner = sphere.closest_point(DVec3::new(2.0, -1.0, -1.0), 1e-9).unwrap();
    assert!(corner.point.distance(DVec3::X) < 1e-12);
    let pole = sphere.closest_point(DVec3::new(-1.0, -1.0, 2.0), 1e-9).unwrap();
    assert!(pole.point.distance(DVec3::Z) < 1e-9, "{pole:?}");
    // From the centre all points are equally near: the distance is right, the bound stays below it.
    let center = sphere.closest_point(DVec3::ZERO, 1e-9).unwrap();
    assert!((center.distance - 1.0).abs() < 1e-14 && center.lower_bound > 0.99 && center.lower_bound <= 1.0);
    assert!(sphere.closest_point(DVec3::NAN, 1e-9).is_err());
    assert!(sphere.closest_point(DVec3::X, 0.0).is_err());
}

#[test]
fn a_point_near_which_the_search_starts_stays_where_all_are_equally_near() {
    // From the centre of a sphere rounding alone tells where the distance is least.
    let sphere = octant();
    for (i, j) in (1..20).flat_map(|i| (1..20).map(move |j| (i, j))) {
        let start = [f64::from(i) / 20.0, f64::from(j) / 20.0];
        let found = sphere.closest_point_from(DVec3::ZERO, start, [[0.0, 1.0]; 2]);
        let moved = found.point.distance(sphere.point(start[0], start[1]));
        assert!(moved < 1e-6, "{moved} from {start:?}");
    }
}

#[test]
fn closest_point_is_no_farther_than_any_of_a_dense_grid() {
    let surface = reference();
    for i in 0..12 {
        let t = f64::from(i);
        let query =
            DVec3::new(2.5 + 3.0 * (t * 1.9).sin(), 2.0 + 3.0 * (t * 0.7).cos(), 2.0 * (t * 2.3).sin());
        let found = surface.closest_point(query, 1e-9).unwrap();
        let steps = |n: i32| (0..=n).map(move |k| f64::from(k) / f64::from(n));
        let least = steps(100)
            .flat_map(|u| steps(100).map(move |v| (u, v)))
            .map(|(u, v)| surface.point(u, v).distance(query))
            .fold(f64::INFINITY, f64::min);
        assert!(found.distance <= least && least - found.distance < 0.01, "{found:?} {least}");
        assert!(found.distance - found.lower_bound <= 2e-9, "{found:?}");
    }
}

#[test]
fn a_quarter_of_a_cylinder_goes_through_its_homogeneous_points() {
    let half = 0.5_f64.sqrt();
    let net = [[1.0, 0.0, 1.0], [half, half, half], [0.0, 1.0, 1.0]];
    let points = net.iter().flat_map(|&[x, y, w]| [0.0, 1.0].map(|z| DVec4::new(x, y, z * w, w))).collect();
    let knots = |degree: usize| KnotVector::clamped_uniform(degree, degree + 1).unwrap();
    let quarter = NurbsSurface::from_knots(knots(2), knots(1), points).unwrap();
    // Of a higher degree, to which numerator and weight belong, too.
    let [knots_u, knots_v] = [knots(4), knots(2)];
    let [us, vs] = [knots_u.greville(), knots_v.greville()];
    let at = |u: &f64| vs.iter().map(|v| quarter.homogeneous_point(*u, *v)).collect::<Vec<_>>();
    let mut through: Vec<DVec4> = us.iter().flat_map(at).collect();
    let found =
        NurbsSurface::interpolate_homogeneous_at([knots_u.clone(), knots_v.clone()], [&us, &vs], &through)
            .unwrap();
    for i in 0..=20 {
        let (u, v) = (f64::from(i) / 20.0, 0.3);
        assert!(found.point(u, v).distance(quarter.point(u, v)) < 1e-14);
        assert!((found.point(u, v).truncate().length() - 1.0).abs() < 1e-14);
    }
    // Weights that change steeply.
    for (i, point) in through.iter_mut().enumerate() {
        *point *= if i % 2 == 0 { 1.0 } else { 1e-3 };
    }
    let steep = NurbsSurface::interpolate_homogeneous_at([knots_u, knots_v], [&us, &vs], &through);
    assert!(matches!(steep, Err(SurfaceError::NotPositive { .. })), "{steep:?}");
}
