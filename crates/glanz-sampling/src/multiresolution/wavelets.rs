//! Semiorthogonal wavelets of minimal support.

use crate::basis::{BandedColumns, FunctionBasis, GramMatrix};

/// The matrix Q: column k holds wavelet k in the fine basis, of L2 norm 1 and orthogonal to every coarse function.
///
/// Wavelet k of the first half starts as far left as k and the support 3 degree + 2 of an inner wavelet allow, and is as short as
/// possible; the second half mirrors the first. The first coefficient (in the second half, the last) is positive.
///
/// # Source
/// @pietrek2001 section C.2.2; the supports and coefficients follow from one more unknown than conditions, as in
/// @finkelstein1994.
pub(super) fn wavelets(
    coarse: &FunctionBasis,
    fine: &FunctionBasis,
    p: &BandedColumns,
    gram: &GramMatrix,
) -> BandedColumns {
    let (d, m) = (coarse.degree(), fine.len());
    let count = m - coarse.len();
    let half = count.div_ceil(2);
    let mut left: Vec<(usize, Vec<f64>)> = Vec::with_capacity(half);
    for k in 0..half {
        let first = k.max((2 * k).saturating_sub(d));
        let mut last = first;
        let (mut low, mut high) = overlapping(coarse, fine, first);
        while last + 1 < m && last - first <= high - low {
            last += 1;
            let (l, h) = overlapping(coarse, fine, last);
            (low, high) = (low.min(l), high.max(h));
        }
        let conditions = (low..=high)
            .map(|i| (first..=last).map(|r| gram.product(p.column(i), (r, &[1.0]))).collect())
            .collect();
        let mut wavelet = null_vector(conditions, last - first + 1);
        let norm = gram.product((first, &wavelet), (first, &wavelet)).sqrt();
        let sign = if wavelet.first().is_some_and(|&w| w < 0.0) { -1.0 } else { 1.0 };
        wavelet.iter_mut().for_each(|w| *w *= sign / norm);
        left.push((first, wavelet));
    }
    let mut matrix = BandedColumns::with_rows(m);
    for (first, wavelet) in &left {
        matrix.push(*first, wavelet);
    }
    for (first, wavelet) in left[..count - half].iter().rev() {
        let mirrored: Vec<f64> = wavelet.iter().rev().copied().collect();
        matrix.push(m - first - wavelet.len(), &mirrored);
    }
    matrix
}

/// First and last coarse function whose support overlaps that of the fine function `r`.
fn overlapping(coarse: &FunctionBasis, fine: &FunctionBasis, r: usize) -> (usize, usize) {
    let [a, b] = fine.support(r);
    let d = coarse.degree();
    let low = coarse.knots().find_span(a) - d;
    // Just below the end, since the segment that starts there does not overlap.
    (low, coarse.knots().find_span(b.next_down()))
}

/// A vector of `unknowns` entries in the null space of fewer rows, by elimination with complete pivoting.
fn null_vector(mut rows: Vec<Vec<f64>>, unknowns: usize) -> Vec<f64> {
    let mut order: Vec<usize> = (0..unknowns).collect();
    let rank = rows.len().min(unknowns.saturating_sub(1));
    for s in 0..rank {
        let (mut best, mut at) = (-1.0, (s, s));
        for (i, row) in rows.iter().enumerate().skip(s) {
            for (j, value) in row.iter().enumerate().skip(s) {
                if value.abs() > best {
                    (best, at) = (value.abs(), (i, j));
                }
            }
        }
        rows.swap(s, at.0);
        rows.iter_mut().for_each(|row| row.swap(s, at.1));
        order.swap(s, at.1);
        let (done, below) = rows.split_at_mut(s + 1);
        let pivot = &done[s];
        for row in below {
            let factor = row[s] / pivot[s];
            for (value, p) in row[s..].iter_mut().zip(&pivot[s..]) {
                *value -= factor * p;
            }
        }
    }
    // The last unknown is free.
    let mut x = vec![0.0; unknowns];
    if let Some(free) = x.last_mut() {
        *free = 1.0;
    }
    for s in (0..rank).rev() {
        let known: f64 = rows[s][s + 1..].iter().zip(&x[s + 1..]).map(|(r, x)| r * x).sum();
        x[s] = -known / rows[s][s];
    }
    let mut ordered = vec![0.0; unknowns];
    for (position, value) in order.into_iter().zip(x) {
        ordered[position] = value;
    }
    ordered
}
