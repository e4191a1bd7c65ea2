//! Statistics over independent replicates of the particles.
//!
//! Particles come from Owen-scrambled Sobol' sequences, whose points are not independent: the usual standard error, from the squares of their
//! contributions, is that of independent points and up to 17 times too large. Therefore particle n belongs to replicate n mod 16, and each replicate
//! has a sequence with a scramble of its own. Replicates are independent, so that the spread of their means is the error of the mean of all (@cranley1976).
//! The price: sixteen short sequences integrate smooth light less well than one long one. For the direct light of a point, errors are twice as large.

use glanz_transport::ParticleRanges;

/// Number of replicates. The standard deviation of a standard error from n of them is 1 / sqrt(2 (n - 1)) of it: 18 %.
pub(crate) const REPLICATES: usize = 16;

/// Quantiles of Student's distribution at 97.5 % for 1 to 15 degrees of freedom.
const QUANTILES: [f64; REPLICATES - 1] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
];

/// The first number in a replicate's sequence that is not of a particle before `particle`.
pub(crate) fn first_in_replicate(replicate: usize, particle: u64) -> u64 {
    particle.saturating_sub(replicate as u64).div_ceil(REPLICATES as u64)
}

/// Numbers of particles of the replicates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReplicateCounts {
    counts: [f64; REPLICATES],
    total: f64,
}

impl ReplicateCounts {
    /// Of replicates with equal weights.
    pub(crate) const EQUAL: Self = Self { counts: [1.0; REPLICATES], total: REPLICATES as f64 };

    pub(crate) fn of(particles: &ParticleRanges) -> Self {
        let count = |replicate: usize| {
            let length = |range: &std::ops::Range<u64>| {
                first_in_replicate(replicate, range.end) - first_in_replicate(replicate, range.start)
            };
            particles.as_slice().iter().map(length).sum::<u64>() as f64
        };
        Self { counts: std::array::from_fn(count), total: particles.total() as f64 }
    }

    /// Numbers of the replicates with particles.
    fn used(&self) -> impl Iterator<Item = usize> {
        (0..REPLICATES).filter(|&replicate| self.counts[replicate] > 0.0)
    }

    /// The means over the particles of each replicate, from their sums; 0 without particles.
    pub(crate) fn means(&self, sums: impl Fn(usize) -> f64) -> [f64; REPLICATES] {
        std::array::from_fn(|replicate| match self.counts[replicate] {
            count if count > 0.0 => sums(replicate) / count,
            _ => 0.0,
        })
    }

    /// Mean of the means of replicates. Its error is infinite for a single replicate.
    pub(crate) fn estimate(&self, means: &[f64; REPLICATES]) -> ReplicateEstimate {
        let used = self.used().count();
        let weight = |replicate: usize| self.counts[replicate] / self.total;
        let value: f64 = self.used().map(|r| weight(r) * means[r]).sum();
        let spread: f64 = self.used().map(|r| (weight(r) * (means[r] - value)).powi(2)).sum();
        let (error, quantile) = match used.saturating_sub(1) {
            0 => (f64::INFINITY, 1.0),
            freedom => ((spread * used as f64 / freedom as f64).sqrt(), QUANTILES[freedom - 1]),
        };
        let margin = quantile * error;
        ReplicateEstimate { value, error, interval: [value - margin, value + margin] }
    }

