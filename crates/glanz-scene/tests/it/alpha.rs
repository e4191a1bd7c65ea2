//! Surfaces that are there only in part.

use glanz_geometry::BoundedRay;
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

const COUNT: u32 = 20_000;

fn grey() -> MaterialKind {
    MaterialKind::diffuse(0.5)
}

fn scene_of(shape: ShapeDescription) -> Scene {
    SceneBuilder::new().shape(shape, grey()).resolve().unwrap().0
}

/// Rays downwards, some of them oblique, to the square of half width `half` in the plane z = 0.
fn rays(half: f64) -> impl Iterator<Item = Ray> {
    let number = |i: u32, k| 2.0 * unit_f64(combine(u64::from(i), k)) - 1.0;
    (0..COUNT).map(move |i| {
        let to = half * DVec3::new(number(i, 0), number(i, 1), 0.0);
        let from = DVec3::new(0.3 * number(i, 2), 0.3 * number(i, 3), 5.0);
        Ray::new(from, to - from)
    })
}

/// Fails if a count differs from `COUNT` times a probability by more than four standard deviations.
fn assert_fraction(count: u32, probability: f64, what: &str) {
    let n = f64::from(COUNT);
    let deviation = (n * probability * (1.0 - probability)).sqrt();
    assert!((f64::from(count) - n * probability).abs() <= 4.0 * deviation, "{what}: {count} of {COUNT}");
}

#[test]
fn opacity_is_the_probability_of_a_hit_and_a_ray_meets_the_same_again() {
    let scene = scene_of(ShapeDescription::disk(3.0).with_alpha(FloatParameter::Value(0.3)));
    let (mut met, mut stopped) = (0, 0);
    for ray in rays(1.0) {
        let hit = scene.intersect(&ray, f64::INFINITY).is_some();
        assert_eq!(hit, scene.occluded(&ray, f64::INFINITY));
        assert_eq!(hit, scene.intersect(&ray, 1.5).is_some());
        met += u32::from(hit);
        stopped += u32::from(scene.occluded(&Ray::new(ray.origin, 1.5 * ray.direction), f64::INFINITY));
    }
    assert_fraction(met, 0.3, "hits");
    assert_fraction(stopped, 0.3, "hits of longer rays");
}

#[test]
fn rays_that_pass_the_front_may_hit_the_back() {
    let scene = scene_of(ShapeDescription::sphere(2.0).with_alpha(FloatParameter::Value(0.5)));
    let (mut front, mut back) = (0, 0);
    for ray in rays(0.5) {
        match scene.intersect(&ray, f64::INFINITY) {
            Some(hit) if hit.point.normal.dot(ray.direction) < 0.0 => front += 1,
            Some(_) => back += 1,
            None => {}
        }
    }
    assert_fraction(front, 0.5, "front");
    assert_fraction(back, 0.25, "back");
}

#[test]
fn surfaces_one_behind_the_other_stop_rays_independently() {
    let half = FloatParameter::Value(0.5);
    let square = || ShapeDescription::rectangle([-2.0, 2.0], [-2.0, 2.0]).with_alpha(half);
    // Rays along z meet all squares at the same parameters, and rays from the centre the spheres.
    let squares =
        SceneBuilder::new().shape(square(), grey()).shape(square().translated([0.0, 0.0, 1.0]), grey());
    let nested = SceneBuilder::new()
        .group("low", |group| group.shape(square(), grey()))
        .group("high", |group| group.shape(square().translated([0.0, 0.0, 1.0]), grey()))
        .instance("low", DMat4::IDENTITY)
        .instance("high", DMat4::IDENTITY);
    let ball = |radius| ShapeDescription::sphere(radius).with_alpha(half);
    let balls = SceneBuilder::new().shape(ball(1.0), grey()).shape(ball(2.0), grey());
    let parallel: fn(Ray) -> Ray = |ray| Ray::new(ray.at(1.0) + 5.0 * DVec3::Z, -DVec3::Z);
    let central: fn(Ray) -> Ray = |ray| Ray::new(DVec3::ZERO, ray.direction);
    let same: fn(Ray) -> Ray = |ray| ray;
    let cases = [
        ("squares", squares, parallel),
        ("squares of groups", nested, parallel),
        ("spheres", balls, central),
        ("coincident squares", SceneBuilder::new().shape(square(), grey()).shape(square(), grey()), same),
    ];
    for (what, builder, map) in cases {
        let scene = builder.resolve().unwrap().0;
        let (mut met, mut stopped) = (0, 0);
        for ray in rays(1.0).map(map) {
            met += u32::from(scene.intersect(&ray, f64::INFINITY).is_some());
            stopped += u32::from(scene.occluded(&ray, f64::INFINITY));
        }
        assert_fraction(met, 0.75, what);
        assert_fraction(stopped, 0.75, what);
    }
}

