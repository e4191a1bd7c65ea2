//! Timing of checkpoints.

use std::time::{Duration, Instant};

/// Timer of the intervals between checkpoints.
#[derive(Clone, Copy, Debug)]
pub struct CheckpointTimer {
    interval: Option<Duration>,
    last: Instant,
}

impl CheckpointTimer {
    /// Starts the first interval; `None` means that no checkpoint is ever due.
    #[must_use]
    pub fn new(interval: Option<Duration>) -> Self {
        Self { interval, last: Instant::now() }
    }

    /// Whether the interval is over.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.interval.is_some_and(|interval| self.last.elapsed() >= interval)
    }

    /// Starts the next interval. Call it after saving, so that a slow disk does not stop the job from working.
    pub fn restart(&mut self) {
        self.last = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoint_is_due_after_the_interval_until_the_restart() {
        let hour = Duration::from_secs(3600);
        let ago =
            |interval, last| CheckpointTimer { interval, last: Instant::now().checked_sub(last).unwrap() };
        assert!(!CheckpointTimer::new(Some(hour)).is_due());
        assert!(CheckpointTimer::new(Some(Duration::ZERO)).is_due());
        let minute = Duration::from_secs(60);
        let mut timer = ago(Some(minute), minute);
        assert!(timer.is_due() && timer.is_due());
        timer.restart();
        assert!(!timer.is_due());
        assert!(!ago(None, minute).is_due());
    }
}
