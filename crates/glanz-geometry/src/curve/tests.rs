use std::f64::consts::PI;

use glanz_math::Bounds3;
use glanz_math::rounding::offset_origin;

use super::*;

const BENT: [DVec3; 4] = [
    DVec3::new(-2.0, -1.0, -1.0),
    DVec3::new(2.0, 2.0, 0.0),
    DVec3::new(-2.0, -2.0, 0.0),
    DVec3::new(2.0, 1.0, -1.0),
];

fn straight(widths: [f64; 2]) -> FacingCurve {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0));
    FacingCurve::try_new(&points, widths, CurveShading::Flat).unwrap()
}

fn bent(shading: CurveShading) -> FacingCurve {
    FacingCurve::try_new(&BENT, [0.35, 0.15], shading).unwrap()
}

fn downwards(x: f64, y: f64) -> Ray {
    Ray::new(DVec3::new(x, y, 4.0), DVec3::new(0.0, 0.0, -2.0))
}

/// Rays through the curve's surroundings, by the golden ratio and the like.
fn rays(count: u32) -> impl Iterator<Item = Ray> {
    let part = |k: u32, a: f64| (f64::from(k) * a).fract() * 2.0 - 1.0;
    (1..=count).map(move |k| {
        let target =
            DVec3::new(2.2 * part(k, 0.618_034), 1.5 * part(k, 0.754_878), -0.5 + 0.8 * part(k, 0.569_840));
        let direction = DVec3::new(part(k, 0.819_173), part(k, 0.671_044), part(k, 0.549_700)).normalize();
        Ray::new(target - 5.0 * direction, direction * 1.7)
    })
}

#[test]
fn straight_curve_covers_length_times_width() {
    let curve = straight([0.5, 0.5]);
    let (n, mut hits) = (400, 0_u32);
    for i in 0..n {
        for j in 0..n {
            let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            hits += u32::from(curve.occluded(&downwards(4.0 * x - 0.5, 2.0 * y - 1.0), f64::INFINITY));
        }
    }
    let area = f64::from(hits) * 8.0 / f64::from(n * n);
    assert!((area - 1.5).abs() < 1e-9, "{area}");
}

#[test]
fn straight_curve_ends_at_its_borders() {
    let curve = straight([0.4, 0.8]);
    let hit = |x: f64, y: f64| curve.intersect(&downwards(x, y), f64::INFINITY);
    // The width at x = 1.5 is 0.6.
    assert!(hit(1.5, 0.299_999).is_some() && hit(1.5, 0.300_001).is_none());
    assert!(hit(1.5, -0.299_999).is_some() && hit(1.5, -0.300_001).is_none());
    assert!(hit(1e-6, 0.0).is_some() && hit(-1e-6, 0.0).is_none());
    assert!(hit(3.0 - 1e-6, 0.0).is_some() && hit(3.0 + 1e-6, 0.0).is_none());
    let found = hit(1.5, 0.15).unwrap();
    assert_eq!((found.t, found.face), (2.0, 0));
    assert!((found.u - 0.5).abs() < 1e-15 && (found.v - 0.25).abs() < 1e-15, "{found:?}");
}

