//! Wavelet transforms of functions of two variables.
//!
//! Coefficients are those of a tensor product basis ([`crate::basis::TensorBasis`]), the second axis fastest. The two axes
//! may have different analyses and levels.
//!
//! # Source
//! @pietrek2001 section C.3.1.

use crate::basis::{check_length, map_axis};
use crate::error::DensityError;
use crate::multiresolution::MultiResolution;

/// The standard transform: the whole transform along each line of the second axis, then along each line of the first.
///
/// # Errors
/// [`DensityError::Level`], [`DensityError::Length`].
pub fn standard(
    analyses: [&MultiResolution; 2],
    coefficients: &mut Vec<f64>,
    levels: [usize; 2],
) -> Result<(), DensityError> {
    both_axes(analyses, coefficients, levels, MultiResolution::transform)
}

/// The inverse of [`standard`].
///
/// # Errors
/// [`DensityError::Level`], [`DensityError::Length`].
pub fn inverse_standard(
    analyses: [&MultiResolution; 2],
    coefficients: &mut Vec<f64>,
    levels: [usize; 2],
) -> Result<(), DensityError> {
    both_axes(analyses, coefficients, levels, MultiResolution::inverse_transform)
}

fn both_axes(
    analyses: [&MultiResolution; 2],
    coefficients: &mut Vec<f64>,
    levels: [usize; 2],
    transform: fn(&MultiResolution, &mut [f64], usize) -> Result<(), DensityError>,
) -> Result<(), DensityError> {
    let shape = shape(analyses, coefficients, levels)?;
    for axis in [1, 0] {
        let mut failed = Ok(());
        let mapped = map_axis(coefficients, &shape, axis, |line| {
            let mut line = line.to_vec();
            if let Err(error) = transform(analyses[axis], &mut line, levels[axis]) {
                failed = Err(error);
            }
            line
        });
        failed?;
        *coefficients = mapped;
    }
    Ok(())
}

/// The non-standard transform: one step along each line of the second axis and one along each line of the first, then the same
/// for the coarser coefficients in the corner, until an axis is on level 0; the other axis continues alone.
///
/// # Errors
/// [`DensityError::Level`], [`DensityError::Length`].
pub fn non_standard(
    analyses: [&MultiResolution; 2],
    coefficients: &mut [f64],
    levels: [usize; 2],
) -> Result<(), DensityError> {
    let [_, stride] = shape(analyses, coefficients, levels)?;
    let deepest = levels[0].max(levels[1]);
    for done in 0..deepest {
        step_corner(
            analyses,
            coefficients,
            stride,
            levels.map(|l| l.saturating_sub(done)),
            TransformDirection::Analysis,
        )?;
    }
    Ok(())
}

/// The inverse of [`non_standard`].
///
/// # Errors
/// [`DensityError::Level`], [`DensityError::Length`].
pub fn inverse_non_standard(
    analyses: [&MultiResolution; 2],
    coefficients: &mut [f64],
    levels: [usize; 2],
) -> Result<(), DensityError> {
    let [_, stride] = shape(analyses, coefficients, levels)?;
    let deepest = levels[0].max(levels[1]);
    for done in (0..deepest).rev() {
        step_corner(
            analyses,
            coefficients,
            stride,
            levels.map(|l| l.saturating_sub(done)),
            TransformDirection::Synthesis,
        )?;
    }
    Ok(())
}

/// Direction of a wavelet transform.
#[derive(Clone, Copy, PartialEq, Eq)]
enum TransformDirection {
    Analysis,
    Synthesis,
}

