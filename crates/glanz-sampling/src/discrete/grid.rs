//! Piecewise constant densities on the unit square.

use glanz_math::DVec2;

use super::{PiecewiseConstant1, WeightsError};

/// A density on [0, 1]^2 that is constant in each cell of a grid: environment maps, luminaires.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant2 {
    rows: PiecewiseConstant1,
    /// The density along each row; `None` for a row of weight 0, which is never chosen.
    columns: Vec<Option<PiecewiseConstant1>>,
    width: usize,
}

/// A point drawn from a [`PiecewiseConstant2`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PiecewiseConstantSample {
    /// The point, in [0, 1)^2.
    pub point: DVec2,
    /// Column and row of its cell.
    pub cell: [usize; 2],
    /// Density per unit of area of the unit square.
    pub pdf: f64,
}

impl PiecewiseConstant2 {
    /// The density proportional to `weights`: `height` rows of `width` values; x runs along a row, y over the rows.
    ///
    /// # Errors
    /// [`WeightsError`] if a side is zero, the number of weights is not width * height, a weight is negative or not
    /// finite, or all are zero.
    pub fn try_new(width: usize, height: usize, weights: &[f64]) -> Result<Self, WeightsError> {
        if weights.is_empty() || width == 0 {
            return Err(WeightsError::Empty);
        }
        if width.checked_mul(height) != Some(weights.len()) {
            return Err(WeightsError::Length { found: weights.len(), width, height });
        }
        super::checked_sum(weights)?;
        let sums: Vec<f64> = weights.chunks_exact(width).map(|row| row.iter().sum()).collect();
        let columns = weights.chunks_exact(width).map(|row| PiecewiseConstant1::try_new(row).ok()).collect();
        Ok(Self { rows: PiecewiseConstant1::try_new(&sums)?, columns, width })
    }

    /// Sum of the weights.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.rows.sum()
    }

    /// A point from the uniform numbers `xi`.
    #[must_use]
    pub fn sample(&self, xi: DVec2) -> PiecewiseConstantSample {
        let row = self.rows.choose(xi.y);
        let height = self.rows.len() as f64;
        // A row of weight 0 is never chosen; its density would be 0.
        let (x, column, pdf) = match self.columns.get(row.index) {
            Some(Some(columns)) => {
                let (x, pdf) = columns.sample(xi.x);
                (x, (x * self.width as f64) as usize, pdf)
            }
            _ => (xi.x, (xi.x * self.width as f64) as usize, 0.0),
        };
        PiecewiseConstantSample {
            point: DVec2::new(x, ((row.index as f64 + row.xi) / height).min(super::BELOW_ONE)),
            cell: [column.min(self.width - 1), row.index],
            pdf: pdf * row.probability * height,
        }
    }

    /// The density at `point`; 0 outside [0, 1)^2.
    #[must_use]
    pub fn pdf(&self, point: DVec2) -> f64 {
        let pdf_y = self.rows.pdf(point.y);
        if pdf_y == 0.0 {
            return 0.0;
        }
        match self.columns.get((point.y * self.rows.len() as f64) as usize) {
            Some(Some(columns)) => columns.pdf(point.x) * pdf_y,
            _ => 0.0,
        }
    }

    /// The inverse of [`PiecewiseConstant2::sample`]; `None` where the density is 0.
    #[must_use]
    pub fn invert(&self, point: DVec2) -> Option<DVec2> {
        let y = self.rows.invert(point.y)?;
        let columns = self.columns.get((point.y * self.rows.len() as f64) as usize)?.as_ref()?;
        Some(DVec2::new(columns.invert(point.x)?, y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::statistics::chi_square;

    const WEIGHTS: [f64; 12] = [1.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.5, 0.5, 4.0];

    fn xi(i: u64) -> DVec2 {
        DVec2::new(unit_f64(combine(4, i)), unit_f64(combine(5, i)))
    }

    #[test]
    fn samples_follow_the_weights_within_and_between_cells() {
        let density = PiecewiseConstant2::try_new(4, 3, &WEIGHTS).unwrap();
        assert_eq!(density.sum(), 16.0);
        // Each cell is cut in 2 x 2.
        let mut counts = [0_u64; 48];
        let n = 100_000;
        for i in 0..n {
            let s = density.sample(xi(i));
            counts[(s.point.y * 6.0) as usize * 8 + (s.point.x * 8.0) as usize] += 1;
            assert!((s.pdf - WEIGHTS[s.cell[1] * 4 + s.cell[0]] / 16.0 * 12.0).abs() < 1e-13);
            assert!((density.pdf(s.point) - s.pdf).abs() < 1e-13);
        }
        let expected: Vec<f64> = (0..48).map(|i| WEIGHTS[i / 16 * 4 + i % 8 / 2] / 64.0 * n as f64).collect();
        assert!(chi_square(&counts, &expected).p_value > 0.001);
    }

    #[test]
    fn invert_undoes_sample() {
        let density = PiecewiseConstant2::try_new(4, 3, &WEIGHTS).unwrap();
        for i in 0..1000 {
            let back = density.invert(density.sample(xi(i)).point).unwrap();
            assert!((back - xi(i)).length() < 1e-13);
        }
        assert_eq!(density.invert(DVec2::new(0.5, 0.5)), None);
    }

    #[test]
    fn wrong_shapes_are_refused() {
        assert!(matches!(PiecewiseConstant2::try_new(5, 3, &WEIGHTS), Err(WeightsError::Length { .. })));
        assert_eq!(PiecewiseConstant2::try_new(0, 3, &[]), Err(WeightsError::Empty));
        assert_eq!(PiecewiseConstant2::try_new(2, 1, &[0.0, 0.0]), Err(WeightsError::Sum(0.0)));
    }
}
