//! Selection of lights.

use std::ops::Range;

use super::LightId;

/// Largest number of groups of lights.
pub const MAX_LIGHT_GROUPS: usize = 16;

/// Fraction of the probability that is spread evenly, so that a light that matters locally is not starved by a strong distant one.
const EVEN_SHARE: f64 = 0.2;

/// Selects lights by power, with an even minimum for each.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSelector {
    /// Probability per light; 0 where it cannot be sampled.
    probabilities: Vec<f64>,
    /// Running sums, ending in 1; empty if there is nothing to select.
    cumulative: Vec<f64>,
    /// Lights with consecutive numbers, without gaps; empty if there is nothing to select.
    groups: Vec<Range<u32>>,
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
        let groups = groups(&probabilities);
        Self { probabilities, cumulative, groups }
    }

    /// A light and its probability, by a number uniform in [0, 1).
    pub(crate) fn select(&self, xi: f64) -> Option<(LightId, f64)> {
        let last = self.cumulative.last()?;
        self.find(xi * last, 0..self.cumulative.len())
    }

    /// The light that is always selected, if there is only one.
    pub(crate) fn only(&self) -> Option<LightId> {
        let mut lights = (0..).zip(&self.probabilities).filter(|(_, p)| **p > 0.0);
        let (first, _) = lights.next()?;
        lights.next().is_none().then_some(LightId(first))
    }

    /// The light of `range` where the running sum passes `sum`, and its probability among all.
    fn find(&self, sum: f64, range: Range<usize>) -> Option<(LightId, f64)> {
        let (start, inside) = (range.start, self.cumulative.get(range.clone())?);
        let index = start + inside.partition_point(|&c| c <= sum);
        // Rounding may carry the sum past the end; the last light that can be selected takes it.
        let index = if index < range.end {
            index
        } else {
            start + self.probabilities.get(range)?.iter().rposition(|&p| p > 0.0)?
        };
        let probability = *self.probabilities.get(index)?;
        (probability > 0.0).then_some((LightId(index as u32), probability))
    }

    /// Number of groups.
    pub(crate) fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The group of `light`.
    pub(crate) fn group(&self, light: LightId) -> usize {
        self.groups.partition_point(|group| group.end <= light.0)
    }

    /// The probability that [`LightSelector::select`] selects a light of this group.
    pub(crate) fn group_probability(&self, group: usize) -> f64 {
        self.bounds(group).map_or(0.0, |(low, high)| high - low)
    }

    /// A light of a group and its probability among those of the group, by a number uniform in [0, 1).
    pub(crate) fn select_in_group(&self, group: usize, xi: f64) -> Option<(LightId, f64)> {
        let (low, high) = self.bounds(group)?;
        let range = self.groups.get(group)?;
        let (light, probability) =
            self.find(low + xi * (high - low), range.start as usize..range.end as usize)?;
        // Differences of sums carry rounding errors.
        Some((light, (probability / (high - low)).min(1.0)))
    }

    /// Running sums at the ends of a group.
    fn bounds(&self, group: usize) -> Option<(f64, f64)> {
        let range = self.groups.get(group)?;
        let before = range.start.checked_sub(1).and_then(|i| self.cumulative.get(i as usize));
        Some((before.copied().unwrap_or(0.0), *self.cumulative.get(range.end as usize - 1)?))
    }

    /// The probability of `light`.
    pub(crate) fn probability(&self, light: LightId) -> f64 {
        self.probabilities.get(light.0 as usize).copied().unwrap_or(0.0)
    }
}

/// Lights in at most [`MAX_LIGHT_GROUPS`] groups of consecutive numbers: one light each if they are few, of about the same probability if
/// they are many.
///
/// Numbers follow the scene file, where related lights are adjacent.
fn groups(probabilities: &[f64]) -> Vec<Range<u32>> {
    let few = probabilities.iter().filter(|&&p| p > 0.0).count() <= MAX_LIGHT_GROUPS;
    let mut groups: Vec<Range<u32>> = Vec::new();
    let mut running = 0.0;
    for (light, &probability) in (0..).zip(probabilities) {
        let shares = groups.len() as f64 / MAX_LIGHT_GROUPS as f64;
        let open = if few { running == 0.0 } else { running < shares || groups.len() == MAX_LIGHT_GROUPS };
        match groups.last_mut() {
            // A light that is never selected belongs to any group.
            Some(last) if open || probability == 0.0 => last.end = light + 1,
            _ => groups.push(light..light + 1),
        }
        running += probability;
    }
    groups
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

    #[test]
    fn few_lights_are_groups_of_one() {
        let selector = LightSelector::new(&[0.0, 3.0, 0.0, 1.0, 0.0]);
        assert_eq!(selector.group_count(), 2);
        assert_eq!([0, 1, 2, 3, 4].map(|i| selector.group(LightId(i))), [0, 0, 0, 1, 1]);
        assert!((selector.group_probability(0) - 0.7).abs() < 1e-15);
        for xi in [0.0, 0.5, 1.0 - f64::EPSILON] {
            for (group, light) in [(0, 1), (1, 3)] {
                let (found, inside) = selector.select_in_group(group, xi).unwrap();
                assert!(found == LightId(light) && (inside - 1.0).abs() < 1e-14);
            }
        }
        assert_eq!(selector.select_in_group(2, 0.5), None);
    }

    #[test]
    fn many_lights_form_groups_of_about_the_same_probability() {
        let importance: Vec<f64> = (0..1000).map(|i| f64::from(i % 7)).collect();
        let selector = LightSelector::new(&importance);
        assert_eq!(selector.group_count(), MAX_LIGHT_GROUPS);
        for group in 0..MAX_LIGHT_GROUPS {
            let probability = selector.group_probability(group);
            assert!((probability - 1.0 / 16.0).abs() < 0.005, "{group}: {probability}");
            // Selecting a group and a light in it has the probability of selecting the light.
            for i in 0..50 {
                let (light, inside) = selector.select_in_group(group, f64::from(i) / 50.0).unwrap();
                assert_eq!(selector.group(light), group);
                assert!((inside * probability - selector.probability(light)).abs() < 1e-15);
            }
        }
    }
}
