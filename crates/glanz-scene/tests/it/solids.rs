//! Solids whose trimming curves agree with their edges up to a width: no ray slips through, and each enters and leaves in turns.

use glanz_geometry::BoundedRay;
use glanz_math::{DMat4, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

use crate::solid_forms::{DEVIATIONS, Deviation, FORMS, Form, REACH, Random, side, square, to_world};

/// Cosine of an angle at which a line runs along a face: within rounding of it, rounding decides whether the line is above or below.
const GRAZING: f64 = 1e-5;

/// A target next to an edge, up to some widths away, or anywhere in the solid.
fn target(form: Form, width: f64, random: &mut Random) -> DVec3 {
    target_away(form, &[0.0, 1e-12, 1e-9, 1e-5, width, 3.0 * width], random)
}

/// A target up to one of these distances away from an edge, or anywhere in the solid.
fn target_away(form: Form, distances: &[f64], random: &mut Random) -> DVec3 {
    let away = distances[random.index(distances.len())];
    match random.index(8) {
        0 => form.inner_point(random),
        _ => form.edge_point(random) + away * random.vector(),
    }
}

/// Cosine between a ray and the normal at its first hit, less than zero if it enters, and the ray that continues there; `None` if it hits
/// nothing.
fn advance(scene: &Scene, ray: &Ray) -> Option<(f64, Ray)> {
    let at = scene.intersect(ray, f64::INFINITY)?;
    Some((at.point.normal.dot(ray.direction) / ray.direction.length(), at.spawn(ray.direction)))
}

/// Number of rays of each test.
fn count(default: u64) -> u64 {
    std::env::var("GLANZ_SOLID_RAYS").ok().and_then(|count| count.parse().ok()).unwrap_or(default)
}

fn each_case(mut check: impl FnMut(Form, Deviation, f64, &Scene, &mut Random)) {
    let mut seed = 0;
    for form in FORMS {
        for deviation in DEVIATIONS {
            for width in [1e-3, 1e-6] {
                seed += 1;
                let scene = form.scene(width, deviation, seed);
                check(form, deviation, width, &scene, &mut Random::new(seed + 1000));
            }
        }
    }
}

#[test]
fn no_ray_from_inside_escapes() {
    each_case(|form, deviation, width, scene, random| {
        for _ in 0..count(4_000) {
            let origin = to_world().transform_point3(form.inner_point(random));
            let to = to_world().transform_point3(target(form, width, random));
            let ray = Ray::new(origin, to - origin);
            let hit = advance(scene, &ray);
            assert!(hit.is_some_and(|(cos, _)| cos > 0.0), "{form:?} {deviation:?} {width}: {hit:?} {ray:?}");
            assert!(scene.occluded(&ray, f64::INFINITY));
        }
    });
}

#[test]
fn lines_enter_and_leave_in_turns() {
    each_case(|form, deviation, width, scene, random| {
        let mut chords = 0;
        for _ in 0..count(4_000) {
            let [from, through] = match random.index(2) {
                // Through one edge, and through two.
                0 => [5.0 * random.vector(), target(form, width, random)],
                _ => {
                    let [a, b] = [target(form, width, random), target(form, width, random)];
                    [b + (b - a).normalize_or(DVec3::X) * 4.0, a]
                }
            };
            if from.length() < 1.0 {
                continue;
            }
            let is_along_a_face = (through - from).normalize().abs().min_element() < GRAZING;
            let [from, through] = [from, through].map(|p| to_world().transform_point3(p));
            let first = Ray::new(from, through - from);
            let (mut ray, mut sides) = (first, Vec::new());
            while let Some((cos, next)) = advance(scene, &ray) {
                sides.push(cos);
                ray = next;
            }
            if is_along_a_face || sides.iter().any(|cos| cos.abs() < GRAZING) {
                continue;
            }
            let alternate = sides.iter().enumerate().all(|(i, cos)| (*cos < 0.0) == i.is_multiple_of(2));
            let is_even = sides.len().is_multiple_of(2);
            assert!(alternate && is_even, "{form:?} {deviation:?} {width}: {first:?} {sides:?}");
            assert_eq!(scene.occluded(&first, f64::INFINITY), !sides.is_empty());
            chords += usize::from(!sides.is_empty());
        }
        assert!(chords as u64 > count(4_000) / 4, "{chords}");
    });
}

#[test]
fn lines_enter_and_leave_in_turns_far_from_the_origin() {
    let far = DMat4::from_translation(DVec3::new(3e5, -2e6, 1e6)) * to_world();
    for form in FORMS {
        let (width, mut chords) = (1e-3, 0);
        let scene = form.placed(width, Deviation::Outwards, 5, far);
        let mut random = Random::new(6);
        for _ in 0..count(4_000) {
            let through = target_away(form, &[1e-5, 0.3 * width, width], &mut random);
            let direction = random.vector();
            if direction.normalize().abs().min_element() < 1e-2 {
                continue;
            }
            let [from, through] =
                [through - 5.0 * direction.normalize(), through].map(|p| far.transform_point3(p));
            let (mut ray, mut sides) = (Ray::new(from, (through - from).normalize()), Vec::new());
            while let Some((cos, next)) = advance(&scene, &ray) {
                sides.push(cos);
                ray = next;
            }
            let alternate = sides.iter().enumerate().all(|(i, cos)| (*cos < 0.0) == i.is_multiple_of(2));
            assert!(alternate && sides.len().is_multiple_of(2), "{form:?} {through:?} {sides:?}");
            chords += u64::from(!sides.is_empty());
        }
        assert!(chords > count(4_000) / 4, "{form:?}: {chords}");
    }
}

#[test]
fn trimmed_infinite_planes_bound_a_solid() {
    let width = 1e-3;
    for deviation in DEVIATIONS {
        let mut random = Random::new(8);
        let plane = |number: usize| {
            let mut trim = square(width, deviation, &mut random);
            // The parameters of an infinite plane are metres.
            for point in trim.loops.iter_mut().flat_map(|l| &mut l.curves).flat_map(|curve| &mut curve.points)
            {
                *point = [(2.0 * point[0] - 1.0) * REACH, (2.0 * point[1] - 1.0) * REACH, 1.0];
            }
            (trim.scale, trim.domain) = ([1.0; 2], Some([[-REACH; 2], [REACH; 2]]));
            side(ShapeDescription::plane().trimmed(trim), number).bounding(0)
        };
        let faces: Vec<ShapeDescription> = (0..6).map(plane).collect();
        let scene = SceneBuilder::new().shapes(faces, MaterialKind::diffuse(0.5)).resolve().unwrap().0;
        for _ in 0..count(4_000) {
            let (from, to) = (Form::Cube.inner_point(&mut random), target(Form::Cube, width, &mut random));
            let ray = Ray::new(from, to - from);
            let (cos, next) = advance(&scene, &ray).unwrap();
            assert!(cos > 0.0, "{deviation:?} {ray:?}");
            if cos > 0.1 {
                assert!(advance(&scene, &next).is_none(), "{deviation:?} {ray:?}");
            }
        }
    }
}

#[test]
fn without_a_solid_rays_slip_through_and_meet_faces_twice() {
    let escapes = |form: Form, deviation, bounding: bool| {
        let mut random = Random::new(7);
        let faces = form.faces(1e-3, deviation, 5).into_iter().map(|mut face| {
            face.solid = bounding.then_some(0);
            if let (false, Some(trim)) = (bounding, &mut face.trim) {
                trim.loops.iter_mut().flat_map(|l| &mut l.curves).for_each(|curve| curve.width = None);
            }
            face
        });
        let (scene, _) = SceneBuilder::new().shapes(faces, MaterialKind::diffuse(0.5)).resolve().unwrap();
        let escapes = |_: &i32| {
            let origin = form.inner_point(&mut random);
            let ray = Ray::new(origin, form.edge_point(&mut random) + 3e-4 * random.vector() - origin);
            advance(&scene, &ray).is_none()
        };
        (0..2000).filter(escapes).count()
    };
    for form in FORMS {
        assert!(escapes(form, Deviation::Inwards, false) > 300, "{form:?}");
        assert_eq!(escapes(form, Deviation::Inwards, true), 0, "{form:?}");
    }
}

#[test]
fn batches_give_the_hits_of_single_rays() {
    each_case(|form, deviation, width, scene, random| {
        let ray = |i: u64| {
            let to = to_world().transform_point3(target(form, width, random));
            let from = if i.is_multiple_of(2) { form.inner_point(random) } else { 3.0 * random.vector() };
            let from = to_world().transform_point3(from);
            let t_max = [f64::INFINITY, 1.0, 1.0 + 1e-3, 1.0 - 1e-4][i as usize % 4];
            BoundedRay::new(Ray::new(from, to - from), t_max)
        };
        let rays: Vec<BoundedRay> = (0..600).map(ray).collect();
        let (mut hits, mut occluded) = (Vec::new(), Vec::new());
        for size in [1, 5, 200] {
            for part in rays.chunks(size) {
                scene.closest_batch(part, &mut hits);
                scene.occluded_batch(part, &mut occluded);
                for ((BoundedRay { ray, t_max }, hit), &occluded) in part.iter().zip(&hits).zip(&occluded) {
                    let single = scene.intersect(ray, *t_max);
                    let hit = hit.map(|hit| scene.interaction(ray, &hit));
                    assert_eq!(format!("{hit:?}"), format!("{single:?}"), "{form:?} {deviation:?}");
                    assert_eq!(occluded, single.is_some());
                    assert_eq!(scene.occluded(ray, *t_max), single.is_some());
                }
            }
        }
    });
}

/// The direction behind a surface of glass with this normal, of index 1.5, refracted or totally reflected.
fn through_glass(direction: DVec3, normal: DVec3) -> DVec3 {
    let (cos, ratio) = (-direction.dot(normal), if direction.dot(normal) < 0.0 { 1.0 / 1.5 } else { 1.5 });
    let normal = normal * cos.signum();
    let sin2 = ratio * ratio * (1.0 - cos * cos);
    if sin2 < 1.0 {
        direction * ratio + normal * (ratio * cos.abs() - (1.0 - sin2).sqrt())
    } else {
        direction + normal * (2.0 * cos.abs())
    }
}

#[test]
fn paths_through_glass_enter_and_leave_in_turns_at_edges() {
    each_case(|form, deviation, width, scene, random| {
        let (mut paths, mut wrong) = (0, 0);
        for _ in 0..count(2_000) {
            // Farther from the edges than rounding.
            let to = target_away(form, &[1e-9, 1e-5, width, 3.0 * width], random);
            let [from, to] = [to + 3.0 * random.vector(), to].map(|p| to_world().transform_point3(p));
            let first = Ray::new(from, (to - from).normalize());
            let (mut ray, mut inside) = (first, false);
            if (from - to_world().w_axis.truncate()).length() < 1.0 {
                continue;
            }
            paths += 1;
            // Light may be trapped by total reflection.
            for _ in 0..30 {
                let at = scene.intersect(&ray, f64::INFINITY);
                let enters = at.is_some_and(|at| at.point.normal.dot(ray.direction) < 0.0);
                let Some(at) = at.filter(|_| enters != inside) else {
                    wrong += u64::from(inside || at.is_some());
                    break;
                };
                let direction = through_glass(ray.direction, at.point.normal);
                inside = direction.dot(at.point.normal) < 0.0;
                ray = at.spawn(direction);
            }
        }
        // Where one face is too large and the other too small, the one that counts is not always that of the true border; only beyond
        // it, at most a width away, a refracted ray may then leave without meeting another face.
        let most = if deviation == Deviation::Random { paths / 50 } else { 0 };
        assert!(
            wrong <= most && paths > count(2_000) / 2,
            "{form:?} {deviation:?} {width}: {wrong} of {paths}"
        );
    });
}
