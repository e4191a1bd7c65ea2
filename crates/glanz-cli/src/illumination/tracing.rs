//! Light by particles, with progress and checkpoints.

use std::time::Duration;

use glanz_illumination::{Tally, TraceGoal, TraceSettings, trace};
use glanz_job::{CancelFlag, JobEnd, JobProgress, ProgressSink};

use super::{Design, far_field_grid, pace, tally_file};
use crate::arguments::IlluminateArguments;
use crate::messages::{Failure, Messages};
use crate::report::grouped;
use crate::saving::{SaveState, SavingProgress};
use tally_file::TallyIdentity;

/// Relative standard error that is aimed at if nothing is said.
const USUAL_ERROR: f64 = 0.01;

/// What particles brought.
pub(super) struct Traced {
    pub(super) tally: Tally,
    pub(super) interrupted: bool,
    pub(super) how: Vec<(String, String)>,
}

/// Refuses what cannot end.
///
/// # Errors
/// Why.
pub(crate) fn check_goal(arguments: &IlluminateArguments) -> Result<(), Failure> {
    if arguments.error.is_some_and(|error| error < 1e-6) {
        return Err(Failure::usage("--error: no run would end at less than 1e-6"));
    }
    Ok(())
}

fn goal(arguments: &IlluminateArguments) -> TraceGoal {
    let error = if arguments.rays.is_none() && arguments.time.is_none() {
        Some(arguments.error.unwrap_or(USUAL_ERROR))
    } else {
        arguments.error
    };
    TraceGoal { particles: arguments.rays, time: arguments.time, error }
}

/// Sends particles until the goal, going on from the checkpoint if that was asked for.
///
/// # Errors
/// Why there is nothing, or why it cannot be kept.
pub(super) fn traced(
    design: &Design,
    arguments: &IlluminateArguments,
    messages: Messages,
    cancel: &CancelFlag,
) -> Result<Traced, Failure> {
    let identity = TallyIdentity::new(design.hash, arguments.seed, arguments.max_depth);
    let far_field = far_field_grid(arguments);
    let (scene, receivers) = (&design.scene, &design.receivers);
    let checkpoint = arguments.checkpoint.as_deref();
    let tally = match checkpoint.filter(|path| path.exists()) {
        Some(path) => {
            let tally = tally_file::read(path, &identity, receivers, far_field)?;
            let particles = grouped(tally.particles());
            messages.note(&format!("{}: going on after {particles} particles", path.display()));
            tally
        }
        None => Tally::new(receivers, far_field),
    };
    let goal = goal(arguments);
    let threads = usize::from(arguments.threads.unwrap_or(0));
    let settings = TraceSettings { seed: arguments.seed, max_events: arguments.max_depth, threads, goal };
    let save = checkpoint
        .map(|path| -> SaveState<'_, Tally> { Box::new(|tally| tally_file::write(path, &identity, tally)) });
    let mut sink = TraceProgress { shown: SavingProgress::start(save, cancel, messages), error: None };
    let outcome = trace(scene, receivers, &settings, tally, &mut sink, cancel);
    let error = sink.error;
    // The last checkpoint is still to come; only that has to succeed.
    let _ = sink.shown.finish();
    let outcome = outcome.map_err(|error| Failure::new(error.to_string()))?;
    if let Some(path) = checkpoint {
        tally_file::write(path, &identity, &outcome.tally)?;
    }
    let interrupted = outcome.end == JobEnd::Interrupted;
    let seconds = outcome.elapsed.as_secs_f64();
    let mut how = vec![
        ("method".to_owned(), "trace: particles from the lamps, all orders of reflection".to_owned()),
        ("particles".to_owned(), pace(outcome.particles, seconds, "particles")),
        ("rays".to_owned(), pace(outcome.counters.rays(), seconds, "rays")),
        ("seed".to_owned(), arguments.seed.to_string()),
    ];
    if outcome.particles < outcome.tally.particles() {
        how.push(("particles in all".to_owned(), grouped(outcome.tally.particles())));
    }
    if let Some(error) = error.filter(|error| error.is_finite()) {
        how.push((
            "largest relative standard error of peaks and means".to_owned(),
            format!("{:.3} %", 100.0 * error),
        ));
    }
    Ok(Traced { tally: outcome.tally, interrupted, how })
}

/// Shows and saves, and remembers the last error.
struct TraceProgress<'a> {
    shown: SavingProgress<'a, Tally>,
    error: Option<f64>,
}

impl ProgressSink<Tally> for TraceProgress<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.error = progress.error;
        self.shown.on_progress(progress);
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        self.shown.checkpoint_interval()
    }

    fn on_checkpoint(&mut self, tally: &Tally) {
        self.shown.on_checkpoint(tally);
    }
}
