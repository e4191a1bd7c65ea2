//! Light through glass, compared with Fresnel's equations.

use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_scene::description::{LightDescription, LightKind, MaterialKind, ShapeDescription};
use glanz_scene::{LightId, ParametricPoint, Scene, SceneBuilder};

use super::tests::{BY_RADIOSITY, baked, texels};
use super::visibility::Visibility;
use super::*;
use crate::elements::ElementSettings;
use crate::scenes::parallelogram;

/// Fractions of light of both polarisations that one face of glass of index 1.5 reflects, by Fresnel's equations.
fn reflected_by_a_face(cos: f64) -> [f64; 2] {
    let inner = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let s = (cos - 1.5 * inner) / (cos + 1.5 * inner);
    let p = (1.5 * cos - inner) / (1.5 * cos + inner);
    [s * s, p * p]
}

/// Fraction of unpolarised light that a face transmits.
fn through_a_face(cos: f64) -> f64 {
    let [s, p] = reflected_by_a_face(cos);
    1.0 - 0.5 * (s + p)
}

/// The same for a thin sheet, with the light reflected between its faces.
fn through_a_sheet(cos: f64) -> f64 {
    let [s, p] = reflected_by_a_face(cos).map(|r| (1.0 - r) / (1.0 + r));
    0.5 * (s + p)
}

const TINT: [f32; 3] = [0.9, 0.5, 0.2];

/// A horizontal pane of glass at a height of 1 m.
#[derive(Clone)]
struct Pane {
    shape: ShapeDescription,
    material: MaterialKind,
    /// Transmittance per channel by the cosine to the vertical.
    law: fn(f64) -> [f64; 3],
}

/// Panes with sides of `size` metres: a single face, a thin sheet, a coloured sheet, and a thick slab.
fn panes(size: f64) -> [Pane; 4] {
    let corner = DVec3::new(0.3 - 0.5 * size, 0.7 - 0.5 * size, 1.0);
    let sheet = parallelogram(corner, DVec3::X * size, DVec3::Y * size);
    let slab = ShapeDescription::cuboid(corner, corner + DVec3::new(size, size, 0.1));
    [
        Pane {
            shape: sheet.clone(),
            material: MaterialKind::dielectric(1.5, 1.0, 1.0),
            law: |cos| [through_a_face(cos); 3],
        },
        Pane {
            shape: sheet.clone(),
            material: MaterialKind::thin_dielectric(1.5, 1.0, 1.0),
            law: |cos| [through_a_sheet(cos); 3],
        },
        Pane {
            shape: sheet,
            material: MaterialKind::thin_dielectric(1.5, 1.0, TINT),
            law: |cos| TINT.map(|tint| f64::from(tint) * through_a_sheet(cos)),
        },
        Pane {
            shape: slab,
            material: MaterialKind::dielectric(1.5, 1.0, TINT),
            law: |cos| TINT.map(|tint| (f64::from(tint) * through_a_face(cos)).powi(2)),
        },
    ]
}

/// A lamp of 0.6 m x 0.6 m at a height of 2 m, and a black floor of 2 m x 2 m, with a pane between them.
fn lamp_above(pane: &Pane) -> Scene {
    let floor = parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0);
    let lamp = parallelogram(DVec3::new(0.5, 0.5, 2.0), DVec3::Y * 0.6, DVec3::X * 0.6).emitting(1.0);
    let black = || MaterialKind::diffuse(0.0);
    let scene = SceneBuilder::new().shape(floor, black()).shape(lamp, black());
    scene.shape(pane.shape.clone(), pane.material.clone()).resolve().unwrap().0
}

#[test]
fn clear_glass_lets_light_pass() {
    // A point light above a thin pane above a black floor.
    let glass = MaterialKind::dielectric(1.5, 1.0, 1.0);
    let pane = parallelogram(DVec3::new(-4.0, -4.0, 1.0), DVec3::X * 10.0, DVec3::Y * 10.0);
    let from = DVec3::new(1.0, 1.0, 2.0);
    let point = LightDescription::new(LightKind::Point { from, range: None }, 1.0);
    let floor = parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0);
    let builder =
        SceneBuilder::new().shape(floor, MaterialKind::diffuse(0.0)).shape(pane, glass).light(point);
    let scene = builder.resolve().unwrap().0;
    let maps = baked(&scene, 0.5, &BY_RADIOSITY);
    let mut count = 0;
    for (_, p, light) in texels(&scene, &maps).filter(|(chart, p, _)| !chart.back && p.z == 0.0) {
        let way = from - p;
        let cos = way.z / way.length();
        let expected = through_a_face(cos) * cos / way.length_squared();
        assert!((light / expected - 1.0).abs() < 0.02, "{p} {light} {expected}");
        count += 1;
    }
    assert_eq!(count, 169);
}

