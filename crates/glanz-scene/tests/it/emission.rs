//! Power that light rays bring to a surface, against light samples from the surface.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Light, LightId, LightSample, Scene, SceneBuilder};

/// Roots of x^5 = x + 1: steps of a sequence that fills four dimensions evenly.
const STEP: f64 = 1.167_303_978_261_418_7;

const COUNT: u32 = 100_000;

/// Two pairs of numbers in [0, 1).
fn point(i: u32) -> [DVec2; 2] {
    let x = |d: i32| (0.5 + f64::from(i) * STEP.powi(-d)).fract();
    [DVec2::new(x(1), x(2)), DVec2::new(x(3), x(4))]
}

fn bright(light: Spectrum) -> f64 {
    f64::from(light.mean(&Wavelengths::default()))
}

fn shining(shape: ShapeDescription, two_sided: bool, to_world: DMat4) -> ShapeDescription {
    shape.emitting(EmissionDescription { two_sided, ..2.0.into() }).transformed(to_world)
}

/// A unit square at z = 0 that faces up, a screen that hides a part of it, and a light.
fn scene(lamp: Option<ShapeDescription>, light: Option<(LightKind, DMat4)>) -> Scene {
    scene_builder(lamp, light).resolve().unwrap().0
}

fn scene_builder(lamp: Option<ShapeDescription>, light: Option<(LightKind, DMat4)>) -> SceneBuilder {
    let square = |corner: [f64; 3], side: f64| {
        ShapeDescription::parallelogram(corner, DVec3::X * side, DVec3::Y * side)
    };
    let shapes = [square([0.0; 3], 1.0), square([0.6, 0.5, 0.4], 0.3)].into_iter().chain(lamp);
    let builder = SceneBuilder::new().shapes(shapes, MaterialKind::diffuse(0.0));
    let light =
        light.map(|(kind, to_world)| LightDescription { to_world, ..LightDescription::new(kind, 3.0) });
    light.into_iter().fold(builder, SceneBuilder::light)
}

/// A luminaire with different light in every plane, some of it upwards.
fn luminaire(opening: Option<LuminousOpening>) -> LightKind {
    let azimuths = [0.0, 50.0, 90.0, 200.0, 300.0];
    let polars = vec![0.0, 15.0, 40.0, 80.0, 130.0, 180.0];
    let candela: Vec<f64> = (0..30).map(|i| f64::from((i * 7) % 11) * 300.0).collect();
    let distribution =
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, &azimuths, polars, candela).unwrap();
    LightKind::Photometric { distribution: Arc::new(distribution), opening, from: DVec3::ZERO }
}

/// Power of all rays, and of those that meet the square from above.
fn sent(scene: &Scene) -> (f64, f64) {
    let (mut all, mut met) = (0.0, 0.0);
    for i in 0..COUNT {
        let [place, direction] = point(i);
        let Some(light) = scene.emit(LightId(0), place, direction) else { continue };
        all += bright(light.power);
        assert!(light.ray.direction.is_normalized());
        if let Some(hit) = scene.intersect(&light.ray, f64::INFINITY)
            && hit.point.position.z.abs() < 1e-9
            && light.ray.direction.z < 0.0
        {
            met += bright(light.power) * f64::from(light.range.attenuation(hit.t));
        }
    }
    (all / f64::from(COUNT), met / f64::from(COUNT))
}

/// The same by light samples from the square.
fn received(scene: &Scene) -> f64 {
    let mut sum = 0.0;
    for i in 0..COUNT {
        let [place, xi] = point(i);
        let ray = Ray::new(DVec3::new(place.x, place.y, 1e-3), -DVec3::Z);
        let from = scene.intersect(&ray, f64::INFINITY).unwrap();
        let Some(sample) = scene.sample_light(LightId(0), &from, xi) else {
            continue;
        };
        if sample.wi.z > 0.0 && !scene.occluded(&sample.shadow, sample.t_max) {
            sum += bright(sample.radiance) * sample.wi.z / sample.pdf.0;
        }
    }
    sum / f64::from(COUNT)
}

/// A scene with a picture of uneven light with a dark part, turned and mirrored.
fn pictured(kind: LightKind, width: u32, height: u32) -> Scene {
    let pixels = crate::image_light::uneven(width, height);
    let to_world = DMat4::from_rotation_x(0.7) * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    crate::image_light::with_picture(scene_builder(None, Some((kind, to_world))), pixels)
}

