//! Light at sampled wavelengths: the same pictures as in RGB where nothing depends on the wavelength alone, and dispersion.

use crate::common::*;
use glanz_light::rgb::xyz_to_rgb;
use glanz_light::{SampledWavelengths, SpectralDistribution, Wavelengths, cie, named};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};
use glanz_shading::TransportMode;
use glanz_shading::model::{DielectricMaterial, Roughness, RoughnessScale};

fn spectral(run: Run) -> Run {
    Run { spectral: true, ..run }
}

/// The inside of a sphere that emits `emission` and reflects `reflectance`.
fn room(
    emission: impl Into<SpectralDistribution>,
    reflectance: impl Into<SpectralDistribution>,
) -> SceneBuilder {
    let shape = ShapeDescription::sphere(2.0).reversed().emitting(emission.into());
    looking(DVec3::new(0.3, -0.2, 0.4), DVec3::X, [8, 8], 1.2)
        .shape(shape, MaterialKind::diffuse(SpectrumParameter::Value(reflectance.into())))
}

/// Glass of a named index, without absorption.
fn dispersive_glass(name: &str, roughness: f32) -> MaterialKind {
    MaterialKind::Dielectric(DielectricMaterial {
        eta: 1.5.into(),
        dispersion: named::spectrum(name),
        reflectance: 1.0.into(),
        transmittance: 1.0.into(),
        thin: false,
        roughness: Roughness::isotropic(roughness, RoughnessScale::Alpha),
        multiple_scattering: true,
    })
}

#[test]
fn grey_rooms_are_as_bright_as_in_rgb() {
    // 1 + 1/2 + 1/4 + ... = 2.
    for run in Run::all_random(60, 512).into_iter().map(spectral) {
        run.picture(&room(1.0, 0.5)).assert_average([2.0; 3], 0.02, &run.name());
    }
}

#[test]
fn light_scattered_once_by_a_color_has_that_color() {
    let color = [0.9, 0.3, 0.1_f32];
    let expected = color.map(|x| 1.0 + f64::from(x));
    for run in Run::all_random(1, 1024).into_iter().map(spectral) {
        run.picture(&room([1.0; 3], color)).assert_average(expected, 0.02, &run.name());
    }
}

#[test]
fn spectra_multiply_by_wavelength() {
    // Tungsten light on a band-pass filter: products of colours would be off by much more than the noise.
    let lamp = SpectralDistribution::try_blackbody(2800.0, 1.0).unwrap();
    let filter =
        SpectralDistribution::try_sampled(vec![(540.0, 0.02), (560.0, 0.9), (590.0, 0.9), (610.0, 0.02)])
            .unwrap();
    let body = |nm: f64| 1.0 / (nm.powi(5) * (1.438_776_877e7 / (nm * 2800.0)).exp_m1());
    let peak = body(2.897_771_955e6 / 2800.0);
    let reflectance = |nm: f64| match nm {
        ..540.0 | 610.0.. => 0.02,
        540.0..560.0 => 0.02 + 0.88 * (nm - 540.0) / 20.0,
        560.0..590.0 => 0.9,
        _ => 0.9 - 0.88 * (nm - 590.0) / 20.0,
    };
    let (mut xyz, step) = ([0.0; 3], 0.1);
    for i in 0..4700 {
        let nm = 360.0 + step * (f64::from(i) + 0.5);
        let light = body(nm) / peak * (1.0 + reflectance(nm)) * step / cie::Y_INTEGRAL;
        cie::observer(nm).iter().zip(&mut xyz).for_each(|(c, sum)| *sum += c * light);
    }
    let expected = xyz_to_rgb(xyz);
    let rgb = Run::new("path", 1, 4096).picture(&room(lamp.clone(), filter.clone()));
    assert!((rgb.average(1).0 / expected[1] - 1.0).abs() > 0.05, "{:?} {expected:?}", rgb.average(1));
    let run = spectral(Run::new("path", 1, 4096));
    let picture = run.picture(&room(lamp, filter));
    for (band, expected) in expected.into_iter().enumerate() {
        let (mean, error) = picture.average(band);
        // Daylight of the tables is white, which differs from the white of Rec. 709 by 4e-4.
        assert!((mean - expected).abs() < 3.0 * error + 1e-3, "{mean} +- {error}, not {expected}");
        assert!(error < 0.01, "{error}");
    }
}

