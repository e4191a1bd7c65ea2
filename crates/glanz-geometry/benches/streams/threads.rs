//! Hits of many rays and the surface at them, on all threads.

use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

use glanz_geometry::{BoundedRay, RaySurface, Surface};
use rayon::prelude::*;

use super::ray_sets::random_lines;
use super::{BATCH, Failure, Model, TIMES, median};

/// Number of rays if none is asked for.
const RAYS: usize = 1_000_000;

/// Writes the rate of random lines, of the hits alone and with the surface at the hits. `words`: name of a model (bicubic) and number of
/// rays (a million).
pub(super) fn rates(words: &[String], out: &mut impl Write) -> Result<(), Failure> {
    let name = words.first().map_or("bicubic", String::as_str);
    let count = words.get(1).map_or(Ok(RAYS), |count| count.parse())?;
    let surface = Model::named(name)?.surface()?;
    let rays: Vec<BoundedRay> =
        random_lines(&surface.bounds(), count).into_iter().map(BoundedRay::from).collect();
    for (what, with_points) in [("hits", false), ("hits and points", true)] {
        let times = (0..TIMES).map(|_| {
            let start = Instant::now();
            black_box(sums(&surface, &rays, with_points));
            start.elapsed().as_secs_f64()
        });
        let rate = 1e-6 * count as f64 / median(times.collect());
        writeln!(out, "{name}, {count} random lines, {what}: {rate:.3} million rays a second")?;
    }
    Ok(())
}

/// Sums of distances and of texture coordinates at the hits.
fn sums(surface: &Surface, rays: &[BoundedRay], with_points: bool) -> f64 {
    let batch = |rays: &[BoundedRay]| {
        let (mut hits, mut points) = (Vec::new(), Vec::new());
        surface.closest_batch(rays, &mut hits);
        let sum = hits.iter().flatten().map(|hit| hit.t).sum::<f64>();
        if !with_points {
            return sum;
        }
        let (met, found): (Vec<_>, Vec<_>) =
            rays.iter().zip(&hits).filter_map(|(ray, hit)| Some((ray.ray, (*hit)?))).unzip();
        surface.point_batch(&met, &found, &mut points);
        sum + points.iter().map(|point| point.uv.x + point.normal.z).sum::<f64>()
    };
    rays.par_chunks(BATCH).map(batch).sum()
}
