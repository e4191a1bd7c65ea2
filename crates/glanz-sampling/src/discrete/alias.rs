//! Choice by weight in constant time.

use super::{BELOW_ONE, DiscreteChoice, WeightsError, checked_sum};

/// A table for choosing among `n` elements by weight in constant time. Neighbouring numbers do not give neighbouring choices.
///
/// # Source
/// @vose1991.
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    cells: Vec<AliasCell>,
    probabilities: Vec<f64>,
    sum: f64,
}

/// One of `n` cells of equal width.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AliasCell {
    /// Fraction of the cell that belongs to its own index.
    keep: f64,
    /// Index that the rest belongs to.
    alias: u32,
}

impl AliasTable {
    /// A table for `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if there are no weights, one is negative or not finite, all are zero, or there are 2^32 or more.
    pub fn try_new(weights: &[f64]) -> Result<Self, WeightsError> {
        let sum = checked_sum(weights)?;
        if u32::try_from(weights.len()).is_err() {
            return Err(WeightsError::Length { found: weights.len(), width: weights.len(), height: 1 });
        }
        let n = weights.len() as f64;
        let probabilities: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        let mut scaled: Vec<f64> = probabilities.iter().map(|p| p * n).collect();
        let mut cells: Vec<AliasCell> =
            (0..weights.len()).map(|i| AliasCell { keep: 1.0, alias: i as u32 }).collect();
        let (mut under, mut over): (Vec<usize>, Vec<usize>) =
            (0..weights.len()).partition(|&i| scaled[i] < 1.0);
        while let (Some(&small), Some(&large)) = (under.last(), over.last()) {
            under.pop();
            cells[small] = AliasCell { keep: scaled[small], alias: large as u32 };
            // The large weight fills the rest of the small one's cell.
            scaled[large] -= 1.0 - scaled[small];
            if scaled[large] < 1.0 {
                over.pop();
                under.push(large);
            }
        }
        // The remaining cells are full up to rounding and keep their index, unless their weight is zero.
        if let Some(heaviest) = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])) {
            for i in under.into_iter().filter(|&i| weights[i] == 0.0) {
                cells[i] = AliasCell { keep: 0.0, alias: heaviest as u32 };
            }
        }
        Ok(Self { cells, probabilities, sum })
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Always `false`: there is at least one element.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Sum of the weights.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// The probability of `index`; 0 beyond the last element.
    #[must_use]
    pub fn probability(&self, index: usize) -> f64 {
        self.probabilities.get(index).copied().unwrap_or(0.0)
    }

    /// Chooses by `xi` in [0, 1).
    #[must_use]
    pub fn choose(&self, xi: f64) -> DiscreteChoice {
        let scaled = xi.clamp(0.0, BELOW_ONE) * self.cells.len() as f64;
        let index = (scaled as usize).min(self.cells.len() - 1);
        let within = (scaled - index as f64).min(BELOW_ONE);
        let AliasCell { keep, alias } = self.cells[index];
        let (index, rest) = if within < keep {
            (index, within / keep)
        } else {
            (alias as usize, (within - keep) / (1.0 - keep))
        };
        DiscreteChoice { index, probability: self.probabilities[index], xi: rest.clamp(0.0, BELOW_ONE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::statistics::chi_square;

    #[test]
    fn choices_follow_the_weights_and_leave_a_uniform_number() {
        let weights = [0.0, 1.0, 4.0, 0.0, 0.5, 2.5, 0.0, 1e-3];
        let total: f64 = weights.iter().sum();
        let table = AliasTable::try_new(&weights).unwrap();
        let (mut cells, mut rest) = ([0; 8], [0; 20]);
        let n = 80_000;
        for i in 0..n {
            let choice = table.choose(unit_f64(combine(2, i)));
            cells[choice.index] += 1;
            rest[(choice.xi * 20.0) as usize] += 1;
            assert_eq!(choice.probability, weights[choice.index] / total);
        }
        assert!(chi_square(&cells, &weights.map(|w| w / total * n as f64)).p_value > 0.001);
        assert!(chi_square(&rest, &[n as f64 / 20.0; 20]).p_value > 0.001);
    }

    #[test]
    fn cells_hold_exactly_the_probabilities() {
        // The measure of all numbers that choose i, added up from the table itself.
        let weights: Vec<f64> = (0..1000).map(|i| unit_f64(combine(3, i)).powi(8)).collect();
        let table = AliasTable::try_new(&weights).unwrap();
        let mut measure = vec![0.0; weights.len()];
        for (i, c) in table.cells.iter().enumerate() {
            measure[i] += c.keep / 1000.0;
            measure[c.alias as usize] += (1.0 - c.keep) / 1000.0;
        }
        for (i, m) in measure.iter().enumerate() {
            assert!((m - table.probability(i)).abs() < 1e-14, "{i}: {m}");
        }
    }

    #[test]
    fn elements_of_weight_zero_are_never_chosen() {
        for weights in [vec![0.0, 1.0], vec![1.0, 0.0, 0.0], vec![0.1, 0.2, 0.0, 0.3, 0.0, 0.7]] {
            let table = AliasTable::try_new(&weights).unwrap();
            for i in 0..=10_000 {
                assert!(weights[table.choose(f64::from(i) / 10_000.0).index] > 0.0);
            }
        }
    }
}
