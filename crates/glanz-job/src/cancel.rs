//! Cancellation and end of jobs.

use std::error::Error;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Request to end a job; clones share it.
///
/// It is raised once and stays raised. Checking it costs one relaxed load: often enough in an inner loop.
#[derive(Clone, Debug, Default)]
pub struct CancelFlag(Arc<AtomicBool>);

impl CancelFlag {
    /// Requests the end of the jobs that were given this flag or a clone of it.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the end was requested.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Returns an error for `?` if the end was requested.
    ///
    /// # Errors
    /// [`Interrupted`] if the end was requested.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_cancelled() { Err(Interrupted) } else { Ok(()) }
    }

    /// The flag itself, for a signal handler: storing `true` cancels.
    #[must_use]
    pub fn atomic(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }
}

/// A job ended by request before it had a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("interrupted")
    }
}

impl Error for Interrupted {}

/// Reason for the end of a job that returns a partial result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEnd {
    /// The goal was reached.
    Complete,
    /// The time limit was reached first.
    TimeUp,
    /// The job was cancelled first.
    Interrupted,
}

impl JobEnd {
    /// Refuses the result of a cancelled job.
    ///
    /// # Errors
    /// [`Interrupted`] for [`JobEnd::Interrupted`].
    pub fn check(self) -> Result<(), Interrupted> {
        if self == Self::Interrupted { Err(Interrupted) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_and_the_atomic_share_one_flag() {
        let flag = CancelFlag::default();
        let clone = flag.clone();
        let other = CancelFlag::default();
        assert_eq!((flag.is_cancelled(), flag.check()), (false, Ok(())));
        clone.cancel();
        assert_eq!((flag.is_cancelled(), flag.check()), (true, Err(Interrupted)));
        assert!(!other.is_cancelled());
        // As a signal handler does it.
        other.atomic().store(true, Ordering::SeqCst);
        assert_eq!(other.check(), Err(Interrupted));
    }

    #[test]
    fn raised_flag_stays_raised() {
        let flag = CancelFlag::default();
        flag.cancel();
        flag.cancel();
        assert!(flag.is_cancelled() && flag.is_cancelled());
    }

    #[test]
    fn only_an_interrupted_result_is_refused() {
        assert_eq!(JobEnd::Complete.check(), Ok(()));
        assert_eq!(JobEnd::TimeUp.check(), Ok(()));
        assert_eq!(JobEnd::Interrupted.check(), Err(Interrupted));
        assert_eq!(Interrupted.to_string(), "interrupted");
    }
}