#[test]
fn glass_of_any_size_transmits_the_light_of_a_lamp_by_fresnels_equations() {
    for size in [4.0, 4e3, 4e6, 4e9] {
        for (number, pane) in panes(size).iter().enumerate() {
            let scene = lamp_above(pane);
            let elements = Elements::new(&scene, &ElementSettings { side: 2.0 * size }).unwrap();
            let visibility = Visibility::new(BY_RADIOSITY.method, &scene);
            for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
                let uv = 0.05 * DVec2::new(f64::from(i) + 0.3, f64::from(j) + 0.6);
                let place = ParametricPoint { surface: 0, face: 0, back: false, uv };
                let receiver = BakeReceiver::new(&elements, &place).unwrap();
                let xi = 0.05 * DVec2::new(f64::from(7 * j % 20) + 0.5, f64::from(11 * i % 20) + 0.5);
                let sample = scene.sample_light(LightId(0), &receiver.at, xi).unwrap();
                let found = visibility.transmittance(&sample.shadow, sample.t_max);
                let expected = (pane.law)(sample.wi.z);
                for (found, expected) in found.to_rgb(&Wavelengths::default()).into_iter().zip(expected) {
                    let error = f64::from(found) - expected;
                    assert!(error.abs() < 1e-5, "{size} {number} {uv}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn lamp_behind_glass_lights_the_floor() {
    for (number, pane) in panes(4.0).iter().enumerate() {
        let scene = lamp_above(pane);
        let maps = baked(&scene, 0.5, &BY_RADIOSITY);
        let (mut sum, mut expected_sum, mut count) = (0.0, 0.0, 0);
        for (_, p, light) in texels(&scene, &maps).filter(|(chart, p, _)| !chart.back && p.z == 0.0) {
            // The integral over the lamp by the midpoint rule.
            let squares = (0..24).flat_map(|i| (0..24).map(move |j| (i, j)));
            let expected: f64 = squares
                .map(|(i, j)| {
                    let at = 0.025 * DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
                    let way = DVec3::new(0.5 + at.x, 0.5 + at.y, 2.0) - p;
                    let cos = way.z / way.length();
                    let rgb = (pane.law)(cos).map(|share| share as f32);
                    let share = Spectrum::from_rgb(rgb).luminance(&Wavelengths::default());
                    f64::from(share) * cos * cos / way.length_squared() * 0.025 * 0.025
                })
                .sum();
            // Direct light is sampled until the halves of the samples differ by 5 %.
            assert!((light / expected - 1.0).abs() < 0.1, "{number} {p}: {light} {expected}");
            (sum, expected_sum, count) = (sum + light, expected_sum + expected, count + 1);
        }
        assert_eq!(count, 169);
        assert!((sum / expected_sum - 1.0_f64).abs() < 0.01, "{number}: {sum} {expected_sum}");
    }
}

#[test]
fn glass_scatters_no_negative_light() {
    let [_, _, coloured, _] = panes(4.0);
    for eta in [1.1_f32, 1.3, 1.5, 2.4] {
        for material in
            [MaterialKind::dielectric(eta, 0.0, TINT), MaterialKind::thin_dielectric(eta, 0.0, TINT)]
        {
            let scene = lamp_above(&Pane { material, ..coloured.clone() });
            let visibility = Visibility::new(BY_RADIOSITY.method, &scene);
            let mut hits = 0;
            for i in 0..500 {
                let slope = 0.004 * f64::from(i);
                let ray = Ray::new(DVec3::new(-1.0, 0.7, 0.5), DVec3::new(slope, 0.0, 1.0).normalize());
                let Some(hit) = scene.intersect(&ray, f64::INFINITY) else { continue };
                // Without reflection nothing is left but what passes.
                let bsdf = hit.bsdf(&scene, &Wavelengths::default());
                let albedo = visibility.albedo(&hit, bsdf.as_ref());
                assert!(albedo.map(|x| -x).max_component() <= 0.0, "{eta} {slope}: {albedo:?}");
                hits += 1;
            }
            assert!(hits > 400, "{hits}");
        }
    }
}
