//! Illuminance by integration, paths from the cells, and particles, with checkpoints.

use std::path::Path;
use std::time::Instant;

use glanz_illumination::integrate::{CellTolerance, Reflections, Tolerance};
use glanz_illumination::{CombinedLight, CombinedOutcome, LightDivision, combine};
use glanz_job::JobEnd;
use glanz_report::FactValue;

use super::combined_file::{self, CombinedFile};
use super::design::Design;
use super::facts::CalculationFacts;
use super::{integrating, tally_file};
use crate::error::Error;
use crate::event::{JobEvent, ResumedState};
use crate::file;
use crate::running_job::{JobSink, RunningJob};

/// Largest number of points in a square for the integration, see [`CellTolerance::points`]: where edges of light need more, paths and particles compute it.
const POINTS: usize = 65;

/// The light on all receivers, from the checkpoint if it is resumed, and the reason for the end.
pub(super) fn combined(
    design: &Design,
    job: &mut RunningJob<'_>,
    facts: &mut CalculationFacts,
) -> Result<(CombinedLight, JobEnd), Error> {
    let start = Instant::now();
    let (options, scene, receivers) = (&design.options, &design.scene, &design.receivers);
    let identity = tally_file::identity(design.hashes, None, options.seed, options.max_depth);
    let saved = match job.resumed() {
        Some(path) => {
            let saved = CombinedFile::from_bytes(&path, &file::read(&path)?, &identity)?;
            if !saved.light.fits(receivers) {
                return Err(combined_file::senseless(&path));
            }
            let state = &ResumedState::Paths(saved.light.paths() + saved.light.particles());
            job.emit(JobEvent::Resumed { path: &path, state });
            Some(saved)
        }
        None => None,
    };
    let relative = saved.as_ref().map_or(options.integration_tolerance(), |saved| saved.tolerance);
    let reflections = job.in_pool(|_| {
        let (reflections, _) = Reflections::of_integrable(scene);
        // Light by a mirror reaches two surfaces.
        let reflections = if options.max_depth < 2 { reflections.without_mirrors() } else { reflections };
        Ok(reflections.without_costly(receivers, Tolerance { relative, absolute: 0.0 }))
    })?;
    let light = match saved {
        Some(saved) => saved.light,
        None => {
            // Dark cells count relative to a tenth of the mean. Of a limited time, half is for the other methods.
            let until = options.goal.time.and_then(|limit| start.checked_add(limit / 2));
            let accuracy = CellTolerance { relative, dark: 0.1, points: POINTS, until };
            let cells = job.in_pool(|job| integrating::cells(design, &reflections, accuracy, job))?;
            CombinedLight::new(receivers, cells)
        }
    };
    let division = job.in_pool(|_| Ok(LightDivision::new(scene, receivers, &reflections)))?;
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let mut settings = design.trace_settings(job);
    settings.goal.time = settings.goal.time.map(|limit| limit.saturating_sub(start.elapsed()));
    let write = |path: &Path, light: &CombinedLight| {
        scene.check_textures()?;
        combined_file::write(path, &identity, relative, light)
    };
    let mut sink = JobSink::new(job, path.clone(), write);
    let outcome = combine(scene, receivers, &division, &settings, light, &mut sink, &cancel)
        .map_err(|error| Error::Threads(error.0))?;
    scene.check_textures()?;
    if let Some(path) = &path {
        combined_file::write(path, &identity, relative, &outcome.light)?;
    }
    if !outcome.light.is_whole() {
        outcome.end.check()?;
    }
    add_facts(&outcome, facts);
    Ok((outcome.light, outcome.end))
}

fn add_facts(outcome: &CombinedOutcome, facts: &mut CalculationFacts) {
    let light =
        "direct light and light of one mirror integrated, the rest by paths from the cells and by particles";
    facts.result.push("light", "light", light);
    facts.result.push("paths from the cells", "paths", outcome.light.paths());
    facts.result.push("particles", "particles", outcome.light.particles());
    if outcome.error.is_finite() {
        let name = "largest relative error of brightest cells, darkest cells and means";
        facts.result.push(name, "relative_error", FactValue::Fraction(outcome.error));
    }
    let rays = outcome.counters.rays();
    facts.run.push("rays of paths and particles", "rays", rays);
    facts.push_rate("rays per second", "rays_per_second", rays, outcome.elapsed);
}
