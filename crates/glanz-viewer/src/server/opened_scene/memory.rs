//! Memory of the processes of opened scenes.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes in use by the process of each opened scene, as last measured.
#[derive(Debug, Default)]
pub(crate) struct SceneMemory(Mutex<BTreeMap<u32, u64>>);

impl SceneMemory {
    fn used(&self) -> MutexGuard<'_, BTreeMap<u32, u64>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records the bytes that a process uses. Returns true if all together use more than `most`, and none more than this one.
    pub(super) fn record(&self, process: u32, bytes: u64, most: u64) -> bool {
        let mut used = self.used();
        used.insert(process, bytes);
        let sum = used.values().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes));
        sum > most && used.values().all(|other| *other <= bytes)
    }

    /// Forgets a process that has ended.
    pub(super) fn remove(&self, process: u32) {
        self.used().remove(&process);
    }
}

/// Bytes of a running process that are its own, not those of files; 0 where the system does not report them.
pub(super) fn own_memory(process: u32) -> u64 {
    let names = ["RssAnon:", "RssShmem:", "VmSwap:"];
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let values = text.lines().filter_map(|line| names.iter().find_map(|name| line.strip_prefix(name)));
    let numbers = values.filter_map(|value| value.split_whitespace().next()?.parse::<u64>().ok());
    numbers.fold(0, |sum: u64, kibibytes| sum.saturating_add(kibibytes.saturating_mul(1024)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_of_too_many_bytes_has_to_go() {
        let memory = SceneMemory::default();
        assert!(!memory.record(1, 60, 100));
        assert!(!memory.record(2, 50, 100), "the first is larger");
        assert!(memory.record(1, 60, 100));
        memory.remove(1);
        assert!(!memory.record(2, 100, 100));
        assert!(memory.record(2, 101, 100));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_that_of_the_system() {
        let before = own_memory(std::process::id());
        let bytes = vec![1_u8; 64 << 20];
        let more = own_memory(std::process::id()).saturating_sub(before);
        // Other tests may free some of theirs.
        assert!(bytes.iter().all(|byte| *byte == 1) && more >= 32 << 20, "{more}");
        assert_eq!(own_memory(u32::MAX), 0);
    }
}
