//! Illuminance by particles, with checkpoints.

use std::path::Path;

use glanz_illumination::{
    FarFieldGrid, FarFieldResolution, Tally, TraceOutcome, TraceSettings, adapted_grid, trace,
};
use glanz_job::JobEnd;
use glanz_report::FactValue;

use super::design::Design;
use super::facts::CalculationFacts;
use super::tally_file::{self, TallyFile, TallyPlan};
use crate::error::Error;
use crate::event::{JobEvent, ResumedState};
use crate::file;
use crate::running_job::{JobSink, RunningJob};

/// Traces particles until the goal is reached, from the checkpoint if it is resumed; returns their sums and the reason for the end.
pub(super) fn traced(
    design: &Design,
    job: &mut RunningJob<'_>,
    facts: &mut CalculationFacts,
) -> Result<(Tally, JobEnd), Error> {
    let options = &design.options;
    let identity = tally_file::identity(design.hashes, options.far_field, options.seed, options.max_depth);
    let (scene, receivers) = (&design.scene, &design.receivers);
    let settings = design.trace_settings(job);
    let mut plan = options.part.zip(options.goal.particles).map(|(part, particles)| TallyPlan {
        particles,
        count: part.count(),
        part: Some(part),
    });
    let tally = match job.resumed() {
        Some(path) => {
            let file = TallyFile::from_bytes(&path, &file::read(&path)?)?;
            file.check(&identity, plan).map_err(Error::of_file(&path))?;
            if !file.tally.fits(receivers, options.far_field.is_some()) {
                return Err(TallyFile::senseless(&path));
            }
            // What is resumed as a whole is no part any longer.
            plan = plan.or_else(|| file.plan.map(|plan| TallyPlan { part: None, ..plan }));
            let (goal, range) = (&options.goal, settings.range());
            let is_counted = goal.particles.is_some() && goal.time.is_none() && goal.error.is_none();
            let state = &ResumedState::Particles {
                done: file.tally.particles().total(),
                wanted: is_counted.then(|| range.end - range.start),
            };
            job.emit(JobEvent::Resumed { path: &path, state });
            file.tally
        }
        None => Tally::new(receivers, far_field_grid(design, &settings, job)?),
    };
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let write = |path: &Path, tally: &Tally| {
        scene.check_textures()?;
        tally_file::write(path, &identity, plan, tally)
    };
    let mut sink = JobSink::new(job, path.clone(), write);
    let outcome = trace(scene, receivers, &settings, tally, &mut sink, &cancel)
        .map_err(|error| Error::Threads(error.0))?;
    scene.check_textures()?;
    if let Some(path) = &path {
        tally_file::write(path, &identity, plan, &outcome.tally)?;
    }
    add_facts(&outcome, facts);
    Ok((outcome.tally, outcome.end))
}

/// The directions of a far field, if it is counted.
fn far_field_grid(
    design: &Design,
    settings: &TraceSettings,
    job: &RunningJob<'_>,
) -> Result<Option<FarFieldGrid>, Error> {
    match design.options.far_field {
        None => Ok(None),
        Some(FarFieldResolution::Steps { gamma, plane }) => Ok(FarFieldGrid::with_steps(gamma, plane)),
        Some(FarFieldResolution::Adaptive) => {
            let cancel = &job.options.cancel;
            let grid =
                adapted_grid(&design.scene, settings, cancel).map_err(|error| Error::Threads(error.0))?;
            cancel.check()?;
            Ok(grid)
        }
    }
}

fn add_facts(outcome: &TraceOutcome, facts: &mut CalculationFacts) {
    let all = outcome.tally.particles().total();
    facts.result.push("traced light", "traced_light", "all orders of reflection");
    facts.result.push("particles", "particles", all);
    if outcome.error.is_finite() {
        let name = "largest relative standard error of brightest cells, darkest cells and means";
        facts.result.push(name, "relative_error", FactValue::Fraction(outcome.error));
    }
    if outcome.particles < all {
        facts.run.push("particles of this run", "run_particles", outcome.particles);
    }
    facts.push_rate("particles per second", "particles_per_second", outcome.particles, outcome.elapsed);
    let rays = outcome.counters.rays();
    facts.run.push("rays", "rays", rays);
    facts.push_rate("rays per second", "rays_per_second", rays, outcome.elapsed);
}
