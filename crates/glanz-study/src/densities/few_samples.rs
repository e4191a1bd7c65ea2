//! Densities learnt from few samples (document 003 figure 2.9), by the document's method and by others.

use glanz_sampling::density::{Density, FittingMethod, MissingCoefficient};
use glanz_sampling::hash::combine;
use glanz_sampling::integrate::{SamplingPattern, integrate_adaptively};

use crate::densities::measure::{PassSchedule, plane};
use crate::study::{Settings, StudyError};
use glanz_report::Table;
use glanz_report::number::significant;

const COLUMNS: [(&str, &str); 7] = [
    ("learning", "learnt from"),
    ("samples_per_pass", "samples per pass"),
    ("published", "document 003"),
    ("least", "least"),
    ("median", "median"),
    ("most", "most"),
    ("shown_median", "sample variance, median"),
];

/// Fitting methods; the first is the document's.
const VARIANTS: [(&str, FittingMethod, SamplingPattern); 5] = [
    (
        "own samples or neighbours, independent",
        FittingMethod::OwnSamples(MissingCoefficient::Neighbours),
        SamplingPattern::Independent,
    ),
    (
        "own samples or the integral, independent",
        FittingMethod::OwnSamples(MissingCoefficient::Constant),
        SamplingPattern::Independent,
    ),
    (
        "own samples or neighbours, Sobol'",
        FittingMethod::OwnSamples(MissingCoefficient::Neighbours),
        SamplingPattern::Sobol,
    ),
    ("all samples, independent", FittingMethod::AllSamples, SamplingPattern::Independent),
    ("all samples, Sobol'", FittingMethod::AllSamples, SamplingPattern::Sobol),
];

/// Results with few samples per pass.
pub(super) struct FewSamples {
    pub(super) table: Table,
    /// Densities learnt by the document's method, by numbers of samples.
    pub(super) densities: Vec<(String, Density<2>)>,
    /// Variant, samples per pass, median of the variance.
    medians: Vec<(&'static str, u32, f64)>,
}

impl FewSamples {
    /// A sentence made from the figures.
    pub(super) fn finding(&self) -> Option<String> {
        let of = |variant: &str| self.medians.iter().find(|m| m.0 == variant && m.1 == 1000).map(|m| m.2);
        let (own, all) = (of(VARIANTS[0].0)?, of(VARIANTS[4].0)?);
        Some(format!(
            "With 1000 samples per pass in two dimensions, coefficients from their own independent samples (or neighbours \
             where there are none) result in a median variance of {}, coefficients from all samples on Sobol' points in {}.",
            significant(own),
            significant(all)
        ))
    }
}

/// Figure 2.9: hat functions with few samples per pass, learnt by the document's method and by others.
pub(super) fn few_samples(schedule: &PassSchedule<2>, settings: &Settings) -> Result<FewSamples, StudyError> {
    let mut table = Table::new(
        "convergence",
        "Exact variance of a single sample from the density learnt in three passes, 41 runs, and the sample variance of a \
         further pass. Hat functions, two dimensions.",
        &COLUMNS,
    );
    let (mut densities, mut medians) = (Vec::new(), Vec::new());
    for (variant, method, sampling) in VARIANTS {
        for (samples, published) in [(100, 0.0145), (1000, 0.001_88), (10_000, 0.0017), (100_000, 0.000_42)] {
            let (mut exact, mut shown) = (Vec::new(), Vec::new());
            let mut last = None;
            for run in 0..41 {
                settings.cancel.check()?;
                let mut plan = schedule.plan(samples, combine(settings.seed, 1000 + run));
                (plan.method, plan.sampling) = (method, sampling);
                let result = integrate_adaptively(&schedule.scales, &plan, plane)?;
                let Some(pass) = result.passes.last() else { continue };
                exact.push(pass.density.primary_variance(60, |x| plane(x)));
                shown.push(pass.estimate.primary_variance);
                last = Some(pass.density.clone());
            }
            exact.sort_by(f64::total_cmp);
            shown.sort_by(f64::total_cmp);
            let median = exact.get(exact.len() / 2).copied();
            medians.extend(median.map(|median| (variant, samples, median)));
            let as_published = variant == VARIANTS[0].0;
            table.push([
                variant.into(),
                u64::from(samples).into(),
                as_published.then_some(published).into(),
                exact.first().copied().into(),
                median.into(),
                exact.last().copied().into(),
                shown.get(shown.len() / 2).copied().into(),
            ]);
            if as_published {
                densities.extend(last.map(|density| (format!("{samples} samples per pass"), density)));
            }
        }
    }
    Ok(FewSamples { table, densities, medians })
}
