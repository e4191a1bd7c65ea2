//! Low-discrepancy sequences.

use glanz::sampling::hash::combine;
use glanz::sampling::sequence::owen::{ScrambledSobol, unit};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::float_array::rows;

/// Points after which signals are handled.
const POINTS_AT_ONCE: usize = 1 << 17;

/// Largest number of dimensions.
const MAX_DIMENSION: usize = 64;

#[pyfunction]
#[pyo3(signature = (count, dimension = 2, seed = 1, first = 0))]
pub(crate) fn sobol(
    py: Python<'_>,
    count: usize,
    dimension: usize,
    seed: u64,
    first: u32,
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    if !(1..=MAX_DIMENSION).contains(&dimension) {
        let message = format!("dimension is {dimension}; it must lie between 1 and {MAX_DIMENSION}");
        return Err(PyValueError::new_err(message));
    }
    if (first as usize).checked_add(count).is_none_or(|end| end > 1 << 32) {
        return Err(PyValueError::new_err(format!(
            "first + count is {first} + {count}; the sequence has 2^32 points"
        )));
    }
    // Groups of four dimensions, scrambled on their own.
    let copies: Vec<ScrambledSobol> =
        (0..dimension.div_ceil(4)).map(|group| ScrambledSobol::new(combine(seed, group as u64))).collect();
    rows(py, &[count], &[dimension], POINTS_AT_ONCE, |i, point| {
        let reversed = (first + i as u32).reverse_bits();
        for (copy, group) in copies.iter().zip(point.chunks_mut(4)) {
            group.iter_mut().enumerate().for_each(|(axis, x)| *x = unit(copy.coordinate(reversed, axis)));
        }
    })
}
