//! Rays per second of freeform surfaces: `cargo bench -p glanz-geometry --bench freeform`.
//!
//! Rays are those of a camera that the surface fills, line by line and in random order, so that the second set shows what
//! caches and branches cost. Each figure is that of the closest hit alone; the share of hits stands in the name. For peers see
//! `peers/freeform`. Two more groups measure building: of the surfaces, and of trimmed regions.

mod camera_rays;
mod models;

use std::hint::black_box;

use camera_rays::{camera_rays, shuffled};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glanz_geometry::trim::{TrimCurve, TrimRegion};
use glanz_geometry::{RaySurface, Surface, SurfaceError};
use glanz_math::DVec2;
use models::{Failure, Model, NAMES};

const PICTURE: (u32, u32) = (480, 270);

fn closest_hit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("freeform, closest hit");
    for name in NAMES {
        let surface = match Model::named(name).and_then(|model| model.surface()) {
            Ok(surface) => surface,
            Err(error) => unreachable!("the parameters of the models are possible: {error}"),
        };
        let coherent = camera_rays(&surface.bounds(), PICTURE.0, PICTURE.1);
        let hits = coherent.iter().filter(|ray| surface.intersect(ray, f64::INFINITY).is_some()).count();
        let share = 100 * hits / coherent.len();
        let mixed = shuffled(coherent.clone());
        group.throughput(Throughput::Elements(coherent.len() as u64));
        for (order, rays) in [("coherent", &coherent), ("shuffled", &mixed)] {
            group.bench_function(format!("{name}, {order} ({share} % hits)"), |bencher| {
                bencher.iter(|| {
                    rays.iter()
                        .filter_map(|ray| surface.intersect(black_box(ray), f64::INFINITY))
                        .map(|hit| hit.t)
                        .sum::<f64>()
                });
            });
        }
        if let Surface::Freeform(surface) = &surface {
            assert_eq!(surface.undecided(), 0, "{name}: searches that gave up");
        }
    }
    group.finish();
}

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("freeform, from control points to hierarchy");
    group.sample_size(10);
    for name in NAMES {
        let Ok(model) = Model::named(name) else { continue };
        group.bench_function(name, |bencher| bencher.iter(|| -> Result<_, Failure> { model.surface() }));
    }
    group.finish();
}

/// The border of the unit square and `rows` times `rows` round holes in it.
fn perforated_sheet(rows: u32) -> Result<Vec<Vec<TrimCurve>>, SurfaceError> {
    let size = 1.0 / f64::from(rows);
    let hole = |(i, j)| {
        let center = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) * size;
        TrimCurve::try_circle(center, 0.35 * size).map(|circle| vec![circle.reversed()])
    };
    let border = TrimCurve::try_rectangle(DVec2::ZERO, DVec2::ONE).map(|border| vec![border]);
    let holes = (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))).map(hole);
    std::iter::once(border).chain(holes).collect()
}

fn region(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trimmed region, from curves to cells");
    group.sample_size(20);
    for rows in [3, 10, 32] {
        let Ok(loops) = perforated_sheet(rows) else { continue };
        group.bench_function(format!("{} holes", rows * rows), |bencher| {
            bencher.iter_batched(|| loops.clone(), TrimRegion::try_from_curves, BatchSize::LargeInput);
        });
    }
    group.finish();
}

criterion_group!(benches, closest_hit, build, region);
criterion_main!(benches);
