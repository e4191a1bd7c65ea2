//! Pictures by `guided` and `light` are those by `path`: a Z-test in every room and every other scene of `scenes`.
//!
//! All take the same number of independent samples, so that variances are what they seem. `GLANZ_UNBIASED_SAMPLES` says how many
//! for each pixel, a power of two, since passes end there; `cargo xtask unbiased` takes 16 384.

use std::path::{Path, PathBuf};

use glanz_formats::{Options, load};
use glanz_job::{CancelFlag, Silent};
use glanz_sampling::SamplerKind;
use glanz_scene::Scene;
use glanz_scene::description::{Description, FilterDescription, FilterKind, IntegratorDescription};
use glanz_transport::{
    Aov, AovSet, Film, FilmFormat, FilmSensor, Filter, IntegratorSettings, RenderSettings, render,
};

const SIZE: [u32; 2] = [24, 18];

/// Samples per pixel in the test suite.
const SAMPLES: u32 = 256;

/// From here on blocks of pixels are judged too: with fewer samples their variances are not known well where light is rare.
const MANY: u32 = 4096;

/// Width and height of a block in pixels. Single pixels cannot be judged: in `glass`, a pixel of `path` that a few of its 16 384
/// paths from the lamp should have reached, and none has, is too dark by 14 times the error that it estimates.
const BLOCK: usize = 2;

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let rooms = ["direct", "uplights", "open", "door", "glass"].map(|room| format!("rooms/{room}"));
    let others = ["demo", "teapot"].map(str::to_owned);
    rooms.into_iter().chain(others).map(|name| folder.join(name).with_extension("pbrt")).collect()
}

/// Mean and its variance of each pixel's green: the other bands tell nearly the same.
fn picture(
    scene: &Scene,
    description: &Description,
    integrator: &str,
    samples: u32,
    seed: u64,
) -> Vec<[f64; 2]> {
    let asked = IntegratorDescription { name: integrator.into(), ..description.integrator.clone() };
    let integrator = IntegratorSettings::resolve(&asked).unwrap().build();
    let filter = FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] };
    let aovs: AovSet = [Aov::Variance].into_iter().collect();
    let film = FilmFormat {
        aovs,
        passes: integrator.learns(),
        splats: integrator.splats(),
        ..FilmFormat::plain(SIZE)
    };
    let settings = RenderSettings {
        filter: Filter::try_new(&filter).unwrap(),
        sensor: FilmSensor::default(),
        sampler: SamplerKind::Independent,
        seed,
        samples_per_pixel: samples,
        samples: 0..samples,
        threads: 2,
        spectral: false,
        time_limit: None,
    };
    let film = Film::try_new(film).unwrap();
    let outcome =
        render(scene, integrator.as_ref(), &settings, film, &mut Silent, &CancelFlag::default()).unwrap();
    let pixels = outcome.film.to_pixels().unwrap();
    let plane = |name: &str| pixels.channel(name).unwrap().iter().map(|&value| f64::from(value));
    plane("G").zip(plane("Variance.G")).map(|(mean, variance)| [mean, variance]).collect()
}

/// Mean of all pixels and its standard error.
fn average(picture: &[[f64; 2]]) -> [f64; 2] {
    let n = picture.len() as f64;
    let sum = |i: usize| picture.iter().map(|pixel| pixel[i]).sum::<f64>();
    [sum(0) / n, sum(1).sqrt() / n]
}

/// Mean and its variance of each block of pixels.
fn blocks(picture: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let [width, height] = SIZE.map(|n| n as usize);
    let corners = (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| [x, y]));
    let of_corner = |[x, y]: [usize; 2]| {
        let pixels = (0..BLOCK * BLOCK).map(|i| picture[x + i % BLOCK + width * (y + i / BLOCK)]);
        let [sum, variance] = pixels.fold([0.0; 2], |[s, v], [mean, variance]| [s + mean, v + variance]);
        let n = (BLOCK * BLOCK) as f64;
        [sum / n, variance / (n * n)]
    };
    corners.map(of_corner).collect()
}

/// The largest standard error of a pixel: that of the worst outlier.
fn worst(picture: &[[f64; 2]]) -> f64 {
    picture.iter().map(|pixel| pixel[1].sqrt()).fold(0.0, f64::max)
}

#[test]
fn guided_pictures_are_those_of_path() {
    compare("guided", 12);
}

#[test]
fn pictures_of_light_are_those_of_path() {
    compare("light", 13);
}

fn compare(integrator: &str, seed: u64) {
    let samples =
        std::env::var("GLANZ_UNBIASED_SAMPLES").ok().and_then(|n| n.parse().ok()).unwrap_or(SAMPLES);
    println!("{samples} samples of each of {} x {} pixels", SIZE[0], SIZE[1]);
    let mut faults = Vec::new();
    for file in scenes() {
        let loaded = load(&file, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
        let mut description = loaded.description;
        description.film.resolution = SIZE;
        let (scene, _) = Scene::resolve(description.clone()).unwrap();
        // With one seed both would see the same points of the scene.
        let [path, other] = [("path", 11), (integrator, seed)]
            .map(|(name, seed)| picture(&scene, &description, name, samples, seed));
        let ([mean, error], [other_mean, other_error]) = (average(&path), average(&other));
        let z = (other_mean - mean) / error.hypot(other_error);
        let squares: Vec<f64> = blocks(&path)
            .iter()
            .zip(&blocks(&other))
            .filter(|([_, v], [_, w])| v + w > 0.0)
            .map(|([a, v], [b, w])| (a - b).powi(2) / (v + w))
            .collect();
        // Of a chi-square variable per block: 1 +- root of 2 / n if all variances were known.
        let spread = squares.iter().sum::<f64>() / squares.len() as f64;
        let largest = squares.iter().copied().fold(0.0, f64::max).sqrt();
        let name = file.file_stem().unwrap().to_string_lossy();
        println!(
            "{name:9} path {mean:.5} +- {error:.5}, {integrator} {other_mean:.5} +- {other_error:.5}: Z {z:+.2}; blocks: mean Z^2 {spread:.3} of {}, \
             largest |Z| {largest:.2}, largest standard error {:.4} and {:.4}",
            squares.len(),
            worst(&path),
            worst(&other)
        );
        // One of 30 000 fair tests fails.
        if z.abs() > 4.0 {
            faults.push(format!("{name}: Z = {z}"));
        }
        // 5 standard deviations of the sum, and as much again since variances are estimates.
        if samples >= MANY && spread > 1.0 + 10.0 * (2.0 / squares.len() as f64).sqrt() {
            faults.push(format!("{name}: mean Z^2 of blocks {spread}"));
        }
        // Where a guide is off, and no caustic found, both are the same but for chance, which moves the largest of all by some per cent.
        if samples >= MANY && worst(&other) > 1.1 * worst(&path) {
            faults.push(format!("{name}: outliers beyond those of path"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
