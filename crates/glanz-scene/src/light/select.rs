//! Selection of lights by power.

use super::LightId;

/// Fraction of the probability that is spread evenly, so that a light that matters locally is not starved by a strong distant one.
const EVEN_SHARE: f64 = 0.2;

/// Selects lights by power, with an even minimum for each.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSelector {
    /// Probability per light; 0 where it cannot be sampled.
    probabilities: Vec<f64>,
    /// Running sums, ending in 1; empty if there is nothing to select.
    cumulative: Vec<f64>,
}

impl LightSelector {
    /// `importance` per light, >= 0; a light of importance 0 is never selected.
    pub(crate) fn new(importance: &[f64]) -> Self {
        let total: f64 = importance.iter().sum();
        let count = importance.iter().filter(|&&i| i > 0.0).count();
        if count == 0 || !total.is_finite() {
            let probabilities = vec![0.0; importance.len()];
            return Self { probabilities, ..Self::default() };
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
        let probabilities: Vec<f64> = probabilities.iter().map(|p| p / sum).collect();
        Self { probabilities, cumulative }
    }

    /// A light and its probability, by a number uniform in [0, 1).
    pub(crate) fn select(&self, xi: f64) -> Option<(LightId, f64)> {
        let last = self.cumulative.last()?;
        let index = self.cumulative.partition_point(|&c| c <= xi * last);
        // Rounding may carry the sum past the end; the last light that can be selected takes it.
        let index = match self.probabilities.get(index) {
            Some(_) => index,
            None => self.probabilities.iter().rposition(|&p| p > 0.0)?,
        };
        let probability = *self.probabilities.get(index)?;
        (probability > 0.0).then_some((LightId(index as u32), probability))
    }

    /// The light that is always selected, if there is only one.
    pub(crate) fn only(&self) -> Option<LightId> {
        let mut lights = (0..).zip(&self.probabilities).filter(|(_, p)| **p > 0.0);
        let (first, _) = lights.next()?;
        lights.next().is_none().then_some(LightId(first))
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
    fn selection_follows_the_probabilities() {
        let selector = LightSelector::new(&[3.0, 0.0, 1.0]);
        let n = 10_000;
        let mut counts = [0.0; 3];
        for i in 0..n {
            let (light, _) = selector.select((f64::from(i) + 0.5) / f64::from(n)).unwrap();
            counts[light.0 as usize] += 1.0 / f64::from(n);
        }
        // 0.2 / 2 + 0.8 * 3 / 4 = 0.7
        for (count, expected) in counts.into_iter().zip([0.7, 0.0, 0.3]) {
            assert!((count - expected).abs() < 1e-3);
        }
        assert!((selector.probability(LightId(0)) - 0.7).abs() < 1e-15);
        let single = LightSelector::new(&[0.0, 7.0]);
        assert_eq!((single.only(), single.select(0.9)), (Some(LightId(1)), Some((LightId(1), 1.0))));
        assert_eq!((selector.only(), LightSelector::new(&[0.0]).only()), (None, None));
    }

    #[test]
    fn nothing_is_selected_without_lights() {
        assert!(LightSelector::new(&[]).select(0.5).is_none());
        assert!(LightSelector::new(&[0.0, 0.0]).select(0.5).is_none());
    }
}
