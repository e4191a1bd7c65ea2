//! Intensities at angles from means around them.
//!
//! The mean of an intensity with a hat as weight is the intensity in the middle of the hat's light, which is not at its peak where the steps on both
//! sides differ, and near the poles, where directions become more with gamma. The slope to the neighbouring values moves it there, never
//! beyond one of them.

use super::grid::FarFieldGrid;

/// Nodes of Gauss and Legendre on [0, 1] and their weights.
const NODES: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

impl FarFieldGrid {
    /// Intensities at the angles of the bins, from their means with the hats as weights; with the same flux.
    pub(crate) fn centred(&self, means: &[f64]) -> Vec<f64> {
        let (planes, gammas) = (self.planes(), self.gammas());
        let count = planes.len();
        let moved = |values: &[f64], by_gamma: bool| -> Vec<f64> {
            let mut moved = values.to_vec();
            let at =
                |plane: usize, gamma: usize| values.get(self.bin_of(plane, gamma)).copied().unwrap_or(0.0);
            for (gamma, plane) in (1..gammas.len() - 1).flat_map(|j| (0..count).map(move |i| (j, i))) {
                let (steps, before, after) = if by_gamma {
                    let steps = [gammas[gamma] - gammas[gamma - 1], gammas[gamma + 1] - gammas[gamma]];
                    (steps, at(plane, gamma - 1), at(plane, gamma + 1))
                } else {
                    (self.plane_steps(plane), at(plane + count - 1, gamma), at(plane + 1, gamma))
                };
                let offset =
                    if by_gamma { middle(gammas[gamma], steps) } else { (steps[1] - steps[0]) / 3.0 };
                let own = at(plane, gamma);
                let slope = limited([(own - before) / steps[0], (after - own) / steps[1]]);
                if let Some(slot) = moved.get_mut(self.bin_of(plane, gamma)) {
                    let centred = own - slope * offset;
                    *slot =
                        if slope == 0.0 { own } else { centred.clamp(before.min(after), before.max(after)) };
                }
            }
            moved
        };
        let mut values = moved(&moved(means, true), false);
        let flux = |values: &[f64]| -> f64 {
            values.iter().enumerate().map(|(bin, value)| value * self.solid_angle(bin)).sum()
        };
        let (counted, found) = (flux(means), flux(&values));
        if found > 0.0 {
            values.iter_mut().for_each(|value| *value *= counted / found);
        }
        values
    }

    /// Steps to a plane from the one before, and from it to the next, degrees.
    fn plane_steps(&self, plane: usize) -> [f64; 2] {
        let planes = self.planes();
        let at = |i: usize| planes.get(i).copied().unwrap_or(360.0);
        let before = if plane == 0 { at(planes.len() - 1) - 360.0 } else { at(plane - 1) };
        [at(plane) - before, at(plane + 1) - at(plane)]
    }
}

/// The harmonic mean of the slopes on both sides, which is close to the flatter one where they differ, and 0 at a peak (@vanleer1974): edges do not overshoot.
fn limited([before, after]: [f64; 2]) -> f64 {
    let product = before * after;
    if product > 0.0 { 2.0 * product / (before + after) } else { 0.0 }
}

/// Distance of the mean gamma under a hat from its peak, degrees; `steps`: of the hat on both sides.
fn middle(gamma: f64, steps: [f64; 2]) -> f64 {
    let (mut sum, mut moment) = (0.0, 0.0);
    for (x, weight) in NODES {
        for (step, sign) in steps.into_iter().zip([-1.0, 1.0]) {
            let distance = sign * step * x;
            let weight = weight * (1.0 - x) * step * (gamma + distance).to_radians().sin();
            sum += weight;
            moment += weight * distance;
        }
    }
    moment / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensities_that_are_linear_in_gamma_are_found_between_uneven_steps() {
        let fine = [0.0, 1.25, 2.5, 5.0, 7.5, 8.75];
        let gammas: Vec<f64> = fine.into_iter().chain((2..=36).map(|i| 5.0 * f64::from(i))).collect();
        let grid = FarFieldGrid::from_angles(vec![0.0, 90.0, 120.0], gammas.clone()).unwrap();
        // 200 - gamma: its mean under a hat, by the midpoint rule.
        let mean = |j: usize| {
            let mut sums = [0.0; 2];
            for end in [j.wrapping_sub(1), j + 1].into_iter().filter_map(|i| gammas.get(i)) {
                for i in 0..2000 {
                    let x = (f64::from(i) + 0.5) / 2000.0;
                    let gamma = gammas[j] + x * (end - gammas[j]);
                    let weight = (1.0 - x) * gamma.to_radians().sin() * (end - gammas[j]).abs();
                    sums = [sums[0] + weight * (200.0 - gamma), sums[1] + weight];
                }
            }
            sums[0] / sums[1]
        };
        let mut means = vec![0.0; grid.bins()];
        for (i, j) in (0..3).flat_map(|i| (0..gammas.len()).map(move |j| (i, j))) {
            means[grid.bin_of(i, j)] = mean(j);
        }
        let values = grid.centred(&means);
        let [worst_mean, worst] = [&means, &values].map(|values| {
            (1..36).map(|j| (values[grid.bin_of(1, j)] - (200.0 - gammas[j])).abs()).fold(0.0, f64::max)
        });
        assert!(worst < 0.25 && worst_mean > 1.0, "{worst} {worst_mean}");
        let flux =
            |values: &[f64]| -> f64 { (0..grid.bins()).map(|bin| values[bin] * grid.solid_angle(bin)).sum() };
        assert!((flux(&values) / flux(&means) - 1.0).abs() < 1e-12);
    }
}
