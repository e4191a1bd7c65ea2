//! Piecewise constant densities on the unit square.

use std::sync::Arc;

use glanz_math::DVec2;

use super::{BELOW_ONE, PiecewiseConstant1, WeightsError};

/// Number of cells of a row from one stored sum to the next: a sample adds up the weights between them, which share a cache line.
const BLOCK: usize = 16;

/// A density on [0, 1]^2 that is constant in each cell of a grid: environment maps, luminaires.
///
/// Weights are kept in single precision, and the density is that of the weights kept: large grids take 4.5 bytes per cell.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant2 {
    width: usize,
    /// Row by row.
    weights: Arc<[f32]>,
    /// The part of each weight that does not count.
    floor: f64,
    /// For each row, the sums of its weights up to the end of each block.
    sums: Vec<f64>,
    rows: PiecewiseConstant1,
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
    /// The density proportional to `weights` times the factor of their row: `height` rows of `width` values; x runs along a row, y over the rows.
    ///
    /// # Errors
    /// [`WeightsError`] if a side is zero, the number of weights is not width * height, a weight or factor is negative or not
    /// finite (the index is then that of the weight or of the row), or all are zero.
    pub fn try_new(
        width: usize,
        height: usize,
        weights: Arc<[f32]>,
        row_factor: impl Fn(usize) -> f64,
    ) -> Result<Self, WeightsError> {
        if weights.is_empty() || width == 0 {
            return Err(WeightsError::Empty);
        }
        if width.checked_mul(height) != Some(weights.len()) {
            return Err(WeightsError::Length { found: weights.len(), width, height });
        }
        if let Some((index, &value)) =
            weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w >= 0.0))
        {
            return Err(WeightsError::Weight { index, value: f64::from(value) });
        }
        Self::with_floor(width, weights, 0.0, row_factor)
    }

    /// The density proportional to what the same weights exceed `floor` by, times the factor of their row. Both share the weights.
    ///
    /// # Errors
    /// [`WeightsError::Sum`] if no weight is above `floor`.
    pub fn above(&self, floor: f64, row_factor: impl Fn(usize) -> f64) -> Result<Self, WeightsError> {
        Self::with_floor(self.width, Arc::clone(&self.weights), floor, row_factor)
    }

    fn with_floor(
        width: usize,
        weights: Arc<[f32]>,
        floor: f64,
        row_factor: impl Fn(usize) -> f64,
    ) -> Result<Self, WeightsError> {
        let blocks = width.div_ceil(BLOCK);
        let mut sums = Vec::with_capacity(weights.len() / width * blocks);
        for row in weights.chunks_exact(width) {
            let mut running = 0.0;
            sums.extend(row.chunks(BLOCK).map(|block| {
                running += block.iter().map(|&weight| excess(weight, floor)).sum::<f64>();
                running
            }));
        }
        let of_row = |(row, sums): (usize, &[f64])| row_factor(row) * sums.last().copied().unwrap_or(0.0);
        let of_rows: Vec<f64> = sums.chunks_exact(blocks).enumerate().map(of_row).collect();
        let rows = PiecewiseConstant1::try_new(&of_rows)?;
        Ok(Self { width, weights, floor, sums, rows })
    }

    /// Sum of the weights times the factors of their rows.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.rows.sum()
    }

    /// A point from the uniform numbers `xi`.
    #[must_use]
    pub fn sample(&self, xi: DVec2) -> PiecewiseConstantSample {
        let row = self.rows.choose(xi.y);
        let (column, share, in_row) = self.choose_in_row(row.index, xi.x);
        let [width, height] = [self.width as f64, self.rows.len() as f64];
        let point = DVec2::new((column as f64 + share) / width, (row.index as f64 + row.xi) / height);
        PiecewiseConstantSample {
            point: point.min(DVec2::splat(BELOW_ONE)),
            cell: [column, row.index],
            pdf: in_row * width * row.probability * height,
        }
    }

    /// A cell of a row by a number uniform in [0, 1), with the share of the cell that lies before the chosen point, and its probability in
    /// the row. Cells of weight 0 are never chosen.
    fn choose_in_row(&self, row: usize, xi: f64) -> (usize, f64, f64) {
        let sums = self.row_sums(row);
        let total = sums.last().copied().unwrap_or(0.0);
        // Below the total also after rounding, so that a block ends above it.
        let target = (xi * total).min(total.next_down()).max(0.0);
        let block = sums.partition_point(|&sum| sum <= target);
        let before = if block == 0 { 0.0 } else { sums.get(block - 1).copied().unwrap_or(0.0) };
        let mut left = target - before;
        let first = block * BLOCK;
        let (mut chosen, mut weight) = (first, 0.0);
        // Rounding may carry the sum past the end of the block; its last cell of any weight takes it.
        for column in first..(first + BLOCK).min(self.width) {
            let next = self.weight(column, row);
            if next > 0.0 {
                left -= weight;
                (chosen, weight) = (column, next);
                if left < next {
                    break;
                }
            }
        }
        (chosen, (left / weight).clamp(0.0, BELOW_ONE), weight / total)
    }

    fn row_sums(&self, row: usize) -> &[f64] {
        let blocks = self.width.div_ceil(BLOCK);
        self.sums.get(row * blocks..(row + 1) * blocks).unwrap_or_default()
    }

    fn weight(&self, column: usize, row: usize) -> f64 {
        self.weights.get(row * self.width + column).map_or(0.0, |&weight| excess(weight, self.floor))
    }

    /// The density at `point`; 0 outside [0, 1)^2.
    #[must_use]
    pub fn pdf(&self, point: DVec2) -> f64 {
        let pdf_y = self.rows.pdf(point.y);
        if pdf_y == 0.0 || !(0.0..1.0).contains(&point.x) {
            return 0.0;
        }
        let [width, height] = [self.width as f64, self.rows.len() as f64];
        let [column, row] = [(point.x * width) as usize, (point.y * height) as usize];
        let total = self.row_sums(row).last().copied().unwrap_or(0.0);
        self.weight(column, row) / total * width * pdf_y
    }
}