/// One step along both axes of the corner with these levels; an axis on level 0 stays unchanged.
fn step_corner(
    analyses: [&MultiResolution; 2],
    coefficients: &mut [f64],
    stride: usize,
    levels: [usize; 2],
    direction: TransformDirection,
) -> Result<(), DensityError> {
    let rows = analyses[0].basis(levels[0])?.len();
    let columns = analyses[1].basis(levels[1])?.len();
    let mut corner: Vec<f64> =
        coefficients.chunks(stride).take(rows).flat_map(|row| row[..columns].iter().copied()).collect();
    // The inverse reverses the order of the axes.
    let order = if direction == TransformDirection::Analysis { [1, 0] } else { [0, 1] };
    for axis in order.into_iter().filter(|&a| levels[a] > 0) {
        let filter_bank = analyses[axis].filter_bank(levels[axis])?;
        corner = map_axis(&corner, &[rows, columns], axis, |line| match direction {
            TransformDirection::Analysis => {
                let (mut coarse, details) = filter_bank.split(line);
                coarse.extend(details);
                coarse
            }
            TransformDirection::Synthesis => {
                let (coarse, details) = line.split_at(filter_bank.p().columns());
                filter_bank.join(coarse, details)
            }
        });
    }
    for (row, new) in coefficients.chunks_mut(stride).zip(corner.chunks(columns)) {
        row[..columns].copy_from_slice(new);
    }
    Ok(())
}

fn shape(
    analyses: [&MultiResolution; 2],
    coefficients: &[f64],
    levels: [usize; 2],
) -> Result<[usize; 2], DensityError> {
    let shape = [analyses[0].basis(levels[0])?.len(), analyses[1].basis(levels[1])?.len()];
    check_length(coefficients, shape[0] * shape[1])?;
    Ok(shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn analyses() -> [MultiResolution; 2] {
        [MultiResolution::haar(4).unwrap(), MultiResolution::bspline(2, 3).unwrap()]
    }

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|i| (2.3 * i as f64).sin()).collect()
    }

    #[test]
    fn both_transforms_are_invertible_on_any_levels() {
        let [u, v] = analyses();
        for levels in [[0, 0], [4, 3], [1, 3], [4, 0], [0, 2]] {
            let n = u.basis(levels[0]).unwrap().len() * v.basis(levels[1]).unwrap().len();
            let original = wave(n);
            let (mut a, mut b) = (original.clone(), original.clone());
            standard([&u, &v], &mut a, levels).unwrap();
            non_standard([&u, &v], &mut b, levels).unwrap();
            if levels == [4, 3] {
                assert_ne!(a, b);
            }
            inverse_standard([&u, &v], &mut a, levels).unwrap();
            inverse_non_standard([&u, &v], &mut b, levels).unwrap();
            for (o, (a, b)) in original.iter().zip(a.iter().zip(&b)) {
                assert!((a - o).abs() < 1e-13 && (b - o).abs() < 1e-13);
            }
        }
        assert!(standard([&u, &v], &mut vec![0.0; 3], [1, 1]).is_err());
    }

    #[test]
    fn standard_transform_of_a_product_is_the_product_of_transforms() {
        let [u, v] = analyses();
        let (mut a, mut b) = (wave(16), wave(10));
        let mut product: Vec<f64> = a.iter().flat_map(|x| b.iter().map(move |y| x * y)).collect();
        standard([&u, &v], &mut product, [4, 3]).unwrap();
        u.transform(&mut a, 4).unwrap();
        v.transform(&mut b, 3).unwrap();
        for (i, found) in product.iter().enumerate() {
            assert!((found - a[i / 10] * b[i % 10]).abs() < 1e-13);
        }
    }

    #[test]
    fn one_step_of_haar_is_means_and_differences_of_four() {
        // Orthonormal: the mean of [[1, 2], [3, 6]] times 2 is 6; along columns, rows and both: 1 + 3 - 2 - 6 and so on, over 2.
        let haar = MultiResolution::haar(1).unwrap();
        let mut c = vec![1.0, 2.0, 3.0, 6.0];
        non_standard([&haar, &haar], &mut c, [1, 1]).unwrap();
        for (found, expected) in c.iter().zip([6.0, -2.0, -3.0, 1.0]) {
            assert!((found - expected).abs() < 1e-14);
        }
    }
}
