//! Batches of rays give what rays give one by one.

use glanz_geometry::BoundedRay;
use glanz_math::{DMat4, DVec3, Ray};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// A wavy bicubic patch over the square of half width 1.
fn patch() -> ShapeDescription {
    let point = |i: u32, j: u32| {
        let (x, y) = (f64::from(i) / 1.5 - 1.0, f64::from(j) / 1.5 - 1.0);
        [x, y, 0.6 * (2.0 * x).sin() * (3.0 * y).cos(), 1.0]
    };
    let points = (0..4).flat_map(|i| (0..4).map(move |j| point(i, j))).collect();
    let patches = BezierPatchesDescription { degree_u: 3, degree_v: 3, patches: vec![points] };
    GeometryDescription::BezierPatches(patches).into()
}

/// Nested instances, an infinite plane, an interface, two spheres in one place, a light and objects of several kinds.
fn scene() -> Scene {
    let grey = || MaterialKind::diffuse(0.5);
    let shift = |x, y, z| DMat4::from_translation(DVec3::new(x, y, z));
    let turned = DMat4::from_rotation_x(0.7) * DMat4::from_scale(DVec3::new(1.0, 0.5, 2.0));
    let cuboid = GeometryDescription::Cuboid { min: DVec3::splat(-0.5), max: DVec3::ONE };
    let corners = [[-1.0, -1.0, 0.2], [1.0, -1.0, 0.0], [1.0, 1.0, 0.3], [-1.0, 1.0, 0.1]];
    let mesh = ShapeDescription::mesh(corners.map(DVec3::from).to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let builder = SceneBuilder::new()
        .group("inner", |group| group.shape(patch(), grey()).shape(ShapeDescription::sphere(0.4), grey()))
        .group("outer", |group| {
            let group = group.shape(ShapeDescription::disk(0.8), grey()).shape(mesh, grey());
            group.instance("inner", shift(0.0, 0.0, 1.0)).instance("inner", turned)
        })
        .shape(ShapeDescription::plane().translated([0.0, 0.0, -4.0]), grey())
        .shape(ShapeDescription::sphere(0.7).translated([3.0, 0.0, 0.0]), grey())
        .shape(ShapeDescription::sphere(0.7).translated([3.0, 0.0, 0.0]).emitting([1.0; 3]), grey())
        .shape(ShapeDescription::sphere(3.5).receiver("air"), MaterialKind::Interface)
        .shape(ShapeDescription::from(cuboid).translated([-3.0, 0.5, 0.0]), grey())
        .shape(patch(), grey());
    let places = [shift(0.0, 3.0, 0.0), shift(0.0, -3.0, 1.0) * turned, shift(0.0, 3.0, 0.0)];
    places.into_iter().fold(builder, |builder, place| builder.instance("outer", place)).resolve().unwrap().0
}

fn rays(count: u64) -> Vec<BoundedRay> {
    let number = |i, k| unit_f64(combine(i, k)) * 10.0 - 5.0;
    let point = |i, k| DVec3::new(number(i, k), number(i, k + 1), number(i, k + 2));
    let ray = |i| {
        let (from, to) = (point(i, 0), 0.6 * point(i, 3));
        // Every second one ends between its points.
        let t_max = if i % 2 == 0 { f64::INFINITY } else { unit_f64(combine(i, 6)) };
        BoundedRay::new(Ray::new(from, to - from), t_max)
    };
    (0..count).map(ray).collect()
}

#[test]
fn batches_give_the_hits_of_single_rays() {
    let (scene, rays) = (scene(), rays(20_000));
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    let (mut met, mut stopped) = (0, 0);
    let mut met_shapes = std::collections::BTreeSet::new();
    for size in [1, 3, 64, 1000, rays.len()] {
        for part in rays.chunks(size).take(3000) {
            scene.closest_batch(part, &mut hits);
            scene.occluded_batch(part, &mut occluded);
            assert_eq!((hits.len(), occluded.len()), (part.len(), part.len()));
            for ((BoundedRay { ray, t_max }, hit), &occluded) in part.iter().zip(&hits).zip(&occluded) {
                let hit = hit.map(|hit| scene.interaction(ray, &hit));
                let single = scene.intersect(ray, *t_max);
                // Printed, all numbers and all fields count.
                assert_eq!(format!("{hit:?}"), format!("{single:?}"));
                assert_eq!(occluded, scene.occluded(ray, *t_max));
                met += usize::from(hit.is_some());
                stopped += usize::from(occluded);
                met_shapes.extend(hit.map(|hit| hit.id));
            }
        }
    }
    assert!(met > 10_000 && stopped > 10_000 && stopped < met, "{met} {stopped}");
    // All but the second of the two spheres in one place.
    assert_eq!(met_shapes.len(), 9, "{met_shapes:?}");
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let scene = scene();
    let away = BoundedRay::from(Ray::new(DVec3::Z * 9.0, DVec3::new(0.1, 0.2, 1.0)));
    let bad = [
        BoundedRay::from(Ray::new(DVec3::NAN, DVec3::X)),
        BoundedRay::from(Ray::new(DVec3::ZERO, DVec3::ZERO)),
        BoundedRay::new(Ray::new(DVec3::ZERO, DVec3::X), 0.0),
        BoundedRay::new(Ray::new(DVec3::ZERO, DVec3::X), f64::NAN),
        away,
    ];
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    scene.closest_batch(&bad, &mut hits);
    scene.occluded_batch(&bad, &mut occluded);
    assert!(hits.iter().all(Option::is_none), "{hits:?}");
    assert_eq!(occluded, [false; 5]);
    scene.closest_batch(&[], &mut hits);
    scene.occluded_batch(&[], &mut occluded);
    assert!(hits.is_empty() && occluded.is_empty());
}
