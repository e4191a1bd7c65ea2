//! Timing of checkpoints.

use std::time::{Duration, Instant};

/// Time until the first checkpoint.
const FIRST: Duration = Duration::from_secs(1);

/// Work between two checkpoints per time of writing one: writing takes a twentieth of the whole.
const WORK_PER_WRITING: u32 = 19;

/// Longest time between two checkpoints, unless their interval is longer, for a single measurement of the cost: the first, or the process may have been stopped.
const WAIT_FOR_ONE: Duration = Duration::from_secs(15);

/// Timer of the intervals between checkpoints.
///
/// The first checkpoint is due after a second. Later ones are due when as much time has passed since the last one as before it, at the latest
/// after the interval of the sink, but never before the 19-fold of the time that the faster of the last two took, or 15 s if there is only one: beyond the
/// first two, whose cost nobody knows, writing takes at most 5 % of the time, unless one takes much longer than that before and after it. An interval of zero makes a checkpoint due at any time.
#[derive(Clone, Copy, Debug)]
pub struct CheckpointTimer {
    interval: Option<Duration>,
    start: Instant,
    /// Start of the current interval.
    last: Instant,
    /// Length of the current interval.
    wait: Duration,
    /// Time that the last checkpoint took.
    cost: Option<Duration>,
}

impl CheckpointTimer {
    /// Starts the first interval. `interval`: longest time between checkpoints whose writing is fast; `None` means that no checkpoint is ever due.
    #[must_use]
    pub fn new(interval: Option<Duration>) -> Self {
        let now = Instant::now();
        let wait = interval.map_or(FIRST, |interval| FIRST.min(interval));
        Self { interval, start: now, last: now, wait, cost: None }
    }

    /// Whether a checkpoint is due.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.interval.is_some() && self.last.elapsed() >= self.wait
    }

    /// Runs `write`, which writes a checkpoint, and starts the next interval.
    pub fn save<T>(&mut self, write: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let written = write();
        self.last = Instant::now();
        let longest = self.interval.unwrap_or_default();
        let cost = self.last - begun;
        self.wait = wait(longest, begun - self.start, cost, self.cost.replace(cost));
        written
    }
}

/// Time between a checkpoint that took `cost`, `elapsed` after the start, and the next one. `longest`: the interval of the sink; `earlier`: the time that the
/// checkpoint before took.
fn wait(longest: Duration, elapsed: Duration, cost: Duration, earlier: Option<Duration>) -> Duration {
    if longest.is_zero() {
        return longest;
    }
    let work = match earlier {
        Some(earlier) => cost.min(earlier).saturating_mul(WORK_PER_WRITING),
        None => cost.saturating_mul(WORK_PER_WRITING).min(WAIT_FOR_ONE),
    };
    elapsed.max(FIRST).min(longest).max(work)
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL: Duration = Duration::from_secs(30);

    /// Times of the checkpoints of a job of an hour, seconds after its start, and the longest work between two of them, if writing one takes `cost` seconds.
    fn checkpoints(cost: f64) -> (Vec<f64>, f64) {
        let (mut times, mut now, mut work) = (Vec::new(), FIRST.as_secs_f64(), FIRST.as_secs_f64());
        let duration = Duration::from_secs_f64(cost);
        while now < 3600.0 {
            let earlier = (!times.is_empty()).then_some(duration);
            times.push(now);
            let next = wait(INTERVAL, Duration::from_secs_f64(now), duration, earlier).as_secs_f64();
            work = f64::max(work, next);
            now += cost + next;
        }
        (times, work)
    }

    #[test]
    fn first_checkpoints_come_early_and_later_ones_every_interval() {
        let (times, work) = checkpoints(0.0);
        assert_eq!(times[..6], [1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        assert_eq!((times[6], work), (62.0, 30.0));
    }

    #[test]
    fn writing_takes_a_twentieth_of_the_time_beyond_the_first_two() {
        for cost in [0.001, 0.1, 1.0, 1.5, 2.0, 10.0, 60.0] {
            let (times, work) = checkpoints(cost);
            let end = times.last().unwrap() + cost;
            let writing = (times.len() - 2) as f64 * cost;
            assert!(writing <= 0.05 * (end - FIRST.as_secs_f64()) + 1e-6, "{cost}: {writing} of {end}");
            // At most 30 s of work are at stake, unless writing takes more than a nineteenth of that.
            assert!((work - f64::max(30.0, 19.0 * cost)).abs() < 1e-6, "{cost}: {work}");
        }
    }

    #[test]
    fn single_slow_writing_does_not_end_checkpoints() {
        let seconds = Duration::from_secs;
        let after = |cost, earlier| wait(INTERVAL, seconds(1000), seconds(cost), earlier);
        assert_eq!(after(600, Some(Duration::from_millis(100))), INTERVAL);
        assert_eq!(after(600, Some(seconds(500))), seconds(9500));
        // The very first one, of a process that was stopped meanwhile.
        assert_eq!(wait(INTERVAL, seconds(1), seconds(600), None), seconds(15));
    }

    #[test]
    fn slow_writing_delays_the_next_checkpoint() {
        let mut timer = CheckpointTimer::new(Some(Duration::from_millis(1)));
        std::thread::sleep(Duration::from_millis(2));
        assert!(timer.is_due());
        assert_eq!(timer.save(|| std::thread::sleep(Duration::from_millis(100))), ());
        // Another 1.9 s, although the interval is over.
        std::thread::sleep(Duration::from_millis(5));
        assert!(!timer.is_due() && timer.wait >= Duration::from_millis(1900));
    }

    #[test]
    fn interval_of_zero_is_always_due_and_none_never() {
        let mut timer = CheckpointTimer::new(Some(Duration::ZERO));
        assert!(timer.is_due());
        timer.save(|| std::thread::sleep(Duration::from_millis(2)));
        assert!(timer.is_due());
        let mut timer = CheckpointTimer::new(None);
        timer.last = timer.last.checked_sub(Duration::from_secs(3600)).unwrap();
        assert!(!timer.is_due());
    }
}
