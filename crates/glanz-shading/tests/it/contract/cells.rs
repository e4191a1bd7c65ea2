//! Integrals over cells of equal solid angles.

use super::*;

/// Gauss-Legendre nodes and weights on [0, 1], of orders 4 and 3.
pub(super) const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];
pub(super) const COARSE_GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];

pub(super) const ROWS: usize = 80;
pub(super) const COLUMNS: usize = 120;

pub(super) fn cell_of(w: DVec3) -> usize {
    let turn = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
    let row = ((w.z + 1.0) * 0.5 * ROWS as f64) as usize;
    row.min(ROWS - 1) * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// The integral of `f` over solid angle in each cell of a grid of equal solid angles.
///
/// Steps and peaks narrower than a cell are seen if it is divided at least once; `divisions`: the least number.
pub(super) fn per_cell(divisions: u32, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let cells = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| [row, column]));
    cells
        .map(|[row, column]| part_integral(&f, [row as f64, column as f64], [1.0; 2], [divisions, 5]))
        .collect()
}

/// The integral over a part of a cell, divided at least `least` and at most `most` times.
pub(super) fn part_integral(
    f: &impl Fn(DVec3) -> f64,
    corner: [f64; 2],
    size: [f64; 2],
    [least, most]: [u32; 2],
) -> f64 {
    let rule = |rule: &[(f64, f64)]| {
        let mut sum = 0.0;
        for (x, wx) in rule {
            for (y, wy) in rule {
                let z = 2.0 * (corner[0] + size[0] * y) / ROWS as f64 - 1.0;
                sum += wx * wy * f(direction(z, TAU * (corner[1] + size[1] * x) / COLUMNS as f64));
            }
        }
        sum * size[0] * size[1] * 2.0 * TAU / (ROWS * COLUMNS) as f64
    };
    let (coarse, fine) = (rule(&COARSE_GAUSS), rule(&GAUSS));
    // A twentieth of a sample in 100 000.
    if most == 0 || least == 0 && (fine - coarse).abs() < 5e-7 {
        return fine;
    }
    let parts = |axis: usize| {
        // Both rules would miss the same steps of the density in even parts.
        let first = 0.382 * size[axis];
        [(corner[axis], first), (corner[axis] + first, size[axis] - first)]
    };
    let parts =
        parts(0).map(|(row, height)| parts(1).map(|(column, width)| ([row, column], [height, width])));
    let next = [least.saturating_sub(1), most - 1];
    parts.iter().flatten().map(|&(corner, size)| part_integral(f, corner, size, next)).sum()
}
