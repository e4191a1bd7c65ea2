//! Light on a floor from one value per element: the tables and figures of document 003, chapter 4.

mod exact;
mod figures;
mod measure;
mod method;
mod parameters;
mod picture;
mod published;
pub(crate) mod quadtree;
mod ranking;
mod report;
mod room;

use self::measure::measure;
use self::parameters::ExponentComparison;
use self::room::SETUPS;
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};

/// Texels of the document's textures.
const SIZE: [u32; 2] = [400, 400];

/// Smallest number of texels along a side: one for each element of the grid.
const LEAST: u32 = 16;

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or textures that are too small.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    let size = settings.size.unwrap_or(SIZE);
    if size.iter().any(|&n| n < LEAST) {
        return Err(StudyError::Setting {
            name: "size",
            value: format!("{}x{}", size[0], size[1]),
            needed: "at least 16x16, one texel per element",
        });
    }
    let size = size.map(|n| n as usize);
    // For each scene the reference, two divisions, and as much again for other parameters at the end.
    let parts = (4 * SETUPS.len()) as f64;
    let mut done = 0.0;
    let mut outcomes = Vec::new();
    for setup in &SETUPS {
        let mut on_progress = |what: String| {
            progress.report(done / parts, &what);
            done += 1.0;
        };
        outcomes.push(measure(setup, size, settings, &mut on_progress)?);
    }
    progress.report(done / parts, "other exponents");
    let parameters = ExponentComparison::measure(&outcomes, size, settings)?;
    let report = report::build_report(&outcomes, parameters, size)?;
    progress.report(1.0, "done");
    Ok(report)
}

#[cfg(test)]
mod tests;
