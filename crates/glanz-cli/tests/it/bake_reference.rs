//! Light maps against path tracing at random points of surfaces.
//!
//! `GLANZ_BAKE_POINTS` says at how many and `GLANZ_BAKE_SAMPLES` with how many paths each; `cargo xtask bake` takes 1000 and 8192, and light
//! maps with the program's own density and number of rays instead of coarser ones.

use std::f64::consts::PI;
use std::path::Path;

use glanz::formats::{Options, load};
use glanz::job::{CancelFlag, Silent};
use glanz::light::{Spectrum, Wavelengths};
use glanz::math::{DVec2, Frame};
use glanz::radiosity::bake::{BakeSettings, LightMap, LightMaps, bake};
use glanz::radiosity::elements::{ElementSettings, Elements};
use glanz::sampling::{PixelSampler, SamplerKind, warp};
use glanz::scene::description::IntegratorDescription;
use glanz::scene::{LightId, PlacedPoint, Scene};
use glanz::transport::{Context, ContextOptions, Integrator, IntegratorSettings};

/// What is asked from outside, or this.
fn setting(name: &str, otherwise: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| otherwise.to_owned())
}

fn number(name: &str, otherwise: u32) -> u32 {
    setting(name, &otherwise.to_string()).parse().expect("a number")
}

fn luminance(light: Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}

/// Irradiance at a place by `samples` paths over the hemisphere, whose first rays look for what lamps light, and as many samples of each
/// lamp; with its standard error.
fn reference(scene: &Scene, path: &dyn Integrator, at: &PlacedPoint, samples: u32, number: u32) -> [f64; 2] {
    let at = &at.at;
    let frame = Frame::from_z(at.wo);
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..samples {
        let mut sampler = PixelSampler::new(SamplerKind::Independent, samples, 7, [number, 0], i);
        let direction = frame.to_world(warp::cosine_hemisphere(sampler.next_2d()));
        let ray = at.spawn(direction);
        let mut light = 0.0;
        for id in (0..scene.lights().len() as u32).map(LightId) {
            let Some(sample) = scene.sample_light(id, at, sampler.next_2d()) else { continue };
            let cos = at.wo.dot(sample.wi);
            if cos > 0.0 && !scene.occluded(&sample.shadow, sample.t_max) {
                light += luminance(sample.radiance) * cos / sample.pdf.0;
            }
        }
        // What the lamps themselves send has been counted.
        let seen = scene.intersect(&ray, f64::INFINITY);
        let own = seen.map_or_else(|| scene.environment_radiance(&ray), |hit| scene.emitted(&hit, hit.wo));
        let mut context = Context::new(scene, ray, sampler, ContextOptions::new(false));
        light += PI * (luminance(path.radiance(&mut context)) - luminance(own));
        sum += light;
        squares += light * light;
    }
    let n = f64::from(samples);
    [sum / n, ((squares / n - (sum / n).powi(2)) / n).max(0.0).sqrt()]
}