#[test]
fn metal_reflects_by_its_constants_at_each_wavelength() {
    let [eta, k] = ["metal-Au-eta", "metal-Au-k"].map(|name| named::spectrum(name).unwrap());
    let gold =
        MaterialKind::conductor(SpectrumParameter::Value(eta.clone()), SpectrumParameter::Value(k.clone()));
    let scene =
        resolved(&one_pixel(DVec3::NEG_X * 3.0, DVec3::ZERO).shape(ShapeDescription::sphere(1.0), gold));
    let hit = scene.intersect(&Ray::new(DVec3::NEG_X * 3.0, DVec3::X), f64::INFINITY).unwrap();
    let at = |spectrum: &SpectralDistribution, nm: f64| match spectrum {
        SpectralDistribution::Sampled(samples) => samples.at(nm),
        other => unreachable!("{other:?}"),
    };
    for xi in [0.05, 0.3, 0.6, 0.8] {
        let sampled = SampledWavelengths::sample(xi);
        let nm = f64::from(sampled.nm()[0]);
        let (n, k) = (at(&eta, nm), at(&k, nm));
        // Fresnel's equations at normal incidence.
        let expected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
        let bsdf = hit.bsdf(&scene, &Wavelengths::Sampled(sampled)).unwrap();
        let found = f64::from(bsdf.albedo(DVec3::Z).hero());
        assert!((found - expected).abs() < 1e-4, "{nm} nm: {found}, not {expected}");
    }
}

#[test]
fn dispersive_glass_without_absorption_is_unseen_in_a_white_room() {
    for roughness in [0.0, 0.3] {
        let sphere = |y: f64| ShapeDescription::sphere(0.5).translated([0.5, y, 0.0]);
        let scene = looking(DVec3::new(-1.2, 0.0, 0.0), DVec3::X, [8, 8], 1.2)
            .shape(ShapeDescription::sphere(2.0).reversed().emitting([1.0; 3]), diffuse(0.5))
            .shape(sphere(-0.6), dispersive_glass("glass-SF11", roughness))
            .shape(sphere(0.6), dispersive_glass("glass-diamond", roughness));
        for name in ["path", "light", "guided", "distributed"] {
            let run = spectral(Run::new(name, 100, 512));
            run.picture(&scene).assert_average([2.0; 3], 0.03, &format!("{roughness}: {}", run.name()));
        }
        let sky = looking(DVec3::new(-1.2, 0.0, 0.0), DVec3::X, [8, 8], 1.2)
            .shape(sphere(0.0), dispersive_glass("glass-SF11", 0.0))
            .light(LightDescription::infinite([1.0; 3]));
        // Weights below the smallest are left out.
        let whitted = spectral(Run::new("whitted", 12, 512)).picture(&sky);
        (0..3).for_each(|band| {
            let (mean, error) = whitted.average(band);
            assert!((mean - 1.0).abs() < 3.0 * error + 2e-3 && error < 0.02, "{mean} +- {error}");
        });
    }
}

#[test]
fn dispersed_paths_end_where_the_hero_is_absorbed() {
    // Paths leave the glass ball around the camera with the hero alone. The walls absorb three of four heroes, and one of the four wavelengths is in the band that they reflect: if it kept a dead path
    // going, all paths would be as long as those of the fourth.
    let band = vec![(560.0, 0.02), (561.0, 0.98), (640.0, 0.98), (641.0, 0.02)];
    let walls = room(1.0, SpectralDistribution::try_sampled(band).unwrap()).shape(
        ShapeDescription::sphere(0.5).translated([0.3, -0.2, 0.4]),
        dispersive_glass("glass-SF11", 0.0),
    );
    let rays = |run: Run| {
        let outcome = run.outcome(&walls);
        outcome.counters.closest as f64 / outcome.samples as f64
    };
    for run in [
        spectral(Run::new("path", 100, 256)),
        spectral(Run { branching: Some(1), ..Run::new("distributed", 100, 256) }),
    ] {
        let (name, rays) = (run.name(), rays(run));
        assert!(rays < 20.0, "{name}: {rays}");
    }
}

