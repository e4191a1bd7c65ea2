//! Solvers of radiosity over the number of elements: time, rays, memory and errors (document 003 chapter 4).

mod descent;
mod field;
mod figures;
mod furnace;
mod measure;
mod progressive;
mod report;

use glanz_scene::Scene;

use self::furnace::Furnace;
use self::measure::measure;
use crate::report::Report;
use crate::rooms;
use crate::study::{Settings, StudyError, StudyProgress};

/// Default of the largest number of elements of a solution by all pairs.
const ELEMENTS: u32 = 3000;

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or rooms that cannot be read or divided.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    let most = settings.elements.unwrap_or(ELEMENTS) as usize;
    let rooms = settings.rooms.clone().unwrap_or_else(|| vec!["direct".to_owned()]);
    let mut scenes = Vec::new();
    for named in &rooms {
        let read = rooms::read(named)?;
        scenes.push((read.name, Scene::resolve(read.loaded.description)?.0));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads.unwrap_or(2).max(1)).build()?;
    let parts = (scenes.len() + 1) as f64;
    progress.report(0.0, "furnaces");
    let furnaces = pool.install(|| furnace::measure(settings))?;
    let mut outcomes = Vec::new();
    for (number, (name, scene)) in scenes.iter().enumerate() {
        let mut on_progress = |share: f64, what: &str| {
            progress.report((number as f64 + 1.0 + share) / parts, &format!("{name}, {what}"));
        };
        // The pool's threads do not report progress: each run is reported before it begins.
        outcomes.push(measure(name, scene, most, settings, &pool, &mut on_progress)?);
    }
    let report = report::build_report(&outcomes, &furnaces, most, pool.current_num_threads());
    progress.report(1.0, "done");
    Ok(report)
}

#[cfg(test)]
mod tests;
