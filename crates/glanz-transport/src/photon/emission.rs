//! Densities of emission that send photons to mirrors and glass.
//!
//! Where few rays of the lights meet mirrors or glass, photons from uniform numbers are few. The density is that of the numbers by which a ray is sampled (the light, the place on
//! it and the direction), fitted to the flux that arrived as photons in two rounds before the first sample: the product of the densities of the three, mixed with uniform numbers,
//! so that no photon has more than four times its flux. The weights of photons do not contain it: a path from the camera that hits a light could not tell its numbers.

use glanz_math::DVec2;
use glanz_sampling::{PiecewiseConstant1, PiecewiseConstant2};

/// Cells along each number of place and direction.
const CELLS: usize = 32;

/// Cells of the number that selects the light.
const SELECTION_CELLS: usize = 64;

/// Fraction of paths by uniform numbers.
const UNIFORM: f64 = 0.25;

/// The numbers in [0, 1) that sample a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmissionNumbers {
    pub(super) direction: DVec2,
    pub(super) place: DVec2,
    pub(super) selection: f64,
}

/// A density of [`EmissionNumbers`].
#[derive(Clone, Debug)]
pub(super) struct EmissionDensity {
    direction: PiecewiseConstant2,
    place: PiecewiseConstant2,
    selection: PiecewiseConstant1,
}

impl EmissionDensity {
    /// The density in proportion to weights, those of place and direction spread over the cells around their own, because they may be few; `None` if all are 0.
    pub(super) fn fit(weighted: impl Iterator<Item = (EmissionNumbers, f64)>) -> Option<Self> {
        let [mut direction, mut place] = [const { [0.0; CELLS * CELLS] }; 2];
        let mut selection = [0.0; SELECTION_CELLS];
        for (numbers, weight) in weighted {
            spread(&mut direction, numbers.direction, weight);
            spread(&mut place, numbers.place, weight);
            selection[cell(numbers.selection, SELECTION_CELLS)] += weight;
        }
        Some(Self {
            direction: grid(&direction)?,
            place: grid(&place)?,
            selection: PiecewiseConstant1::try_new(&selection).ok()?,
        })
    }

    /// Numbers of the density from uniform ones, and their density. `xi`: another uniform number.
    pub(super) fn sample(&self, uniform: EmissionNumbers, xi: f64) -> (EmissionNumbers, f64) {
        let numbers = if xi < UNIFORM {
            uniform
        } else {
            EmissionNumbers {
                direction: self.direction.sample(uniform.direction).point,
                place: self.place.sample(uniform.place).point,
                selection: self.selection.sample(uniform.selection).0,
            }
        };
        let fitted = self.direction.pdf(numbers.direction)
            * self.place.pdf(numbers.place)
            * self.selection.pdf(numbers.selection);
        (numbers, UNIFORM + (1.0 - UNIFORM) * fitted)
    }
}

/// The density over the unit square in proportion to weights of its cells; `None` if all are 0.
fn grid(weights: &[f64; CELLS * CELLS]) -> Option<PiecewiseConstant2> {
    let largest = weights.iter().fold(0.0, |a: f64, &b| a.max(b));
    let weights = weights.iter().map(|weight| (weight / largest) as f32).collect();
    PiecewiseConstant2::try_new(CELLS, CELLS, weights, |_| 1.0).ok()
}

/// The cell of a number in [0, 1).
fn cell(x: f64, cells: usize) -> usize {
    ((x * cells as f64) as usize).min(cells - 1)
}

/// Adds a weight to the cell of a point of the unit square and to those around it.
fn spread(cells: &mut [f64; CELLS * CELLS], point: DVec2, weight: f64) {
    let around = |x: f64| {
        let middle = cell(x, CELLS);
        middle.saturating_sub(1)..=(middle + 1).min(CELLS - 1)
    };
    for row in around(point.y) {
        for column in around(point.x) {
            cells[row * CELLS + column] += weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::{PixelSampler, SamplerKind};

    use super::*;

    fn uniform(i: u32) -> (EmissionNumbers, f64) {
        let mut sampler = PixelSampler::new(SamplerKind::Sobol, 1, 5, [0, 0], i);
        let [x, y, u, v] = sampler.next_group();
        let [selection, xi, ..] = sampler.next_group();
        (EmissionNumbers { direction: DVec2::new(x, y), place: DVec2::new(u, v), selection }, xi)
    }

    #[test]
    fn weighted_means_are_those_of_uniform_numbers() {
        // Photons from a corner of the directions by one of the lights alone.
        let seen = |n: &EmissionNumbers| n.direction.x < 0.25 && n.direction.y > 0.5 && n.selection < 0.5;
        let trained = (0..1 << 14).map(|i| (uniform(i).0, 1.0)).filter(|(n, _)| seen(n));
        let density = EmissionDensity::fit(trained).unwrap();
        let (mut hits, mut sum, mut mean) = (0, 0.0, 0.0);
        for i in 0..1 << 14 {
            let (numbers, xi) = uniform(i);
            let (numbers, pdf) = density.sample(numbers, xi);
            assert!(pdf >= UNIFORM);
            mean += 1.0 / pdf;
            if seen(&numbers) {
                hits += 1;
                sum += 1.0 / pdf * numbers.place.x;
            }
        }
        let count = f64::from(1 << 14);
        // 1/16 of the uniform numbers, with a mean place of 1/2. Weights are 4 or nearly 0, so that their mean has an error of 1.4 %; three of them.
        assert!((mean / count - 1.0).abs() < 0.042, "{}", mean / count);
        // 10 000 hits, the weights of which vary by a third: an error of 0.4 %, without stratification.
        assert!((sum / count - 0.5 / 16.0).abs() < 0.012 / 32.0, "{}", sum / count);
        // Three quarters, less what is spread over the borders of the corner.
        assert!(f64::from(hits) > 0.6 * count, "{hits}");
    }
}
