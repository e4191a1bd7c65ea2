//! Piecewise constant densities on [0, 1].

use super::{BELOW_ONE, DiscreteChoice, WeightsError, checked_sum};

/// A density on [0, 1] that is constant in each of `n` cells of equal width; also a choice among `n` elements by weight.
///
/// Neighbouring numbers give neighbouring choices, which preserves stratification. A choice takes log2(n) steps.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant1 {
    /// `n + 1` values from 0 to 1.
    cumulative: Vec<f64>,
    sum: f64,
}

impl PiecewiseConstant1 {
    /// The density proportional to `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if there are no weights, one is negative or not finite, or all are zero.
    pub fn try_new(weights: &[f64]) -> Result<Self, WeightsError> {
        let sum = checked_sum(weights)?;
        let mut cumulative = Vec::with_capacity(weights.len() + 1);
        cumulative.push(0.0);
        let mut running = 0.0;
        // The same order of summation as for `sum`, so that the last value is exactly 1.
        cumulative.extend(weights.iter().map(|w| {
            running += w;
            running / sum
        }));
        Ok(Self { cumulative, sum })
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cumulative.len() - 1
    }

    /// Always `false`: there is at least one cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Sum of the weights.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// The probability of cell `index`; 0 beyond the last cell.
    #[must_use]
    pub fn probability(&self, index: usize) -> f64 {
        match (self.cumulative.get(index), self.cumulative.get(index + 1)) {
            (Some(low), Some(high)) => high - low,
            _ => 0.0,
        }
    }

    /// Chooses a cell by `xi` in [0, 1); cells of probability 0 are never chosen.
    #[must_use]
    pub fn choose(&self, xi: f64) -> DiscreteChoice {
        let xi = xi.clamp(0.0, BELOW_ONE);
        // The first boundary above xi is the end of a cell of positive width that contains xi.
        let above = self.cumulative.partition_point(|&c| c <= xi).clamp(1, self.len());
        let (low, high) = (self.cumulative[above - 1], self.cumulative[above]);
        let probability = high - low;
        DiscreteChoice { index: above - 1, probability, xi: ((xi - low) / probability).clamp(0.0, BELOW_ONE) }
    }

    /// A point of [0, 1) from the uniform number `xi`, and the density there.
    #[must_use]
    pub fn sample(&self, xi: f64) -> (f64, f64) {
        let choice = self.choose(xi);
        let n = self.len() as f64;
        (((choice.index as f64 + choice.xi) / n).min(BELOW_ONE), choice.probability * n)
    }

    /// The density at `x`; 0 outside [0, 1).
    #[must_use]
    pub fn pdf(&self, x: f64) -> f64 {
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        self.probability((x * self.len() as f64) as usize) * self.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::statistics::chi_square;

    const WEIGHTS: [f64; 7] = [0.0, 1.0, 4.0, 0.0, 0.5, 2.5, 0.0];

    #[test]
    fn choices_follow_the_weights_and_leave_a_uniform_number() {
        let density = PiecewiseConstant1::try_new(&WEIGHTS).unwrap();
        let (mut cells, mut rest) = ([0; 7], [0; 20]);
        let n = 80_000;
        for i in 0..n {
            let choice = density.choose(unit_f64(combine(1, i)));
            cells[choice.index] += 1;
            rest[(choice.xi * 20.0) as usize] += 1;
            assert_eq!(choice.probability, density.probability(choice.index));
        }
        let expected = WEIGHTS.map(|w| w / 8.0 * n as f64);
        assert!(chi_square(&cells, &expected).p_value > 0.001);
        assert!(chi_square(&rest, &[n as f64 / 20.0; 20]).p_value > 0.001);
    }

    #[test]
    fn cells_without_weight_are_never_chosen_even_at_the_ends() {
        let density = PiecewiseConstant1::try_new(&WEIGHTS).unwrap();
        for xi in [0.0, 1.0 / 8.0, 5.0 / 8.0, 5.5 / 8.0, BELOW_ONE, 1.0] {
            assert!(WEIGHTS[density.choose(xi).index] > 0.0, "xi = {xi}");
        }
    }

    #[test]
    fn density_is_that_of_samples() {
        let density = PiecewiseConstant1::try_new(&WEIGHTS).unwrap();
        for i in 0..1000 {
            let (x, pdf) = density.sample((f64::from(i) + 0.5) / 1000.0);
            assert_eq!(density.pdf(x), pdf);
        }
        assert_eq!(density.pdf(1.0), 0.0);
        assert_eq!(density.pdf(-0.1), 0.0);
    }

    #[test]
    fn invalid_weights_are_refused_with_their_values() {
        assert_eq!(PiecewiseConstant1::try_new(&[]), Err(WeightsError::Empty));
        assert_eq!(PiecewiseConstant1::try_new(&[0.0, 0.0]), Err(WeightsError::Sum(0.0)));
        let negative = PiecewiseConstant1::try_new(&[1.0, -2.0]);
        assert_eq!(negative, Err(WeightsError::Weight { index: 1, value: -2.0 }));
        assert!(PiecewiseConstant1::try_new(&[f64::NAN]).is_err());
        assert!(PiecewiseConstant1::try_new(&[f64::MAX, f64::MAX]).is_err());
    }
}
