//! Densities that learn an integrand from coarse to fine: the tables and figures of document 003, chapter 2.

mod few_samples;
mod figures;
mod fixed;
mod measure;
mod passes;

use std::f64::consts::FRAC_2_PI;

use glanz_sampling::density::Density;
use glanz_sampling::integrate::AdaptiveResult;
use glanz_sampling::multiresolution::MultiResolution;

use self::few_samples::{FewSamples, few_samples};
use self::fixed::table_2_1;
use self::measure::{plane, sine};
use self::passes::{PASS_COLUMNS, PassResults, RUNS, findings, measure, push_passes, schedule, variances};
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};
use glanz_report::Table;

/// Samples of a pass, as in the document.
const SAMPLES: u32 = 1_000_000;

/// Headlines of the plots, in the order of the bases.
const TITLES: [&str; 2] = ["Haar's boxes", "Hat functions"];

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    progress.report(0.0, "table 2.1");
    let fixed = table_2_1(settings)?;
    let line = [
        schedule("Haar's boxes", MultiResolution::haar(3)?, [1, 2, 3], [0.0947, 0.0388, 0.0132, 0.004_32]),
        schedule(
            "hat functions",
            MultiResolution::bspline(1, 2)?,
            [0, 1, 2],
            [0.0947, 0.005_86, 0.000_372, 0.000_09],
        ),
    ];
    let square = [
        schedule("Haar's boxes", MultiResolution::haar(3)?, [1, 2, 3], [0.0857, 0.0332, 0.0111, 0.003_61]),
        schedule(
            "hat functions",
            MultiResolution::bspline(1, 2)?,
            [0, 1, 2],
            [0.0857, 0.005, 0.000_251, 0.000_073_3],
        ),
    ];
    progress.report(0.1, "table 2.2");
    let (on_line, line_runs) = measure(&line, FRAC_2_PI, sine, settings)?;
    progress.report(0.4, "table 2.4");
    let (on_square, square_runs) = measure(&square, FRAC_2_PI * FRAC_2_PI, plane, settings)?;
    progress.report(0.9, "figure 2.9");
    let few = few_samples(&square[1], settings)?;

    let mut summary = Table::new(
        "summary",
        "Variance of a single sample f / p in the fourth pass, after three learning passes.",
        &PASS_COLUMNS,
    );
    push_passes(&mut summary, "1D, ", &on_line, 3..4);
    push_passes(&mut summary, "2D, ", &on_square, 3..4);
    let mut report =
        Report::new("Study densities: integrals with densities that are learnt from samples", summary);
    introduce(settings, &mut report);
    report.heading("Fixed densities (table 2.1)");
    report.table(fixed);
    add_one_dimension(&on_line, &line_runs, &mut report);
    add_two_dimensions(&on_square, &square_runs, &mut report);
    let found = findings(&on_line, "one dimension").into_iter().chain(findings(&on_square, "two dimensions"));
    let found: Vec<String> = found.chain(few.finding()).collect();
    add_few_samples(few, &mut report);
    report.heading("Findings");
    for sentence in found {
        report.paragraph(sentence);
    }
    progress.report(1.0, "done");
    Ok(report)
}

/// Table 2.2 and figure 2.6.
fn add_one_dimension(all: &[PassResults], runs: &[AdaptiveResult<1>], report: &mut Report) {
    report.heading("Learnt densities (table 2.2)");
    let mut table =
        Table::new("table_2_2", "Variance of a single sample, sin(pi x / 2), by pass.", &PASS_COLUMNS);
    push_passes(&mut table, "", all, 0..4);
    report.table(table);
    report.plot(
        "variance",
        variances("Variance of a single sample, one dimension", all),
        "The variances of table 2.2, measured and published.",
    );
    let names = [["approximation_haar", "density_haar"], ["approximation_hat", "density_hat"]];
    for ((result, title), [approximation, density]) in runs.iter().zip(TITLES).zip(names) {
        let caption =
            format!("{title}: approximations learnt in the first three passes (document 003, figure 2.6).");
        report.plot(approximation, figures::approximations(title, result), caption);
        let caption = format!("{title}: the densities of passes 2 to 4.");
        report.plot(density, figures::densities(title, result), caption);
    }
}

/// Table 2.4, figures 2.7 and 2.8.
fn add_two_dimensions(all: &[PassResults], runs: &[AdaptiveResult<2>], report: &mut Report) {
    report.heading("In two dimensions (table 2.4)");
    let mut table =
        Table::new("table_2_4", "Variance of a single sample, two dimensions, by pass.", &PASS_COLUMNS);
    push_passes(&mut table, "", all, 0..4);
    report.table(table);
    report.plot(
        "variance_2d",
        variances("Variance of a single sample, two dimensions", all),
        "The variances of table 2.4, measured and published.",
    );
    report.plot(
        "integrand",
        figures::integrand(),
        "The integrand along lines of constant v (document 003, figure 2.7).",
    );
    for ((result, title), name) in runs.iter().zip(TITLES).zip(["density_2d_haar", "density_2d_hat"]) {
        let passes = result.passes.iter().enumerate().skip(1);
        let densities: Vec<(String, Density<2>)> =
            passes.map(|(index, pass)| (format!("pass {}", index + 1), pass.density.clone())).collect();
        let caption = format!("{title}: densities along the diagonal (document 003, figure 2.8).");
        report.plot(name, figures::along_diagonal(title, &densities), caption);
    }
}

/// Figure 2.9.
fn add_few_samples(few: FewSamples, report: &mut Report) {
    report.heading("Few samples (figure 2.9)");
    report.table(few.table);
    report.plot(
        "convergence",
        figures::along_diagonal("Hat functions, third scale", &few.densities),
        "Densities along the diagonal after three passes of few samples each (document 003, figure 2.9).",
    );
}

fn introduce(settings: &Settings, report: &mut Report) {
    report.heading("Question");
    report.paragraph(
        "Document 003 fits the density of a Monte Carlo integral to the samples of earlier passes: the coefficients in a \
         basis of densities, on a finer scale after each pass. By how much does this reduce the variance of a single sample \
         f / p?",
    );
    report.paragraph(format!(
        "Settings: {SAMPLES} independent samples per pass, {RUNS} runs, seed {}. *Exact* values are computed by quadrature; \
         *infinitely many samples* denotes the variances of densities from exact projections. *Measured* values are means \
         over the runs of the sample variance of a pass, with their standard errors; in table 2.1 they are means over groups \
         of samples. As in the document, coefficients are raised to at least 0.1 times the integral times that of their \
         function, and coefficients without samples take the values of their neighbours.",
        settings.seed
    ));
    report.paragraph(
        "The document's formulas 2.21 and 2.22 for two dimensions divide by the density once too often; its tables were \
         computed without this error, as are these.",
    );
}
