//! Rays per second of freeform surfaces: `cargo bench -p glanz-geometry --bench freeform`.
//!
//! Rays are those of a camera that the surface fills, line by line and in random order, so that the second set shows what
//! caches and branches cost. Each figure is that of the closest hit alone; the share of hits stands in the name. For peers see
//! `peers/freeform`.

mod camera_rays;
mod models;

use std::hint::black_box;

use camera_rays::{camera_rays, shuffled};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glanz_geometry::{RaySurface, Surface};
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

criterion_group!(benches, closest_hit, build);
criterion_main!(benches);