/// Lights by name, and whether their power is known.
fn cases() -> Vec<(&'static str, Scene, bool)> {
    let (disk, ball) = (ShapeDescription::disk(0.4), ShapeDescription::sphere(0.2));
    let up = DMat4::from_translation(DVec3::new(0.4, 0.5, 0.9));
    let down = up * DMat4::from_rotation_x(2.6);
    let spot = |falloff| LightKind::Spot {
        from: DVec3::new(0.2, 0.3, 0.9),
        to: DVec3::new(0.6, 0.5, 0.0),
        cone_angle: 0.7,
        inner_angle: 0.3,
        falloff,
    };
    let point_light = |range| LightKind::Point { from: DVec3::new(0.3, 0.4, 0.7), range };
    let distant = LightKind::Distant { from: DVec3::new(0.3, -0.2, 1.0), to: DVec3::ZERO };
    let sun = LightKind::Sun { from: DVec3::new(0.3, -0.2, 1.0), to: DVec3::ZERO, angular_radius: 0.4 };
    let sky = LightKind::Sky(SkyDescription {
        towards_sun: DVec3::new(0.3, -0.2, 0.4),
        turbidity: 4.0,
        albedo: [0.3, 0.2, 0.1],
        is_ground_sunlit: true,
    });
    let overcast = LightKind::OvercastSky { albedo: [0.3, 0.2, 0.1] };
    let turned = DMat4::from_translation(DVec3::new(0.5, 0.3, 0.8))
        * DMat4::from_rotation_x(0.4)
        * DMat4::from_rotation_z(1.0);
    let opening = LuminousOpening { shape: OpeningShape::Rectangle, size: [0.5, 0.2, 0.0] };
    let of_sphere = |mapping| LightKind::ImageInfinite { image: 0, mapping };
    let with_image = |shape: ShapeDescription| {
        let emission = EmissionDescription { image: Some(0), ..shape.emission.clone().unwrap() };
        let pixels = crate::image_light::uneven(8, 12);
        crate::image_light::with_picture(scene_builder(Some(shape.emitting(emission)), None), pixels)
    };
    let above = |kind, turn: f64| {
        let kind = LightDescription {
            to_world: DMat4::from_translation(DVec3::new(0.4, 0.5, 0.8)) * DMat4::from_rotation_x(turn),
            ..LightDescription::new(kind, 3.0)
        };
        let pixels = crate::image_light::uneven(16, 12);
        crate::image_light::with_picture(scene_builder(None, None).light(kind), pixels)
    };
    let projection = LightKind::Projection { image: 0, field_of_view: 1.2 };
    let of_point = |mapping| LightKind::Goniometric { image: 0, mapping };
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.8);
    let portal = |image| LightKind::PortalInfinite {
        image,
        portal: [corner(0.1, 0.2), corner(0.1, 0.7), corner(0.6, 0.7), corner(0.6, 0.2)],
    };
    vec![
        ("point", scene(None, Some((point_light(None), DMat4::IDENTITY))), true),
        ("fading point", scene(None, Some((point_light(Some(1.0)), DMat4::IDENTITY))), true),
        ("quartic spot", scene(None, Some((spot(SpotFalloff::Quartic), DMat4::IDENTITY))), true),
        ("smooth spot", scene(None, Some((spot(SpotFalloff::Smoothstep), DMat4::IDENTITY))), true),
        ("luminaire as a point", scene(None, Some((luminaire(None), turned))), true),
        ("luminaire as an area", scene(None, Some((luminaire(Some(opening)), turned))), true),
        ("distant", scene(None, Some((distant, DMat4::IDENTITY))), false),
        ("sun", scene(None, Some((sun, DMat4::IDENTITY))), false),
        ("infinite", scene(None, Some((LightKind::Infinite, DMat4::IDENTITY))), false),
        ("picture by latitude", pictured(of_sphere(SphereMapping::LatitudeLongitude), 24, 12), false),
        ("equal-area picture", pictured(of_sphere(SphereMapping::EqualArea), 16, 16), false),
        ("sky", scene(None, Some((sky, DMat4::IDENTITY))), false),
        ("overcast sky", scene(None, Some((overcast, DMat4::IDENTITY))), false),
        ("portal", scene(None, Some((portal(None), DMat4::IDENTITY))), false),
        (
            "picture behind a portal",
            pictured(portal(Some((0, SphereMapping::LatitudeLongitude))), 24, 12),
            false,
        ),
        ("projected picture", above(projection, 2.9), true),
        ("goniometric picture", above(of_point(SphereMapping::EqualArea), 0.3), true),
        ("goniometric picture by latitude", above(of_point(SphereMapping::LatitudeLongitude), 0.3), true),
        ("disk", scene(Some(shining(disk.clone(), false, down)), None), true),
        ("disk of two sides", scene(Some(shining(disk.clone(), true, down)), None), true),
        ("disk with a picture", with_image(shining(disk.clone(), true, down)), true),
        ("sphere with a picture", with_image(shining(ball.clone(), false, up)), true),
        ("sphere", scene(Some(shining(ball, false, up)), None), true),
    ]
}

