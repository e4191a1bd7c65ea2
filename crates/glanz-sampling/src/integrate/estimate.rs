//! Estimates of integrals with their variances.

use crate::density::Weighting;

/// An integral estimated from samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Number of values of the integrand.
    pub samples: u64,
    /// The mean of f / p: the integral.
    pub mean: f64,
    /// Variance of the primary estimator f / p of a single sample. 0 for a single sample.
    pub primary_variance: f64,
    /// Variance of [`Estimate::mean`]. For independent samples, the primary variance divided by their number (@pietrek2001 equation
    /// 2.5); for others, from the variance of the repetitions. Infinite if it cannot be estimated.
    pub mean_variance: f64,
}

impl Estimate {
    /// Standard deviation of the mean, in units of the integral.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.mean_variance.sqrt()
    }

    /// The combination of estimates of the same integral; `None` if there are none.
    ///
    /// The primary variance is the mean weighted by samples, as in tables 2.3 and 2.5 of document 003.
    #[must_use]
    pub fn combine(estimates: &[Self], weighting: Weighting) -> Option<Self> {
        let samples: u64 = estimates.iter().map(|e| e.samples).sum();
        if samples == 0 {
            return None;
        }
        let all = samples as f64;
        let primary = estimates.iter().map(|e| e.samples as f64 * e.primary_variance).sum::<f64>() / all;
        let known = estimates.iter().all(|e| e.mean_variance.is_finite() && e.mean_variance > 0.0);
        let by_variance = weighting == Weighting::InverseVariance && known;
        let weight = |e: &Self| if by_variance { 1.0 / e.mean_variance } else { e.samples as f64 };
        let sum: f64 = estimates.iter().map(weight).sum();
        let mean = estimates.iter().map(|e| weight(e) / sum * e.mean).sum();
        let mean_variance = estimates.iter().map(|e| (weight(e) / sum).powi(2) * e.mean_variance).sum();
        Some(Self { samples, mean, primary_variance: primary, mean_variance })
    }
}

/// Mean and variance of numbers that are added one by one, without cancellation (Welford's recurrences).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RunningMoments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl RunningMoments {
    pub(super) fn add(&mut self, x: f64) {
        self.count += 1;
        let before = x - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (x - self.mean);
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased estimate of the variance; `None` for fewer than two numbers.
    pub(super) fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.squares / (self.count - 1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUGH: Estimate = Estimate { samples: 100, mean: 2.0, primary_variance: 4.0, mean_variance: 0.04 };
    const FINE: Estimate = Estimate { samples: 300, mean: 1.0, primary_variance: 3.0, mean_variance: 0.01 };

    #[test]
    fn moments_are_those_of_the_numbers() {
        let mut m = RunningMoments::default();
        [1e9 + 1.0, 1e9 + 2.0, 1e9 + 6.0].iter().for_each(|x| m.add(*x));
        assert_eq!((m.mean(), m.variance()), (1e9 + 3.0, Some(7.0)));
        assert_eq!(RunningMoments::default().variance(), None);
    }

    #[test]
    fn standard_error_is_the_root_of_the_variance_of_the_mean() {
        assert!((FINE.standard_error() - 0.1).abs() < 1e-16);
    }

    #[test]
    fn estimates_combine_by_samples_or_by_variance() {
        let by_samples = Estimate::combine(&[ROUGH, FINE], Weighting::Samples).unwrap();
        // Weights 1/4 and 3/4.
        assert_eq!((by_samples.samples, by_samples.mean, by_samples.primary_variance), (400, 1.25, 3.25));
        assert!((by_samples.mean_variance - (0.04 / 16.0 + 9.0 * 0.01 / 16.0)).abs() < 1e-17);
        let by_variance = Estimate::combine(&[ROUGH, FINE], Weighting::InverseVariance).unwrap();
        // Weights 1/5 and 4/5; 1 / (25 + 100).
        assert!((by_variance.mean - 1.2).abs() < 1e-15);
        assert!((by_variance.mean_variance - 0.008).abs() < 1e-17);
        assert!(Estimate::combine(&[], Weighting::Samples).is_none());
    }
}
