//! Time of solvers over the number of elements in a furnished room: all form factors with the Gauss-Seidel method, and the hierarchical
//! solver, which divides elements by an error bound.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot make its input has failed")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glanz_job::{CancelFlag, Silent};
use glanz_math::DVec3;
use glanz_radiosity::elements::{ElementSettings, Elements};
use glanz_radiosity::form_factor::FormFactors;
use glanz_radiosity::solve::{GaussSeidelSettings, HierarchicalSettings, gauss_seidel, hierarchical};
use glanz_scene::Scene;
use glanz_scene::description::ShapeDescription;

// Shared with the tests.
#[path = "../src/scenes.rs"]
mod scenes;

use scenes::{parallelogram, scene, walls};

fn cuboid(min: [f64; 3], max: [f64; 3]) -> (ShapeDescription, f32, f32) {
    (ShapeDescription::cuboid(min, max), 0.4, 0.0)
}

/// 6 m x 5 m x 3 m: two lamps under the ceiling, a table with chairs, shelves with books, a rug and a ball in a corner.
fn room() -> Scene {
    let mut shapes: Vec<_> =
        walls(DVec3::new(6.0, 5.0, 3.0)).into_iter().map(|wall| (wall, 0.7, 0.0)).collect();
    for x in [1.5, 3.9] {
        shapes.push((parallelogram(DVec3::new(x, 2.0, 2.8), DVec3::Y, DVec3::X * 0.6), 0.5, 20.0));
    }
    let legs = |at: [f64; 2], size: [f64; 2], height: f64| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        corners.map(|[u, v]| {
            let (x, y) = (at[0] + u * (size[0] - 0.05), at[1] + v * (size[1] - 0.05));
            cuboid([x, y, 0.0], [x + 0.05, y + 0.05, height])
        })
    };
    shapes.extend(legs([2.0, 2.0], [1.8, 0.9], 0.7));
    shapes.push(cuboid([2.0, 2.0, 0.7], [3.8, 2.9, 0.74]));
    for [x, y] in [[2.2, 1.4], [3.1, 1.4], [2.2, 3.1], [3.1, 3.1]] {
        shapes.extend(legs([x, y], [0.45, 0.45], 0.43));
        shapes.push(cuboid([x, y, 0.43], [x + 0.45, y + 0.45, 0.47]));
        let back = if y < 2.0 { y } else { y + 0.41 };
        shapes.push(cuboid([x, back, 0.5], [x + 0.45, back + 0.04, 0.95]));
    }
    for k in 0..5 {
        let z = 0.1 + 0.4 * f64::from(k);
        shapes.push(cuboid([0.001, 1.0, z], [0.3, 3.0, z + 0.025]));
        for i in 0..20 {
            let (y, high) = (1.02 + 0.095 * f64::from(i), 0.22 + 0.02 * f64::from((i * 7 + k) % 6));
            shapes.push(cuboid([0.02, y, z + 0.026], [0.25, y + 0.06, z + 0.026 + high]));
        }
    }
    shapes.push((parallelogram(DVec3::new(4.2, 1.0, 0.01), DVec3::X * 1.5, DVec3::Y * 2.5), 0.3, 0.0));
    shapes.push((ShapeDescription::sphere(0.5), 0.6, 0.0));
    scene(shapes)
}

fn start(scene: &Scene, side: f64) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side }).unwrap()
}

fn solvers(c: &mut Criterion) {
    let scene = room();
    let cancel = CancelFlag::default();
    let mut group = c.benchmark_group("room");
    group.sample_size(10);
    for side in [2.0, 1.0] {
        let elements = start(&scene, side);
        let count = elements.list.len();
        group.bench_function(BenchmarkId::new("full", count), |b| {
            b.iter(|| {
                let factors = FormFactors::new(&elements, &cancel).unwrap();
                gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &cancel).unwrap()
            });
        });
    }
    for bound in [1e-3, 1e-4, 1e-5] {
        let settings = HierarchicalSettings { bound, side: 0.05, ..HierarchicalSettings::default() };
        let solve = || hierarchical(start(&scene, 100.0), &settings, &mut Silent, &cancel).unwrap();
        let name = BenchmarkId::new("hierarchical", solve().elements.list.len());
        group.bench_function(name, |b| b.iter(solve));
    }
    group.finish();
}

criterion_group!(benches, solvers);
criterion_main!(benches);