    /// The mean over the particles of every other replicate, from the first or the second one on; 0 without any.
    fn half_mean(&self, means: &[f64; REPLICATES], first: usize) -> f64 {
        let half = || self.used().filter(|replicate| replicate % 2 == first);
        let count: f64 = half().map(|replicate| self.counts[replicate]).sum();
        let sum: f64 = half().map(|replicate| self.counts[replicate] * means[replicate]).sum();
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// The smallest of the expected values of several quantities, given by the means of their replicates; `None` without quantities.
    ///
    /// The smallest of the means would be too small: noise decides which it is. Therefore each half of the replicates gives the values of the quantity that is
    /// smallest in the other half, of which they are independent. What remains is that noise may choose another quantity than the smallest: then the value is
    /// too large, by less than the noise. The interval reaches from the least of all lower limits to the upper limit of the value, so that it holds the smallest expected value with a probability of 95 % at least.
    ///
    /// To choose for each replicate by all others has hardly less bias and a much larger variance: mostly they all choose the smallest mean.
    pub(crate) fn smallest<'a>(
        &self,
        quantities: impl Iterator<Item = &'a [f64; REPLICATES]>,
    ) -> Option<ReplicateEstimate> {
        let mut lower: Option<f64> = None;
        let mut chosen = [(f64::INFINITY, [0.0; REPLICATES]); 2];
        for means in quantities {
            let [low, _] = self.estimate(means).interval;
            lower = Some(lower.map_or(low, |lower| lower.min(low)));
            for (first, chosen) in chosen.iter_mut().enumerate() {
                let by_half = self.half_mean(means, first);
                if by_half < chosen.0 {
                    *chosen = (by_half, *means);
                }
            }
        }
        let lower = lower?;
        let values = std::array::from_fn(|replicate| chosen[1 - replicate % 2].1[replicate]);
        let mut estimate = self.estimate(&values);
        estimate.interval[0] = estimate.interval[0].min(lower);
        Some(estimate)
    }

    /// The largest, as [`ReplicateCounts::smallest`].
    pub(crate) fn largest<'a>(
        &self,
        quantities: impl Iterator<Item = &'a [f64; REPLICATES]>,
    ) -> Option<ReplicateEstimate> {
        let negated: Vec<[f64; REPLICATES]> = quantities.map(|means| means.map(|mean| -mean)).collect();
        let ReplicateEstimate { value, error, interval: [low, high] } = self.smallest(negated.iter())?;
        Some(ReplicateEstimate { value: -value, error, interval: [-high, -low] })
    }
}

/// An expected value, estimated from replicates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReplicateEstimate {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
    /// Interval that holds the expected value with a probability of 95 %.
    pub interval: [f64; 2],
}

/// Estimate from the means of replicates of equal size.
pub(crate) fn of_replicates(means: &[f64; REPLICATES]) -> ReplicateEstimate {
    let counts = ReplicateCounts { counts: [1.0; REPLICATES], total: REPLICATES as f64 };
    counts.estimate(means)
}

impl ReplicateEstimate {
    /// The same with an exact number more.
    pub(crate) fn plus(self, exact: f64) -> Self {
        Self { value: self.value + exact, interval: self.interval.map(|limit| limit + exact), ..self }
    }

    /// The same after a multiplication by a positive number.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        let Self { value, error, interval } = self;
        Self { value: value * factor, error: error * factor, interval: interval.map(|limit| limit * factor) }
    }

    /// The same with another error of at most `bound`.
    pub(crate) fn widened(self, bound: f64) -> Self {
        let Self { value, error, interval: [low, high] } = self;
        Self { value, error: with_bound(error, bound), interval: [low - bound, high + bound] }
    }
}

