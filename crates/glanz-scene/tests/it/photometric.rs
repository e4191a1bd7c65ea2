//! Direction and intensity of luminaires in scenes.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_light::{SpectralDistribution, Wavelengths, units};
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Light, LightId, Scene, SceneBuilder, SceneErrorKind};

fn light(
    distribution: IntensityDistribution,
    opening: Option<LuminousOpening>,
    to_world: DMat4,
) -> LightDescription {
    let kind = LightKind::Photometric { distribution: Arc::new(distribution), opening, from: DVec3::ZERO };
    LightDescription { to_world, ..LightDescription::new(kind, [5.0, 3.0, 1.0]) }
}

/// A ball of radius 10 about the origin, and the lights.
fn scene(lights: Vec<LightDescription>) -> Scene {
    let ball = ShapeDescription::sphere(10.0).reversed();
    let builder = SceneBuilder::new().shape(ball, MaterialKind::diffuse(0.5));
    lights.into_iter().fold(builder, SceneBuilder::light).resolve().unwrap().0
}

/// 900 cd at C 0 and gamma 30, linearly less up to 20 degrees of C and 10 of gamma beside it.
fn beam() -> IntensityDistribution {
    let azimuths = [0.0, 20.0, 340.0];
    let polars = vec![20.0, 30.0, 40.0];
    let candela = vec![0.0, 900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, &azimuths, polars, candela).unwrap()
}

/// C 0, gamma 30 in the luminaire's frame.
fn beam_axis() -> DVec3 {
    DVec3::new(0.5, 0.0, -0.75_f64.sqrt())
}

/// Lux on the wall in `direction` from the origin, from the light alone.
fn lux(scene: &Scene, direction: DVec3) -> f64 {
    let wavelengths = Wavelengths::default();
    let at = scene.intersect(&Ray::new(DVec3::ZERO, direction), f64::INFINITY).unwrap();
    match scene.sample_light(LightId(0), &at, DVec2::splat(0.5)) {
        Some(sample) => {
            units::photometric(sample.radiance, &wavelengths) * sample.wi.dot(at.point.normal).abs()
        }
        None => 0.0,
    }
}

#[test]
fn the_beam_goes_where_the_frame_is_turned() {
    let y = DMat4::from_rotation_y(FRAC_PI_2);
    let z = DMat4::from_rotation_z(FRAC_PI_2);
    let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let DVec3 { x: s, z: c, .. } = beam_axis();
    for (to_world, expected) in [
        (DMat4::IDENTITY, DVec3::new(s, 0.0, c)),
        // x goes to -z and z to x; x goes to y.
        (y, DVec3::new(c, 0.0, -s)),
        (z, DVec3::new(0.0, s, c)),
        (z * y, DVec3::new(0.0, c, -s)),
        (mirror, DVec3::new(-s, 0.0, c)),
        (DMat4::from_scale(DVec3::splat(3.0)), DVec3::new(s, 0.0, c)),
    ] {
        let scene = scene(vec![light(beam(), None, to_world)]);
        // 900 cd at 10 m.
        assert!((lux(&scene, expected) / 9.0 - 1.0).abs() < 1e-5, "{expected}: {}", lux(&scene, expected));
        for dark in [-expected, DVec3::new(-s, 0.0, c), DVec3::new(0.0, s, c), DVec3::new(c, 0.0, -s)] {
            if dark.dot(expected) < 0.99 {
                assert_eq!(lux(&scene, dark), 0.0, "{expected} {dark}");
            }
        }
        // Its rays stay within the beam, too.
        let mut mean = DVec3::ZERO;
        for i in 0..1000_u32 {
            let xi = DVec2::new(f64::from(i) / 1000.0, (f64::from(i) * 0.618).fract());
            let ray = scene.emit(LightId(0), DVec2::ZERO, xi).unwrap().ray;
            assert!(ray.origin == DVec3::ZERO && ray.direction.dot(expected) > 0.97);
            mean += ray.direction / 1000.0;
        }
        assert!(mean.normalize().dot(expected) > 0.9999, "{mean} {expected}");
    }
}

#[test]
fn the_color_has_no_influence_on_lumens_and_scale_has() {
    let distribution = beam();
    let flux = distribution.flux();
    let description = LightDescription { scale: 0.5, ..light(distribution, None, DMat4::IDENTITY) };
    let scene = scene(vec![description]);
    let Light::Photometric(light) = &scene.lights()[0] else { unreachable!() };
    let lumens = units::photometric(light.power(), &Wavelengths::default());
    assert!((lumens / (0.5 * flux) - 1.0).abs() < 1e-5, "{lumens} {flux}");
    let [r, g, b] = light.power().to_rgb(&Wavelengths::default());
    assert!((r / b - 5.0).abs() < 1e-5 && (g / b - 3.0).abs() < 1e-5);
}

