//! What `--json` prints: one object on the standard output.

use std::io::Write;

pub(crate) use glanz_illumination::report::table::{grouped, plural};
use serde::Serialize;

use crate::messages::Failure;

/// Prints `report` as one object on the standard output.
///
/// # Errors
/// If the stream is closed.
pub(crate) fn print(report: &impl Serialize) -> Result<(), Failure> {
    let closed = |error: &dyn std::fmt::Display| Failure::new(format!("standard output: {error}"));
    let mut text = serde_json::to_string_pretty(report).map_err(|error| closed(&error))?;
    text.push('\n');
    print_text(&text)
}

/// Prints `text` on the standard output.
///
/// # Errors
/// If the stream is closed.
pub(crate) fn print_text(text: &str) -> Result<(), Failure> {
    let mut stream = std::io::stdout().lock();
    stream
        .write_all(text.as_bytes())
        .and_then(|()| stream.flush())
        .map_err(|error| Failure::new(format!("standard output: {error}")))
}

/// The most memory this process has held, in bytes; known on Linux only.
pub(crate) fn peak_memory_bytes() -> Option<u64> {
    kilobytes(&std::fs::read_to_string("/proc/self/status").ok()?)?.checked_mul(1024)
}

/// The number in the line `VmHWM:     1234 kB`.
fn kilobytes(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim_end().parse().ok()
}

/// A duration in words of the largest fitting unit: `3.2 s`, `4 min 05 s`, `2 h 10 min`.
pub(crate) fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn high_water_mark_is_found_in_the_status_file() {
        let status = "Name:\tglanz\nVmPeak:\t  900 kB\nVmHWM:\t  12345 kB\nVmRSS:\t 1 kB\n";
        assert_eq!(kilobytes(status), Some(12345));
        assert_eq!(kilobytes("Name:\tglanz\n"), None);
        if cfg!(target_os = "linux") {
            assert!(peak_memory_bytes() > Some(100_000));
        }
    }

    #[test]
    fn numbers_are_easy_to_read() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(duration(3.24), "3.2 s");
        assert_eq!(duration(245.2), "4 min 05 s");
        assert_eq!(duration(7800.0), "2 h 10 min");
    }
}
