//! Lights with pictures.
//!
//! Seeds are fixed; a chi-square test fails where p < 0.001.

use std::f64::consts::{PI, TAU};

use glanz_light::{Pixels, Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::statistics::chi_square;
use glanz_sampling::warp;
use glanz_scene::description::*;
use glanz_scene::{Interaction, Light, LightId, LightSample, Scene, SceneBuilder};

const LIGHT: LightId = LightId(0);

/// A rectangle above the unit sphere, from which it sends light down.
const PORTAL: [[f64; 3]; 4] = [[-0.7, -0.3, 1.5], [-0.7, 0.6, 1.5], [0.9, 0.6, 1.5], [0.9, -0.3, 1.5]];

/// Uneven light: a dark part, a bright spot, and the rest in between.
pub(crate) fn uneven(width: u32, height: u32) -> Pixels {
    let value = |i: u32| {
        let (x, y) = (i % width, i / width);
        match (3 * x / width, 4 * y / height) {
            (0, 1 | 2) => 0.0,
            _ if x == width / 2 && y == height / 3 => 8.0,
            _ => 0.5 + unit_f64(combine(7, u64::from(i))) as f32,
        }
    };
    let rgb: Vec<[f32; 3]> = (0..width * height).map(|i| [value(i), 0.5 * value(i), value(i)]).collect();
    Pixels::try_from_rgb(width, height, &rgb).unwrap()
}

/// The scene with this picture as its first.
pub(crate) fn with_picture(builder: SceneBuilder, pixels: Pixels) -> Scene {
    let image = ImageDescription::try_new("picture", &pixels).unwrap();
    builder.edit(|scene| scene.images.push(image)).resolve().unwrap().0
}

fn lit(pixels: Pixels, mapping: SphereMapping, to_world: DMat4) -> Scene {
    let kind = LightKind::ImageInfinite { image: 0, mapping };
    let light = LightDescription { to_world, ..LightDescription::new(kind, [2.0, 3.0, 4.0]) };
    with_picture(
        SceneBuilder::new().shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5)).light(light),
        pixels,
    )
}

fn from_top(scene: &Scene) -> Interaction {
    scene.intersect(&Ray::new(DVec3::Z * 3.0, -DVec3::Z), f64::INFINITY).unwrap()
}

fn xi(i: u64) -> DVec2 {
    DVec2::new(unit_f64(combine(1, i)), unit_f64(combine(2, i)))
}

fn cases() -> Vec<(SphereMapping, Scene)> {
    let turn = DMat4::from_rotation_y(0.4)
        * DMat4::from_scale(DVec3::new(1.0, -2.0, 2.0) * DVec3::new(2.0, 1.0, 1.0));
    vec![
        (SphereMapping::LatitudeLongitude, lit(uneven(16, 8), SphereMapping::LatitudeLongitude, turn)),
        (SphereMapping::EqualArea, lit(uneven(12, 12), SphereMapping::EqualArea, turn)),
    ]
}

/// Those, and a picture behind a portal above the sphere.
fn cases_with_portal() -> Vec<(SphereMapping, Scene)> {
    let mapping = SphereMapping::LatitudeLongitude;
    let kind = LightKind::PortalInfinite { image: Some((0, mapping)), portal: PORTAL.map(DVec3::from_array) };
    let ball = SceneBuilder::new().shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5));
    let scene = with_picture(ball.light(LightDescription::new(kind, [2.0, 3.0, 4.0])), uneven(16, 8));
    cases().into_iter().chain([(mapping, scene)]).collect()
}

type Sample = fn(&Scene, &Interaction, DVec2) -> Option<LightSample>;
type Density = fn(&Scene, &Interaction, DVec3) -> f64;

/// The two ways to sample, each with its density.
const WAYS: [(&str, Sample, Density); 2] = [
    (
        "complete",
        |scene, from, xi| scene.sample_light(LIGHT, from, xi),
        |scene, from, wi| scene.infinite_pdf(LIGHT, &from.light_sample_context(), wi).0,
    ),
    (
        "compensated",
        |scene, from, xi| scene.sample_light_compensated(LIGHT, from, xi),
        |scene, from, wi| scene.compensated_infinite_pdf(LIGHT, &from.light_sample_context(), wi).0,
    ),
];