#[test]
fn hits_are_all_feet_of_perpendiculars_within_half_the_width() {
    // Reference: signs of the derivative of the squared distance at 20000 parameters.
    let curve = bent(CurveShading::Flat);
    let at = |u: f64| {
        let [a, b, c, d] = BENT;
        let rest = 1.0 - u;
        a * rest.powi(3) + b * (3.0 * u * rest * rest) + c * (3.0 * u * u * rest) + d * u.powi(3)
    };
    let (mut total, mut skipped) = (0, 0);
    for ray in rays(1500) {
        let direction = ray.direction.normalize();
        let across = |u: f64| (at(u) - ray.origin).reject_from_normalized(direction).length();
        let samples = 20_000;
        let parameter = |k: u32| f64::from(k) / f64::from(samples);
        let distances: Vec<f64> = (0..=samples).map(|k| across(parameter(k))).collect();
        let feet: Vec<u32> = (1..samples)
            .filter(|&k| {
                let [before, here, after] = [k - 1, k, k + 1].map(|k| distances[k as usize]);
                (here <= before && here < after) || (here >= before && here > after)
            })
            .collect();
        let margin = |k: u32| distances[k as usize] - 0.5 * (0.35 - 0.2 * parameter(k));
        if feet.iter().any(|&k| margin(k).abs() < 1e-5) {
            skipped += 1;
            continue;
        }
        let mut expected: Vec<f64> = feet
            .iter()
            .filter(|&&k| margin(k) < 0.0)
            .map(|&k| (at(parameter(k)) - ray.origin).dot(direction) / 1.7)
            .collect();
        expected.sort_by(f64::total_cmp);
        let mut hits = Vec::new();
        curve.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), expected.len(), "{ray:?}: {hits:?} {expected:?}");
        assert!(hits.iter().zip(&expected).all(|(hit, t)| (hit.t - t).abs() < 1e-3), "{hits:?} {expected:?}");
        total += hits.len();
    }
    assert!(total > 150 && skipped < 20, "{total} {skipped}");
}

#[test]
fn queries_agree_and_points_lie_on_ray_and_in_bounds() {
    let curve = bent(CurveShading::Cylinder);
    let bounds = curve.bounds();
    for ray in rays(20_000) {
        let mut hits = Vec::new();
        curve.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(curve.intersect(&ray, f64::INFINITY), hits.first().copied());
        assert_eq!(curve.occluded(&ray, f64::INFINITY), !hits.is_empty());
        for hit in &hits {
            let closer = hits.iter().any(|other| other.t < hit.t);
            assert_eq!(curve.occluded(&ray, hit.t), closer);
            let point = curve.point(&ray, hit);
            assert!(bounds.contains(point.position) && point.position.distance(ray.at(hit.t)) < 1e-14);
            assert!(
                (point.normal.length() - 1.0).abs() < 1e-14 && point.normal.dot(point.dpdu).abs() < 1e-12
            );
            assert!(point.normal.dot(point.dpdv).abs() < 1e-12 && (0.0..=1.0).contains(&hit.v));
            // The hit is in the plane through the point of the curve that is perpendicular to the curve as seen along the ray.
            assert!(
                point.position.distance(at_parameter(hit.u)) <= 0.5 * curve.width(0, hit.u) * (1.0 + 1e-9)
            );
        }
    }
}

fn at_parameter(u: f64) -> DVec3 {
    on_curve(BENT, u)
}

fn on_curve([a, b, c, d]: [DVec3; 4], u: f64) -> DVec3 {
    a.lerp(b, u).lerp(b.lerp(c, u), u).lerp(b.lerp(c, u).lerp(c.lerp(d, u), u), u)
}

#[test]
fn no_ray_passes_where_pieces_meet() {
    // Thin enough for eight pieces: rays across the curve at their ends, and next to these by some roundings.
    let curve = FacingCurve::try_new(&BENT, [0.02, 0.02], CurveShading::Flat).unwrap();
    for joint in 1..8 {
        for step in -20..=20 {
            for offset in [-0.9, -0.3, 0.0, 0.5, 0.9] {
                let u = f64::from(joint) / 8.0 + f64::from(step) * 1e-16;
                let tangent = (at_parameter(u + 1e-6) - at_parameter(u - 1e-6)).normalize();
                let across = tangent.any_orthonormal_vector();
                let direction = tangent.cross(across);
                let target = at_parameter(u) + 0.01 * offset * across;
                let ray = Ray::new(target - 3.0 * direction, direction);
                let mut hits = Vec::new();
                curve.all_hits(&ray, f64::INFINITY, &mut hits);
                let near = hits.iter().filter(|hit| (hit.t - 3.0).abs() < 1e-6).count();
                assert_eq!(near, 1, "{joint} {step} {offset}: {hits:?}");
            }
        }
    }
}

