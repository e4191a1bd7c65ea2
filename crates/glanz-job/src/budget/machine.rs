//! Memory of the machine.

use std::path::Path;
use std::sync::OnceLock;

/// Bytes of memory that were available when this was first called: the least of the machine's and its control group's. `None` where neither can be asked.
pub(super) fn available_memory() -> Option<u64> {
    static AVAILABLE: OnceLock<Option<u64>> = OnceLock::new();
    *AVAILABLE.get_or_init(|| {
        let machine = read("/proc/meminfo").as_deref().and_then(available_in);
        // Within a container, its own group is the root of what it sees.
        let group = group_rest("/sys/fs/cgroup", "memory.max", "memory.current").or_else(|| {
            group_rest("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes")
        });
        match (machine, group) {
            (Some(machine), Some(group)) => Some(machine.min(group)),
            (machine, group) => machine.or(group),
        }
    })
}

fn read(path: impl AsRef<Path>) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// `MemAvailable` of `/proc/meminfo`.
pub(super) fn available_in(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// What a control group may still allocate; `None` without a limit.
fn group_rest(folder: &str, limit: &str, usage: &str) -> Option<u64> {
    let number = |name: &str| read(Path::new(folder).join(name))?.trim().parse::<u64>().ok();
    Some(number(limit)?.saturating_sub(number(usage)?))
}
