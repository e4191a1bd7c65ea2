//! Bernstein coefficients of parts of a leaf: several lists, one behind the other in memory.

use super::parameter_rect::{DyadicRect, ParameterRect};

/// Replaces the cell at `start`, the last one, by its halves.
pub(super) fn split(cells: &mut Vec<f64>, start: usize, (p, q): (usize, usize), across_x: bool) {
    let size = cells.len() - start;
    cells.resize(start + 2 * size, 0.0);
    let (low, high) = cells[start..].split_at_mut(size);
    let n = (p + 1) * (q + 1);
    let (rows, length, stride, step) =
        if across_x { (q + 1, p + 1, p + 1, 1) } else { (p + 1, q + 1, 1, p + 1) };
    for list in 0..size / n {
        for row in 0..rows {
            let first = list * n + row * stride;
            for k in 0..length {
                high[first + (length - 1 - k) * step] = low[first + (length - 1) * step];
                for i in (k + 1..length).rev() {
                    let at = first + i * step;
                    low[at] = 0.5 * (low[at - step] + low[at]);
                }
            }
        }
    }
}

/// Restricts polynomials to a part of the square. On entry the coefficients along v are consecutive, on return those along u.
pub(super) fn restrict(cells: &mut Vec<f64>, (p, q): (usize, usize), part: DyadicRect) {
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

/// Restricts each column of a table to a part of [0, 1]: Bernstein coefficients, one in each row of `length` numbers. By de Casteljau's
/// algorithm at the upper end, then at the lower one; whole rows at a time, for vector instructions.
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