#[test]
fn rays_that_leave_do_not_meet_the_place_that_they_leave() {
    for shading in [CurveShading::Flat, CurveShading::Cylinder] {
        let curve = straight([0.5, 0.3]);
        let curve = FacingCurve { shading, ..curve };
        let mut count = 0;
        for ray in rays(4000) {
            let Some(hit) = curve.intersect(&ray, f64::INFINITY) else { continue };
            let point = curve.point(&ray, &hit);
            assert!(point.normal.dot(ray.direction) <= 1e-12);
            for direction in rays(40).map(|ray| ray.direction) {
                let origin = offset_origin(point.position, point.error, point.normal, direction);
                assert!(!curve.occluded(&Ray::new(origin, direction), f64::INFINITY), "{ray:?} {direction}");
                count += 1;
            }
        }
        assert!(count > 1000, "{count}");
    }
}

#[test]
fn normals_of_a_cylinder_turn_from_side_to_side() {
    let curve = FacingCurve { shading: CurveShading::Cylinder, ..straight([0.5, 0.5]) };
    let normal = |y: f64| {
        let ray = downwards(1.0, y);
        curve.point(&ray, &curve.intersect(&ray, f64::INFINITY).unwrap()).normal
    };
    for (y, expected) in [(0.0, DVec3::Z), (0.25 - 1e-12, DVec3::Y), (-0.25 + 1e-12, -DVec3::Y)] {
        assert!(normal(y).distance(expected) < 1e-9, "{y}: {}", normal(y));
    }
    assert!(normal(0.125).distance(DVec3::new(0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt())) < 1e-9);
}

#[test]
fn wrong_curves_are_refused() {
    let refused =
        |points: &[DVec3], widths| FacingCurve::try_new(points, widths, CurveShading::Flat).unwrap_err();
    let expected = SurfaceError::CountMismatch { parameter: "control points", count: 5, expected: 4 };
    assert_eq!(refused(&[DVec3::ZERO; 5], [1.0; 2]), expected);
    assert!(matches!(refused(&[DVec3::ZERO; 4], [1.0; 2]), SurfaceError::Degenerate { .. }));
    assert!(matches!(refused(&BENT, [0.0; 2]), SurfaceError::Degenerate { .. }));
    assert!(matches!(refused(&BENT, [1.0, -1.0]), SurfaceError::Negative { value: -1.0, .. }));
    assert!(matches!(refused(&[DVec3::NAN; 4], [1.0; 2]), SurfaceError::NotFinite { .. }));
}

#[test]
fn curves_that_start_with_equal_points_are_cut_off_straight_far_from_the_origin() {
    // All rays pass the tip within half of the width, so that a round cap would stop them.
    for place in (0..100).map(|k| 1000.0 + 0.37 * f64::from(k)) {
        let points = [0.0, 0.0, 0.03, 0.07].map(|x| DVec3::new(place + x, place, 0.0));
        // Seven pieces.
        let width = 0.07 / (8.0 * 6.5);
        let curve = FacingCurve::try_new(&points, [width; 2], CurveShading::Flat).unwrap();
        for k in 1..40 {
            let before = 0.5 * width * f64::from(k) / 40.0;
            assert!(
                !curve.occluded(&downwards(place - before, place + 0.01 * width), f64::INFINITY),
                "{place} {k}"
            );
        }
    }
}

