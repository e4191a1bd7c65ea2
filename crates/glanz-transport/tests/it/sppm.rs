//! Photons: closed forms of caustics behind glass and mirrors, and the pictures of other integrators where these find the light.
//!
//! Seeds are fixed. Photons are common to all pixels, so that the errors of pixels are not independent: pixels are compared one by one, and averages by a stated bound.

use std::f64::consts::PI;

use crate::common::*;
use crate::light::{assert_pixels, plane_picture};
use glanz_math::DVec3;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;

/// `run` with `count` photon paths per sample.
fn with_photons(radius: f64, count: u32, run: Run) -> Run {
    Run { photons: PhotonSettings { radius: Some(radius), count: Some(count) }, ..run }
}

/// Fresnel reflectance of a dielectric of relative index `n` under the angle of incidence `t`, unpolarised.
fn fresnel(t: f64, n: f64) -> f64 {
    let inside = (t.sin() / n).asin();
    let (s, p) = (
        (t.cos() - n * inside.cos()) / (t.cos() + n * inside.cos()),
        (n * t.cos() - inside.cos()) / (n * t.cos() + inside.cos()),
    );
    (s * s + p * p) / 2.0
}

/// Reflectance of the floor under the pane.
const RHO: f32 = 0.6;

/// Fails unless the floor of `add_floor`, of the reflectance [`RHO`] in a share of all hits and dark in others, is seen through a glass pane under a lamp by its closed form.
fn assert_floor_under_pane(share: f64, name: &str, add_floor: impl FnOnce(SceneBuilder) -> SceneBuilder) {
    let (intensity, n) = (3.0_f32, 1.5);
    let (above, thickness, below) = (0.7, 0.4, 0.9);
    let top = below + thickness;
    let pane = ShapeDescription::cuboid(DVec3::new(-30.0, -30.0, below), DVec3::new(30.0, 30.0, top));
    // Vertical rays, which the pane does not shift.
    let scene = looking(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, [6, 5], 1.0)
        .edit(|scene| scene.camera.kind = CameraKind::Orthographic);
    let scene = add_floor(scene)
        .shape(pane, glass())
        .light(LightDescription::point(DVec3::new(0.2, 0.0, top + above), [intensity; 3]));
    // A ray under the angle t arrives at the distance r(t); the flux 2 pi I sin t dt, less what both sides reflect, falls on the ring 2 pi r dr.
    // Five events, the pane on both ways and the floor, leave no light for further reflections.
    let reach = |t: f64| (above + below) * t.tan() + thickness * (t.sin() / n).asin().tan();
    let irradiance = |r: f64| {
        let (mut low, mut high) = (0.0, 1.57);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if reach(middle) < r { low = middle } else { high = middle }
        }
        let slope = (reach(low + 1e-5) - reach(low - 1e-5)) / 2e-5;
        f64::from(intensity) * low.sin() / (r * slope) * (1.0 - fresnel(low, n)).powi(2)
    };
    let seen = share * f64::from(RHO) / PI * (1.0 - fresnel(0.0, n)).powi(2);
    let expected = plane_picture(&scene, 0.0, |x, y| seen * irradiance((x - 0.2).hypot(y)));
    let run = with_photons(0.3, 2048, Run::new("sppm", 5, (1600.0 / (share * share)) as u32));
    assert_pixels(&run.picture(&scene), &expected, name);
    let chance = Run::new("path", 5, 16).picture(&scene);
    assert!(chance.mean[0].iter().all(|&mean| mean == 0.0), "a path from the camera met a point");
}

#[test]
fn floor_under_a_glass_pane_is_seen_through_it_by_its_closed_form() {
    let floor = || ShapeDescription::disk(2.1);
    assert_floor_under_pane(1.0, "diffuse", |scene| scene.shape(floor(), diffuse(RHO)));
    // The selection of a part of a mixture, and the opacity, count once.
    assert_floor_under_pane(0.5, "half a mirror", |scene| {
        let parts = scene.material("matte", diffuse(RHO)).material("mirror", MaterialKind::mirror(1.0));
        parts.shape(floor(), MaterialKind::mix([0, 1], 0.5))
    });
    assert_floor_under_pane(0.5, "half open", |scene| {
        scene.shape(floor().with_alpha(FloatParameter::Value(0.5)), diffuse(RHO))
    });
}

