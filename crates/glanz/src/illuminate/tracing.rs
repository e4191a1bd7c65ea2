//! Illuminance by particles, with checkpoints.

use std::path::Path;

use glanz_illumination::{Tally, TraceOutcome, TraceSettings, trace};
use glanz_job::JobEnd;
use glanz_report::number::grouped;

use super::tally_file::{self, TallyFile, TallyPlan};
use super::{Design, pace};
use crate::error::Error;
use crate::event::{JobEvent, ResumedState};
use crate::file;
use crate::running_job::{JobSink, RunningJob};

/// Result of the particles.
pub(super) struct Traced {
    pub(super) tally: Tally,
    pub(super) end: JobEnd,
    /// Facts for the report.
    pub(super) how: Vec<(String, String)>,
}

/// Traces particles until the goal is reached, from the checkpoint if it is resumed.
pub(super) fn traced(design: &Design, job: &mut RunningJob<'_>) -> Result<Traced, Error> {
    let options = &design.options;
    let far_field = design.far_field_grid();
    let identity = tally_file::identity(design.hashes, far_field.is_some(), options.seed, options.max_depth);
    let (scene, receivers) = (&design.scene, &design.receivers);
    let mut plan = options.part.zip(options.goal.particles).map(|(part, particles)| TallyPlan {
        particles,
        count: part.count(),
        part: Some(part),
    });
    let tally = match job.resumed() {
        Some(path) => {
            let file = TallyFile::from_bytes(&path, &file::read(&path)?)?;
            file.check(&identity, plan).map_err(Error::of_file(&path))?;
            if !file.tally.fits(receivers, far_field) {
                return Err(TallyFile::senseless(&path));
            }
            // What is resumed as a whole is no part any longer.
            plan = plan.or_else(|| file.plan.map(|plan| TallyPlan { part: None, ..plan }));
            let state = &ResumedState::Particles(file.tally.particles().total());
            job.emit(JobEvent::Resumed { path: &path, state });
            file.tally
        }
        None => Tally::new(receivers, far_field),
    };
    let settings = TraceSettings {
        seed: options.seed,
        max_events: options.max_depth,
        threads: job.options.threads,
        goal: options.goal,
        part: options.part,
    };
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let write = |path: &Path, tally: &Tally| tally_file::write(path, &identity, plan, tally);
    let mut sink = JobSink::new(job, path.clone(), write);
    let outcome = trace(scene, receivers, &settings, tally, &mut sink, &cancel)
        .map_err(|error| Error::Threads(error.0))?;
    if let Some(path) = &path {
        tally_file::write(path, &identity, plan, &outcome.tally)?;
    }
    let how = facts(&outcome, options.seed);
    Ok(Traced { tally: outcome.tally, end: outcome.end, how })
}

fn facts(outcome: &TraceOutcome, seed: u64) -> Vec<(String, String)> {
    let seconds = outcome.elapsed.as_secs_f64();
    let mut facts = vec![
        ("method", "trace: particles from the lights, all orders of reflection".to_owned()),
        ("particles", pace(outcome.particles, seconds, "particles")),
        ("rays", pace(outcome.counters.rays(), seconds, "rays")),
        ("seed", seed.to_string()),
    ];
    let all = outcome.tally.particles().total();
    if outcome.particles < all {
        facts.push(("particles in all", grouped(all)));
    }
    if outcome.error.is_finite() {
        let percent = format!("{:.3} %", 100.0 * outcome.error);
        facts.push(("largest relative standard error of brightest cells, darkest cells and means", percent));
    }
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