#[test]
fn shadow_rays_have_the_product_of_both_opacities() {
    let alpha = AlphaDescription { opacity: FloatParameter::Value(0.8), shadow: FloatParameter::Value(0.5) };
    let scene = scene_of(ShapeDescription::rectangle([-2.0, 2.0], [-2.0, 2.0]).with_alpha(alpha));
    let (mut met, mut stopped) = (0, 0);
    for ray in rays(1.0) {
        let (hit, occluded) = (scene.intersect(&ray, 2.0).is_some(), scene.occluded(&ray, 2.0));
        assert!(hit || !occluded, "what stops a shadow ray stops others");
        (met, stopped) = (met + u32::from(hit), stopped + u32::from(occluded));
    }
    assert_fraction(met, 0.8, "hits");
    assert_fraction(stopped, 0.4, "shadow rays");
}

#[test]
fn shapes_of_opacity_0_are_missing_and_those_of_1_are_whole() {
    let ball = || ShapeDescription::sphere(1.0);
    let alpha = |shape: ShapeDescription, x| shape.with_alpha(FloatParameter::Value(x));
    let low = || ShapeDescription::disk(5.0).translated([0.0, 0.0, -2.0]);
    let resolve = |builder: SceneBuilder| builder.resolve().unwrap().0;
    let whole = resolve(SceneBuilder::new().shape(low(), grey()).shape(ball(), grey()));
    let opaque = resolve(SceneBuilder::new().shape(low(), grey()).shape(alpha(ball(), 1.0), grey()));
    let missing = resolve(SceneBuilder::new().shape(low(), grey()));
    let absent = resolve(SceneBuilder::new().shape(low(), grey()).shape(alpha(ball(), 0.0), grey()));
    assert_eq!(absent.placed_surfaces().len(), 1);
    assert_eq!(absent.bounds(), missing.bounds());
    for ray in rays(1.5).take(2000) {
        let hit = |scene: &Scene| format!("{:?}", scene.intersect(&ray, f64::INFINITY));
        assert_eq!(hit(&opaque), hit(&whole));
        assert_eq!(hit(&absent), hit(&missing));
    }
}

/// A checkerboard of opacity 0 and 1 in the texture coordinates.
fn with_board(builder: SceneBuilder) -> SceneBuilder {
    builder.edit(|description| {
        let mapping = MappingDescription::Uv { scale: DVec2::new(8.0, 8.0), offset: DVec2::ZERO };
        let kind = TextureKind::Checkerboard { even: 1.0.into(), odd: 0.0.into(), mapping };
        let name = "board".to_owned();
        description.textures.push(TextureDescription { name, kind, location: None });
    })
}

#[test]
fn textures_cut_shapes_out() {
    let board = FloatParameter::Texture(0);
    let mesh = GeometryDescription::Triangles {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.0))
            .to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uvs: Some([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from).to_vec()),
    };
    for shape in [ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]), mesh.into()] {
        let scene =
            with_board(SceneBuilder::new()).shape(shape.with_alpha(board), grey()).resolve().unwrap().0;
        let mut met = 0;
        for ray in rays(0.95) {
            let at = ray.at(1.0);
            let cell = |x: f64| (4.0 * (x + 1.0)).floor();
            let is_even = (cell(at.x) + cell(at.y)).rem_euclid(2.0) == 0.0;
            let hit = scene.intersect(&ray, f64::INFINITY);
            // At the borders of cells rounding decides.
            let inside = |x: f64| (4.0 * (x + 1.0)).fract() * (1.0 - (4.0 * (x + 1.0)).fract()) > 1e-6;
            if inside(at.x) && inside(at.y) {
                assert_eq!(hit.is_some(), is_even, "{at}");
                assert_eq!(scene.occluded(&ray, f64::INFINITY), is_even, "{at}");
            }
            met += u32::from(hit.is_some());
        }
        assert!((COUNT / 3..2 * COUNT / 3).contains(&met), "{met}");
    }
}

