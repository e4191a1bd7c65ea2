//! Bernstein coefficients of parts of a leaf: several lists, one behind the other in memory.

use super::parameter_rect::{DyadicRect, ParameterRect};
use crate::bvh::simd::{Isa, Simd, Task};

/// Replaces the cell at `start`, the last one, by its halves.
pub(super) fn split(isa: Isa, cells: &mut Vec<f64>, start: usize, degrees: (usize, usize), across_x: bool) {
    let size = cells.len() - start;
    cells.resize(start + 2 * size, 0.0);
    let (low, high) = cells[start..].split_at_mut(size);
    isa.run(Halving { low, high, degrees, across_x });
}

/// Replaces polynomials by their lower halves in `low`, and fills `high` with the upper ones.
struct Halving<'a> {
    low: &'a mut [f64],
    high: &'a mut [f64],
    degrees: (usize, usize),
    across_x: bool,
}

impl Task for Halving<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { low, high, degrees: (p, q), across_x } = self;
        let lists = low.chunks_exact_mut((p + 1) * (q + 1)).zip(high.chunks_exact_mut((p + 1) * (q + 1)));
        if across_x {
            let rows =
                lists.flat_map(|(low, high)| low.chunks_exact_mut(p + 1).zip(high.chunks_exact_mut(p + 1)));
            for (low, high) in rows {
                for k in 0..=p {
                    high[p - k] = low[p];
                    for i in (k + 1..=p).rev() {
                        low[i] = 0.5 * (low[i - 1] + low[i]);
                    }
                }
            }
            return;
        }
        // Rows at a time, whose entries are neighbours.
        for (low, high) in lists {
            for k in 0..=q {
                high[(q - k) * (p + 1)..][..=p].copy_from_slice(&low[q * (p + 1)..]);
                for j in (k + 1..=q).rev() {
                    let (before, here) = low.split_at_mut(j * (p + 1));
                    for (here, before) in here[..=p].iter_mut().zip(&before[(j - 1) * (p + 1)..]) {
                        *here = 0.5 * (before + *here);
                    }
                }
            }
        }
    }
}

/// Restricts polynomials to a part of the square. On entry the coefficients along v are consecutive, on return those along u.
pub(super) fn restrict(cells: &mut Vec<f64>, degrees: (usize, usize), part: DyadicRect) {
    Isa::detect().run(Restriction { cells, degrees, part });
}

struct Restriction<'a> {
    cells: &'a mut Vec<f64>,
    degrees: (usize, usize),
    part: DyadicRect,
}

impl Task for Restriction<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { cells, degrees: (p, q), part } = self;
        let ParameterRect { u, v } = part.rect();
        let (size, n) = (cells.len(), (p + 1) * (q + 1));
        cells.reserve(size);
        for start in (0..size).step_by(n) {
            restrict_columns(&mut cells[start..start + n], q + 1, u);
            for j in 0..=q {
                for i in 0..=p {
                    cells.push(cells[start + i * (q + 1) + j]);
                }
            }
        }
        cells.drain(..size);
        for list in cells.chunks_exact_mut(n) {
            restrict_columns(list, p + 1, v);
        }
    }
}

/// Restricts each column of a table to a part of [0, 1]: Bernstein coefficients, one in each row of `length` numbers. By de Casteljau's
/// algorithm at the upper end, then at the lower one; whole rows at a time, for vector instructions.
#[inline(always)]
fn restrict_columns(rows: &mut [f64], length: usize, [low, high]: [f64; 2]) {
    let size = rows.len();
    if high < 1.0 {
        for k in 1..size / length {
            // Row after row from the last one, each with the one before it.
            for row in (k..size / length).rev() {
                let (before, here) = rows.split_at_mut(row * length);
                let before = &before[(row - 1) * length..];
                for (here, &before) in here[..length].iter_mut().zip(before) {
                    *here = (1.0 - high) * before + high * *here;
                }
            }
        }
    }
    if low > 0.0 {
        let x = low / high;
        for k in 1..size / length {
            for row in 0..size / length - k {
                let (here, behind) = rows.split_at_mut((row + 1) * length);
                let here = &mut here[row * length..];
                for (here, &behind) in here.iter_mut().zip(&behind[..length]) {
                    *here = (1.0 - x) * *here + x * behind;
                }
            }
        }
    }
}
