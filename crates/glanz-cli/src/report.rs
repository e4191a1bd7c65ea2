//! Results on the standard output, and their numbers.

pub(crate) use glanz::report::number::{duration, grouped, plural};
pub(crate) use glanz_terminal::output::{print, print_text};

/// The most memory this process has held, in bytes; known on Linux only.
pub(crate) fn peak_memory_bytes() -> Option<u64> {
    kilobytes(&std::fs::read_to_string("/proc/self/status").ok()?)?.checked_mul(1024)
}

/// The number in the line `VmHWM:     1234 kB`.
fn kilobytes(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim_end().parse().ok()
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
    }
}