#[test]
fn power_of_light_rays_equals_that_of_light_samples() {
    for (name, scene, has_power) in cases() {
        let ((all, met), expected) = (sent(&scene), received(&scene));
        assert!(expected > 0.01, "{name}: nothing to compare");
        // Samples of a surface do not follow its picture.
        let tolerance = if name.contains("with a picture") { 0.02 } else { 0.005 };
        assert!((met / expected - 1.0).abs() < tolerance, "{name}: {met} {expected}");
        let power = match scene.light(LightId(0)).unwrap() {
            Light::Point(light) => bright(light.power()),
            Light::Spot(light) => bright(light.power()),
            Light::Photometric(light) => bright(light.power()),
            Light::Projection(light) => bright(light.power()),
            Light::Goniometric(light) => bright(light.power()),
            Light::Area(light) => bright(light.power()),
            _ => continue,
        };
        assert!(has_power && (all / power - 1.0).abs() < 0.005, "{name}: {all} {power}");
    }
}

/// Two integrals over the square and the directions from which it sees the light, by rays of the light: of the cosine,
/// and of the cosine times the density of light sampling; for a delta light, twice that of the cosine over the square.
fn extent_sent(scene: &Scene) -> [f64; 2] {
    let (mut all, mut sampled) = (0.0, 0.0);
    for i in 0..COUNT {
        let [place, direction] = point(i);
        let Some(light) = scene.emit(LightId(0), place, direction) else { continue };
        let towards = -light.ray.direction;
        let Some(hit) = scene.intersect(&light.ray, f64::INFINITY) else { continue };
        let arrives = towards.z > 0.0 && light.range.attenuation(hit.t) > 0.0;
        if hit.point.position.z.abs() > 1e-9 || !arrives {
            continue;
        }
        // What the square sees there is the place on the light.
        let seen = scene.intersect(&hit.spawn(towards), f64::INFINITY);
        let area_pdf = seen.filter(|seen| seen.light().is_some()).and_then(|seen| seen.area_pdf());
        let pdf = scene.emission_pdf(LightId(0), hit.point.position, towards, area_pdf);
        assert!(pdf > 0.0);
        all += 1.0 / pdf;
        sampled += scene.light_pdf_of_ray(LightId(0), &hit.light_sample_context(), &light).0 / pdf;
    }
    [all, sampled].map(|sum| sum / f64::from(COUNT))
}

/// The same by light samples from the square; the density is that of samples that are combined with others.
fn extent_found(scene: &Scene) -> [f64; 2] {
    let (mut all, mut sampled) = (0.0, 0.0);
    for i in 0..COUNT {
        let [place, xi] = point(i);
        let ray = Ray::new(DVec3::new(place.x, place.y, 1e-3), -DVec3::Z);
        let from = scene.intersect(&ray, f64::INFINITY).unwrap();
        let arrives = |sample: &LightSample| {
            let pdf = scene.emission_pdf(LightId(0), from.point.position, sample.wi, sample.area_pdf);
            let is_free = sample.wi.z > 0.0 && !scene.occluded(&sample.shadow, sample.t_max);
            assert!(pdf > 0.0 || !is_free);
            is_free
        };
        if let Some(sample) = scene.sample_light(LightId(0), &from, xi).filter(arrives) {
            all += sample.wi.z / sample.pdf.0;
        }
        if let Some(sample) = scene.sample_light_compensated(LightId(0), &from, xi).filter(arrives) {
            sampled += sample.wi.z;
        }
    }
    [all, sampled].map(|sum| sum / f64::from(COUNT))
}

