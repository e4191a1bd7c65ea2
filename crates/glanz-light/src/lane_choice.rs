//! Random choice between the lanes of a spectrum.

use crate::spectrum::{Spectrum, Wavelengths};

/// Probabilities of the lanes of a [`Spectrum`], for a number that can only be sampled for one of them, such as a free path.
///
/// The number then serves all lanes: divided by the mean of its densities, each with the probability of its lane, it is the balance heuristic of
/// @veach1995 for one sample of several densities. With probabilities in proportion to the throughput of a path, the sum of the lanes of its
/// throughput grows by no choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneChoice(Spectrum);

impl LaneChoice {
    /// Probabilities in proportion to `weights`, at least 0; lanes without a meaning are not chosen. `None` unless the sum is positive and
    /// finite.
    #[must_use]
    pub fn try_new(weights: Spectrum, wavelengths: &Wavelengths) -> Option<Self> {
        let used = match wavelengths {
            Wavelengths::Rgb => Spectrum::from_rgb(weights.to_rgb(wavelengths)),
            Wavelengths::Sampled(_) => weights,
        };
        let sum = used.sum_of_lanes();
        (sum > 0.0 && sum.is_finite()).then(|| Self(used.map(|weight| weight.max(0.0) / sum)))
    }

    /// The value of the lane that a number uniform in [0, 1) chooses.
    #[must_use]
    pub fn select(&self, values: Spectrum, xi: f64) -> f32 {
        // The probabilities are rounded: a number beyond their sum would choose the last lane.
        let xi = xi * self.0.0.into_iter().map(f64::from).sum::<f64>();
        let (mut below, mut chosen) = (0.0, 0.0);
        for (probability, value) in self.0.0.into_iter().zip(values.0) {
            if probability > 0.0 && xi >= below {
                chosen = value;
            }
            below += f64::from(probability);
        }
        chosen
    }

    /// `values` over their mean by the probabilities; 0 in lanes that are not chosen.
    ///
    /// `values`: the densities with which the lanes sample the number at hand, of which some that can be chosen is not 0.
    #[must_use]
    pub fn balanced(&self, values: Spectrum) -> Spectrum {
        let mean = (self.0 * values).sum_of_lanes();
        self.0.zip(values, |probability, value| if probability > 0.0 { value / mean } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RGB: Wavelengths = Wavelengths::Rgb;

    #[test]
    fn lanes_are_chosen_in_proportion_to_their_weights() {
        let choice = LaneChoice::try_new(Spectrum::from_rgb([2.0, 0.0, 6.0]), &RGB).unwrap();
        let values = Spectrum::from_rgb([1.0, 2.0, 3.0]);
        for (xi, value) in [(0.0, 1.0), (0.2499, 1.0), (0.25, 3.0), (0.999_999_999, 3.0)] {
            assert_eq!(choice.select(values, xi), value);
        }
        // The mean is 1/4 * 1 + 3/4 * 3 = 2.5.
        assert_eq!(choice.balanced(values).to_rgb(&RGB), [0.4, 0.0, 1.2]);
    }

    #[test]
    fn lanes_without_a_meaning_are_not_chosen() {
        let choice = LaneChoice::try_new(Spectrum::ONE, &RGB).unwrap();
        let colour = Spectrum::from_rgb([5.0; 3]);
        assert_eq!(choice.select(colour, 1.0 - 1e-16), 5.0);
        let [r, g, b, unused] = choice.balanced(Spectrum::splat(7.0)).0;
        // Three thirds in f32.
        assert!(unused == 0.0 && [r, g, b].iter().all(|x| (x - 1.0).abs() < 1e-6), "{r} {g} {b} {unused}");
        assert_eq!(LaneChoice::try_new(Spectrum::BLACK, &RGB), None);
        assert_eq!(LaneChoice::try_new(Spectrum::splat(f32::NAN), &RGB), None);
    }
}
