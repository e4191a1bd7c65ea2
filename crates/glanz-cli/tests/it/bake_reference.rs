//! Light maps compared with path tracing at random points of surfaces.
//!
//! `GLANZ_BAKE_POINTS` sets the number of points and `GLANZ_BAKE_SAMPLES` the largest number of paths per point; `cargo xtask bake` uses 1000 and 8192, and light
//! maps with the program's default density and number of rays instead of coarser ones. `GLANZ_BAKE_METHODS` names the methods of the bake
//! that are compared with the same paths: the gather and, by its reconstruction, radiosity.

use std::path::Path;

use glanz::formats::{Options, load};
use glanz::job::{CancelFlag, Silent};
use glanz::radiosity::bake::{BakeMethod, BakeSettings, LightMaps, bake};
use glanz::radiosity::elements::{ElementSettings, Elements};
use glanz::scene::Scene;

use crate::bake_points::{PointSettings, ReferencePoint, luminance, reference_points};

/// Points that are compared: of 100, the fifth worst decided, and moved from 6 to 10 % with other random numbers.
const POINTS: u32 = 250;

/// The scene of the suite.
const SUITE_SCENE: &str = "scenes/rooms/vase.pbrt";

/// The value of an environment variable, or this default.
fn setting(name: &str, otherwise: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| otherwise.to_owned())
}

fn number(name: &str, otherwise: u32) -> u32 {
    setting(name, &otherwise.to_string()).parse().expect("a number")
}

/// Errors of light maps relative to the irradiance, or to a hundredth of the mean irradiance where that is larger; without an upper limit.
struct MapErrors {
    /// Ascending, with the name of the point.
    relative: Vec<(f64, String)>,
    /// Share of the points on curved surfaces with errors of at most 8 %.
    curved_share: f64,
    /// Relative error of the total irradiance.
    bias: f64,
}

impl MapErrors {
    fn new(maps: &LightMaps, points: &[ReferencePoint]) -> Self {
        let light: Vec<f64> =
            points.iter().map(|point| luminance(maps.irradiance(&point.place).unwrap())).collect();
        let all: f64 = points.iter().map(|point| point.irradiance).sum();
        let floor = 0.01 * all / points.len() as f64;
        let compare = |(point, &light): (&ReferencePoint, &f64)| {
            let ReferencePoint { kind, shape, position, normal, irradiance, deviation, .. } = point;
            let error = (light - irradiance).abs() / irradiance.max(floor);
            let name = format!(
                "{kind} {shape} at {position:.3}, normal {normal:.2}: {light:.4}, path {irradiance:.4} +- {deviation:.4}"
            );
            (error, name)
        };
        let mut relative: Vec<(f64, String)> = points.iter().zip(&light).map(compare).collect();
        let curved = points.iter().zip(&relative).filter(|(point, _)| point.is_curved);
        let curved: Vec<bool> = curved.map(|(_, (error, _))| *error <= 0.08).collect();
        let curved_share = curved.iter().filter(|near| **near).count() as f64 / curved.len().max(1) as f64;
        relative.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { relative, curved_share, bias: light.iter().sum::<f64>() / all - 1.0 }
    }

    fn mean(&self) -> f64 {
        self.relative.iter().map(|(error, _)| error).sum::<f64>() / self.relative.len() as f64
    }

    fn at(&self, share: f64) -> f64 {
        let count = self.relative.len();
        self.relative[((count as f64 * share) as usize).min(count - 1)].0
    }
}

#[test]
fn light_maps_agree_with_path_tracing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let scene_name = setting("GLANZ_BAKE_SCENE", SUITE_SCENE);
    let file = root.join(&scene_name);
    let settings = BakeSettings {
        density: f64::from(number("GLANZ_BAKE_DENSITY", 16)),
        rays: number("GLANZ_BAKE_RAYS", 256),
        ..BakeSettings::default()
    };
    let description = load(&file, &Options::default()).unwrap_or_else(|error| panic!("{error}")).description;
    let (scene, _) = Scene::resolve(description).unwrap();
    let mut elements = Elements::new(&scene, &ElementSettings { side: 0.3 }).unwrap();
    elements.cut_at_walls(settings.density).unwrap();
    let (mut points, mut too_far) = (Vec::new(), Vec::new());
    for name in setting("GLANZ_BAKE_METHODS", "gather natural").split_whitespace() {
        let method = BakeMethod::from_name(name).expect("a method of the bake");
        let start = std::time::Instant::now();
        let light =
            bake(&elements, &BakeSettings { method, ..settings }, &mut Silent, &CancelFlag::default());
        let maps = light.unwrap().maps;
        let seconds = start.elapsed().as_secs_f64();
        if points.is_empty() {
            let wanted = PointSettings {
                count: number("GLANZ_BAKE_POINTS", POINTS),
                error: 0.005,
                samples: number("GLANZ_BAKE_SAMPLES", 4096),
                density: settings.density,
                threads: 0,
            };
            let found = reference_points(&scene, &maps, &wanted).unwrap_or_else(|error| panic!("{error}"));
            println!("{} points beside these are covered", found.covered);
            // They must be few where little stands on other surfaces.
            assert!(scene_name != SUITE_SCENE || 20 * found.covered <= wanted.count, "{}", found.covered);
            points = found.points;
        }
        let texels: usize = maps.iter().map(|map| map.irradiance.len()).sum();
        let errors = MapErrors::new(&LightMaps::new(&elements, maps), &points);
        println!(
            "{}: {texels} texels in {seconds:.1} s; {} points: mean error {:.2} %, median {:.2} %, 95 % within {:.2} %, \
             largest {:.1} %; on curved surfaces {:.1} % within 8 %; of all light {:+.2} %",
            method.name(),
            points.len(),
            100.0 * errors.mean(),
            100.0 * errors.at(0.5),
            100.0 * errors.at(0.95),
            100.0 * errors.at(1.0),
            100.0 * errors.curved_share,
            100.0 * errors.bias,
        );
        for (error, name) in errors.relative.iter().rev().take(12) {
            println!("{:6.1} %  {name}", 100.0 * error);
        }
        // Few points are on curved surfaces, some inside the dark vase, where the reference has errors of up to 9 % itself.
        let [mean, almost_all, curved_share] =
            if method == BakeMethod::Gather { [0.02, 0.06, 0.5] } else { [0.03, 0.1, 0.5] };
        // In a furnished room, dark nooks decide these.
        let is_near = scene_name != SUITE_SCENE
            || errors.mean() <= mean && errors.at(0.95) <= almost_all && errors.curved_share >= curved_share;
        if !(is_near && errors.at(0.5) <= 0.03 && errors.bias.abs() <= 0.03) {
            too_far.push(method.name());
        }
    }
    let mean = points.iter().map(|point| point.irradiance).sum::<f64>() / points.len() as f64;
    let noise = points.iter().map(|point| point.deviation / point.irradiance.max(0.01 * mean)).sum::<f64>();
    println!("standard error of the reference {:.2} %", 100.0 * noise / points.len() as f64);
    assert!(too_far.is_empty(), "too far from path tracing: {too_far:?}");
}
