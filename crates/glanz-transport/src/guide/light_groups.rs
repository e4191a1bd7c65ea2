//! Learnt probabilities of selecting lights.
//!
//! Light sampling selects one of many lights; the variance is smallest if the probability of each is proportional to the root of its mean
//! squared contribution. At most points few lights are visible, which their powers do not reflect. Lights are selected by the scene's
//! groups ([`Scene::light_group_count`]), so that thousands of lights cost no more than sixteen; within a group the scene selects them.

use glanz_scene::{LightSampleContext, MAX_LIGHT_GROUPS, Scene};

/// Smallest fraction of selections by the scene's own probabilities, because lights without samples so far may still contribute.
const BLIND: f64 = 0.05;

/// This fraction times the square root of the number of samples, for few samples.
const BLIND_AT_FIRST: f64 = 4.0;

/// Probabilities of the groups of lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LightGroups {
    /// Learnt probability of each group; the scene's own probabilities apply with the remainder to 1.
    pub(crate) shares: [f32; MAX_LIGHT_GROUPS],
}

impl LightGroups {
    /// The scene's own probabilities.
    pub(crate) const UNKNOWN: Self = Self { shares: [0.0; MAX_LIGHT_GROUPS] };

    /// Probabilities from the number of samples and the sum of each group's squared contributions divided by the probability of the
    /// group, in any unit. Those of the scene if there were no contributions.
    pub(crate) fn learnt(samples: u64, squares: &[u64; MAX_LIGHT_GROUPS]) -> Self {
        let roots = squares.map(|square| (square as f64).sqrt());
        let sum: f64 = roots.iter().sum();
        let known = 1.0 - (BLIND_AT_FIRST / (samples.max(1) as f64).sqrt()).max(BLIND);
        if sum <= 0.0 || known <= 0.0 {
            return Self::UNKNOWN;
        }
        Self { shares: roots.map(|root| (known * root / sum) as f32) }
    }

    /// Whether these are valid probabilities.
    pub(crate) fn is_valid(&self) -> bool {
        self.shares.iter().all(|&share| share >= 0.0) && self.known() <= 1.0 + 1e-6
    }

    fn known(&self) -> f64 {
        self.shares.iter().map(|&share| f64::from(share)).sum()
    }

    /// Weights of the groups at a point, in proportion to their probabilities; 0 where no light of a group can arrive.
    #[inline]
    pub(crate) fn weights(&self, scene: &Scene, from: &LightSampleContext) -> [f64; MAX_LIGHT_GROUPS] {
        let mut weights = scene.light_group_probabilities(from);
        let blind = (1.0 - self.known()).max(0.0);
        for (weight, &share) in weights.iter_mut().zip(&self.shares).filter(|(weight, _)| **weight > 0.0) {
            *weight = f64::from(share) + blind * *weight;
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_follow_the_root_of_squared_contributions() {
        // With 6400 samples, 5 % of selections are by the scene; the rest is divided 1 : 3.
        let mut squares = [0; MAX_LIGHT_GROUPS];
        (squares[0], squares[2]) = (100, 900);
        let groups = LightGroups::learnt(6400, &squares);
        for (group, expected) in [(0, 0.2375), (1, 0.0), (2, 0.7125)] {
            assert!((groups.shares[group] - expected).abs() < 1e-6);
        }
        assert!(groups.is_valid());
        // With few samples the fraction is larger: 4 / sqrt(64).
        assert!((LightGroups::learnt(64, &squares).known() - 0.5).abs() < 1e-6);
        assert_eq!(LightGroups::learnt(9, &squares), LightGroups::UNKNOWN);
        assert_eq!(LightGroups::learnt(6400, &[0; MAX_LIGHT_GROUPS]), LightGroups::UNKNOWN);
    }
}