#[test]
fn floor_lit_by_a_mirror_is_seen_in_it_by_its_closed_form() {
    let (rho, reflectance, intensity, h, ceiling) = (0.5_f32, 0.8_f32, 3.0_f32, 1.0, 1.5);
    let scene = looking(DVec3::new(-2.0, 0.2, 0.6), DVec3::new(0.0, 0.0, 2.0 * ceiling), [6, 5], 0.5)
        .shape(ShapeDescription::disk(2.0), diffuse(rho))
        .shape(
            ShapeDescription::disk(200.0).translated([0.0, 0.0, ceiling]),
            MaterialKind::mirror(reflectance),
        )
        .light(LightDescription::point(DVec3::new(0.0, 0.0, h), [intensity; 3]));
    // I h / d^3 of the lamp and of its image; the image of the floor is twice as high as the mirror. Depth 3: mirror, floor, mirror.
    let lit = |height: f64, x: f64, y: f64| {
        f64::from(intensity) * height / (height * height + x * x + y * y).powf(1.5)
    };
    let mirrored = f64::from(reflectance);
    let expected = plane_picture(&scene, 2.0 * ceiling, |x, y| {
        let irradiance = lit(h, x, y) + mirrored * lit(2.0 * ceiling - h, x, y);
        mirrored * f64::from(rho) / PI * irradiance
    });
    let run = with_photons(0.06, 8192, Run::new("sppm", 3, 400));
    assert_pixels(&run.picture(&scene), &expected, "mirror");
}

/// A lamp over a glass ball over a floor; `seen`: what the camera looks through.
fn ball(seen: impl FnOnce(SceneBuilder) -> SceneBuilder) -> SceneBuilder {
    let lamp = ShapeDescription::sphere(0.3).translated([0.3, 0.0, 3.0]);
    let scene = looking(DVec3::new(-1.5, 0.0, 0.7), DVec3::ZERO, [10, 10], 0.5)
        .shape(ShapeDescription::disk(3.0), diffuse(0.6))
        .shape(ShapeDescription::sphere(0.4).translated([0.0, 0.0, 1.0]), glass())
        .shape(lamp.emitting([25.0, 20.0, 15.0]), diffuse(0.0));
    seen(scene)
}

/// A glass pane before the camera.
fn pane(scene: SceneBuilder) -> SceneBuilder {
    let pane = ShapeDescription::cuboid(DVec3::new(-1.1, -2.0, 0.1), DVec3::new(-1.0, 2.0, 2.0));
    scene.shape(pane, glass())
}

/// Fails unless the averages of two pictures differ by less than 3 %, three times the error of either, and pixels by their errors.
fn assert_alike(a: &Picture, b: &Picture, name: &str) {
    for band in 0..3 {
        let ((a, _), (b, _)) = (a.average(band), b.average(band));
        assert!((a - b).abs() < 0.03 * a, "{name}: averages {a} and {b}");
    }
    let spread = pooled_square(a, b);
    println!("{name}: {spread:.2}, averages {:?} {:?}", a.average(1), b.average(1));
    assert!(spread < 1.4, "{name}: {spread}");
}

#[test]
fn glass_seen_through_glass_throws_the_light_that_path_finds_by_chance() {
    let scene = ball(pane);
    let path = Run { seed: 5, ..Run::new("path", 8, 8000) }.picture(&scene);
    let sppm = with_photons(0.03, 8192, Run { seed: 6, ..Run::new("sppm", 8, 500) }).picture(&scene);
    assert_alike(&path, &sppm, "glass through glass");
}

#[test]
fn caustics_and_their_indirect_light_are_those_of_paths_from_lights() {
    let scene = ball(|scene| {
        scene
            .shape(rectangle(DVec3::new(0.5, -2.0, 0.0), DVec3::Z * 2.0, DVec3::Y * 4.0), diffuse(0.5))
            .light(LightDescription::point(DVec3::new(0.2, 0.1, 2.0), [2.0; 3]))
    });
    let light = Run { seed: 5, ..Run::new("light", 6, 3000) }.picture(&scene);
    let sppm = with_photons(0.012, 8192, Run { seed: 6, ..Run::new("sppm", 6, 500) }).picture(&scene);
    assert_alike(&light, &sppm, "caustic");
}

#[test]
fn light_of_a_sky_through_glass_is_counted_once() {
    // Hit by chance nearly as often as by photons: the weights of both matter.
    let scene = looking(DVec3::new(-1.5, 0.0, 0.7), DVec3::ZERO, [10, 10], 0.5)
        .shape(ShapeDescription::disk(3.0), diffuse(0.6))
        .shape(ShapeDescription::sphere(0.4).translated([0.0, 0.0, 0.5]), glass());
    let scene = under_picture(scene, SphereMapping::LatitudeLongitude, [16, 8]);
    let path = Run { seed: 5, ..Run::new("path", 6, 4000) }.picture(&scene);
    for (count, radius) in [(300, 0.02), (5000, 0.06)] {
        let sppm = with_photons(radius, count, Run { seed: 6, ..Run::new("sppm", 6, 500) }).picture(&scene);
        assert_alike(&path, &sppm, "sky");
    }
}