#[test]
fn samples_follow_their_density() {
    const ROWS: usize = 12;
    const COLUMNS: usize = 24;
    for (mapping, scene) in cases_with_portal() {
        let from = from_top(&scene);
        for (name, sample, density) in WAYS {
            // Cells of the same area in world space, integrated by the midpoint rule; densities jump between pixels.
            let n = 120;
            let mut expected = vec![0.0; ROWS * COLUMNS];
            for (row, column) in (0..ROWS * n).flat_map(|y| (0..COLUMNS * n).map(move |x| (y, x))) {
                let place = DVec2::new(
                    (row as f64 + 0.5) / (ROWS * n) as f64,
                    (column as f64 + 0.5) / (COLUMNS * n) as f64,
                );
                expected[row / n * COLUMNS + column / n] +=
                    density(&scene, &from, warp::uniform_sphere(place)) * 4.0 * PI
                        / (ROWS * COLUMNS * n * n) as f64;
            }
            let whole: f64 = expected.iter().sum();
            assert!((whole - 1.0).abs() < 2e-3, "{mapping:?} {name}: the density integrates to {whole}");
            let mut counts = vec![0_u64; ROWS * COLUMNS];
            let samples = 100_000;
            for i in 0..samples {
                let found = sample(&scene, &from, xi(i)).unwrap();
                let pdf = density(&scene, &from, found.wi);
                assert!((pdf / found.pdf.0 - 1.0).abs() < 1e-9, "{mapping:?} {name}: {pdf} {:?}", found.pdf);
                let place = warp::uniform_sphere_inverse(found.wi);
                let (row, column) = ((place.x * ROWS as f64) as usize, (place.y * COLUMNS as f64) as usize);
                counts[row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)] += 1;
            }
            let expected: Vec<f64> = expected.iter().map(|share| share / whole * samples as f64).collect();
            let test = chi_square(&counts, &expected);
            assert!(test.p_value > 0.001, "{mapping:?} {name}: {test:?}");
        }
    }
}

#[test]
fn compensation_leaves_out_what_is_darker_than_the_mean() {
    for (mapping, scene) in cases() {
        let from = from_top(&scene).light_sample_context();
        let (mut left_out, mut dark) = (0, 0);
        for i in 0..10_000 {
            let wi = warp::uniform_sphere(xi(i));
            let complete = scene.infinite_pdf(LIGHT, &from, wi).0;
            let compensated = scene.compensated_infinite_pdf(LIGHT, &from, wi).0;
            // The mean of a density over all directions is 1 / 4 pi.
            assert_eq!(compensated > 0.0, complete > 0.25 / PI, "{mapping:?} {complete} {compensated}");
            left_out += usize::from(compensated == 0.0 && complete > 0.0);
            let radiance = scene.infinite_radiance(LIGHT, &Ray::new(DVec3::ZERO, wi));
            dark += usize::from(radiance.is_black());
            assert!(complete > 0.0 || radiance.is_black());
        }
        assert!(left_out > 1000 && dark > 100, "{mapping:?}: {left_out} {dark}");
    }
}

#[test]
fn even_picture_is_an_infinite_light() {
    for (mapping, size) in [(SphereMapping::LatitudeLongitude, [8, 4]), (SphereMapping::EqualArea, [5, 5])] {
        let count = (size[0] * size[1]) as usize;
        let pixels = Pixels::try_from_rgb(size[0], size[1], &vec![[0.5; 3]; count]).unwrap();
        let scene = lit(pixels, mapping, DMat4::IDENTITY);
        let from = from_top(&scene);
        for i in 0..1000 {
            let sample = scene.sample_light_compensated(LIGHT, &from, xi(i)).unwrap();
            assert!((sample.pdf.0 * 4.0 * PI - 1.0).abs() < 1e-12, "{mapping:?}: {:?}", sample.pdf);
            assert_eq!(sample.radiance, Spectrum::from_rgb([1.0, 1.5, 2.0]));
        }
    }
}

#[test]
fn transformation_turns_and_mirrors_the_picture() {
    // Red around x, green around y, blue around z of the light.
    let mapping = SphereMapping::LatitudeLongitude;
    let (width, height) = (64, 32);
    let rgb: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            let place =
                DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5) / DVec2::new(64.0, 32.0);
            mapping.direction(place).max(DVec3::ZERO).as_vec3().to_array()
        })
        .collect();
    let pixels = Pixels::try_from_rgb(width, height, &rgb).unwrap();
    // x to y, y to -z, z to x: a rotation and a mirror, and a scale.
    let axes = [DVec3::Y * 3.0, -DVec3::Z * 3.0, DVec3::X * 3.0];
    let to_world = DMat4::from_cols(
        axes[0].extend(0.0),
        axes[1].extend(0.0),
        axes[2].extend(0.0),
        DVec3::ONE.extend(1.0),
    );
    let scene = lit(pixels, mapping, to_world);
    for (axis, band) in axes.into_iter().zip(0..) {
        // Of any length.
        let seen =
            scene.infinite_radiance(LIGHT, &Ray::new(DVec3::ONE * 0.3, axis)).to_rgb(&Wavelengths::Rgb);
        for (other, value) in seen.into_iter().enumerate() {
            let expected = if other == band { [2.0, 3.0, 4.0][band] } else { 0.0 };
            assert!((value - expected).abs() < 0.1, "{axis}: {seen:?}");
        }
    }
}

