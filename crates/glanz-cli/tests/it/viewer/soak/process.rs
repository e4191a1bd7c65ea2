//! Threads and memory of a process, as the operating system reports them.

use std::time::{Duration, Instant};

/// Threads and resident memory of a process at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Usage {
    pub(crate) threads: u64,
    /// MiB.
    pub(crate) memory: f64,
}

impl Usage {
    /// The usage of a running process, read from `/proc`.
    pub(crate) fn of(process: u32) -> Option<Self> {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let number = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse::<u64>().ok()
        };
        Some(Self { threads: number("Threads:")?, memory: number("VmRSS:")? as f64 / 1024.0 })
    }

    /// The usage of a process once it has at most `threads`, or after the time `patience`.
    pub(crate) fn settled(process: u32, threads: u64, patience: Duration) -> Option<Self> {
        let start = Instant::now();
        loop {
            let usage = Self::of(process)?;
            if usage.threads <= threads || start.elapsed() > patience {
                return Some(usage);
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

impl std::fmt::Display for Usage {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} threads, {:.1} MiB", self.threads, self.memory)
    }
}
