//! Time to compute textures of 400 x 400 texels from about 500 samples of a quadtree and from 16 x 16 cells (document 003, table 4.1).

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot make its input has failed")]

use criterion::{Criterion, criterion_group, criterion_main};
use glanz_math::{DVec2, DVec3};
use glanz_radiosity::reconstruct::{Border, Interpolation, ParameterCell, ParameterCells};

const SIZE: [usize; 2] = [400, 400];

/// Cells that are fine along a diagonal.
fn quadtree() -> ParameterCells {
    let mut open = vec![(DVec2::ZERO, 1.0)];
    let mut cells = Vec::new();
    while let Some((min, side)) = open.pop() {
        let crosses = (min.x + 0.3 * min.y - 0.55).abs() < 1.3 * side;
        if side > 0.13 || (side > 0.008 && crosses) {
            let half = 0.5 * side;
            let quarters = [[0.0, 0.0], [half, 0.0], [0.0, half], [half, half]];
            open.extend(quarters.map(|offset| (min + DVec2::from(offset), half)));
        } else {
            let middle = min + 0.5 * side;
            let value = if middle.x + 0.3 * middle.y < 0.55 { DVec3::ONE } else { 0.2 * DVec3::ONE };
            cells.push(ParameterCell { min, max: min + side, value });
        }
    }
    ParameterCells::try_new(cells).unwrap()
}

fn textures(c: &mut Criterion) {
    let values: Vec<DVec3> = (0..256).map(|i| DVec3::splat(f64::from(i % 7))).collect();
    let (tree, grid) = (quadtree(), ParameterCells::grid([16, 16], &values).unwrap());
    let mut group = c.benchmark_group("texture_400");
    group.sample_size(10);
    for method in Interpolation::ALL {
        for (name, cells) in [("grid", &grid), ("quadtree", &tree)] {
            if method.needs_grid() && name == "quadtree" {
                continue;
            }
            // Includes the preparation, since a texture is made once.
            let name = format!("{}/{name}_{}", method.name(), cells.samples(Border::Sampled).len());
            group.bench_function(name, |b| {
                b.iter(|| method.of_cells(cells, Border::Sampled).unwrap().texture(SIZE));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, textures);
criterion_main!(benches);
