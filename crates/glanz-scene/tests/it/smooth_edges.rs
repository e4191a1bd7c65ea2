//! Faces that meet smoothly, one a little above the other: rays at any angle meet one of them. Faces that reach into a solid beyond its edges.

use glanz_geometry::BoundedRay;
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

use crate::solid_forms::{HALF, REACH, Random, metric, polyline, sheet, side};

/// Distance of the halves of the top along its normal, metres.
const STEP: f64 = 1e-6;

/// A rectangle from `low` to `high` of a sheet, by one curve.
fn rectangle([low, high]: [DVec2; 2], width: f64) -> TrimDescription {
    let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y), low];
    metric(vec![TrimLoopDescription { curves: vec![polyline(&corners, width)] }], DVec2::splat(2.0 * REACH))
}

/// A cube whose top consists of two halves that meet in y = 0, that on the side of negative y lower than the other by `step`.
///
/// The halves end `gap` before their edge.
fn split_cube(is_spline: bool, step: f64, gap: f64) -> Scene {
    let width = 2.0 * step.abs().max(gap);
    let (low, high) = (DVec2::splat(-HALF), DVec2::splat(HALF));
    let mut faces: Vec<ShapeDescription> = [0, 1, 2, 3, 5]
        .map(|number| side(sheet(is_spline).trimmed(rectangle([low, high], width)), number))
        .into();
    for sign in [-1.0, 1.0] {
        let half = if sign < 0.0 { [low, DVec2::new(HALF, -gap)] } else { [DVec2::new(-HALF, gap), high] };
        let half = sheet(is_spline).trimmed(rectangle(half, width));
        faces.push(half.translated([0.0, 0.0, HALF + 0.5 * sign * step]));
    }
    let faces = faces.into_iter().map(|face| face.bounding(0));
    SceneBuilder::new().shapes(faces, MaterialKind::diffuse(0.5)).resolve().unwrap().0
}

/// A ray from inside that passes through y = 0 within the step, at a small angle to the top.
fn grazing_ray(random: &mut Random, step: f64) -> Ray {
    let (x, along) = (0.3 * random.next(), random.next().signum());
    let target = DVec3::new(x, 0.0, HALF + 0.5 * step * random.next());
    let slope = 10_f64.powf(-2.5 + 1.4 * random.next());
    let direction = DVec3::new(0.3 * random.next(), along, slope);
    Ray::new(target - 0.4 * direction, direction.normalize())
}

#[test]
fn no_ray_passes_between_faces_that_meet_smoothly() {
    let mut random = Random::new(11);
    for is_spline in [false, true] {
        for (step, gap) in [(STEP, 0.0), (-STEP, 0.0), (STEP, STEP), (0.0, STEP)] {
            let scene = split_cube(is_spline, step, gap);
            let rays: Vec<BoundedRay> =
                (0..4000).map(|_| BoundedRay::new(grazing_ray(&mut random, STEP), f64::INFINITY)).collect();
            let (mut hits, mut occluded) = (Vec::new(), Vec::new());
            scene.closest_batch(&rays, &mut hits);
            scene.occluded_batch(&rays, &mut occluded);
            for ((BoundedRay { ray, .. }, hit), occluded) in rays.iter().zip(&hits).zip(occluded) {
                let case = format!("{is_spline} {step} {gap} {ray:?}");
                let at = scene.intersect(ray, f64::INFINITY);
                assert!(at.is_some_and(|at| at.point.normal.dot(ray.direction) > 0.0), "{case}");
                let hit = hit.map(|hit| scene.interaction(ray, &hit));
                assert_eq!(format!("{at:?}"), format!("{hit:?}"), "{case}");
                assert!(occluded && scene.occluded(ray, f64::INFINITY), "{case}");
                // Behind the boundary there is nothing. A ray reflected within the step is not told from one that enters over it.
                let at = at.unwrap();
                assert!(scene.intersect(&at.spawn(ray.direction), f64::INFINITY).is_none(), "{case}");
            }
        }
    }
}

#[test]
fn rays_that_pass_by_a_smooth_edge_meet_nothing() {
    let scene = split_cube(false, STEP, 0.0);
    let mut random = Random::new(12);
    for _ in 0..4000 {
        let over = DVec3::new(0.9 * random.next(), 0.0, HALF + 0.51 * STEP + STEP * random.next().abs());
        let direction = DVec3::new(0.3 * random.next(), random.next().signum(), 0.0);
        let ray = Ray::new(over - 3.0 * direction, direction.normalize());
        assert!(scene.intersect(&ray, f64::INFINITY).is_none(), "{ray:?}");
    }
}

/// A bar along x with two bars across, at x = -0.25 and 0.25, by faces that extend beyond their edges by `width`, into the solid at its inner edges.
fn crossed_bars(width: f64) -> Scene {
    let quarter = [(0.15, 0.1), (0.15, 0.3), (0.35, 0.3), (0.35, 0.1), (0.5, 0.1)].map(DVec2::from);
    let mirrored = |signs: DVec2, reverse: bool| {
        let mut points = quarter.map(|p| p * signs);
        if reverse {
            points.reverse();
        }
        points
    };
    let outline = [
        mirrored(DVec2::new(1.0, -1.0), false),
        mirrored(DVec2::ONE, true),
        mirrored(DVec2::new(-1.0, 1.0), false),
        mirrored(DVec2::NEG_ONE, true),
    ]
    .concat();
    let closed: Vec<DVec2> = outline.iter().chain(outline.first()).copied().collect();
    let placed = |trim: TrimDescription, x: DVec3, y: DVec3, at: DVec3| {
        let map = DMat4::from_cols(x.extend(0.0), y.extend(0.0), x.cross(y).extend(0.0), at.extend(1.0));
        sheet(false).trimmed(trim).transformed(map).bounding(0)
    };
    let mut faces: Vec<ShapeDescription> = closed
        .windows(2)
        .map(|side| {
            let half = DVec2::new(0.5 * side[0].distance(side[1]), HALF);
            let (along, middle) = ((side[1] - side[0]).normalize(), 0.5 * (side[0] + side[1]));
            placed(rectangle([-half, half], width), along.extend(0.0), DVec3::Z, middle.extend(0.0))
        })
        .collect();
    for sign in [-1.0, 1.0] {
        let curves = vec![polyline(&closed, width)];
        let trim = metric(vec![TrimLoopDescription { curves }], DVec2::splat(2.0 * REACH));
        faces.push(placed(trim, DVec3::X, sign * DVec3::Y, DVec3::Z * sign * HALF));
    }
    SceneBuilder::new().shapes(faces, MaterialKind::diffuse(0.5)).resolve().unwrap().0
}

#[test]
fn faces_that_reach_into_a_solid_stop_no_ray_inside() {
    let width = 0.01;
    let scene = crossed_bars(width);
    let mut random = Random::new(13);
    for _ in 0..4000 {
        let height = 0.1 - width * (0.1 + 0.4 * (1.0 + random.next()));
        let from = DVec3::new(-0.45, height, 0.3 * random.next());
        let ray = Ray::new(from, DVec3::new(1.0, 0.0, 0.1 * random.next()).normalize());
        let at = scene.intersect(&ray, f64::INFINITY).unwrap();
        assert!((at.point.position.x - 0.5).abs() < 1e-9, "{ray:?} {at:?}");
    }
}
