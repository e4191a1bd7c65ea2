//! Memory of the machine.

use std::path::Path;
use std::sync::OnceLock;

/// Bytes of memory that were available when this was first called: the least of the machine's and its control group's. `None` where neither can be asked.
pub(super) fn available_memory() -> Option<u64> {
    static AVAILABLE: OnceLock<Option<u64>> = OnceLock::new();
    *AVAILABLE.get_or_init(|| {
        let machine = read("/proc/meminfo").as_deref().and_then(available_in);
        // Within a container, its own group is the root of what it sees.
        let group = group_rest("/sys/fs/cgroup", &VERSION_2)
            .or_else(|| group_rest("/sys/fs/cgroup/memory", &VERSION_1));
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

/// Names in the folder of a control group.
struct GroupFiles {
    limit: &'static str,
    usage: &'static str,
    /// The line of `memory.stat` with the cached pages of files that were not used lately.
    inactive: &'static str,
}

const VERSION_2: GroupFiles =
    GroupFiles { limit: "memory.max", usage: "memory.current", inactive: "inactive_file" };

const VERSION_1: GroupFiles = GroupFiles {
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    inactive: "total_inactive_file",
};

/// What a control group may still allocate; `None` without a limit.
fn group_rest(folder: &str, files: &GroupFiles) -> Option<u64> {
    let text = |name: &str| read(Path::new(folder).join(name));
    let limit = text(files.limit)?.trim().parse().ok()?;
    let usage = text(files.usage)?.trim().parse().ok()?;
    let inactive = text("memory.stat").and_then(|statistics| statistic(&statistics, files.inactive));
    Some(rest(limit, usage, inactive.unwrap_or(0)))
}

/// What is left of `limit`: the system gives up `inactive` of the memory in use before it refuses an allocation.
pub(super) fn rest(limit: u64, usage: u64, inactive: u64) -> u64 {
    limit.saturating_sub(usage.saturating_sub(inactive))
}

/// The number in the line `NAME NUMBER` of `memory.stat`.
pub(super) fn statistic(statistics: &str, name: &str) -> Option<u64> {
    let line = statistics.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
    line.trim().parse().ok()
}
