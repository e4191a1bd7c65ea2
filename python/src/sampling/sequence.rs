//! Low-discrepancy sequences.

use glanz::sampling::hash::combine;
use glanz::sampling::sequence::owen::{ScrambledSobol, unit};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::Whole;
use crate::float_array::{ROWS_AT_ONCE, rows};

/// Largest number of dimensions.
const MAX_DIMENSION: u32 = 64;

#[pyfunction]
#[pyo3(signature = (count, dimension = Whole(2), seed = Whole(1), first = Whole(0)))]
pub(crate) fn sobol(
    py: Python<'_>,
    count: Whole,
    dimension: Whole,
    seed: Whole,
    first: Whole,
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let dimension = dimension.within("dimension", 1..=MAX_DIMENSION)? as usize;
    let first = first.within("first", 0..=u32::MAX)?;
    let (count, seed) = (count.0, seed.0);
    if u64::from(first).checked_add(count).is_none_or(|end| end > 1 << 32) {
        return Err(PyValueError::new_err(format!(
            "first + count is {first} + {count}; the sequence has 2^32 points"
        )));
    }
    // Groups of four dimensions, scrambled on their own.
    let copies: Vec<ScrambledSobol> =
        (0..dimension.div_ceil(4)).map(|group| ScrambledSobol::new(combine(seed, group as u64))).collect();
    rows(py, &[count as usize], &[dimension], ROWS_AT_ONCE, |i, point| {
        let reversed = (first + i as u32).reverse_bits();
        for (copy, group) in copies.iter().zip(point.chunks_mut(4)) {
            group.iter_mut().enumerate().for_each(|(axis, x)| *x = unit(copy.coordinate(reversed, axis)));
        }
    })
}
