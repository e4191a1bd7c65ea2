//! Which lamps matter at a place.
//!
//! Light sampling picks one lamp of many; with the probability of each in proportion to the root of its mean squared
//! contribution the variance is least. At most places few lamps are seen at all, and their powers say nothing of it. Lamps are taken in
//! the scene's groups ([`Scene::light_groups`](glanz_scene::Scene::light_group_count)), so that thousands cost no more than sixteen.

use glanz_scene::{LightId, MAX_LIGHT_GROUPS, Scene};

/// Least share of picks that follow the scene's own probabilities: lamps that have not been seen yet may be there all the same.
const BLIND: f64 = 0.05;

/// That share times the square root of the number of samples, where these are few.
const BLIND_AT_FIRST: f64 = 4.0;

/// Probabilities of the groups of lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LightGroups {
    /// Share of each group; what is missing to 1 is shared as the scene does.
    pub(crate) shares: [f32; MAX_LIGHT_GROUPS],
}

impl LightGroups {
    /// As the scene does.
    pub(crate) const UNKNOWN: Self = Self { shares: [0.0; MAX_LIGHT_GROUPS] };

    /// From a number of samples and the sum of each group's squared contributions over the probability with which the group
    /// was picked, in any unit. As the scene does if nothing was found.
    pub(crate) fn learnt(samples: u64, squares: &[u64; MAX_LIGHT_GROUPS]) -> Self {
        let roots = squares.map(|square| (square as f64).sqrt());
        let sum: f64 = roots.iter().sum();
        let known = 1.0 - (BLIND_AT_FIRST / (samples.max(1) as f64).sqrt()).max(BLIND);
        if sum <= 0.0 || known <= 0.0 {
            return Self::UNKNOWN;
        }
        Self { shares: roots.map(|root| (known * root / sum) as f32) }
    }

    /// True if these are valid probabilities.
    pub(crate) fn is_valid(&self) -> bool {
        self.shares.iter().all(|&share| share >= 0.0) && self.known() <= 1.0 + 1e-6
    }

    fn known(&self) -> f64 {
        self.shares.iter().map(|&share| f64::from(share)).sum()
    }

    /// Probability of a group.
    #[inline]
    pub(crate) fn group_probability(&self, scene: &Scene, group: usize) -> f64 {
        let share = self.shares.get(group).map_or(0.0, |&share| f64::from(share));
        share + (1.0 - self.known()).max(0.0) * scene.light_group_probability(group)
    }

    /// Probability of a lamp.
    #[inline]
    pub(crate) fn probability(&self, scene: &Scene, id: LightId) -> f64 {
        let group = scene.light_group(id);
        let among_all = scene.light_group_probability(group);
        if among_all <= 0.0 {
            return 0.0;
        }
        self.group_probability(scene, group) * scene.light_probability(id) / among_all
    }

    /// A lamp and its probability, by a number uniform in [0, 1).
    #[inline]
    pub(crate) fn pick(&self, scene: &Scene, xi: f64) -> Option<(LightId, f64)> {
        let mut below = 0.0;
        let last = scene.light_group_count().checked_sub(1)?;
        for group in 0..=last {
            let probability = self.group_probability(scene, group);
            // Rounding may carry xi past the end; a group that the scene does not have is never reached.
            if xi < below + probability || group == last {
                let left = ((xi - below) / probability).clamp(0.0, 1.0 - f64::EPSILON / 2.0);
                let (id, inside) = scene.select_light_in_group(group, left)?;
                return Some((id, probability * inside));
            }
            below += probability;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_the_root_of_what_was_found() {
        // Of 6400 samples 5 % stay blind; the rest is shared 1 : 3.
        let mut squares = [0; MAX_LIGHT_GROUPS];
        (squares[0], squares[2]) = (100, 900);
        let lamps = LightGroups::learnt(6400, &squares);
        for (group, expected) in [(0, 0.2375), (1, 0.0), (2, 0.7125)] {
            assert!((lamps.shares[group] - expected).abs() < 1e-6);
        }
        assert!(lamps.is_valid());
        // With few samples more stays blind: 4 / sqrt(64).
        assert!((LightGroups::learnt(64, &squares).known() - 0.5).abs() < 1e-6);
        assert_eq!(LightGroups::learnt(9, &squares), LightGroups::UNKNOWN);
        assert_eq!(LightGroups::learnt(6400, &[0; MAX_LIGHT_GROUPS]), LightGroups::UNKNOWN);
    }
}