#[test]
fn estimates_of_irradiance_agree_with_the_sum_over_the_picture() {
    for (mapping, scene) in cases_with_portal() {
        let from = from_top(&scene);
        // Midpoint rule over the hemisphere around z.
        let n = 1000;
        let mut expected = 0.0;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let wi =
                warp::uniform_hemisphere(DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(n));
            expected += bright(scene.infinite_radiance(LIGHT, &from.spawn(wi))) * wi.z;
        }
        expected *= TAU / f64::from(n * n);
        let samples = 200_000;
        let sum: f64 = (0..samples)
            .filter_map(|i| scene.sample_light(LIGHT, &from, xi(i)))
            .map(|sample| bright(sample.radiance) * sample.wi.z.max(0.0) / sample.pdf.0)
            .sum();
        let found = sum / samples as f64;
        assert!((found / expected - 1.0).abs() < 0.01, "{mapping:?}: {found} {expected}");
    }
}

fn bright(light: Spectrum) -> f64 {
    f64::from(light.mean(&Wavelengths::default()))
}

#[test]
fn black_picture_is_never_sampled() {
    let pixels = Pixels::try_from_rgb(4, 2, &[[0.0; 3]; 8]).unwrap();
    let scene = lit(pixels, SphereMapping::LatitudeLongitude, DMat4::IDENTITY);
    let from = from_top(&scene);
    assert!(scene.sample_light(LIGHT, &from, DVec2::splat(0.5)).is_none());
    assert!(scene.select_light(&from.light_sample_context(), 0.5).is_none());
    assert!(scene.emit(LIGHT, DVec2::splat(0.5), DVec2::splat(0.5)).is_none());
}

#[test]
fn stretched_light_and_picture_without_colours_are_refused() {
    let kind = LightKind::ImageInfinite { image: 0, mapping: SphereMapping::EqualArea };
    let to_world = DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0));
    let light = LightDescription { to_world, ..LightDescription::new(kind, 1.0) };
    let image = ImageDescription::try_new("picture", &uneven(4, 4)).unwrap();
    let builder = SceneBuilder::new().light(light).edit(|scene| scene.images.push(image));
    let message = builder.resolve().unwrap_err().to_string();
    assert!(message.starts_with("infinite light: transformation is anisotropic"), "{message}");
    let mut depth = Pixels::try_new(1, 1).unwrap();
    depth.add_channel("Z", vec![1.0]).unwrap();
    let message = ImageDescription::try_new("depth", &depth).unwrap_err().to_string();
    assert_eq!(message, "the picture has the channels [\"Z\"]; textures and lights need R, G and B, or Y");
}

#[test]
fn light_passes_a_portal_in_one_direction() {
    let kind = LightKind::PortalInfinite { image: None, portal: PORTAL.map(DVec3::from_array) };
    let scene = SceneBuilder::new().light(LightDescription::new(kind, 1.0)).resolve().unwrap().0;
    let seen = |origin: [f64; 3], target: [f64; 3]| {
        let origin = DVec3::from_array(origin);
        let ray = Ray::new(origin, DVec3::from_array(target) - origin);
        !scene.infinite_radiance(LIGHT, &ray).is_black()
    };
    for (target, expected) in [
        ([0.89, 0.59, 1.5], true),
        ([-0.69, -0.29, 1.5], true),
        ([0.91, 0.0, 1.5], false),
        ([0.0, 0.61, 1.5], false),
        ([-0.71, 0.0, 1.5], false),
        ([0.0, -0.31, 1.5], false),
    ] {
        assert_eq!(seen([0.1, 0.2, 1.1], target), expected, "{target:?}");
    }
    assert!(!seen([0.0, 0.0, 3.0], [0.0, 0.0, 1.5]) && !seen([0.0, 0.0, 3.0], [0.0, 0.0, 4.0]));
}

