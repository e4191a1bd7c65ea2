//! Illuminance by particles, with checkpoints.

use std::path::Path;

use glanz_illumination::{Tally, TraceOutcome, TraceSettings, trace};
use glanz_job::JobEnd;
use glanz_report::number::grouped;

use super::tally_file::{self, TallyIdentity};
use super::{Design, pace};
use crate::error::Error;
use crate::event::{JobEvent, ResumedState};
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
    let identity = TallyIdentity::new(design.hash, options.seed, options.max_depth);
    let far_field = design.far_field_grid();
    let (scene, receivers) = (&design.scene, &design.receivers);
    let tally = match job.resumed() {
        Some(path) => {
            let tally = tally_file::read(&path, &identity, receivers, far_field)?;
            let state = &ResumedState::Particles(tally.particles());
            job.emit(JobEvent::Resumed { path: &path, state });
            tally
        }
        None => Tally::new(receivers, far_field),
    };
    let (threads, goal) = (job.options.threads, options.goal);
    let trace_settings = TraceSettings { seed: options.seed, max_events: options.max_depth, threads, goal };
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let write = |path: &Path, tally: &Tally| tally_file::write(path, &identity, tally);
    let mut sink = JobSink::new(job, path.clone(), write);
    let outcome = trace(scene, receivers, &trace_settings, tally, &mut sink, &cancel)
        .map_err(|error| Error::Threads(error.0))?;
    let error = sink.error.filter(|error| error.is_finite());
    if let Some(path) = &path {
        tally_file::write(path, &identity, &outcome.tally)?;
    }
    let how = facts(&outcome, options.seed, error);
    Ok(Traced { tally: outcome.tally, end: outcome.end, how })
}

fn facts(outcome: &TraceOutcome, seed: u64, error: Option<f64>) -> Vec<(String, String)> {
    let seconds = outcome.elapsed.as_secs_f64();
    let mut facts = vec![
        ("method", "trace: particles from the lights, all orders of reflection".to_owned()),
        ("particles", pace(outcome.particles, seconds, "particles")),
        ("rays", pace(outcome.counters.rays(), seconds, "rays")),
        ("seed", seed.to_string()),
    ];
    if outcome.particles < outcome.tally.particles() {
        facts.push(("particles in all", grouped(outcome.tally.particles())));
    }
    if let Some(error) = error {
        let percent = format!("{:.3} %", 100.0 * error);
        facts.push(("largest relative standard error of peaks and means", percent));
    }
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
