//! Sampling patterns of the unit cube.

use crate::basis::BELOW_ONE;
use crate::hash::{combine, unit_f64};
use crate::sequence::owen::{ScrambledSobol, unit};

/// Patterns of samples in [0, 1)^D.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum SamplingPattern {
    /// Independent uniform numbers.
    Independent,
    /// One random point per cell of a grid of k^D cells (@pietrek2001 section 2.2.3); the number of samples is rounded up to the
    /// next k^D.
    Stratified,
    /// Owen-scrambled Sobol' points, padded beyond four dimensions.
    #[default]
    Sobol,
}

impl SamplingPattern {
    /// Number of points for at least `samples` of them in `dimensions` dimensions.
    #[must_use]
    pub fn count(self, samples: u32, dimensions: usize) -> u32 {
        SamplePoints::new(self, 0, 0, samples, dimensions).count()
    }
}

/// The points of one repetition, which depend only on seed, index and dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct SamplePoints {
    sampling: SamplingPattern,
    key: u64,
    count: u32,
    /// Cells along each axis.
    side: u32,
}

impl SamplePoints {
    /// The points of a repetition, at least `samples` of them in `dimensions` dimensions.
    pub(super) fn new(
        sampling: SamplingPattern,
        seed: u64,
        repetition: u32,
        samples: u32,
        dimensions: usize,
    ) -> Self {
        let key = combine(seed, u64::from(repetition));
        let (side, count) = match sampling {
            SamplingPattern::Stratified => grid(samples, dimensions),
            _ => (1, samples),
        };
        Self { sampling, key, count, side }
    }

    /// Number of points.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Point `index` below [`SamplePoints::count`].
    #[inline]
    pub(super) fn point<const D: usize>(&self, index: u32) -> [f64; D] {
        match self.sampling {
            SamplingPattern::Independent => {
                let key = combine(self.key, u64::from(index));
                std::array::from_fn(|a| unit_f64(combine(key, a as u64)))
            }
            SamplingPattern::Stratified => {
                let key = combine(self.key, u64::from(index));
                let mut cell = index;
                std::array::from_fn(|a| {
                    let column = cell % self.side;
                    cell /= self.side;
                    let jitter = unit_f64(combine(key, a as u64));
                    ((f64::from(column) + jitter) / f64::from(self.side)).min(BELOW_ONE)
                })
            }
            SamplingPattern::Sobol => {
                let reversed = index.reverse_bits();
                std::array::from_fn(|a| {
                    let copy = ScrambledSobol::new(combine(self.key, (a / 4) as u64));
                    unit(copy.coordinate(reversed, a % 4))
                })
            }
        }
    }
}

/// The side and the number of cells of the smallest cubic grid with at least `samples` cells. If that has more than 2^32 - 1
/// cells, the side is smaller by one.
fn grid(samples: u32, dimensions: usize) -> (u32, u32) {
    let all = |side: u32| {
        (0..dimensions)
            .try_fold(1_u64, |p, _| Some(p * u64::from(side)).filter(|p| *p <= u64::from(u32::MAX)))
    };
    let mut side = f64::from(samples).powf(1.0 / dimensions.max(1) as f64).floor().max(1.0) as u32;
    // Corrects the rounding of the root.
    while side > 1 && all(side - 1).is_none_or(|p| p >= u64::from(samples)) {
        side -= 1;
    }
    while all(side).is_some_and(|p| p < u64::from(samples)) && all(side + 1).is_some() {
        side += 1;
    }
    (side, all(side).map_or(1, |p| p as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_hold_the_samples_and_no_more_cells_than_needed() {
        for dimensions in 1..=6 {
            for samples in
                [1_u32, 2, 3, 4, 7, 8, 9, 16, 17, 63, 64, 65, 100, 125, 126, 1000, 65536, 1_000_000]
            {
                let (side, count) = grid(samples, dimensions);
                assert_eq!(u64::from(count), u64::from(side).pow(dimensions as u32));
                assert!(count >= samples, "{samples} in {dimensions}");
                assert!(side == 1 || u64::from(side - 1).pow(dimensions as u32) < u64::from(samples));
            }
        }
        assert_eq!(grid(u32::MAX, 2), (65535, 65535 * 65535));
    }

    #[test]
    fn strata_hold_one_point_each() {
        let points = SamplePoints::new(SamplingPattern::Stratified, 5, 0, 64, 3);
        let mut seen = [0; 64];
        for i in 0..points.count() {
            let cell = points.point::<3>(i).iter().fold(0, |c, x| c * 4 + (x * 4.0) as usize);
            seen[cell] += 1;
        }
        assert_eq!(seen, [1; 64]);
    }

    #[test]
    fn any_dimension_of_any_kind_is_uniform_and_repetitions_differ() {
        for sampling in [SamplingPattern::Independent, SamplingPattern::Stratified, SamplingPattern::Sobol] {
            let points = SamplePoints::new(sampling, 1, 3, 4096, 6);
            let mut sums = [0.0; 6];
            for i in 0..points.count() {
                for (s, x) in sums.iter_mut().zip(points.point::<6>(i)) {
                    assert!((0.0..1.0).contains(&x));
                    *s += x;
                }
            }
            // Independent numbers: standard deviation sqrt(1 / 12 / 4096) = 0.0045 of the mean; 4.5 of them.
            assert!(
                sums.iter().all(|s| (s / f64::from(points.count()) - 0.5).abs() < 0.02),
                "{sampling:?} {sums:?}"
            );
            let other = SamplePoints::new(sampling, 1, 4, 4096, 6);
            assert_ne!(points.point::<6>(0), other.point::<6>(0));
        }
    }
}