#[test]
fn rays_of_a_sphere_leave_it_wherever_it_stands() {
    let turned = DMat4::from_rotation_x(0.4) * DMat4::from_rotation_z(1.0);
    let at = DMat4::from_translation;
    let far = DVec3::new(1000.0, 300.0, 70.0);
    let back = at(DVec3::new(0.4, 0.5, 0.9)) * turned * at(-far);
    let ball = |to_world| shining(ShapeDescription::sphere(0.1), false, to_world);
    let alone = |to_world| SceneBuilder::new().shape(ball(to_world), MaterialKind::diffuse(0.0));
    let scenes = [
        alone(DMat4::IDENTITY),
        alone(at(far) * turned * DMat4::from_scale(DVec3::splat(3.0))),
        alone(turned * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * at(1e6 * DVec3::ONE)),
        SceneBuilder::new()
            .group("lamp", |group| group.shape(ball(at(far)), MaterialKind::diffuse(0.0)))
            .instance("lamp", back),
    ];
    for (number, scene) in scenes.into_iter().enumerate() {
        let scene = scene.resolve().unwrap().0;
        for i in 0..10_000 {
            let [place, direction] = point(i);
            let light = scene.emit(LightId(0), place, direction).unwrap();
            assert!(scene.intersect(&light.ray, f64::INFINITY).is_none(), "scene {number}: {:?}", light.ray);
        }
    }
}

#[test]
fn emission_pdf_is_the_density_of_emitted_rays() {
    // A luminaire with a size has the density of one at its centre, an approximation good enough for weights. From some places all
    // that a portal shows of the picture is dark, and their few samples have large weights.
    let others = ["luminaire as an area", "picture behind a portal"];
    let exact = cases().into_iter().filter(|(name, ..)| !others.contains(name));
    for (name, scene, _) in exact {
        let (sent, found) = (extent_sent(&scene), extent_found(&scene));
        // Few samples are in the dark parts of pictures, of which the first integral tells the extent.
        for i in usize::from(name.contains("picture"))..2 {
            let tolerance = if name.contains("picture") { 0.04 } else { 0.01 };
            assert!((sent[i] / found[i] - 1.0).abs() < tolerance, "{name}: {sent:?} {found:?}");
        }
    }
}

#[test]
fn infinite_planes_occlude_infinitely_far_lights() {
    let ball = ShapeDescription::sphere(1.0);
    let below = ShapeDescription::plane().translated([0.0, 0.0, -100.0]);
    let builder = SceneBuilder::new().shapes([ball, below], MaterialKind::diffuse(0.5));
    let scene = builder.light(LightDescription::infinite(1.0)).resolve().unwrap().0;
    let rays: Vec<_> = (0..1000)
        .filter_map(|i| {
            let [place, direction] = point(i);
            scene.emit(LightId(0), place, direction)
        })
        .collect();
    assert!(rays.iter().all(|light| light.ray.direction.z <= 0.0));
    assert!(rays.len() > 450 && rays.len() < 550, "half of all: {}", rays.len());
    // A distant point of the plane gets none, since rays start near the ball.
    let far = DVec3::new(50.0, 0.0, -100.0);
    assert_eq!(scene.emission_pdf(LightId(0), far, DVec3::Z, None), 0.0);
    assert!(scene.emission_pdf(LightId(0), DVec3::new(0.0, 0.0, -100.0), DVec3::Z, None) > 0.0);
}

#[test]
fn rays_from_far_away_fill_the_sphere_around_the_scene() {
    let scene = scene(None, Some((LightKind::Infinite, DMat4::IDENTITY)));
    let radius = 1.001 * 0.5 * scene.bounds().diagonal().length();
    let (all, _) = sent(&scene);
    // A sphere in even light of radiance 3 gets pi times that on its 4 pi r^2.
    assert!((all / (4.0 * PI * PI * radius * radius * 3.0) - 1.0).abs() < 1e-5);
}

#[test]
fn unknown_lights_emit_nothing() {
    let scene = scene(None, Some((LightKind::Infinite, DMat4::IDENTITY)));
    assert!(scene.emit(LightId(1), DVec2::ZERO, DVec2::ZERO).is_none());
}
