//! Rays in batches against the same rays one by one: `cargo bench -p glanz-geometry --bench streams [-- MODEL|SET ...]`.
//!
//! Both ways take turns in one run, on one thread, so that the ratio of their processor times holds on a busy machine as well. Rays are those
//! of a camera in tiles of 64 x 64 pixels, the same in random order, and random lines through the surface, in batches of 4096.
//!
//! With the word `growth`, instead of the models, surfaces of a thousand to a million patches, or of the numbers that follow: time and
//! memory of building, and the same rates, as CSV. With the word `threads`, and the name of a model and a number of rays after it, the
//! rate of random lines on all threads.

#[path = "../freeform/camera_rays.rs"]
mod camera_rays;
mod growth;
#[path = "../freeform/models.rs"]
mod models;
mod processor_time;
mod ray_sets;
mod threads;

use std::hint::black_box;
use std::io::Write;

use camera_rays::{camera_rays, shuffled};
use glanz_geometry::{BoundedRay, RaySurface, Surface};
use glanz_math::Ray;
use models::{Failure, Model, NAMES};
use processor_time::processor_time;
use ray_sets::{TILE, random_lines, tiles};

/// Size of the picture, pixels.
const PICTURE: [usize; 2] = [960, 512];

/// Rays of a batch.
const BATCH: usize = TILE * TILE;

/// Number of measurements of each way.
const TIMES: usize = 7;

/// Number of runs of one measurement: together they take many ticks of the clock, which are 4 ms on some systems.
const RUNS: usize = 10;

/// Sets of rays.
const SETS: [&str; 3] = ["tiles", "shuffled", "random lines"];

/// Whether `name` is among the words, or none of its kind is.
fn is_asked(name: &str, kind: &[&str], words: &[String]) -> bool {
    words.iter().any(|word| word == name) || !words.iter().any(|word| kind.contains(&word.as_str()))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Seconds of both ways, which take turns.
fn medians(mut single: impl FnMut(), mut batch: impl FnMut()) -> [f64; 2] {
    let seconds = |work: &mut dyn FnMut()| {
        let start = processor_time();
        for _ in 0..RUNS {
            work();
        }
        1e-9 * (processor_time() - start) as f64 / RUNS as f64
    };
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..TIMES {
        times[0].push(seconds(&mut single));
        times[1].push(seconds(&mut batch));
    }
    times.map(median)
}

/// The sets of rays for a surface, in the order of their names.
fn ray_sets_of(surface: &Surface) -> [Vec<Ray>; 3] {
    let camera = camera_rays(&surface.bounds(), PICTURE[0] as u32, PICTURE[1] as u32);
    let lines = random_lines(&surface.bounds(), camera.len());
    [tiles(&camera, PICTURE), shuffled(camera), lines]
}

/// Seconds of the closest hits of all rays, one by one and in batches.
fn closest_hits(surface: &Surface, rays: &[Ray]) -> [f64; 2] {
    let bounded: Vec<BoundedRay> = rays.iter().map(|&ray| ray.into()).collect();
    let mut hits = Vec::new();
    medians(
        || {
            let t = rays.iter().filter_map(|ray| surface.intersect(ray, f64::INFINITY));
            black_box(t.map(|hit| hit.t).sum::<f64>());
        },
        || {
            let mut sum = 0.0;
            for batch in bounded.chunks(BATCH) {
                surface.closest_batch(batch, &mut hits);
                sum += hits.iter().flatten().map(|hit| hit.t).sum::<f64>();
            }
            black_box(sum);
        },
    )
}

fn measure(name: &str, surface: &Surface, only: &[String], out: &mut impl Write) -> Result<(), Failure> {
    for (set, rays) in SETS.into_iter().zip(ray_sets_of(surface)) {
        if !is_asked(set, &SETS, only) {
            continue;
        }
        let bounded: Vec<BoundedRay> = rays.iter().map(|&ray| ray.into()).collect();
        let mut occluded = Vec::new();
        let closest = closest_hits(surface, &rays);
        let any = medians(
            || {
                black_box(rays.iter().filter(|ray| surface.occluded(ray, f64::INFINITY)).count());
            },
            || {
                let mut count = 0;
                for batch in bounded.chunks(BATCH) {
                    surface.occluded_batch(batch, &mut occluded);
                    count += occluded.iter().filter(|&&hit| hit).count();
                }
                black_box(count);
            },
        );
        for (query, [single, batch]) in [("closest", closest), ("any", any)] {
            let rate = |seconds: f64| 1e-6 * rays.len() as f64 / seconds;
            let (single_rate, batch_rate, ratio) = (rate(single), rate(batch), single / batch);
            writeln!(out, "{name:18} {set:13} {query:8} {single_rate:7.2} {batch_rate:7.2} {ratio:6.2}")?;
        }
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let named: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let mut out = std::io::stdout();
    if let Some((first, counts)) = named.split_first()
        && first == "growth"
    {
        return growth::table(counts, &mut out);
    }
    if let Some((first, words)) = named.split_first()
        && first == "threads"
    {
        return threads::rates(words, &mut out);
    }
    writeln!(out, "million rays a second, medians of {TIMES}: one by one, in batches of {BATCH}, ratio")?;
    for name in NAMES {
        if is_asked(name, &NAMES, &named) {
            measure(name, &Model::named(name)?.surface()?, &named, &mut out)?;
        }
    }
    Ok(())
}
