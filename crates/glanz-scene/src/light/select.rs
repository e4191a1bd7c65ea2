//! Which light to sample.

use super::LightId;

/// Share of the probability spread evenly, so that no light that matters locally is starved by a strong far one.
const EVEN_SHARE: f64 = 0.2;

/// Chooses lights by power, with an even share for each.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSelector {
    /// Probability per light; 0 where it cannot be sampled.
    probabilities: Vec<f64>,
    /// Running sums, ending in 1; empty if there is nothing to choose.
    cumulative: Vec<f64>,
}

impl LightSelector {
    /// `importance` per light, >= 0; a light of importance 0 is never chosen.
    pub(crate) fn new(importance: &[f64]) -> Self {
        let total: f64 = importance.iter().sum();
        let count = importance.iter().filter(|&&i| i > 0.0).count();
        if count == 0 || !total.is_finite() {
            return Self { probabilities: vec![0.0; importance.len()], cumulative: Vec::new() };
        }
        let even = EVEN_SHARE / count as f64;
        let probabilities: Vec<f64> = importance
            .iter()
            .map(|&i| if i > 0.0 { even + (1.0 - EVEN_SHARE) * i / total } else { 0.0 })
            .collect();
        let sum: f64 = probabilities.iter().sum();
        let mut running = 0.0;
        let cumulative = probabilities
            .iter()
            .map(|p| {
                running += p / sum;
                running
            })
            .collect();
        Self { probabilities: probabilities.iter().map(|p| p / sum).collect(), cumulative }
    }

    /// A light and its probability, by a number uniform in [0, 1).
    pub(crate) fn pick(&self, xi: f64) -> Option<(LightId, f64)> {
        let last = self.cumulative.last()?;
        let index = self.cumulative.partition_point(|&c| c <= xi * last);
        // Rounding may carry xi past the end; the last light that can be chosen takes it.
        let index = if index < self.cumulative.len() {
            index
        } else {
            self.probabilities.iter().rposition(|&p| p > 0.0)?
        };
        let probability = *self.probabilities.get(index)?;
        (probability > 0.0).then_some((LightId(index as u32), probability))
    }

    /// The probability of `light`.
    pub(crate) fn probability(&self, light: LightId) -> f64 {
        self.probabilities.get(light.0 as usize).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picks_follow_the_probabilities() {
        let selector = LightSelector::new(&[3.0, 0.0, 1.0]);
        let n = 10_000;
        let mut counts = [0.0; 3];
        for i in 0..n {
            let (light, _) = selector.pick((f64::from(i) + 0.5) / f64::from(n)).unwrap();
            counts[light.0 as usize] += 1.0 / f64::from(n);
        }
        // 0.2 / 2 + 0.8 * 3 / 4 = 0.7
        for (count, expected) in counts.into_iter().zip([0.7, 0.0, 0.3]) {
            assert!((count - expected).abs() < 1e-3);
        }
        assert!((selector.probability(LightId(0)) - 0.7).abs() < 1e-15);
    }

    #[test]
    fn no_light_is_picked_where_there_is_none() {
        assert!(LightSelector::new(&[]).pick(0.5).is_none());
        assert!(LightSelector::new(&[0.0, 0.0]).pick(0.5).is_none());
    }
}
