//! `glanz compare`: the differences between two pictures.

use std::fmt::Write;
use std::path::Path;

use glanz::formats::ContentKind;
use glanz::formats::image::{self, Encoding, Format, Image, ImageError};
use glanz::job::{CancelFlag, ResourceBudget};
use glanz::light::compare::{PictureComparison, RELATIVE_EPSILON, compare};
use glanz::light::flip;
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::{CommandError, Messages};
use serde::Serialize;

use crate::arguments::{CompareArguments, Metric};
use crate::file_help::{is_guess, named};
use crate::input::{self, with_limit_help};
use crate::report::{self, plural};

/// The output of `--json`.
#[derive(Serialize)]
struct CompareReport {
    picture: String,
    reference: String,
    width: u32,
    height: u32,
    rmse: f64,
    relmse: f64,
    display_rmse: f64,
    max: f64,
    /// Column and row of the pixel with the largest difference.
    max_at: (u32, u32),
    flip: f64,
    mean: [f64; 3],
    reference_mean: [f64; 3],
    /// Pixels that are infinite or not a number in either picture.
    excluded_pixels: usize,
    metric: Option<&'static str>,
    fail_above: Option<f64>,
    passed: bool,
}

/// Measures and prints the differences, and compares one with a bound if there is one.
///
/// # Errors
/// Pictures that cannot be read or compared.
pub(crate) fn run(arguments: &CompareArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    // Of both pictures together; without a flag, so that the first Ctrl-C ends the command.
    let budget = ResourceBudget::new(arguments.limits.limits(), CancelFlag::default());
    let picture = read(&arguments.picture, &budget, messages)?;
    let reference = read(&arguments.reference, &budget, messages)?;
    let names = (arguments.picture.display().to_string(), arguments.reference.display().to_string());
    let failed = |error: &dyn std::fmt::Display| {
        CommandError::new(format!("{} cannot be compared with {}: {error}", names.0, names.1))
    };
    let comparison =
        compare(&picture.pixels, &reference.pixels, RELATIVE_EPSILON).map_err(|error| failed(&error))?;
    // Scene light is compared at all relevant exposures, a picture for a display as displayed.
    let is_display_light = [&picture, &reference].iter().any(|image| image.format == Format::Png);
    let flip = if is_display_light { flip::ldr } else { flip::hdr };
    let flip = flip(&picture.pixels, &reference.pixels, flip::PIXELS_PER_DEGREE)
        .map_err(|error| failed(&error))?
        .mean;

    let measured = measure(arguments.metric, &comparison, flip);
    // NaN fails the test.
    let passed = arguments.fail_above.is_none_or(|bound| measured <= bound);
    let report = CompareReport {
        picture: names.0.clone(),
        reference: names.1.clone(),
        width: picture.pixels.width(),
        height: picture.pixels.height(),
        rmse: comparison.rmse,
        relmse: comparison.relative_mse,
        display_rmse: comparison.clipped_rmse,
        max: comparison.max_error,
        max_at: comparison.max_at,
        flip,
        mean: comparison.mean_test,
        reference_mean: comparison.mean_reference,
        excluded_pixels: comparison.excluded_test + comparison.excluded_reference,
        metric: arguments.fail_above.map(|_| metric_name(arguments.metric)),
        fail_above: arguments.fail_above,
        passed,
    };
    if arguments.json {
        report::print(&report)?
    } else {
        report::print_text(&table(&report))?
    }
    Ok(if passed { CommandOutcome::Done } else { CommandOutcome::Refused })
}

fn read(path: &Path, budget: &ResourceBudget, messages: Messages) -> Result<Image, CommandError> {
    let failed = |error: &dyn std::fmt::Display| CommandError::new(format!("{}: {error}", path.display()));
    let bytes = input::read(path, budget, messages)?;
    // Until the bytes are decoded.
    let reserved = budget.reserve(bytes.len() as u64);
    let _reserved = reserved.map_err(|end| with_limit_help(failed(&end), end))?;
    image::read_with(&bytes, Some(path), Encoding::Srgb, budget).map_err(|error| match error {
        ImageError::Budget { end, .. } => with_limit_help(failed(&error), end),
        _ => {
            let fits = |kind: &ContentKind| matches!(kind, ContentKind::Picture(_)) || is_guess(kind);
            named(failed(&error), path, fits)
        }
    })
}

fn measure(metric: Metric, comparison: &PictureComparison, flip: f64) -> f64 {
    match metric {
        Metric::Rmse => comparison.rmse,
        Metric::Relmse => comparison.relative_mse,
        Metric::DisplayRmse => comparison.clipped_rmse,
        Metric::Max => comparison.max_error,
        Metric::Flip => flip,
    }
}

fn metric_name(metric: Metric) -> &'static str {
    match metric {
        Metric::Rmse => "rmse",
        Metric::Relmse => "relmse",
        Metric::DisplayRmse => "display-rmse",
        Metric::Max => "max",
        Metric::Flip => "flip",
    }
}

fn table(report: &CompareReport) -> String {
    let mut text = String::new();
    let (x, y) = report.max_at;
    let [r, g, b] = report.mean;
    let [reference_r, reference_g, reference_b] = report.reference_mean;
    // Writing to a text cannot fail.
    let _ = writeln!(text, "rmse          {:.6e}", report.rmse);
    let _ = writeln!(text, "relmse        {:.6e}", report.relmse);
    let _ = writeln!(text, "display-rmse  {:.6e}", report.display_rmse);
    let _ = writeln!(text, "max           {:.6e}  at column {x}, row {y}", report.max);
    let _ = writeln!(text, "flip          {:.6e}", report.flip);
    let _ = writeln!(text, "mean          {r:.6} {g:.6} {b:.6}");
    let _ = writeln!(text, "reference     {reference_r:.6} {reference_g:.6} {reference_b:.6}");
    if report.excluded_pixels > 0 {
        let pixels = plural(report.excluded_pixels as u64, "pixel is", "pixels are");
        let _ = writeln!(text, "{pixels} infinite or not a number, and left out");
    }
    if let (Some(metric), Some(bound)) = (report.metric, report.fail_above) {
        let verdict = if report.passed { "within" } else { "ABOVE" };
        let _ = writeln!(text, "{metric} is {verdict} {bound}");
    }
    text
}
