//! Progress of a job, and its receiver.

use std::fmt;
use std::time::Duration;

/// Progress of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobProgress<'a> {
    /// Name of the phase.
    pub phase: &'a str,
    /// Number of the phase, from 1, and the number of phases.
    pub step: [u32; 2],
    /// Count of completed work, if the phase counts anything.
    pub count: Option<WorkCount>,
    /// Largest relative standard error so far, if the job estimates it.
    pub error: Option<f64>,
    /// Share of the phase that is done, [0, 1].
    pub fraction: f64,
    /// Time since the phase began.
    pub elapsed: Duration,
    /// Estimated time until the phase ends, or all phases if the job can estimate those to come; `None` if it is not known yet.
    pub remaining: Option<Duration>,
}

/// A count of completed things.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkCount {
    /// Things done so far, those of earlier runs included.
    pub done: u64,
    /// Goal of the count; `None` if something else ends the phase.
    pub wanted: Option<u64>,
    /// Name of one thing and of several: `["particle", "particles"]`.
    pub unit: [&'static str; 2],
}

impl fmt::Display for WorkCount {
    /// `1 200 of 4 000 particles`, or `1 particle` without a goal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, many] = self.unit;
        match self.wanted {
            Some(wanted) => write!(f, "{} of {} {many}", grouped(self.done), grouped(wanted)),
            None => write!(f, "{} {}", grouped(self.done), if self.done == 1 { one } else { many }),
        }
    }
}

/// Digits of a count in groups of three: `12 345`.
#[must_use]
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

impl<'a> JobProgress<'a> {
    /// Progress of a phase whose end is known in time: the fraction is that of the time.
    #[must_use]
    pub fn by_time(phase: &'a str, elapsed: Duration, remaining: Option<Duration>) -> Self {
        let fraction = remaining.map_or(0.0, |remaining| {
            let (elapsed, remaining) = (elapsed.as_secs_f64(), remaining.as_secs_f64());
            if remaining == 0.0 { 1.0 } else { elapsed / (elapsed + remaining) }
        });
        Self { phase, step: [1, 1], count: None, error: None, fraction, elapsed, remaining }
    }

    /// Progress of a phase of which `fraction`, [0, 1], is done: the rest takes time in proportion.
    #[must_use]
    pub fn by_work(phase: &'a str, fraction: f64, elapsed: Duration) -> Self {
        let seconds = elapsed.as_secs_f64() * (1.0 - fraction) / fraction;
        // Before the first part is done, this is infinite or not a number.
        let remaining = Duration::try_from_secs_f64(seconds).ok();
        Self { phase, step: [1, 1], count: None, error: None, fraction, elapsed, remaining }
    }

    /// The same as the phase `number`, from 1, of `phases`.
    #[must_use]
    pub fn with_step(self, number: u32, phases: u32) -> Self {
        Self { step: [number, phases], ..self }
    }

    /// The same with a count.
    #[must_use]
    pub fn with_count(self, count: WorkCount) -> Self {
        Self { count: Some(count), ..self }
    }

    /// The same with the largest relative standard error so far.
    #[must_use]
    pub fn with_error(self, error: f64) -> Self {
        Self { error: Some(error), ..self }
    }
}

/// Receiver of a job's progress, and of its state for checkpoints. Called by the thread that called the job.
///
/// `State`: what the job saves to be resumed later; `()` for a job that cannot be.
pub trait ProgressSink<State: ?Sized = ()> {
    /// Receives the progress about twice a second.
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        let _ = progress;
    }

    /// Longest time between two calls of [`ProgressSink::on_checkpoint`], see [`CheckpointTimer`](crate::CheckpointTimer); zero calls it whenever the job can, `None` never.
    /// Queried once, when the job begins.
    fn checkpoint_interval(&self) -> Option<Duration> {
        None
    }

    /// Receives the state when a checkpoint is due. A job that returns its state when it ends does not pass it here again; one that
    /// returns an error when it is cancelled does so before.
    fn on_checkpoint(&mut self, state: &State) {
        let _ = state;
    }
}

/// Sink that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl<State: ?Sized> ProgressSink<State> for Silent {}

#[cfg(test)]
mod tests {
    use super::*;

    const TEN: Duration = Duration::from_secs(10);

    #[test]
    fn time_left_is_in_proportion_to_the_work_left() {
        // A quarter took 10 s: three quarters take 30 s.
        let progress = JobProgress::by_work("work", 0.25, TEN);
        assert_eq!(progress.remaining, Some(Duration::from_secs(30)));
        assert_eq!(JobProgress::by_work("work", 1.0, TEN).remaining, Some(Duration::ZERO));
        assert_eq!(JobProgress::by_work("work", 0.0, TEN).remaining, None);
        assert_eq!(JobProgress::by_work("work", 0.0, Duration::ZERO).remaining, None);
    }

    #[test]
    fn fraction_is_the_share_of_the_time() {
        let fraction = |remaining| JobProgress::by_time("work", TEN, remaining).fraction;
        assert_eq!(fraction(Some(Duration::from_secs(30))), 0.25);
        assert_eq!(fraction(Some(Duration::ZERO)), 1.0);
        assert_eq!(fraction(None), 0.0);
        assert!(fraction(Some(Duration::MAX)) < 1e-15);
        // At the very beginning of an empty job.
        assert_eq!(JobProgress::by_time("work", Duration::ZERO, Some(Duration::ZERO)).fraction, 1.0);
    }

    #[test]
    fn details_are_added_without_changing_the_rest() {
        let count = WorkCount { done: 3, wanted: Some(12), unit: ["cell", "cells"] };
        let plain = JobProgress::by_work("integration", 0.25, TEN);
        let detailed = plain.with_step(2, 3).with_count(count).with_error(0.01);
        assert_eq!((detailed.step, detailed.count, detailed.error), ([2, 3], Some(count), Some(0.01)));
        assert_eq!(JobProgress { step: [1, 1], count: None, error: None, ..detailed }, plain);
    }

    #[test]
    fn counts_are_words() {
        let count = |done, wanted| WorkCount { done, wanted, unit: ["particle", "particles"] }.to_string();
        assert_eq!(count(1200, Some(4_000_000)), "1 200 of 4 000 000 particles");
        assert_eq!(count(1, None), "1 particle");
        assert_eq!(count(0, None), "0 particles");
    }
}
