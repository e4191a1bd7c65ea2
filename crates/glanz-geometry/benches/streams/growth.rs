//! Time, memory and rates of surfaces of growing numbers of patches.

use std::fs::{read_to_string, write};
use std::io::Write;
use std::time::Instant;

use glanz_geometry::Surface;
use glanz_geometry::freeform::Freeform;

use super::models::{Failure, Model};
use super::processor_time::processor_time;
use super::{closest_hits, ray_sets_of};

/// Numbers of patches without arguments: squares next to powers of ten.
const COUNTS: [&str; 4] = ["1024", "10000", "99856", "1000000"];

/// Number of times that each surface is built; other programs make some of them slow.
const BUILDS: usize = 3;

/// A line of `/proc/self/status`, bytes; 0 where the system does not report it.
fn memory(name: &str) -> u64 {
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
    1024 * kilobytes.unwrap_or_default()
}

/// A surface and the seconds of its building.
struct TimedBuild {
    surface: Freeform,
    seconds: f64,
    /// Processor time of this thread.
    thread_seconds: f64,
    /// Whether the peak of the memory is that since the patches were there; without that it is unknown.
    is_peak_reset: bool,
}

impl TimedBuild {
    fn new(count: &str) -> Result<Self, Failure> {
        let pieces = Model::named(&format!("{count} patches"))?.source.pieces()?;
        let is_peak_reset = write("/proc/self/clear_refs", "5").is_ok();
        let (start, thread) = (Instant::now(), processor_time());
        let surface = Freeform::try_new(pieces)?;
        let (seconds, thread_seconds) =
            (start.elapsed().as_secs_f64(), 1e-9 * (processor_time() - thread) as f64);
        Ok(Self { surface, seconds, thread_seconds, is_peak_reset })
    }
}

/// Writes a table of `counts`: seconds of building and processor seconds of this thread, the least of a few; bytes of a patch at the
/// end, and at the peak (resident memory, with the patches from which the surface is built); million rays a second one by one and in
/// batches.
pub(super) fn table(counts: &[String], out: &mut impl Write) -> Result<(), Failure> {
    writeln!(
        out,
        "patches,leaves,build_s,thread_s,bytes_per_patch,peak_bytes_per_patch,tiles,tiles_batch,shuffled,shuffled_batch,lines,lines_batch"
    )?;
    let all = COUNTS.map(String::from);
    for count in if counts.is_empty() { &all } else { counts } {
        let before = memory("VmRSS");
        let mut build = TimedBuild::new(count)?;
        let peak = if build.is_peak_reset { memory("VmHWM").saturating_sub(before) as f64 } else { f64::NAN };
        for _ in 1..BUILDS {
            let TimedBuild { seconds, thread_seconds, .. } = build;
            drop(build);
            build = TimedBuild::new(count)?;
            build.seconds = seconds.min(build.seconds);
            build.thread_seconds = thread_seconds.min(build.thread_seconds);
        }
        let TimedBuild { surface, seconds, thread_seconds, .. } = build;
        let patches = surface.patch_count() as f64;
        let (bytes, leaves) = (surface.bytes() as f64, surface.statistics().leaves);
        write!(out, "{patches},{leaves},{seconds:.4},{thread_seconds:.4},")?;
        write!(out, "{:.0},{:.0}", bytes / patches, peak / patches)?;
        let surface = Surface::from(surface);
        for rays in ray_sets_of(&surface) {
            for seconds in closest_hits(&surface, &rays) {
                write!(out, ",{:.2}", 1e-6 * rays.len() as f64 / seconds)?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
