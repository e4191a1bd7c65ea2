//! Progress of a bake in phases.

use std::time::Instant;

use glanz_job::{CancelFlag, CheckpointTimer, Interrupted, JobProgress, ProgressSink};

use super::BakeState;

/// Progress of the current phase, reported to a sink.
pub(super) struct BakeProgress<'a> {
    sink: &'a mut dyn ProgressSink<BakeState>,
    cancel: &'a CancelFlag,
    timer: CheckpointTimer,
    number: u32,
    phases: u32,
    phase: &'static str,
    start_time: Instant,
}

impl<'a> BakeProgress<'a> {
    /// Starts the first of `phases` phases, direct light.
    pub(super) fn new(
        sink: &'a mut dyn ProgressSink<BakeState>,
        cancel: &'a CancelFlag,
        phases: u32,
    ) -> Self {
        let timer = CheckpointTimer::new(sink.checkpoint_interval());
        Self {
            sink,
            cancel,
            timer,
            number: 1,
            phases,
            phase: "light from lighting",
            start_time: Instant::now(),
        }
    }

    /// The request to end the bake.
    pub(super) fn cancel(&self) -> &'a CancelFlag {
        self.cancel
    }

    /// Starts the phase of this number.
    pub(super) fn begin(&mut self, number: u32, phase: &'static str) {
        (self.number, self.phase, self.start_time) = (number, phase, Instant::now());
    }

    /// Reports the completed fraction of the phase, [0, 1], and saves the state if a checkpoint is due or the bake is cancelled.
    ///
    /// # Errors
    /// [`Interrupted`] if the bake is cancelled.
    pub(super) fn report(
        &mut self,
        fraction: f64,
        state: impl FnOnce() -> BakeState,
    ) -> Result<(), Interrupted> {
        let progress = JobProgress::by_work(self.phase, fraction, self.start_time.elapsed());
        self.sink.on_progress(&progress.with_step(self.number, self.phases));
        let outcome = self.cancel.check();
        if outcome.is_err() || self.timer.is_due() {
            self.sink.on_checkpoint(&state());
            self.timer.restart();
        }
        outcome
    }
}

/// Sink for a job that is a phase of the bake.
impl ProgressSink for BakeProgress<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        let of_phase = JobProgress::by_work(self.phase, progress.fraction, self.start_time.elapsed());
        self.sink.on_progress(&of_phase.with_step(self.number, self.phases));
    }
}
