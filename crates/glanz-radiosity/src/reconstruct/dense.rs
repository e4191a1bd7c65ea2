//! Dense systems of linear equations.

use glanz_math::DVec3;
use rayon::prelude::*;

/// Columns that are eliminated before the rest of the matrix is updated.
const PANEL: usize = 32;

/// Smallest number of rows per task of a thread.
const ROWS: usize = 16;

/// Solves A X = B by Gaussian elimination with partial pivoting; `None` if a pivot is 0 or not finite.
///
/// `matrix`: A, row by row, square, with as many rows as B. The result does not depend on the number of threads.
///
/// # Source
/// @press2007 section 2.3; departure: columns are eliminated in blocks, so that the rest of the matrix is read once per block.
pub(super) fn solve(mut matrix: Vec<f64>, right: &[DVec3]) -> Option<Vec<DVec3>> {
    let n = right.len();
    let mut x = right.to_vec();
    for start in (0..n).step_by(PANEL) {
        let end = (start + PANEL).min(n);
        eliminate_panel(&mut matrix, &mut x, start, end)?;
        update_rest(&mut matrix, n, start, end);
    }
    // The factors below the diagonal were swapped along with their rows.
    for i in 0..n {
        let row = &matrix[i * n..i * n + i];
        let known: DVec3 = row.iter().zip(&x).map(|(factor, x)| *factor * *x).sum();
        x[i] -= known;
    }
    for i in (0..n).rev() {
        let row = &matrix[i * n..(i + 1) * n];
        let rest: DVec3 = row[i + 1..].iter().zip(&x[i + 1..]).map(|(factor, x)| *factor * *x).sum();
        x[i] = (x[i] - rest) / row[i];
    }
    Some(x)
}

/// Eliminates the columns `start..end` below the diagonal; factors replace the zeros.
fn eliminate_panel(matrix: &mut [f64], x: &mut [DVec3], start: usize, end: usize) -> Option<()> {
    let n = x.len();
    for k in start..end {
        let size = |&row: &usize| matrix[row * n + k].abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if !(size(&pivot) > 0.0 && size(&pivot).is_finite()) {
            return None;
        }
        if pivot != k {
            let (above, below) = matrix.split_at_mut(pivot * n);
            above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            x.swap(k, pivot);
        }
        let (above, below) = matrix.split_at_mut((k + 1) * n);
        let top = &above[k * n + k..k * n + end];
        for row in below.chunks_exact_mut(n) {
            let factor = row[k] / top[0];
            row[k] = factor;
            row[k + 1..end].iter_mut().zip(&top[1..]).for_each(|(a, b)| *a -= factor * b);
        }
    }
    Some(())
}

/// Updates the columns from `end` on with the elimination of the columns `start..end`.
fn update_rest(matrix: &mut [f64], n: usize, start: usize, end: usize) {
    let (above, below) = matrix.split_at_mut(end * n);
    for i in start + 1..end {
        let (done, row) = above.split_at_mut(i * n);
        subtract(&mut row[..n], &done[start * n..], n, [start, i], end);
    }
    let panel = &above[start * n..];
    below
        .par_chunks_exact_mut(n)
        .with_min_len(ROWS)
        .for_each(|row| subtract(row, panel, n, [start, end], end));
}

/// Subtracts the rows `from..to`, which start `rows`, times the factors in the columns `from..to` of `row`, from the columns of `row`
/// from `end` on; four rows at a time, which reduces memory traffic.
fn subtract(row: &mut [f64], rows: &[f64], n: usize, [from, to]: [usize; 2], end: usize) {
    let (factors, rest) = row.split_at_mut(end);
    let factors = &factors[from..to];
    let mut groups = factors.chunks_exact(4).zip(rows.chunks_exact(4 * n));
    for (f, four) in groups.by_ref() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &four[k * n + end..(k + 1) * n]);
        for ((((x, a), b), c), d) in rest.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *x -= f[0] * a + f[1] * b + (f[2] * c + f[3] * d);
        }
    }
    let left = factors.len() % 4;
    let done = factors.len() - left;
    for (factor, single) in factors[done..].iter().zip(rows[done * n..].chunks_exact(n)) {
        rest.iter_mut().zip(&single[end..]).for_each(|(x, a)| *x -= factor * a);
    }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::hash::combine;

    use super::*;

    /// Numbers in [-1, 1] that look random.
    fn numbers(count: usize, key: u64) -> Vec<f64> {
        (0..count as u64).map(|i| (combine(key, i) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0).collect()
    }

    #[test]
    fn solution_is_mapped_to_the_right_side() {
        for n in [1, 2, 3, 31, 32, 33, 100, 131] {
            let matrix = numbers(n * n, 3);
            let expected: Vec<DVec3> = numbers(3 * n, 5).chunks(3).map(DVec3::from_slice).collect();
            let rows = matrix.chunks(n);
            let right: Vec<DVec3> =
                rows.map(|row| row.iter().zip(&expected).map(|(a, x)| *a * *x).sum()).collect();
            let found = solve(matrix.clone(), &right).unwrap();
            let off = found.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            // The condition numbers of such matrices are of order n.
            assert!(off < 1e-11 * n as f64, "{n}: {off}");
        }
    }

    #[test]
    fn zeros_on_the_diagonal_are_swapped_away() {
        let found = solve(vec![0.0, 2.0, 4.0, 0.0], &[DVec3::splat(6.0), DVec3::splat(2.0)]).unwrap();
        assert_eq!(found, [DVec3::splat(0.5), DVec3::splat(3.0)]);
    }

    #[test]
    fn systems_without_a_solution_are_refused() {
        assert_eq!(solve(vec![0.0, 0.0, 1.0, 0.0], &[DVec3::ONE; 2]), None);
        assert_eq!(solve(vec![f64::NAN], &[DVec3::ONE]), None);
        assert_eq!(solve(Vec::new(), &[]), Some(Vec::new()));
    }
}
