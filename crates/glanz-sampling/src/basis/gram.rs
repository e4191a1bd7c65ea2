//! Gram matrices: inner products, symmetric, positive definite and banded.

use crate::error::DensityError;

/// The inner products of the functions of a basis, with their Cholesky factor.
///
/// Multiplication converts coefficients from the primary to the dual basis, solving converts them back.
#[derive(Clone, Debug, PartialEq)]
pub struct GramMatrix {
    size: usize,
    /// Number of diagonals below the main one.
    band: usize,
    /// Entries by rows: `entries[i (band + 1) + k]` is the entry (i, i - k).
    entries: Vec<f64>,
    /// Lower Cholesky factor in the same order.
    factor: Vec<f64>,
}

impl GramMatrix {
    /// The matrix with these entries, `band` + 1 in each row from the diagonal to the left (those before the first column are
    /// ignored).
    ///
    /// # Errors
    /// [`DensityError::Pivot`] if it is not positive definite.
    pub(crate) fn try_new(size: usize, band: usize, entries: Vec<f64>) -> Result<Self, DensityError> {
        check_length(&entries, size * (band + 1))?;
        let width = band + 1;
        let mut factor = entries.clone();
        for i in 0..size {
            let first = i.saturating_sub(band);
            for j in first..=i {
                let shared = first.max(j.saturating_sub(band));
                let done: f64 =
                    (shared..j).map(|l| factor[i * width + i - l] * factor[j * width + j - l]).sum();
                let rest = entries[i * width + i - j] - done;
                factor[i * width + i - j] = if j < i {
                    rest / factor[j * width]
                } else if rest > 0.0 {
                    rest.sqrt()
                } else {
                    return Err(DensityError::Pivot { pivot: i, value: rest });
                };
            }
        }
        Ok(Self { size, band, entries, factor })
    }

    /// Number of functions.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// The inner product of functions i and j; 0 beyond the last function.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        if i >= self.size || i - j > self.band { 0.0 } else { self.entries[i * (self.band + 1) + i - j] }
    }

    /// Converts primary to dual coefficients.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn to_dual(&self, primary: &[f64]) -> Result<Vec<f64>, DensityError> {
        check_length(primary, self.size)?;
        Ok(self.multiply(primary))
    }

    /// Converts dual to primary coefficients in place: inner products of a function with the basis to the coefficients of its
    /// projection (@pietrek2001 equation 2.19).
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn to_primary(&self, dual: &mut [f64]) -> Result<(), DensityError> {
        check_length(dual, self.size)?;
        self.solve(dual);
        Ok(())
    }

    /// The inverse by rows: column j holds the coefficients of the dual function j in the primary basis.
    #[must_use]
    pub fn inverse(&self) -> Vec<Vec<f64>> {
        (0..self.size)
            .map(|i| {
                // The inverse is symmetric, so that its columns equal its rows.
                let mut row = vec![0.0; self.size];
                row[i] = 1.0;
                self.solve(&mut row);
                row
            })
            .collect()
    }

    /// Number of diagonals below the main one.
    pub(crate) fn band(&self) -> usize {
        self.band
    }

    /// The inner product of two functions, each given by the index of its first coefficient and its coefficients.
    pub(crate) fn product(&self, a: (usize, &[f64]), b: (usize, &[f64])) -> f64 {
        let row = |i: usize, x: f64| -> f64 {
            x * b.1.iter().enumerate().map(|(j, y)| y * self.entry(i, b.0 + j)).sum::<f64>()
        };
        a.1.iter().enumerate().map(|(i, x)| row(a.0 + i, *x)).sum()
    }

    /// The product with `x`, whose length must match.
    pub(crate) fn multiply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.size)
            .map(|i| {
                let columns = i.saturating_sub(self.band)..(i + self.band + 1).min(self.size);
                columns.map(|j| self.entry(i, j) * x[j]).sum()
            })
            .collect()
    }

    /// Solves the linear system in place; the length of `b` must match.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let width = self.band + 1;
        for i in 0..self.size {
            let done: f64 =
                (i.saturating_sub(self.band)..i).map(|j| self.factor[i * width + i - j] * b[j]).sum();
            b[i] = (b[i] - done) / self.factor[i * width];
        }
        for i in (0..self.size).rev() {
            let done: f64 =
                (i + 1..(i + width).min(self.size)).map(|j| self.factor[j * width + j - i] * b[j]).sum();
            b[i] = (b[i] - done) / self.factor[i * width];
        }
    }
}

pub(crate) fn check_length(values: &[f64], expected: usize) -> Result<(), DensityError> {
    if values.len() == expected {
        Ok(())
    } else {
        Err(DensityError::Length { found: values.len(), expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solving_undoes_multiplying() {
        let n = 40;
        let entries = (0..n).flat_map(|i| [4.0, 1.0, -0.5, 1.0 / (1.0 + i as f64)]).collect();
        let gram = GramMatrix::try_new(n, 3, entries).unwrap();
        assert_eq!(
            [gram.entry(5, 4), gram.entry(4, 5), gram.entry(5, 3), gram.entry(5, 1)],
            [1.0, 1.0, -0.5, 0.0]
        );
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut y = gram.to_dual(&x).unwrap();
        gram.to_primary(&mut y).unwrap();
        for (a, b) in x.iter().zip(&y) {
            assert!((a - b).abs() < 1e-14);
        }
        assert!(gram.to_dual(&x[1..]).is_err());
    }

    #[test]
    fn indefinite_matrices_are_refused() {
        let found = GramMatrix::try_new(2, 1, vec![1.0, 0.0, 1.0, 2.0]);
        assert_eq!(found, Err(DensityError::Pivot { pivot: 1, value: -3.0 }));
    }
}
