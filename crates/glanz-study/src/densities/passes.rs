//! Densities that are learnt in passes, from coarse to fine (document 003 tables 2.2 and 2.4).

use std::sync::Arc;

use glanz_sampling::density::{CoefficientFloor, TensorMultiResolution};
use glanz_sampling::hash::combine;
use glanz_sampling::integrate::{AdaptiveResult, integrate_adaptively};
use glanz_sampling::multiresolution::MultiResolution;

use crate::densities::SAMPLES;
use crate::densities::measure::{MeasuredMean, PassSchedule};
use crate::study::{Settings, StudyError};
use glanz_report::number::significant;
use glanz_report::{Axis, Plot, Series, Table, TableCell};

/// Number of runs with different random numbers; their spread gives standard errors.
pub(super) const RUNS: u64 = 8;

pub(super) const PASS_COLUMNS: [(&str, &str); 7] = [
    ("basis", "basis"),
    ("pass", "pass"),
    ("published", "document 003"),
    ("limit", "infinitely many samples"),
    ("limit_without_floor", "the same, coefficients raised to 0 only"),
    ("measured", "measured"),
    ("standard_error", "standard error"),
];

/// Results of the passes of one schedule.
pub(super) struct PassResults {
    name: &'static str,
    published: [f64; 4],
    limits: [f64; 4],
    unraised: [f64; 4],
    measured: [MeasuredMean; 4],
    /// Error of the integral in the last run, and its standard error.
    error: [f64; 2],
}

pub(super) fn schedule<const D: usize>(
    name: &'static str,
    analysis: MultiResolution,
    levels: [usize; 3],
    published: [f64; 4],
) -> PassSchedule<D> {
    PassSchedule {
        name,
        scales: Arc::new(TensorMultiResolution::new([(); D].map(|()| analysis.clone()))),
        levels,
        published,
    }
}

/// Results of all schedules, and the last run of each.
pub(super) fn measure<const D: usize>(
    schedules: &[PassSchedule<D>],
    integral: f64,
    f: fn(&[f64]) -> f64,
    settings: &Settings,
) -> Result<(Vec<PassResults>, Vec<AdaptiveResult<D>>), StudyError> {
    let (mut all, mut last_runs) = (Vec::new(), Vec::new());
    for schedule in schedules {
        let limits = schedule.limits(CoefficientFloor::default(), integral, f)?;
        let unraised = schedule.limits(CoefficientFloor::Zero, integral, f)?;
        let mut seen = [const { Vec::new() }; 4];
        let mut last = None;
        for run in 0..RUNS {
            settings.cancel.check()?;
            let plan = schedule.plan(SAMPLES, combine(settings.seed, run));
            let result = integrate_adaptively(&schedule.scales, &plan, f)?;
            for (seen, pass) in seen.iter_mut().zip(&result.passes) {
                seen.push(pass.estimate.primary_variance);
            }
            last = Some(result);
        }
        let Some(last) = last else { continue };
        all.push(PassResults {
            name: schedule.name,
            published: schedule.published,
            limits,
            unraised,
            measured: seen.map(|values| MeasuredMean::of(&values)),
            error: [last.estimate.mean - integral, last.estimate.standard_error()],
        });
        last_runs.push(last);
    }
    Ok((all, last_runs))
}

pub(super) fn push_passes(
    table: &mut Table,
    before: &str,
    all: &[PassResults],
    which: std::ops::Range<usize>,
) {
    for passes in all {
        for i in which.clone() {
            let MeasuredMean { mean, standard_error } = passes.measured[i];
            table.push([
                TableCell::from(format!("{before}{}", passes.name).as_str()),
                (i as u64 + 1).into(),
                passes.published[i].into(),
                passes.limits[i].into(),
                passes.unraised[i].into(),
                mean.into(),
                standard_error.into(),
            ]);
        }
    }
}

pub(super) fn variances(title: &str, all: &[PassResults]) -> Plot {
    let points = |values: [f64; 4]| (1..).zip(values).map(|(i, v)| [f64::from(i), v]).collect();
    let series = all.iter().flat_map(|passes| {
        let name = passes.name;
        [
            Series { name: format!("{name}, measured"), points: points(passes.measured.map(|m| m.mean)) },
            Series { name: format!("{name}, document 003"), points: points(passes.published) },
        ]
    });
    Plot {
        title: title.to_owned(),
        x: Axis::linear("pass"),
        y: Axis::logarithmic("variance, square of the integral's unit"),
        series: series.collect(),
        reference_lines: Vec::new(),
    }
}

/// Findings as sentences with their figures.
pub(super) fn findings(all: &[PassResults], place: &str) -> Vec<String> {
    let mut found = Vec::new();
    for passes in all {
        let [first, .., last] = passes.measured;
        let off = |i: usize| 100.0 * (passes.measured[i].mean / passes.limits[i] - 1.0);
        let worst = (0..4).map(off).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        found.push(format!(
            "In {place}, with {}, three passes lower the variance by a factor of {} (document 003: {}). The measured \
             variances deviate from those of infinitely many samples by at most {} %. The error of the integral in the last \
             run is {} standard errors.",
            passes.name,
            significant(first.mean / last.mean),
            significant(passes.published[0] / passes.published[3]),
            significant(worst.abs()),
            significant(passes.error[0].abs() / passes.error[1])
        ));
        for i in 0..4 {
            let ratio = passes.published[i] / passes.limits[i];
            if !(0.97..=1.03).contains(&ratio) {
                found.push(format!(
                    "The published {} with {} in pass {} is {} times the limit {}; the measured value is {} +- {}.",
                    significant(passes.published[i]),
                    passes.name,
                    i + 1,
                    significant(ratio),
                    significant(passes.limits[i]),
                    significant(passes.measured[i].mean),
                    significant(passes.measured[i].standard_error)
                ));
            }
        }
    }
    found
}