#[test]
fn batches_and_instances_decide_as_single_rays() {
    let half = FloatParameter::Value(0.5);
    let corners = [[-1.0, -1.0, 0.2], [1.0, -1.0, 0.0], [1.0, 1.0, 0.3], [-1.0, 1.0, 0.1]];
    let mesh = ShapeDescription::mesh(corners.map(DVec3::from).to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let torus = ShapeDescription::torus(1.0, 0.3).with_alpha(FloatParameter::Texture(0));
    let builder = with_board(SceneBuilder::new())
        .group("pair", |group| group.shape(mesh.with_alpha(half), grey()).shape(torus, grey()))
        .instance("pair", DMat4::from_rotation_x(0.3))
        .instance("pair", DMat4::from_translation(DVec3::Z) * DMat4::from_scale(DVec3::splat(0.7)))
        .shape(ShapeDescription::cuboid([-0.5; 3], [0.5; 3]).with_alpha(half).bounding(1), grey())
        .shape(ShapeDescription::plane().translated([0.0, 0.0, -3.0]).with_alpha(half), grey());
    let scene = builder.resolve().unwrap().0;
    let bounded: Vec<_> = rays(1.5).map(|ray| BoundedRay::new(ray, 3.0)).collect();
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    let mut counts = [0; 5];
    for size in [1, 7, 1000] {
        for part in bounded.chunks(size).take(4000) {
            scene.closest_batch(part, &mut hits);
            scene.occluded_batch(part, &mut occluded);
            for ((BoundedRay { ray, t_max }, hit), &occluded) in part.iter().zip(&hits).zip(&occluded) {
                let hit = hit.map(|hit| scene.interaction(ray, &hit));
                let single = scene.intersect(ray, *t_max);
                assert_eq!(format!("{hit:?}"), format!("{single:?}"));
                assert_eq!(occluded, scene.occluded(ray, *t_max));
                assert_eq!(occluded, hit.is_some());
                hit.iter().for_each(|hit| counts[hit.id as usize] += 1);
            }
        }
    }
    // Every shape is hit; the one with the number 4 does not exist.
    assert!(counts[..4].iter().all(|&count| count > 100) && counts[4] == 0, "{counts:?}");
}

#[test]
fn lights_emit_by_their_opacity_and_invisible_ones_in_full() {
    let floor = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let light = |alpha| {
        let lamp = ShapeDescription::disk(0.5).rotated(DVec3::X, std::f64::consts::PI).emitting(8.0);
        let lamp = lamp.translated([0.0, 0.0, 2.0]).with_alpha(FloatParameter::Value(alpha));
        SceneBuilder::new().shape(floor(), grey()).shape(lamp, grey()).resolve().unwrap().0
    };
    let up = Ray::new(DVec3::new(0.1, 0.1, 1.0), DVec3::Z);
    for (alpha, radiance, is_delta) in [(1.0, 8.0, false), (0.25, 2.0, false), (0.0, 8.0, true)] {
        let scene = light(alpha);
        let from = scene.intersect(&Ray::new(DVec3::new(0.2, 0.1, 1.0), -DVec3::Z), f64::INFINITY).unwrap();
        let id = scene.select_light(&from.light_sample_context(), 0.5).unwrap().id;
        assert_eq!(scene.light(id).unwrap().can_be_hit(), !is_delta);
        let sample = scene.sample_light(id, &from, DVec2::new(0.3, 0.6)).unwrap();
        assert_eq!(sample.radiance, glanz_light::Spectrum::from_rgb([radiance; 3]), "{alpha}");
        assert_eq!(sample.is_delta, is_delta);
        assert!(!scene.occluded(&sample.shadow, sample.t_max));
        let ray = scene.emit(id, DVec2::new(0.3, 0.6), DVec2::new(0.2, 0.7)).unwrap();
        let whole = light(1.0).emit(id, DVec2::new(0.3, 0.6), DVec2::new(0.2, 0.7)).unwrap();
        assert_eq!(ray.power, whole.power * (radiance / 8.0));
        assert!(is_delta != scene.intersect(&up, 2.0).is_some() || alpha == 0.25);
    }
}

#[test]
fn opacities_that_are_not_numbers_are_0() {
    let nan = FloatParameter::Value(f32::NAN);
    let lamp = ShapeDescription::disk(0.5).rotated(DVec3::X, std::f64::consts::PI).emitting(8.0);
    let lamp = lamp.translated([0.0, 0.0, 2.0]).with_alpha(nan);
    let floor = ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let scene = SceneBuilder::new().shape(floor, grey()).shape(lamp, grey()).resolve().unwrap().0;
    assert!(scene.intersect(&Ray::new(DVec3::new(0.1, 0.1, 1.0), DVec3::Z), f64::INFINITY).is_none());
    let from = scene.intersect(&Ray::new(DVec3::new(0.2, 0.1, 1.0), -DVec3::Z), f64::INFINITY).unwrap();
    let id = scene.select_light(&from.light_sample_context(), 0.5).unwrap().id;
    let sample = scene.sample_light(id, &from, DVec2::new(0.3, 0.6)).unwrap();
    assert!(sample.radiance.is_black());
}