#[test]
fn what_only_scatters_is_unseen_under_a_white_sky_at_wavelengths() {
    let fog = MediumDescription { g: 0.3, ..MediumDescription::new(0.0, [0.5, 1.0, 3.0]) };
    let scene = looking(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO, [4, 4], 0.4)
        .edit(|description| description.media.push(fog))
        .shape(ShapeDescription::sphere(1.0).enclosing(0, None), MaterialKind::Interface)
        .shape(ShapeDescription::sphere(0.3).translated([0.2, 0.1, 0.0]), dispersive_glass("glass-SF11", 0.0))
        .light(LightDescription::infinite([1.0; 3]));
    for name in ["path", "guided"] {
        let run = spectral(Run::new(name, 200, 1024));
        run.picture(&scene).assert_average([1.0; 3], 0.05, &run.name());
    }
}

#[test]
fn grey_absorption_leaves_the_same_at_wavelengths() {
    let scene = one_pixel(DVec3::ZERO, DVec3::X)
        .edit(|description| {
            description.media.push(MediumDescription::new(0.7, 0.0));
            description.camera_medium = Some(0);
        })
        .shape(ShapeDescription::sphere(2.0).reversed().emitting([1.0; 3]), diffuse(0.0));
    let run = spectral(Run::new("path", 1, 4096));
    // The way from the middle to the sphere is 2 m.
    run.picture(&scene).assert_average([(-1.4_f64).exp(); 3], 0.02, &run.name());
}

/// An equilateral prism of side 1 along z, its base on y = 0.
fn prism() -> ShapeDescription {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let height = 0.75_f64.sqrt();
    let triangle = |z| [corner(-0.5, 0.0, z), corner(0.5, 0.0, z), corner(0.0, height, z)];
    let positions = [triangle(-1.0), triangle(1.0)].concat();
    let ends = [[0, 2, 1], [3, 4, 5]];
    let sides = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    let indices = ends.into_iter().chain(sides).collect();
    ShapeDescription::mesh(positions, indices)
}

/// The direction of a ray behind the prism, refracted at both faces.
fn refracted(scene: &Scene, mut ray: Ray, wavelengths: &Wavelengths) -> DVec3 {
    while let Some(hit) = scene.intersect(&ray, f64::INFINITY) {
        let bsdf = hit.bsdf(scene, wavelengths).unwrap();
        assert!(bsdf.is_dispersive());
        let frame = hit.frame_of(&bsdf, hit.point.shading_normal);
        let [_, through] = bsdf.delta_branches(frame.to_local(hit.wo), TransportMode::Radiance);
        ray = hit.spawn(frame.to_world(through.unwrap().wi));
    }
    ray.direction
}

