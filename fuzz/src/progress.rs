//! Progress of a run of hours, and its display.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use glanz::job::CancelFlag;
use glanz::report::number::duration;

use crate::targets::Target;
use crate::worker::MutantRun;

/// What the processes of all tasks have done so far, and whether they are to end.
#[derive(Debug, Default)]
pub struct CampaignProgress {
    /// Number of mutants.
    pub cases: AtomicU64,
    /// Number of mutants times the divisors of their targets, which is in proportion to their time.
    pub work: AtomicU64,
    /// Longest time of a mutant, microseconds.
    pub slowest: AtomicU64,
    /// Largest peak of memory, bytes.
    pub peak: AtomicUsize,
    /// Flag of a signal that ends all tasks early; the processes receive it as well.
    pub cancel: CancelFlag,
}

impl CampaignProgress {
    /// Adds mutants of a target.
    pub(crate) fn add(&self, target: &Target, cases: u64) {
        self.cases.fetch_add(cases, Ordering::Relaxed);
        self.add_work(target, cases);
    }

    /// Adds the work of mutants that are made or left out.
    pub(crate) fn add_work(&self, target: &Target, cases: u64) {
        self.work.fetch_add(cases.saturating_mul(target.divisor), Ordering::Relaxed);
    }

    /// Raises the largest figures to these.
    pub(crate) fn raise(&self, slowest: u64, peak: usize) {
        self.slowest.fetch_max(slowest, Ordering::Relaxed);
        self.peak.fetch_max(peak, Ordering::Relaxed);
    }
}

/// How many cases a run has and how long it may take; `None`: without a limit.
#[derive(Clone, Debug)]
pub struct CampaignExtent {
    /// Number of cases.
    cases: Option<u64>,
    /// Number of cases times the divisors of their targets.
    work: Option<u64>,
    /// Longest time, s.
    seconds: Option<f64>,
}

impl CampaignExtent {
    /// The extent of these tasks, `slots` of which run at a time. `is_counted`: whether their numbers of cases are limits.
    #[must_use]
    pub fn of(tasks: &[MutantRun], slots: usize, is_counted: bool) -> Self {
        let sum = |of_task: fn(&MutantRun) -> u64| {
            is_counted.then(|| tasks.iter().map(of_task).fold(0, u64::saturating_add))
        };
        let seconds = tasks.iter().find_map(|task| task.seconds);
        Self {
            cases: sum(|task| task.cases),
            work: sum(|task| task.cases.saturating_mul(task.target.divisor)),
            seconds: seconds.map(|seconds| seconds * tasks.len().div_ceil(slots.max(1)) as f64),
        }
    }

    /// The time left after `work` in `seconds`, if the rest is as fast.
    fn seconds_left(&self, work: u64, seconds: f64) -> Option<f64> {
        let rest = self.work.filter(|_| work > 0).map(|all| all.saturating_sub(work) as f64 / work as f64);
        let limit = self.seconds.map(|longest| (longest - seconds).max(0.0));
        rest.map(|rest| rest * seconds).into_iter().chain(limit).reduce(f64::min)
    }

    /// A line of progress after this time.
    fn line(&self, progress: &CampaignProgress, seconds: f64) -> String {
        let CampaignProgress { cases, work, slowest, peak, .. } = progress;
        let [cases, work, slowest] = [cases, work, slowest].map(|number| number.load(Ordering::Relaxed));
        let total = self.cases.map(|total| format!(" of {total}")).unwrap_or_default();
        let left = self.seconds_left(work, seconds);
        let left = left.map(|left| format!(", {} left", duration(left))).unwrap_or_default();
        format!(
            "{cases}{total} mutants, {:.0}/s, slowest {:.3} s, peak {:.1} MB, {}{left}",
            cases as f64 / seconds.max(1e-9),
            slowest as f64 * 1e-6,
            peak.load(Ordering::Relaxed) as f64 * 1e-6,
            duration(seconds)
        )
    }

    /// Prints a line of progress every ten seconds until `is_over`.
    pub fn show(&self, progress: &CampaignProgress, is_over: &AtomicBool) {
        let (mut shown, start) = (Instant::now(), Instant::now());
        while !is_over.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(20));
            if shown.elapsed() > Duration::from_secs(10) {
                shown = Instant::now();
                // If nobody reads this stream, the mutants matter still.
                let _ = writeln!(io::stderr(), "{}", self.line(progress, start.elapsed().as_secs_f64()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_in_proportion_to_the_work_left_and_within_the_limit() {
        let extent = |work, seconds| CampaignExtent { cases: None, work, seconds };
        assert_eq!(extent(Some(400), None).seconds_left(100, 10.0), Some(30.0));
        assert_eq!(extent(Some(400), Some(25.0)).seconds_left(100, 10.0), Some(15.0));
        assert_eq!(extent(None, Some(25.0)).seconds_left(100, 30.0), Some(0.0));
        assert_eq!(extent(Some(400), None).seconds_left(0, 10.0), None);
    }

    #[test]
    fn line_of_progress_has_cases_rate_slowest_peak_and_time_left() {
        let progress = CampaignProgress::default();
        progress.cases.store(500, Ordering::Relaxed);
        progress.work.store(1000, Ordering::Relaxed);
        progress.slowest.store(250_000, Ordering::Relaxed);
        progress.peak.store(12_300_000, Ordering::Relaxed);
        let extent = CampaignExtent { cases: Some(900), work: Some(3000), seconds: None };
        let line = extent.line(&progress, 20.0);
        let start = "500 of 900 mutants, 25/s, slowest 0.250 s, peak 12.3 MB, ";
        assert!(line.starts_with(start) && line.ends_with(" left"), "{line}");
    }
}
