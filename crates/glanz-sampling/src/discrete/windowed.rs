//! Piecewise constant densities on rectangles.

use glanz_math::DVec2;

use super::{BELOW_ONE, WeightsError};

/// A density on rectangles of [0, 1]^2 that is proportional to a grid of weights there: windows of a picture.
///
/// # Source
/// @bitterli2015; @pharr2023 section A.5.6.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowedPiecewiseConstant2 {
    width: usize,
    height: usize,
    weights: Vec<f64>,
    /// Integrals from the first corner to the corners of cells: `height + 1` rows of `width + 1` values.
    sums: Vec<f64>,
}

/// A rectangle between its lower and its upper corner.
pub type GridWindow = [DVec2; 2];

impl WindowedPiecewiseConstant2 {
    /// The density proportional to `weights`: `height` rows of `width` values; x runs along a row, y over the rows.
    ///
    /// # Errors
    /// [`WeightsError`] if a side is zero, the number of weights is not width * height, a weight is negative or not
    /// finite, or all are zero.
    pub fn try_new(width: usize, height: usize, weights: Vec<f64>) -> Result<Self, WeightsError> {
        if weights.is_empty() || width == 0 {
            return Err(WeightsError::Empty);
        }
        if width.checked_mul(height) != Some(weights.len()) {
            return Err(WeightsError::Length { found: weights.len(), width, height });
        }
        super::checked_sum(&weights)?;
        let area = 1.0 / (width as f64 * height as f64);
        let mut sums = vec![0.0; width + 1];
        sums.reserve((width + 1) * height);
        for (row, values) in weights.chunks_exact(width).enumerate() {
            let mut running = 0.0;
            sums.push(0.0);
            for (column, weight) in values.iter().enumerate() {
                running += weight * area;
                sums.push(sums[row * (width + 1) + column + 1] + running);
            }
        }
        Ok(Self { width, height, weights, sums })
    }

    /// The integral of the weights over a window inside [0, 1]^2.
    #[must_use]
    pub fn integral(&self, [low, high]: GridWindow) -> f64 {
        let part = self.integral_to(high) + self.integral_to(low);
        let rest = self.integral_to(DVec2::new(low.x, high.y)) + self.integral_to(DVec2::new(high.x, low.y));
        (part - rest).max(0.0)
    }

    /// The integral between the first corner and a point of [0, 1]^2: linear between the corners of a cell.
    fn integral_to(&self, point: DVec2) -> f64 {
        let size = DVec2::new(self.width as f64, self.height as f64);
        let at = (point * size).clamp(DVec2::ZERO, size);
        let (column, row) = ((at.x as usize).min(self.width - 1), (at.y as usize).min(self.height - 1));
        let share = at - DVec2::new(column as f64, row as f64);
        let start = row * (self.width + 1) + column;
        let (top, bottom) = (&self.sums[start..start + 2], &self.sums[start + self.width + 1..]);
        let along = |sums: &[f64]| sums[0] + share.x * (sums[1] - sums[0]);
        along(top) + share.y * (along(bottom) - along(top))
    }

    /// A point of the window by the uniform numbers `xi`, with its density per unit of area; `None` if the weights in the window are 0.
    #[must_use]
    pub fn sample(&self, xi: DVec2, window: GridWindow) -> Option<(DVec2, f64)> {
        let [low, high] = window;
        let whole = self.integral(window);
        if !(whole > 0.0 && low.cmplt(high).all()) {
            return None;
        }
        let x = invert(xi.x * whole, [low.x, high.x], self.width, |x| {
            self.integral([low, DVec2::new(x, high.y)])
        });
        // The strip of the cells' column: there the density along y is the same for all x.
        let column = (x * self.width as f64).floor();
        let left = (column / self.width as f64).max(low.x);
        let right = ((column + 1.0) / self.width as f64).min(high.x);
        let strip = |y: f64| self.integral([DVec2::new(left, low.y), DVec2::new(right, y)]);
        let y = invert(xi.y * strip(high.y), [low.y, high.y], self.height, strip);
        let point = DVec2::new(x, y);
        let pdf = self.weight(point) / whole;
        (pdf > 0.0).then_some((point, pdf))
    }

    /// The density at `point` of the samples in a window; 0 outside.
    #[must_use]
    pub fn pdf(&self, point: DVec2, window: GridWindow) -> f64 {
        let [low, high] = window;
        if !(point.cmpge(low).all() && point.cmple(high).all()) {
            return 0.0;
        }
        let whole = self.integral(window);
        if whole > 0.0 { self.weight(point) / whole } else { 0.0 }
    }

    /// The weight of the cell of a point.
    fn weight(&self, point: DVec2) -> f64 {
        let column = ((point.x * self.width as f64) as usize).min(self.width - 1);
        let row = ((point.y * self.height as f64) as usize).min(self.height - 1);
        self.weights[row * self.width + column]
    }
}