#[test]
fn deviation_by_a_prism_is_that_of_its_glass() {
    // Schott's coefficients, and the angle of a symmetric or any other passage: i2 = asin(n sin(60 deg - asin(sin i1 / n))).
    let sf10 = ([1.621_539_02, 0.256_287_842, 1.644_475_52], [0.012_224_145_7, 0.059_573_677_5, 147.468_793]);
    let bk7 = ([1.039_612_12, 0.231_792_344, 1.010_469_45], [0.006_000_698_67, 0.020_017_914_4, 103.560_653]);
    for (name, (b, c)) in [("glass-SF10", sf10), ("glass-BK7", bk7)] {
        let scene = resolved(&one_pixel(DVec3::NEG_X, DVec3::X).shape(prism(), dispersive_glass(name, 0.0)));
        let mut deviations = Vec::new();
        for xi in [0.03, 0.25, 0.5, 0.75, 0.9] {
            let sampled = SampledWavelengths::sample(xi);
            let nm = f64::from(sampled.nm()[0]);
            let w2 = (nm * 1e-3).powi(2);
            let n = (1.0 + (0..3).map(|i| b[i] * w2 / (w2 - c[i])).sum::<f64>()).sqrt();
            let incidence = 62_f64.to_radians();
            let leaves = (n * (60_f64.to_radians() - (incidence.sin() / n).asin()).sin()).asin();
            let expected = incidence + leaves - 60_f64.to_radians();
            // The left face looks to 150 degrees from x.
            let towards = 150_f64.to_radians() - incidence + std::f64::consts::PI;
            let direction = DVec3::new(towards.cos(), towards.sin(), 0.0);
            let ray = Ray::new(DVec3::new(-0.25, 0.5 * 0.75_f64.sqrt(), 0.0) - direction, direction);
            let found = refracted(&scene, ray, &Wavelengths::Sampled(sampled)).angle_between(direction);
            assert!((found - expected).to_degrees().abs() < 0.01, "{name} {nm} nm: {found} {expected}");
            deviations.push((nm, found));
        }
        assert!(deviations.is_sorted_by(|a, b| a.0 < b.0 && a.1 > b.1), "{deviations:?}");
    }
}

/// Mean row of the light of a band.
fn middle_row(picture: &Picture, band: usize, width: usize) -> f64 {
    let light = picture.mean[band].iter().map(|x| x.max(0.0)).enumerate();
    let (sum, weight) =
        light.fold((0.0, 0.0), |(sum, weight), (i, x)| (sum + x * (i / width) as f64, weight + x));
    sum / weight
}

#[test]
fn white_line_seen_through_a_prism_is_a_spectrum() {
    // The prism at its least deviation, of a camera in front of it and a lamp behind it.
    let n = 1.728_28_f64;
    let tilt = (0.5 * n).asin() - 30_f64.to_radians();
    let (way, height) = (DVec2::from_angle(tilt), 0.5 * 0.75_f64.sqrt());
    let camera = DVec3::new(-0.25 - 3.0 * way.x, height - 3.0 * way.y, 0.0);
    let lamp = DVec3::new(0.25 + 4.0 * way.x, height - 4.0 * way.y, 0.0);
    let (thick, along) = (DVec3::new(way.y, way.x, 0.0) * 0.04, DVec3::Z * 0.5);
    let line = rectangle(lamp - 0.5 * (thick + along), along, thick);
    let emission = EmissionDescription { two_sided: true, ..EmissionDescription::from([1.0; 3]) };
    let scene = looking(camera, DVec3::new(-0.25, height, 0.0), [64, 64], 6_f64.to_radians())
        .shape(line.emitting(emission), diffuse(0.0));
    let seen = |glass: MaterialKind, run: Run| {
        let picture = run.picture(&scene.clone().shape(prism(), glass));
        [0, 1, 2].map(|band| middle_row(&picture, band, 64))
    };
    let run = Run {
        aovs: glanz_transport::AovSet::NONE.with(glanz_transport::Aov::Variance),
        ..Run::new("path", 8, 64)
    };
    let [red, green, blue] = seen(dispersive_glass("glass-SF10", 0.0), spectral(run.clone()));
    // Light of 650 nm in row 27, of 580 nm in row 33, of 500 nm in row 42 and of 450 nm in row 52, by ray tracing in the plane.
    let are_apart =
        (27.0..33.0).contains(&red) && (33.0..42.0).contains(&green) && (42.0..56.0).contains(&blue);
    assert!(are_apart, "{red} {green} {blue}");
    let same = seen(MaterialKind::dielectric(n as f32, 1.0, 1.0), spectral(run));
    // All bands in the row of 587.6 nm, which is that in the middle, up to their noise.
    assert!((same[0] - same[2]).abs() < 0.05 && (same[1] - 31.5).abs() < 0.5, "{same:?}");
}