/// What a weight exceeds `floor` by, or 0.
fn excess(weight: f32, floor: f64) -> f64 {
    (f64::from(weight) - floor).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::statistics::chi_square;

    const WEIGHTS: [f32; 12] = [1.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.5, 0.5, 4.0];

    fn density(width: usize, height: usize, weights: &[f32]) -> Result<PiecewiseConstant2, WeightsError> {
        PiecewiseConstant2::try_new(width, height, weights.into(), |_| 1.0)
    }

    fn xi(i: u64) -> DVec2 {
        DVec2::new(unit_f64(combine(4, i)), unit_f64(combine(5, i)))
    }

    #[test]
    fn samples_follow_the_weights_within_and_between_cells() {
        let density = density(4, 3, &WEIGHTS).unwrap();
        assert_eq!(density.sum(), 16.0);
        // Each cell is cut in 2 x 2.
        let mut counts = [0_u64; 48];
        let n = 100_000;
        for i in 0..n {
            let s = density.sample(xi(i));
            counts[(s.point.y * 6.0) as usize * 8 + (s.point.x * 8.0) as usize] += 1;
            let weight = f64::from(WEIGHTS[s.cell[1] * 4 + s.cell[0]]);
            assert!((s.pdf - weight / 16.0 * 12.0).abs() < 1e-13);
            assert!((density.pdf(s.point) - s.pdf).abs() < 1e-13);
        }
        let expected: Vec<f64> =
            (0..48).map(|i| f64::from(WEIGHTS[i / 16 * 4 + i % 8 / 2]) / 64.0 * n as f64).collect();
        assert!(chi_square(&counts, &expected).p_value > 0.001);
    }

    /// A wide grid with rows and blocks without weight.
    fn wide() -> Vec<f32> {
        let weight = |i: usize| match (i / 50, i % 50) {
            (1, _) | (_, 16..32 | 47..) => 0.0,
            (2, 5) => 300.0,
            (row, column) => (1 + row + (7 * column) % 11) as f32,
        };
        (0..200).map(weight).collect()
    }

    #[test]
    fn samples_follow_what_weights_of_wide_grids_exceed_a_floor_by() {
        let factor = |row: usize| 1.0 + 0.5 * row as f64;
        let complete = PiecewiseConstant2::try_new(50, 4, wide().into(), factor).unwrap();
        for floor in [0.0, 4.5] {
            let density = if floor > 0.0 { complete.above(floor, factor).unwrap() } else { complete.clone() };
            let weights: Vec<f64> = (0..)
                .zip(wide())
                .map(|(i, weight)| (f64::from(weight) - floor).max(0.0) * factor(i / 50))
                .collect();
            let sum: f64 = weights.iter().sum();
            assert!((density.sum() / sum - 1.0).abs() < 1e-14);
            let (n, mut counts) = (200_000, vec![0_u64; 200]);
            for i in 0..n {
                let s = density.sample(xi(i));
                let cell = s.cell[1] * 50 + s.cell[0];
                counts[cell] += 1;
                assert_eq!([(s.point.x * 50.0) as usize, (s.point.y * 4.0) as usize], s.cell);
                assert!((s.pdf / (weights[cell] / sum * 200.0) - 1.0).abs() < 1e-12);
                assert!((density.pdf(s.point) / s.pdf - 1.0).abs() < 1e-14);
            }
            let expected: Vec<f64> = weights.iter().map(|weight| weight / sum * n as f64).collect();
            assert!(chi_square(&counts, &expected).p_value > 0.001);
        }
        assert!(matches!(complete.above(300.0, factor), Err(WeightsError::Sum(_))));
    }

    #[test]
    fn faint_cells_beside_a_bright_one_keep_their_density() {
        // A sun of 2e9 in a sky of 1: a running sum in single precision would lose the sky.
        let mut weights = vec![1.0; 4096];
        weights[100] = 2e9;
        let density = density(2048, 2, &weights).unwrap();
        let sum = 2e9 + 4095.0;
        for i in 0..4096 {
            let at = (DVec2::new(f64::from(i % 2048), f64::from(i / 2048)) + 0.5) / DVec2::new(2048.0, 2.0);
            let expected = if i == 100 { 2e9 } else { 1.0 } * 4096.0 / sum;
            assert!((density.pdf(at) / expected - 1.0).abs() < 1e-9);
        }
        // The last cell of the row takes its last part.
        let last = density.sample(DVec2::new(1.0 - 0.5 / sum, 0.0));
        assert_eq!(last.cell, [2047, 0]);
    }

    #[test]
    fn cells_without_weight_are_never_chosen_at_the_ends() {
        let density = PiecewiseConstant2::try_new(50, 4, wide().into(), |_| 1.0).unwrap();
        for (x, y) in [(0.0, 0.0), (BELOW_ONE, 0.0), (BELOW_ONE, BELOW_ONE), (0.0, BELOW_ONE), (1.0, 1.0)] {
            let s = density.sample(DVec2::new(x, y));
            assert!(s.pdf > 0.0 && density.pdf(s.point) > 0.0, "{x} {y}: {s:?}");
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        assert!(matches!(density(5, 3, &WEIGHTS), Err(WeightsError::Length { .. })));
        assert_eq!(density(0, 3, &[]), Err(WeightsError::Empty));
        assert_eq!(density(2, 1, &[0.0, 0.0]), Err(WeightsError::Sum(0.0)));
        assert_eq!(density(2, 1, &[1.0, -1.0]), Err(WeightsError::Weight { index: 1, value: -1.0 }));
    }
}
