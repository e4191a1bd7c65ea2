//! Numbers of samples of passes, by the time that they take.

use std::time::Duration;

/// Desired time of a pass over the picture: short enough for cancelling, long enough to keep threads busy.
const PASS_SECONDS: f64 = 0.5;

/// Scheduler of passes: chooses their numbers of samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct PassClock {
    limit: Option<Duration>,
    /// Seconds for one sample of every pixel: the larger of the last pass and the mean.
    per_sample: Option<f64>,
    samples: u64,
    seconds: f64,
}

impl PassClock {
    pub(super) fn new(limit: Option<Duration>) -> Self {
        Self { limit, per_sample: None, samples: 0, seconds: 0.0 }
    }

    /// Number of samples of the next pass, at most `missing` (> 0); `None` if there is no time for a pass.
    pub(super) fn next_pass(&self, missing: u32, elapsed: Duration) -> Option<u32> {
        // The first pass measures the time.
        let Some(per_sample) = self.per_sample else { return Some(1) };
        let mut fitting = (PASS_SECONDS / per_sample).clamp(1.0, f64::from(missing));
        if let Some(limit) = self.limit {
            let left = limit.saturating_sub(elapsed).as_secs_f64() / per_sample;
            if left < 1.0 {
                return None;
            }
            fitting = fitting.min(left);
        }
        Some(fitting as u32)
    }

    pub(super) fn note(&mut self, length: u32, duration: Duration) {
        // The lower bound avoids endless passes if the clock does not advance.
        let seconds = duration.as_secs_f64().max(1e-9);
        self.samples += u64::from(length);
        self.seconds += seconds;
        self.per_sample = Some((seconds / f64::from(length)).max(self.seconds / self.samples as f64));
    }

    /// Time for `missing` samples, or until the limit.
    pub(super) fn remaining(&self, missing: u64, elapsed: Duration) -> Duration {
        let mean = self.seconds / self.samples.max(1) as f64;
        let work = Duration::try_from_secs_f64(mean * missing as f64).unwrap_or(Duration::MAX);
        self.limit.map_or(work, |limit| work.min(limit.saturating_sub(elapsed)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(s: f64) -> Duration {
        Duration::from_secs_f64(s)
    }

    #[test]
    fn first_pass_measures_and_the_next_ones_take_half_a_second() {
        let mut clock = PassClock::new(None);
        assert_eq!(clock.next_pass(1000, Duration::ZERO), Some(1));
        clock.note(1, seconds(0.01));
        assert_eq!(clock.next_pass(1000, seconds(0.01)), Some(50));
        assert_eq!(clock.next_pass(7, seconds(0.01)), Some(7));
        clock.note(50, seconds(50.0));
        assert_eq!(clock.next_pass(1000, seconds(51.0)), Some(1));
    }

    #[test]
    fn no_pass_starts_that_would_end_too_late() {
        let mut clock = PassClock::new(Some(seconds(2.0)));
        // The first pass completes regardless of the limit.
        assert_eq!(clock.next_pass(1000, Duration::ZERO), Some(1));
        clock.note(1, seconds(0.1));
        assert_eq!(clock.next_pass(1000, seconds(1.75)), Some(2));
        assert_eq!(clock.next_pass(1000, seconds(1.95)), None);
        assert_eq!(clock.next_pass(1000, seconds(2.5)), None);
    }

    #[test]
    fn remaining_time_is_that_of_the_samples_or_of_the_limit() {
        let mut clock = PassClock::new(Some(seconds(10.0)));
        clock.note(4, seconds(2.0));
        assert_eq!(clock.remaining(6, seconds(2.0)), seconds(3.0));
        assert_eq!(clock.remaining(600, seconds(2.0)), seconds(8.0));
    }
}
