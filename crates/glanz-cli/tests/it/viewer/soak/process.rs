//! Threads, memory, open files and processes of a process, as the operating system reports them.

use std::time::{Duration, Instant};

/// What a process uses at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Usage {
    pub(crate) threads: u64,
    /// Resident, MiB.
    pub(crate) memory: f64,
    /// Open files, sockets included.
    pub(crate) files: usize,
    /// Processes that it has started.
    pub(crate) children: usize,
}

impl Usage {
    /// The usage of a running process, read from `/proc`.
    pub(crate) fn of(process: u32) -> Option<Self> {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let number = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse::<u64>().ok()
        };
        let files = std::fs::read_dir(format!("/proc/{process}/fd")).ok()?.count();
        let children = children(process).len();
        let memory = number("VmRSS:")? as f64 / 1024.0;
        Some(Self { threads: number("Threads:")?, memory, files, children })
    }

    /// The usage of a process once it has at most the threads, files and processes of `before`, or after the time `patience`.
    pub(crate) fn settled(process: u32, before: Self, patience: Duration) -> Option<Self> {
        let start = Instant::now();
        loop {
            let usage = Self::of(process)?;
            let is_settled = usage.threads <= before.threads
                && usage.files <= before.files
                && usage.children <= before.children;
            if is_settled || start.elapsed() > patience {
                return Some(usage);
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

impl std::fmt::Display for Usage {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { threads, memory, files, children } = self;
        write!(formatter, "{threads} threads, {memory:.1} MiB, {files} files, {children} processes")
    }
}

/// The processes that a process has started and that it has not seen end.
pub(crate) fn children(process: u32) -> Vec<u32> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let ids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    ids.filter(|id| parent(*id) == Some(process)).collect()
}

/// The parent of a process.
fn parent(process: u32) -> Option<u32> {
    let status = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may contain anything.
    status.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
}
