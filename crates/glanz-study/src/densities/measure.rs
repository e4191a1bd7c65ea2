//! Variances, exact and estimated from samples.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_sampling::DensityError;
use glanz_sampling::basis::GaussLegendre;
use glanz_sampling::density::{CoefficientFloor, Density, TensorMultiResolution};
use glanz_sampling::hash::combine;
use glanz_sampling::integrate::{AdaptivePlan, IntegrationPass, IntegrationPlan, SamplingPattern, integrate};

use crate::study::{Settings, StudyError};

/// Number of groups of samples; their spread gives the standard error of a variance.
const GROUPS: u64 = 20;

/// sin(pi x / 2).
pub(super) fn sine(x: &[f64]) -> f64 {
    x.iter().map(|x| (0.5 * PI * x).sin()).product()
}

/// sin(pi (1 - u) / 2) sin(pi v / 2).
pub(super) fn plane(x: &[f64]) -> f64 {
    let [u, v] = x else { return 0.0 };
    sine(&[1.0 - u, *v])
}

/// The mean of repeated measurements.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredMean {
    pub(super) mean: f64,
    pub(super) standard_error: f64,
}

impl MeasuredMean {
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Self { mean, standard_error: (squares / (n - 1.0).max(1.0) / n).sqrt() }
    }
}

/// The variance of the mean of `count` samples of the sine from this density, from `total` samples.
pub(super) fn variance_of_means(
    density: &Density<1>,
    sampling: SamplingPattern,
    count: u32,
    total: u64,
    settings: &Settings,
) -> Result<MeasuredMean, StudyError> {
    let means = (total / u64::from(count) / GROUPS).max(2);
    let mut variances = Vec::new();
    for group in 0..GROUPS {
        settings.cancel.check()?;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..means {
            let seed = combine(combine(settings.seed, u64::from(count)), group * means + i);
            let plan = IntegrationPlan { samples: count, repetitions: 1, sampling, seed };
            // Errors instead of values, whose squares would cancel.
            let error = integrate(density, &plan, sine)?.mean - 2.0 / PI;
            sum += error;
            squares += error * error;
        }
        let n = means as f64;
        variances.push((squares - sum * sum / n) / (n - 1.0));
    }
    Ok(MeasuredMean::of(&variances))
}

/// The variance of the mean of `strata` samples of the sine, one from each of as many equal strata (@pietrek2001 equation
/// 2.9).
pub(super) fn stratified_variance(strata: u32) -> f64 {
    let gauss = GaussLegendre::new(30);
    let n = f64::from(strata);
    let of = |k: u32| {
        let (a, b) = (f64::from(k) / n, f64::from(k + 1) / n);
        let mean = n * gauss.integrate(a, b, |x| sine(&[x]));
        n * gauss.integrate(a, b, |x| (sine(&[x]) - mean).powi(2))
    };
    (0..strata).map(of).sum::<f64>() / (n * n)
}

/// Passes over scales, one more than scales: the first samples the constant density, the last the finest one.
pub(super) struct PassSchedule<const D: usize> {
    pub(super) name: &'static str,
    pub(super) scales: Arc<TensorMultiResolution<D>>,
    pub(super) levels: [usize; 3],
    /// Variances published in document 003, by pass.
    pub(super) published: [f64; 4],
}

impl<const D: usize> PassSchedule<D> {
    /// One run; every pass takes `samples`.
    pub(super) fn plan(&self, samples: u32, seed: u64) -> AdaptivePlan<D> {
        let [a, b, c] = self.levels;
        let passes = [a, b, c, c].map(|level| IntegrationPass { levels: [level; D], samples });
        AdaptivePlan::new(passes.to_vec(), seed)
    }

    /// The variance of each pass from infinitely many samples: densities from exact projections.
    pub(super) fn limits(
        &self,
        floor: CoefficientFloor,
        integral: f64,
        f: impl Fn(&[f64]) -> f64,
    ) -> Result<[f64; 4], DensityError> {
        // A density that almost vanishes near 0 needs many nodes.
        let nodes = if D == 1 { 400 } else { 100 };
        let mut variances = [0.0; 4];
        let first = Density::uniform(self.scales.basis([self.levels[0]; D])?);
        variances[0] = first.primary_variance(nodes, |x| f(x));
        for (variance, level) in variances[1..].iter_mut().zip(self.levels) {
            let basis = self.scales.basis([level; D])?;
            let proximum = basis.project(20, |x| f(x));
            let density = Density::from_approximation(basis, proximum, integral, floor)?;
            *variance = density.primary_variance(nodes, |x| f(x));
        }
        Ok(variances)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strata_have_the_variances_of_table_2_1() {
        // By quadrature in high precision; table 2.1 of document 003 has 0.0947, 0.0126, 0.00160.
        for (strata, expected) in
            [(1, 0.094_715_265_430_648_91), (2, 0.012_589_699_112_054_091), (4, 0.001_598_146_154_167_736_5)]
        {
            assert!((stratified_variance(strata) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn mean_and_standard_error_of_three_numbers() {
        let m = MeasuredMean::of(&[1.0, 2.0, 6.0]);
        assert_eq!(m.mean, 3.0);
        assert!((m.standard_error - (7.0_f64 / 3.0).sqrt()).abs() < 1e-15);
    }
}