#[test]
fn edges_of_a_ribbon_are_half_the_width_away_and_perpendicular() {
    let normals = [DVec3::new(-0.1, 0.0, 1.0), DVec3::new(-0.7, 0.1, 0.4)];
    let [a, b, c, d] = BENT;
    for curve in [BENT, [a, a, c, d], [a, b, d, d]] {
        let ribbon = ribbon_surface(curve, [0.35, 0.15], normals).unwrap();
        assert_eq!(ribbon.knots.len(), ribbon.points.len() + 4);
        let pieces = (ribbon.points.len() - 1) / 3;
        for k in 0..pieces {
            let side = |v: usize| [0, 1, 2, 3].map(|i| ribbon.points[3 * k + i][v]);
            let [from, to] = [ribbon.knots[3 * k + 3], ribbon.knots[3 * k + 6]];
            for t in [0.0, 0.1, 0.37, 0.63, 0.9, 1.0] {
                let u = from + (to - from) * t;
                // The ends of the curve have no tangent where two points are equal.
                let tangent = on_curve(curve, (u + 1e-5).min(1.0)) - on_curve(curve, (u - 1e-5).max(0.0));
                // The normal of the surface is the part of the mean normal perpendicular to the curve.
                let (start, end) = (normals[0].normalize(), normals[1].normalize());
                let angle = start.angle_between(end);
                let mean = (start * ((1.0 - u) * angle).sin() + end * (u * angle).sin()) / angle.sin();
                let expected = 0.5 * (0.35 - 0.2 * u) * mean.cross(tangent).normalize();
                // Ends of pieces are exact; the others are splines within the stated part of the width. The tangent is a difference of points.
                let accuracy = if t == 0.0 || t == 1.0 { 1e-7 } else { 1e-5 * 0.35 };
                let accuracy = if u == 0.0 || u == 1.0 { 1e-5 } else { accuracy };
                for (v, sign) in [(0, -1.0), (1, 1.0)] {
                    let off = on_curve(side(v), t) - on_curve(curve, u) - sign * expected;
                    assert!(off.length() < accuracy, "{curve:?} {u} {v}: {}", off.length());
                }
            }
        }
        assert!((4..=128).contains(&pieces), "{pieces}");
    }
}

#[test]
fn ribbons_with_opposite_normals_are_flat() {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0));
    for normal in [DVec3::Z, DVec3::new(0.3, -0.7, 0.9), DVec3::new(0.1, 0.2, 1e-3)] {
        let [flat, opposite] =
            [1.0, -2.3].map(|factor| ribbon_surface(points, [1.0; 2], [normal, factor * normal]).unwrap());
        assert_eq!((flat.knots, flat.points), (opposite.knots, opposite.points), "{normal}");
    }
    let half_a_turn = ribbon_surface(points, [1.0; 2], [DVec3::Z, DVec3::new(0.0, 1e-6, -1.0)]).unwrap();
    // The normal turns evenly from z by y to -z.
    for (k, points) in half_a_turn.points.iter().step_by(3).enumerate() {
        let (sin, cos) = (PI * half_a_turn.knots[3 * k + 3]).sin_cos();
        assert!((points[1] - points[0]).distance(DVec3::new(0.0, cos, -sin)) < 1e-5, "{points:?}");
    }
    assert!(half_a_turn.points.len() > 7, "it turns within the segment");
}

#[test]
fn straight_ribbon_is_one_bilinear_piece() {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0));
    let ribbon = ribbon_surface(points, [1.0, 2.0], [DVec3::Z; 2]).unwrap();
    assert_eq!(ribbon.knots, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    for (point, x) in ribbon.points.iter().zip([0.0, 1.0, 2.0, 3.0]) {
        let half = 0.5 + x / 6.0;
        assert!(point[0].distance(DVec3::new(x, -half, 0.0)) < 1e-15);
        assert!(point[1].distance(DVec3::new(x, half, 0.0)) < 1e-15);
    }
    assert!(ribbon_surface(points, [1.0; 2], [DVec3::ZERO; 2]).is_err());
}

#[test]
fn ribbons_that_start_with_almost_equal_points_stay_within_their_width() {
    let [a, _, c, d] = BENT;
    let along = (c - a).normalize();
    for off in [1e-3, 1e-5, 1e-7, 1e-9] {
        let points = [a, a + off * along.any_orthonormal_vector(), c, d];
        let normals = [DVec3::new(-0.1, 0.0, 1.0), DVec3::new(-0.7, 0.1, 0.4)];
        let ribbon = ribbon_surface(points, [0.35, 0.15], normals).unwrap();
        let reach = Bounds3::from_points(points);
        // Splines lie within their control points.
        for point in ribbon.points.iter().flatten() {
            assert!((reach.min - *point).max(*point - reach.max).max_element() < 0.35, "{off}: {point}");
        }
    }
}
