//! Light that is stored on surfaces, looked at.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use glanz_light::Spectrum;
use glanz_math::DVec3;
use glanz_sampling::SamplerKind;
use glanz_scene::ParametricPoint;
use glanz_scene::description::*;
use glanz_transport::StoredLight;

/// Irradiance that grows with the first parameter of surfaces , each side with its own, but for the first.
#[derive(Debug)]
struct Slope;

impl StoredLight for Slope {
    fn irradiance(&self, place: &ParametricPoint) -> Option<Spectrum> {
        let side = if place.back { 2.0 } else { 1.0 };
        (place.surface + place.face > 0).then(|| Spectrum::splat((side * PI * place.uv.x) as f32))
    }
}

/// The first parameter goes along `a`.
fn square(corner: DVec3, a: DVec3, b: DVec3) -> GeometryDescription {
    let positions = vec![corner, corner + a, corner + b, corner + a + b];
    GeometryDescription::Bilinear { positions, indices: vec![[0, 1, 2, 3]] }
}

/// What a camera sees of a 2 m x 2 m square around (2, 0, 0) that faces it with one side and reflects half of the light, at the place
/// `y` metres from its middle; `first`: another shape before it, which has no light.
fn seen(material: &MaterialKind, from: DVec3, to: DVec3, turned: bool) -> f64 {
    let run = Run { sampler: SamplerKind::Center, ..Run::new("radiosity", 5, 1) };
    seen_by(&run, material, from, to, turned)[0]
}

/// As [`seen`], in red, green and blue.
fn seen_by(run: &Run, material: &MaterialKind, from: DVec3, to: DVec3, turned: bool) -> [f64; 3] {
    let (a, b) = (DVec3::Y * 2.0, DVec3::Z * 2.0);
    let corner = DVec3::new(2.0, -1.0, -1.0);
    let wall = if turned { square(corner, b, a) } else { square(corner, a, b) };
    let scene = one_pixel(from, to)
        .shape(square(DVec3::new(-1.0, -1.0, -2.0), a, DVec3::X * 2.0), material.clone())
        .shape(wall, diffuse(0.5));
    let integrator = run.integrator_settings().build_with_light(Arc::new(Slope));
    let outcome = run.outcome_with(&scene, integrator.as_ref());
    run.picture_of(&outcome).mean.map(|band| band[0])
}

#[test]
fn stored_light_is_daylight_at_wavelengths() {
    let run = Run { spectral: true, sampler: SamplerKind::Sobol, ..Run::new("radiosity", 5, 1024) };
    let seen_in = |run: &Run| seen_by(run, &diffuse(0.5), DVec3::ZERO, DVec3::new(2.0, 0.5, 0.25), false);
    let [grey, ..] = seen_in(&Run { spectral: false, ..run.clone() });
    for band in seen_in(&run) {
        // Grey is daylight of its luminance, up to the noise of 1024 stratified wavelengths.
        assert!((band / grey - 1.0).abs() < 0.01, "{band}, not {grey}");
    }
}

#[test]
fn stored_irradiance_is_reflected_by_the_albedo_on_the_side_that_is_seen() {
    let eye = DVec3::ZERO;
    let to = DVec3::new(2.0, 0.5, 0.25);
    // u = (y + 1) / 2 = 0.75, with the sides exchanged (z + 1) / 2 = 0.625.
    let sides =
        [(false, 0.75), (true, 0.625)].map(|(turned, u)| seen(&diffuse(0.5), eye, to, turned) / (0.5 * u));
    let [a, b] = sides;
    assert!(
        (a - 1.0).abs() < 1e-5 && (b - 2.0).abs() < 1e-5 || (a - 2.0).abs() < 1e-5 && (b - 1.0).abs() < 1e-5
    );
}

#[test]
fn mirror_shows_stored_light_and_what_has_none_is_dark() {
    // Down on the floor at z = -2, and from there to (2, 0.4, -0.5): the image of the eye is at z = -4.
    let (eye, there) = (DVec3::new(-0.5, 0.0, 0.0), DVec3::new(2.0, 0.4, -0.5));
    let image = DVec3::new(-0.5, 0.0, -4.0);
    let t = (-2.0 - image.z) / (there.z - image.z);
    let on_floor = image + t * (there - image);
    let mirror = MaterialKind::mirror(0.8);
    let direct = seen(&diffuse(0.5), eye, there, false);
    let mirrored = seen(&mirror, eye, on_floor, false);
    assert!(direct > 0.3 && (mirrored / direct - 0.8).abs() < 1e-5, "{mirrored} {direct}");
    assert_eq!(seen(&diffuse(0.5), eye, on_floor, false), 0.0);
}
