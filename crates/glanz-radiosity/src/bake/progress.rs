//! Progress of a bake in phases.

use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, Interrupted, JobProgress, ProgressSink};

use super::BakeState;

/// Share of a phase up to which its expected duration counts more than what it has taken so far.
const TRUSTED_SHARE: f64 = 0.03;

/// Amounts of work in a phase, in any unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PhaseWork {
    /// Work that a resumed state had done.
    pub(super) resumed: f64,
    /// Work that is done, with that of the state.
    pub(super) done: f64,
    /// Estimate of all work.
    pub(super) all: f64,
}

impl PhaseWork {
    /// Work of a phase of which `fraction`, [0, 1], is done.
    pub(super) fn fraction(fraction: f64) -> Self {
        Self { resumed: 0.0, done: fraction, all: 1.0 }
    }

    /// The fraction that is done, [0, 1].
    fn share(&self) -> f64 {
        if self.all > 0.0 { (self.done / self.all).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Seconds until the end of the phase; `None` if nothing is known. `expected`: duration of the phase, seconds, before it began.
    fn remaining(&self, elapsed: f64, expected: Option<f64>) -> Option<f64> {
        let (own, rest) = (self.done - self.resumed, self.all - self.done);
        let measured = (own > 0.0).then(|| elapsed / own);
        let planned = expected.map(|seconds| seconds / self.all);
        let trust = own / (own + TRUSTED_SHARE * self.all);
        let per_unit = match (measured, planned) {
            (Some(measured), Some(planned)) => trust * measured + (1.0 - trust) * planned,
            (measured, planned) => measured.or(planned)?,
        };
        Some(per_unit * rest.max(0.0))
    }
}

/// Progress of the current phase, reported to a sink.
pub(super) struct BakeProgress<'a> {
    sink: &'a mut dyn ProgressSink<BakeState>,
    cancel: &'a CancelFlag,
    timer: CheckpointTimer,
    number: u32,
    phase: &'static str,
    start_time: Instant,
    /// Largest reported fraction of the phase.
    shown: f64,
    /// Expected duration of each phase, seconds; `None` if it is not known.
    expected: Vec<Option<f64>>,
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
            phase: "direct light",
            start_time: Instant::now(),
            shown: 0.0,
            expected: vec![None; phases as usize],
        }
    }

    /// The request to end the bake.
    pub(super) fn cancel(&self) -> &'a CancelFlag {
        self.cancel
    }

    /// Expects a phase to take this time, seconds.
    pub(super) fn expect(&mut self, number: u32, seconds: f64) {
        let index = number.saturating_sub(1) as usize;
        if let Some(expected) = self.expected.get_mut(index) {
            *expected = Some(seconds).filter(|seconds| seconds.is_finite());
        }
    }

    /// Starts the phase of this number.
    pub(super) fn begin(&mut self, number: u32, phase: &'static str) {
        (self.number, self.phase, self.start_time, self.shown) = (number, phase, Instant::now(), 0.0);
    }

    /// Reports the work of the phase, and saves the state if a checkpoint is due or the bake is cancelled.
    ///
    /// # Errors
    /// [`Interrupted`] if the bake is cancelled.
    pub(super) fn report(
        &mut self,
        work: PhaseWork,
        state: impl FnOnce() -> BakeState,
    ) -> Result<(), Interrupted> {
        self.show(work);
        self.check(state)
    }

    /// As [`BakeProgress::report`], for work before a phase, of which nothing is shown.
    ///
    /// # Errors
    /// [`Interrupted`] if the bake is cancelled.
    pub(super) fn check(&mut self, state: impl FnOnce() -> BakeState) -> Result<(), Interrupted> {
        let outcome = self.cancel.check();
        if outcome.is_err() || self.timer.is_due() {
            let sink = &mut *self.sink;
            self.timer.save(|| sink.on_checkpoint(&state()));
        }
        outcome
    }

    /// Passes on the progress, with the time until the end of all phases.
    fn show(&mut self, work: PhaseWork) {
        let elapsed = self.start_time.elapsed();
        let index = self.number.saturating_sub(1) as usize;
        let own = work.remaining(elapsed.as_secs_f64(), self.expected.get(index).copied().flatten());
        let later = self.expected.iter().skip(index + 1);
        let remaining = later.fold(own, |sum, phase| Some(sum? + (*phase)?));
        // More work than estimated does not undo what is done.
        self.shown = self.shown.max(work.share());
        let progress = JobProgress {
            remaining: remaining.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()),
            ..JobProgress::by_work(self.phase, self.shown, elapsed)
        };
        self.sink.on_progress(&progress.with_step(self.number, self.expected.len() as u32));
    }
}

/// Sink for a job that is a phase of the bake.
impl ProgressSink for BakeProgress<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.show(PhaseWork::fraction(progress.fraction));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remaining_time_is_expected_first_and_measured_later() {
        let work = |done| PhaseWork { resumed: 20.0, done, all: 120.0 };
        assert_eq!(work(20.0).remaining(0.0, None), None);
        assert_eq!(work(20.0).remaining(0.0, Some(6.0)), Some(5.0));
        // Of 100 units that are left, 50 took 10 seconds.
        assert_eq!(work(70.0).remaining(10.0, None), Some(10.0));
        let mixed = work(70.0).remaining(10.0, Some(6.0)).unwrap();
        assert!(mixed > 9.0 && mixed < 10.0, "{mixed}");
        assert_eq!(work(120.0).remaining(10.0, Some(6.0)), Some(0.0));
        assert_eq!(PhaseWork { resumed: 0.0, done: 0.0, all: 0.0 }.share(), 1.0);
    }
}
