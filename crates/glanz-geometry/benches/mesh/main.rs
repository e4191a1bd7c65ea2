//! Building a mesh of a million triangles, and rays against it: `cargo bench -p glanz-geometry --bench mesh`.
//!
//! Times on a shared machine are only worth comparing within one run; for peers see `peers/embree`.

mod landscape;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glanz_geometry::RaySurface;
use glanz_geometry::mesh::Mesh;
use glanz_math::{DVec3, Ray};
use landscape::{Model, bounced_rays, camera_rays, displaced_sphere, random_rays, wavy_grid};

fn mesh(Model { positions, indices }: Model) -> Option<Mesh> {
    Mesh::try_new(positions, indices, None, None).ok()
}

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build");
    group.sample_size(10);
    for (name, model) in [("sphere", displaced_sphere as fn(u32) -> Model), ("grid", |n| wavy_grid(2 * n))] {
        let Model { positions, indices } = model(354);
        group.throughput(Throughput::Elements(indices.len() as u64));
        for threads in [1, 2] {
            let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { continue };
            group.bench_function(format!("{name}, {threads} threads"), |bencher| {
                bencher.iter_batched(
                    || (positions.clone(), indices.clone()),
                    |(positions, indices)| pool.install(|| Mesh::try_new(positions, indices, None, None)),
                    criterion::BatchSize::LargeInput,
                );
            });
        }
    }
    group.finish();
}

fn rays(group: &mut BenchmarkGroup<'_, WallTime>, mesh: &Mesh, name: &str, rays: &[Ray]) {
    group.throughput(Throughput::Elements(rays.len() as u64));
    for threads in [1, 2] {
        let part = rays.len().div_ceil(threads);
        let all = |query: &(dyn Fn(&Ray) + Sync)| {
            std::thread::scope(|scope| {
                for rays in rays.chunks(part) {
                    scope.spawn(move || rays.iter().for_each(query));
                }
            });
        };
        group.bench_function(format!("{name}, closest, {threads} threads"), |bencher| {
            bencher.iter(|| {
                all(&|ray| {
                    std::hint::black_box(mesh.intersect(ray, f64::INFINITY));
                });
            });
        });
        group.bench_function(format!("{name}, any, {threads} threads"), |bencher| {
            bencher.iter(|| {
                all(&|ray| {
                    std::hint::black_box(mesh.occluded(ray, f64::INFINITY));
                });
            });
        });
    }
}

fn query(criterion: &mut Criterion) {
    let camera = camera_rays(512, 512);
    let random = random_rays(1 << 18);
    for (name, model) in [("sphere", displaced_sphere(354)), ("grid", wavy_grid(708))] {
        // The same in f64: moved by less than the f32 grid.
        let moved = model.positions.iter().map(|&p| p + DVec3::splat(1e-12)).collect();
        let double = mesh(Model { positions: moved, indices: model.indices.clone() });
        let Some((single, double)) = mesh(model).zip(double) else { continue };
        let bounced = bounced_rays(&single, &camera);
        for (kind, mesh) in [("f32", single), ("f64", double)] {
            let mut group = criterion.benchmark_group(format!("{name} {kind}"));
            group.sample_size(10);
            rays(&mut group, &mesh, "camera", &camera);
            rays(&mut group, &mesh, "bounced", &bounced);
            rays(&mut group, &mesh, "random", &random);
            group.finish();
        }
    }
}

criterion_group!(benches, build, query);
criterion_main!(benches);
