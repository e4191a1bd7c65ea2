//! Fixed densities (document 003 table 2.1).

use std::sync::Arc;

use glanz_sampling::DensityError;
use glanz_sampling::basis::{FunctionBasis, TensorBasis};
use glanz_sampling::density::Density;
use glanz_sampling::integrate::SamplingPattern;

use crate::densities::SAMPLES;
use crate::densities::measure::{MeasuredMean, sine, stratified_variance, variance_of_means};
use crate::study::{Settings, StudyError};
use glanz_report::Table;

const COLUMNS: [(&str, &str); 6] = [
    ("case", "case"),
    ("samples", "samples"),
    ("published", "document 003"),
    ("exact", "exact"),
    ("measured", "measured"),
    ("standard_error", "standard error"),
];

/// Table 2.1: variances of the means of one, two and four samples from fixed densities.
pub(super) fn table_2_1(settings: &Settings) -> Result<Table, StudyError> {
    let mut table = Table::new(
        "table_2_1",
        "Variance of the mean of one, two and four samples, sin(pi x / 2).",
        &COLUMNS,
    );
    let hats = |level| -> Result<_, DensityError> {
        Ok(Arc::new(TensorBasis::try_new([FunctionBasis::uniform_bspline(1, level)?])?))
    };
    let interpolated = |level: usize| -> Result<_, DensityError> {
        let n = f64::from(1_u32 << level);
        let values = (0..=1_u32 << level).map(|i| sine(&[f64::from(i) / n])).collect();
        Density::try_new(hats(level)?, values)
    };
    let proximum = hats(0)?.project(30, |x| sine(x));
    let mirrored = proximum.iter().rev().copied().collect();
    let uniform = Density::<1>::constant()?;
    let cases = [
        ("uniform", uniform.clone(), [0.0947, 0.0474, 0.0237]),
        ("linear, 1 segment", interpolated(0)?, [0.006_78, 0.003_39, 0.0017]),
        ("linear, 2 segments", interpolated(1)?, [0.000_267, 0.000_133, 0.000_066_7]),
        ("linear, 4 segments", interpolated(2)?, [0.000_014_3, 0.000_007_16, 0.000_003_58]),
        ("linear, L2", Density::try_new(hats(0)?, proximum)?, [0.006_14, 0.003_07, 0.001_54]),
        ("linear, L2, mirrored", Density::try_new(hats(0)?, mirrored)?, [0.593, 0.297, 0.148]),
    ];
    let mut push = |name: &str, samples: u32, published: f64, exact: f64, measured: MeasuredMean| {
        table.push([
            name.into(),
            u64::from(samples).into(),
            published.into(),
            exact.into(),
            measured.mean.into(),
            measured.standard_error.into(),
        ]);
    };
    let total = u64::from(SAMPLES);
    for (name, density, published) in &cases {
        let exact = density.primary_variance(100, |x| sine(x));
        for (samples, published) in [1, 2, 4].into_iter().zip(published) {
            let measured =
                variance_of_means(density, SamplingPattern::Independent, samples, total, settings)?;
            push(name, samples, *published, exact / f64::from(samples), measured);
        }
    }
    for (samples, published) in [1, 2, 4].into_iter().zip([0.0947, 0.0126, 0.0016]) {
        let measured = variance_of_means(&uniform, SamplingPattern::Stratified, samples, total, settings)?;
        push("uniform, stratified", samples, published, stratified_variance(samples), measured);
    }
    Ok(table)
}