/// The position in `[low, high]` at which the increasing function `integral`, linear between multiples of 1 / `cells`, reaches `target`.
fn invert(target: f64, [low, high]: [f64; 2], cells: usize, integral: impl Fn(f64) -> f64) -> f64 {
    let n = cells as f64;
    // Borders of cells inside the range, of which the first ones are not beyond the target.
    let (first, last) = ((low * n).floor() as usize + 1, (high * n).ceil() as usize);
    let (mut below, mut above) = (first, last.max(first));
    while below < above {
        let middle = below.midpoint(above);
        if integral(middle as f64 / n) <= target { below = middle + 1 } else { above = middle }
    }
    let start = if below == first { low } else { (below - 1) as f64 / n };
    let end = (below as f64 / n).min(high);
    let (before, after) = (integral(start), integral(end));
    let share =
        if after > before { ((target - before) / (after - before)).clamp(0.0, BELOW_ONE) } else { 0.5 };
    (start + share * (end - start)).clamp(low, high).min(BELOW_ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::statistics::chi_square;

    const WEIGHTS: [f64; 12] = [1.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.5, 0.5, 4.0];
    const WINDOWS: [GridWindow; 4] = [
        [DVec2::ZERO, DVec2::ONE],
        [DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.8)],
        [DVec2::new(0.3, 0.7), DVec2::new(0.45, 0.95)],
        [DVec2::new(0.55, 0.0), DVec2::new(0.7, 1.0)],
    ];

    fn density() -> WindowedPiecewiseConstant2 {
        WindowedPiecewiseConstant2::try_new(4, 3, WEIGHTS.to_vec()).unwrap()
    }

    fn xi(i: u64) -> DVec2 {
        DVec2::new(unit_f64(combine(4, i)), unit_f64(combine(5, i)))
    }

    /// Overlap of the intervals [a, b] and [c, d].
    fn overlap([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
        (b.min(d) - a.max(c)).max(0.0)
    }

    #[test]
    fn integral_is_the_sum_of_the_overlaps_with_cells() {
        for window in WINDOWS {
            let [low, high] = window;
            let expected: f64 = (0..12)
                .map(|i| {
                    let (x, y) = (f64::from(i % 4), f64::from(i / 4));
                    WEIGHTS[i as usize]
                        * overlap([low.x, high.x], [x / 4.0, (x + 1.0) / 4.0])
                        * overlap([low.y, high.y], [y / 3.0, (y + 1.0) / 3.0])
                })
                .sum();
            assert!((density().integral(window) - expected).abs() < 1e-15, "{window:?}");
        }
    }

    #[test]
    fn samples_follow_the_weights_inside_the_window() {
        // 24 x 24 parts of the window; cells of the grid overlap several.
        const SIDE: usize = 24;
        for window in WINDOWS {
            let (density, [low, high]) = (density(), window);
            let n = 100_000;
            let mut counts = vec![0_u64; SIDE * SIDE];
            for i in 0..n {
                let (point, pdf) = density.sample(xi(i), window).unwrap();
                assert!(point.cmpge(low).all() && point.cmple(high).all());
                assert!((density.pdf(point, window) - pdf).abs() < 1e-12);
                let at = (point - low) / (high - low) * SIDE as f64;
                counts[(at.y as usize).min(SIDE - 1) * SIDE + (at.x as usize).min(SIDE - 1)] += 1;
            }
            let step = (high - low) / SIDE as f64;
            let expected: Vec<f64> = (0..SIDE * SIDE)
                .map(|i| {
                    let corner = low + DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) * step;
                    density.integral([corner, corner + step]) / density.integral(window) * n as f64
                })
                .collect();
            let test = chi_square(&counts, &expected);
            assert!(test.p_value > 0.001, "{window:?}: {test:?}");
        }
    }

    #[test]
    fn window_without_weight_has_no_samples() {
        let density = density();
        let dark = [DVec2::new(0.1, 0.4), DVec2::new(0.9, 0.6)];
        assert_eq!(density.sample(DVec2::splat(0.5), dark), None);
        assert_eq!(density.pdf(DVec2::splat(0.5), dark), 0.0);
        let empty = [DVec2::splat(0.1), DVec2::splat(0.1)];
        assert_eq!(density.sample(DVec2::splat(0.5), empty), None);
        assert_eq!(density.pdf(DVec2::splat(0.95), [DVec2::ZERO, DVec2::splat(0.9)]), 0.0);
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let refused = |width, height, weights: &[f64]| {
            WindowedPiecewiseConstant2::try_new(width, height, weights.to_vec()).unwrap_err()
        };
        assert!(matches!(refused(5, 3, &WEIGHTS), WeightsError::Length { .. }));
        assert_eq!(refused(0, 3, &[]), WeightsError::Empty);
        assert_eq!(refused(2, 1, &[0.0, 0.0]), WeightsError::Sum(0.0));
    }
}
