//! Memory of the machine.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Bytes of memory that were available when this was first called: the least of the machine's and its control group's. `None` where neither can be asked.
pub(super) fn available_memory() -> Option<u64> {
    static AVAILABLE: OnceLock<Option<u64>> = OnceLock::new();
    *AVAILABLE.get_or_init(|| {
        let machine = read(Path::new("/proc/meminfo")).as_deref().and_then(available_in);
        match (machine, group_rest(read)) {
            (Some(machine), Some(group)) => Some(machine.min(group)),
            (machine, group) => machine.or(group),
        }
    })
}

fn read(path: &Path) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// `MemAvailable` of `/proc/meminfo`.
pub(super) fn available_in(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// Paths of the control groups of a version.
struct GroupFiles {
    /// The folder of the group around all others.
    root: &'static str,
    limit: &'static str,
    usage: &'static str,
    /// The line of `memory.stat` with the cached pages of files that were not used lately.
    inactive: &'static str,
}

const VERSION_2: GroupFiles = GroupFiles {
    root: "/sys/fs/cgroup",
    limit: "memory.max",
    usage: "memory.current",
    inactive: "inactive_file",
};

const VERSION_1: GroupFiles = GroupFiles {
    root: "/sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    inactive: "total_inactive_file",
};

/// What the control group of this process and those around it may still allocate: the least. `text`: the content of a file. `None` without a limit.
pub(super) fn group_rest(text: impl Fn(&Path) -> Option<String>) -> Option<u64> {
    let own = text(Path::new("/proc/self/cgroup")).unwrap_or_default();
    let own = own.lines().filter_map(group_folder);
    // Within a container, its own group may be the root of what it sees, whatever the path that it has outside.
    let roots = [&VERSION_2, &VERSION_1].map(|files| (PathBuf::from(files.root), files));
    let rest_around = |(folder, files): (PathBuf, &GroupFiles)| {
        let folders = folder.ancestors().take_while(|folder| folder.starts_with(files.root));
        folders.filter_map(|folder| rest_in(folder, files, &text)).min()
    };
    own.chain(roots).filter_map(rest_around).min()
}

/// The folder of the group in a line of `/proc/self/cgroup`: `0::PATH`, or in version 1 `NUMBER:CONTROLLERS:PATH`.
fn group_folder(line: &str) -> Option<(PathBuf, &'static GroupFiles)> {
    let (_, rest) = line.split_once(':')?;
    let (controllers, path) = rest.split_once(':')?;
    let files = match controllers {
        "" => &VERSION_2,
        _ if controllers.split(',').any(|name| name == "memory") => &VERSION_1,
        _ => return None,
    };
    Some((Path::new(files.root).join(path.trim_start_matches('/')), files))
}

/// What the control group with this folder may still allocate; `None` without a limit.
fn rest_in(folder: &Path, files: &GroupFiles, text: impl Fn(&Path) -> Option<String>) -> Option<u64> {
    let text = |name: &str| text(&folder.join(name));
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
