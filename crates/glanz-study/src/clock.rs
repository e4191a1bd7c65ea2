//! Processor time of a computation, which does not depend on other work of the machine.

use std::time::{Duration, Instant};

/// Length of a tick in `/proc/self/stat`; 100 a second on every machine that Linux supports today (`getconf CLK_TCK`).
const TICK: Duration = Duration::from_millis(10);

/// Shortest time that is measured: [`repeated`] repeats the work until then, because Linux counts in steps of some milliseconds.
pub const SHORTEST: Duration = Duration::from_millis(200);

/// The threads whose processor time is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeScope {
    /// The calling thread.
    Thread,
    /// All threads of the process, also those that ended.
    Process,
}

/// A running measurement.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    scope: TimeScope,
    processor: Option<Duration>,
    wall: Instant,
}

impl Stopwatch {
    /// Starts now.
    #[must_use]
    pub fn start(scope: TimeScope) -> Self {
        Self { scope, processor: processor_time(scope), wall: Instant::now() }
    }

    /// Processor time since the start; wall time where the system does not report it.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        match (self.processor, processor_time(self.scope)) {
            (Some(start), Some(now)) => now.saturating_sub(start),
            _ => self.wall.elapsed(),
        }
    }
}

/// Whether times are processor times; otherwise they are wall times.
#[must_use]
pub fn counts_processor_time() -> bool {
    processor_time(TimeScope::Thread).is_some() && processor_time(TimeScope::Process).is_some()
}

/// Calls `work` for at least [`SHORTEST`], each time with a new value of `prepare`. Returns its last value and the mean processor
/// time of a call, without that of `prepare`.
///
/// # Errors
/// That of `work`.
pub fn repeated<A, T, E>(
    prepare: impl FnMut() -> A,
    work: impl FnMut(A) -> Result<T, E>,
) -> Result<(T, Duration), E> {
    repeated_for(SHORTEST, prepare, work)
}

/// As [`repeated`], for at least `shortest`.
///
/// # Errors
/// That of `work`.
pub fn repeated_for<A, T, E>(
    shortest: Duration,
    mut prepare: impl FnMut() -> A,
    mut work: impl FnMut(A) -> Result<T, E>,
) -> Result<(T, Duration), E> {
    let (mut calls, mut total) = (0_u32, Duration::ZERO);
    let begun = Instant::now();
    loop {
        // Many short calls are measured together: each alone is below the clock's steps.
        let batch: Vec<A> = (0..calls.clamp(1, 256)).map(|_| prepare()).collect();
        calls += batch.len() as u32;
        let watch = Stopwatch::start(TimeScope::Thread);
        let mut last = None;
        for input in batch {
            last = Some(work(input)?);
        }
        total += watch.elapsed();
        if let Some(value) = last
            && (total >= shortest || begun.elapsed() >= 8 * shortest)
        {
            return Ok((value, total / calls));
        }
    }
}

fn processor_time(scope: TimeScope) -> Option<Duration> {
    match scope {
        TimeScope::Thread => thread_time(&std::fs::read_to_string("/proc/thread-self/schedstat").ok()?),
        TimeScope::Process => process_time(&std::fs::read_to_string("/proc/self/stat").ok()?),
    }
}

/// The first number of `/proc/thread-self/schedstat`, nanoseconds on a processor.
fn thread_time(text: &str) -> Option<Duration> {
    Some(Duration::from_nanos(text.split_whitespace().next()?.parse().ok()?))
}

/// User and system time, fields 14 and 15 of `/proc/self/stat`. The second field is a name in parentheses that may contain any character.
fn process_time(text: &str) -> Option<Duration> {
    let (_, fields) = text.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u32>().ok();
    Some(TICK * ticks()?.checked_add(ticks()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_the_system_are_read() {
        assert_eq!(thread_time("1500 20 3\n"), Some(Duration::from_nanos(1500)));
        let stat = "42 (a (b) c) R 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20 0\n";
        assert_eq!(process_time(stat), Some(Duration::from_secs(3)));
        assert_eq!(process_time("42 (a) R 1"), None);
    }

    #[test]
    fn sleep_costs_no_processor_time() {
        if !counts_processor_time() {
            return;
        }
        let watch = Stopwatch::start(TimeScope::Thread);
        std::thread::sleep(Duration::from_millis(60));
        assert!(watch.elapsed() < Duration::from_millis(30));
    }

    #[test]
    fn work_is_repeated_until_it_can_be_measured() {
        let mut calls = 0_u32;
        let work = |n: u64| {
            calls += 1;
            Ok::<u64, ()>((0..n).fold(1, |a: u64, b| std::hint::black_box(a.wrapping_mul(b | 1))))
        };
        let (_, each) = repeated(|| 100_000, work).unwrap();
        assert!(calls > 100 && each > Duration::ZERO && each < Duration::from_millis(50), "{calls} {each:?}");
        assert_eq!(repeated(|| (), |()| Err::<(), _>(5)), Err(5));
    }
}