#[test]
fn light_maps_are_what_path_tracing_finds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join(setting("GLANZ_BAKE_SCENE", "scenes/rooms/vase.pbrt"));
    let (points, samples) = (number("GLANZ_BAKE_POINTS", 100), number("GLANZ_BAKE_SAMPLES", 4096));
    let settings = BakeSettings {
        density: f64::from(number("GLANZ_BAKE_DENSITY", 16)),
        rays: number("GLANZ_BAKE_RAYS", 256),
        ..BakeSettings::default()
    };
    let description = load(&file, &Options::default()).unwrap_or_else(|error| panic!("{error}")).description;
    let (scene, _) = Scene::resolve(description).unwrap();
    let mut elements = Elements::new(&scene, &ElementSettings { side: 0.3 }).unwrap();
    elements.cut_at_walls(settings.density).unwrap();
    let start = std::time::Instant::now();
    let maps = bake(&elements, None, &settings, &mut Silent, &CancelFlag::default()).unwrap();
    let texels: usize = maps.iter().map(|map| map.irradiance.len()).sum();
    println!("{texels} texels in {:.1} s", start.elapsed().as_secs_f64());
    let walk = IntegratorDescription {
        name: "path".into(),
        max_depth: Some(64),
        ..IntegratorDescription::default()
    };
    let path = IntegratorSettings::resolve(&walk).unwrap().build();

    // Points uniform by area: as many candidates as texels, each kept by how much area it stands for.
    let maps = LightMaps::new(&elements, maps);
    let lit: Vec<&LightMap> = maps.as_slice().iter().filter(|map| !map.is_dark()).collect();
    let last =
        |map: &LightMap| DVec2::new(f64::from(map.chart.size[0]) - 1.0, f64::from(map.chart.size[1]) - 1.0);
    let mut random = PixelSampler::new(SamplerKind::Independent, 1, 3, [0, 0], 0);
    let total: usize = lit.iter().map(|map| map.chart.texels()).sum();
    let largest = 1.0 / (settings.density * settings.density);
    let mut compared: Vec<([f64; 3], String)> = Vec::new();
    let (mut noise, mut sum, mut found) = (0.0, [0.0; 2], 0);
    while found < points {
        let mut pick = (random.next_1d() * total as f64) as usize;
        let Some(map) = lit.iter().find(|map| {
            let here = pick < map.chart.texels();
            if !here {
                pick -= map.chart.texels();
            }
            here
        }) else {
            continue;
        };
        let texel = random.next_2d() * last(map);
        let keep = random.next_1d();
        let surface = &elements.surfaces[map.chart.surface as usize];
        let Some(place) = map.chart.place(surface, texel) else { continue };
        let Some(at) = surface.at(place.face, place.uv, place.back) else { continue };
        // Area of a texel, from neighbours a hundredth of one away.
        let beside = |step: DVec2| {
            let place = map.chart.place(surface, texel + step)?;
            Some(surface.at(place.face, place.uv, place.back)?.at.point.position)
        };
        let (Some(a), Some(b)) = (beside(DVec2::X * 0.01), beside(DVec2::Y * 0.01)) else { continue };
        let here = at.at.point.position;
        let area = (a - here).cross(b - here).length() * 1e4;
        if keep * largest > area {
            continue;
        }
        found += 1;
        let [expected, deviation] = reference(&scene, path.as_ref(), &at, samples, found);
        let light = luminance(maps.irradiance(&place).unwrap());
        sum = [sum[0] + light, sum[1] + expected];
        let name = format!(
            "{} {} {:?}: {light:.4}, path {expected:.4} +- {deviation:.4}",
            surface.surface().kind(),
            map.chart.shape,
            here.to_array().map(|x| (x * 1e3).round() / 1e3)
        );
        compared.push(([light, expected, deviation], name));
    }
    // Per what is there, or a hundredth of the mean where less is: in the dark there is no error of so many per cent.
    let floor = 0.01 * sum[1] / f64::from(points);
    let relative = |[light, expected, deviation]: [f64; 3]| {
        [(light - expected).abs() / expected.max(floor), deviation / expected.max(floor)]
    };
    let mut errors: Vec<(f64, String)> = Vec::new();
    for (values, name) in compared {
        let [error, deviation] = relative(values);
        noise += deviation;
        errors.push((error, name));
    }
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = errors.len();
    let mean = errors.iter().map(|(error, _)| error).sum::<f64>() / count as f64;
    let at = |share: f64| errors[((count as f64 * share) as usize).min(count - 1)].0;
    println!(
        "{count} points: mean error {:.2} %, median {:.2} %, 95 % within {:.2} %, largest {:.1} %; of all light {:+.2} %; \
         standard error of the reference {:.2} %",
        100.0 * mean,
        100.0 * at(0.5),
        100.0 * at(0.95),
        100.0 * at(1.0),
        100.0 * (sum[0] / sum[1] - 1.0),
        100.0 * noise / count as f64
    );
    for (error, name) in errors.iter().rev().take(12) {
        println!("{:6.1} %  {name}", 100.0 * error);
    }
    assert!(mean <= 0.03 && at(0.95) <= 0.08, "the light maps are too far from path tracing");
}
