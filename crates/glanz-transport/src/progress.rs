//! What a render tells while it runs.

use std::time::Duration;

use crate::film::Film;

/// How far a render is, after a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgressReport {
    /// Samples per pixel that the film has of those wanted, also from earlier runs.
    pub samples_done: u64,
    /// Samples per pixel wanted.
    pub samples_wanted: u64,
    /// Rays of this run so far.
    pub rays: u64,
    /// Since the render began.
    pub elapsed: Duration,
    /// Until it ends, by samples or by the time limit, whichever comes first.
    pub remaining: Duration,
}

impl ProgressReport {
    /// Share of the render's time that has passed, [0, 1].
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let (elapsed, remaining) = (self.elapsed.as_secs_f64(), self.remaining.as_secs_f64());
        if remaining == 0.0 { 1.0 } else { elapsed / (elapsed + remaining) }
    }
}

/// Someone who wants to know. Called between passes, by the thread that called [`crate::render()`].
pub trait Progress {
    /// A pass has ended.
    fn report(&mut self, report: &ProgressReport);

    /// The interval between checkpoints is over: `film` has everything so far. Not called after the last pass, whose
    /// film [`crate::render()`] returns.
    fn checkpoint(&mut self, film: &Film) {
        let _ = film;
    }
}

/// Nobody wants to know.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&mut self, _: &ProgressReport) {}
}