/// The standard error of a sum, a part of which has a known `bound` of its error: as if that were uniform between its limits (@jcgm100 section 4.3.7).
pub(crate) fn with_bound(error: f64, bound: f64) -> f64 {
    error.hypot(bound / 3.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_sampling::hash::combine;

    /// The replicate of a particle, and its number in the sequence of the replicate.
    fn replicate_of(particle: u64) -> (usize, u64) {
        ((particle % REPLICATES as u64) as usize, particle / REPLICATES as u64)
    }

    fn counts(particles: u64) -> ReplicateCounts {
        let mut ranges = ParticleRanges::default();
        ranges.try_insert(0..particles).unwrap();
        ReplicateCounts::of(&ranges)
    }

    /// Normally distributed numbers of mean 0 and variance 1, by the sum of twelve uniform ones.
    fn noise(seed: u64, number: u64) -> f64 {
        let uniform = |i: u64| combine(combine(seed, number), i) as f64 / u64::MAX as f64;
        (0..12).map(uniform).sum::<f64>() - 6.0
    }

    #[test]
    fn particles_take_turns_in_the_replicates() {
        let ranges = vec![3..70, 100..101, 1000..4000];
        let particles = ParticleRanges::from_ascending(ranges.clone()).unwrap();
        let mut expected = [0.0; REPLICATES];
        for (replicate, _) in ranges.into_iter().flatten().map(replicate_of) {
            expected[replicate] += 1.0;
        }
        assert_eq!(ReplicateCounts::of(&particles).counts, expected);
        for particle in 0..100 {
            let (replicate, number) = replicate_of(particle);
            assert_eq!(first_in_replicate(replicate, particle), number);
            assert_eq!(first_in_replicate(replicate, particle + 1), number + 1);
        }
    }

    #[test]
    fn error_of_equal_replicates_is_that_of_their_mean() {
        let means: [f64; REPLICATES] = std::array::from_fn(|i| i as f64);
        let estimate = counts(160).estimate(&means);
        // Variance of 0 to 15: 255 / 12; unbiased 16 / 15 of it; of the mean 1 / 16.
        let error = (255.0_f64 / 12.0 * 16.0 / 15.0 / 16.0).sqrt();
        assert!((estimate.value - 7.5).abs() < 1e-14 && (estimate.error - error).abs() < 1e-14);
        assert!((estimate.interval[1] - (7.5 + 2.131 * error)).abs() < 1e-13);
        assert_eq!(counts(1).estimate(&means).error, f64::INFINITY);
        assert_eq!(counts(0).estimate(&means).value, 0.0);
        // Two replicates with one particle each: of 0 and 1.
        assert_eq!(counts(2).estimate(&means).error, 0.5);
    }

    #[test]
    fn smallest_and_largest_are_not_biased_by_noise() {
        // 400 equal quantities 10 with noise 1 in the mean of all: the smallest mean is near 10 - 3.
        let (runs, counts) = (200, counts(1600));
        let (mut sum, mut plain, mut held) = (0.0, 0.0, 0);
        for run in 0..runs {
            let quantity =
                |i: u64| std::array::from_fn(|r| 10.0 + 4.0 * noise(run, i * REPLICATES as u64 + r as u64));
            let quantities: Vec<[f64; REPLICATES]> = (0..400).map(quantity).collect();
            let [low, high] =
                [counts.smallest(quantities.iter()), counts.largest(quantities.iter())].map(Option::unwrap);
            plain +=
                quantities.iter().map(|means| counts.estimate(means).value).fold(f64::INFINITY, f64::min);
            sum += low.value;
            let holds =
                |estimate: ReplicateEstimate| estimate.interval[0] <= 10.0 && 10.0 <= estimate.interval[1];
            held += u32::from(holds(low)) + u32::from(holds(high));
        }
        let [mean, plain] = [sum, plain].map(|sum| sum / runs as f64);
        // Standard error of the mean over 200 runs: 0.07 and less.
        assert!((mean - 10.0).abs() < 0.3 && plain < 7.4, "{mean} {plain}");
        assert!(held >= 380, "{held} of 400 intervals hold the value");
    }

    #[test]
    fn a_clear_minimum_is_its_own_mean() {
        let quantities: Vec<[f64; REPLICATES]> = (0..50)
            .map(|i| {
                std::array::from_fn(|r| 10.0 * f64::from((i as i32 - 20).abs()) + 0.1 * noise(i, r as u64))
            })
            .collect();
        let counts = counts(1600);
        assert_eq!(counts.smallest(quantities.iter()), Some(counts.estimate(&quantities[20])));
        assert_eq!(counts.smallest(std::iter::empty()), None);
    }
}