#[test]
fn picture_of_one_long_row_behind_a_portal_is_resampled_to_about_as_many_pixels() {
    // As many pixels in both directions as it has in its row would be 10^11.
    let width = 1 << 20;
    let pixels = Pixels::try_from_rgb(width, 1, &vec![[1.0; 3]; width as usize]).unwrap();
    let kind = LightKind::PortalInfinite {
        image: Some((0, SphereMapping::LatitudeLongitude)),
        portal: PORTAL.map(DVec3::from_array),
    };
    let scene = with_picture(SceneBuilder::new().light(LightDescription::new(kind, 2.0)), pixels);
    let Some(Light::PortalInfinite(light)) = scene.light(LIGHT) else { unreachable!() };
    // pi times the radiance and the area.
    let expected = PI * 2.0 * 1.6 * 0.9;
    assert!((bright(light.power()) / expected - 1.0).abs() < 1e-3, "{:?}", light.power());
}

#[test]
fn portal_has_to_be_a_rectangle() {
    for portal in [
        [DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::X + DVec3::Y],
        [DVec3::ZERO, DVec3::Y, DVec3::X + 2.0 * DVec3::Y, DVec3::X + DVec3::Y],
        [DVec3::ZERO; 4],
    ] {
        let light = LightDescription::new(LightKind::PortalInfinite { image: None, portal }, 1.0);
        let message = SceneBuilder::new().light(light).resolve().unwrap_err().to_string();
        assert!(message.ends_with("it must be the four corners of a rectangle in order"), "{message}");
    }
}

/// A picture whose quarters are, row by row, black, red, green and blue.
pub(crate) fn quarters() -> Pixels {
    let rgb: Vec<[f32; 3]> = (0..64)
        .map(|i| match (i % 8 / 4, i / 32) {
            (0, 0) => [0.0; 3],
            (1, 0) => [1.0, 0.0, 0.0],
            (0, _) => [0.0, 1.0, 0.0],
            _ => [0.0, 0.0, 1.0],
        })
        .collect();
    Pixels::try_from_rgb(8, 8, &rgb).unwrap()
}

#[test]
fn projected_picture_is_upright_for_the_one_who_looks_along_z() {
    let kind = LightKind::Projection { image: 0, field_of_view: 1.0 };
    let to_world = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0));
    let light = LightDescription { to_world, ..LightDescription::new(kind, 6.0) };
    let scene = with_picture(SceneBuilder::new().light(light), quarters());
    let light = scene.light(LIGHT).unwrap();
    // x to the right and y up, in the left-handed space of pbrt's cameras: in the distance 2 half a side is 2 tan 0.5 = 1.09.
    for (x, y, expected) in [
        (-0.7, 0.7, [0.0; 3]),
        (0.7, 0.7, [6.0, 0.0, 0.0]),
        (-0.7, -0.7, [0.0, 6.0, 0.0]),
        (0.7, -0.7, [0.0, 0.0, 6.0]),
        (1.1, -0.7, [0.0; 3]),
    ] {
        let found = light.incident(DVec3::new(1.0 + x, 2.0 + y, 5.0)).unwrap();
        let distance_squared = (x * x + y * y + 4.0) as f32;
        let intensity = (found.irradiance * distance_squared).to_rgb(&Wavelengths::Rgb);
        for (found, expected) in intensity.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{x} {y}: {intensity:?}");
        }
    }
    assert!(light.incident(DVec3::new(1.0, 2.0, 1.0)).unwrap().irradiance.is_black());
}

#[test]
fn axis_of_a_goniometric_picture_is_y() {
    // Light in the upper half of the picture: around +y.
    let rgb: Vec<[f32; 3]> = (0..128).map(|i| [f32::from(u8::from(i < 64)); 3]).collect();
    let pixels = Pixels::try_from_rgb(16, 8, &rgb).unwrap();
    let kind = LightKind::Goniometric { image: 0, mapping: SphereMapping::LatitudeLongitude };
    let scene = with_picture(SceneBuilder::new().light(LightDescription::new(kind, 2.0)), pixels);
    let light = scene.light(LIGHT).unwrap();
    let seen = |at: DVec3| bright(light.incident(at).unwrap().irradiance) * at.length_squared();
    for x in [-0.5, 0.5] {
        assert!((seen(DVec3::new(x, 2.0, -x)) - bright(Spectrum::ONE * 2.0)).abs() < 1e-6);
        assert_eq!(seen(DVec3::new(x, -2.0, x)), 0.0);
    }
}

#[test]
fn projection_needs_an_angle_below_pi() {
    let kind = LightKind::Projection { image: 0, field_of_view: PI };
    let builder = SceneBuilder::new().light(LightDescription::new(kind, 1.0));
    let message = builder.resolve().unwrap_err().to_string();
    assert!(message.contains("field of view") && message.ends_with("between 0 and pi"), "{message}");
}