#[test]
fn incident_light_is_known_of_points_only() {
    let disk = LuminousOpening { shape: OpeningShape::Ellipse, size: [0.2, 0.2, 0.0] };
    let up = DMat4::from_translation(DVec3::new(0.0, 0.0, 5.0));
    let scene = scene(vec![light(beam(), None, up), light(beam(), Some(disk), up)]);
    let incident = scene.lights()[0].incident(DVec3::new(0.0, 0.0, 5.0) + 2.0 * beam_axis()).unwrap();
    // 900 cd at 2 m.
    let lux = units::photometric(incident.irradiance, &Wavelengths::default());
    assert!((lux / 225.0 - 1.0).abs() < 1e-5, "{lux}");
    assert!((incident.distance - 2.0).abs() < 1e-12 && (incident.towards + beam_axis()).length() < 1e-12);
    assert!(scene.lights()[1].incident(DVec3::ZERO).is_none());
}

#[test]
fn points_of_an_opening_scale_with_the_frame() {
    let disk = LuminousOpening { shape: OpeningShape::Ellipse, size: [0.2, 0.2, 0.0] };
    let to_world = DMat4::from_rotation_x(FRAC_PI_2) * DMat4::from_scale(DVec3::splat(10.0));
    let scene = scene(vec![light(beam(), Some(disk), to_world)]);
    let light = &scene.lights()[0];
    assert!(!light.is_delta());
    let mut reach = 0.0_f64;
    for i in 0..1000_u32 {
        let xi = DVec2::new((f64::from(i) + 0.5) / 1000.0, (f64::from(i) * 0.618).fract());
        let origin = scene.emit(LightId(0), xi, DVec2::splat(0.3)).unwrap().ray.origin;
        // z goes to -y.
        assert!(origin.y.abs() < 1e-12 && origin.length() <= 1.0);
        reach = reach.max(origin.length());
    }
    assert!(reach > 0.99);
}

#[test]
fn rays_are_emitted_by_flux_and_cannot_be_sampled() {
    let ray = |x: f32, lumens: f32| SourceRay { origin: [x, 0.0, 0.0], direction: [0.0, 0.0, 1.0], lumens };
    let rays = Arc::new([ray(0.0, 1.0), ray(1.0, 0.0), ray(2.0, 3.0)]);
    // z goes to -y, lengths are doubled.
    let to_world = DMat4::from_rotation_x(FRAC_PI_2) * DMat4::from_scale(DVec3::splat(2.0));
    let description =
        LightDescription { kind: LightKind::Rays { rays, from: DVec3::Z }, ..light(beam(), None, to_world) };
    let scene = scene(vec![description]);
    let mut found = [0_u32; 2];
    for i in 0..400_u32 {
        let sent = scene.emit(LightId(0), DVec2::splat((f64::from(i) + 0.5) / 400.0), DVec2::ZERO).unwrap();
        assert!((sent.ray.direction + DVec3::Y).length() < 1e-12);
        let lumens = units::photometric(sent.power, &Wavelengths::default());
        assert!((lumens - 4.0).abs() < 1e-5);
        let origin = sent.ray.origin + 2.0 * DVec3::Y;
        found[usize::from(origin.x > 1.0)] += 1;
        assert!(origin.length() < 1e-12 || (origin - 4.0 * DVec3::X).length() < 1e-12, "{origin}");
    }
    assert_eq!(found, [100, 300]);
    assert_eq!(scene.select_emitter(0.5), Some((LightId(0), 1.0)));
    let at = scene.intersect(&Ray::new(DVec3::ZERO, DVec3::X), f64::INFINITY).unwrap();
    assert_eq!(scene.select_light(&at.light_sample_context(), 0.5), None);
    assert!(scene.sample_light(LightId(0), &at, DVec2::splat(0.5)).is_none());
}

#[test]
fn invalid_luminaires_are_refused() {
    let uneven = light(beam(), None, DMat4::from_scale(DVec3::new(1.0, 1.0, 1.01)));
    let black = LightDescription {
        emission: SpectralDistribution::Constant(0.0),
        ..light(beam(), None, DMat4::IDENTITY)
    };
    let negative = LightDescription { scale: -1.0, ..light(beam(), None, DMat4::IDENTITY) };
    for (light, expected) in [(uneven, "transformation"), (black, "colour"), (negative, "emission")] {
        match SceneBuilder::new().light(light).resolve().unwrap_err().kind {
            SceneErrorKind::Range { what, .. } => assert!(what.ends_with(expected), "{what}"),
            other => unreachable!("{other}"),
        }
    }
}
