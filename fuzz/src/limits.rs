//! The limits of one case.

use std::time::Duration;

use glanz::job::ResourceLimits;

/// Longest time.
pub const TIME: Duration = Duration::from_secs(1);

/// Time after which a case that has not ended is ended with its process.
pub const HANG: Duration = Duration::from_secs(20);

/// Peak of the memory of the smallest file, bytes; larger ones have [`Target::memory_factor`](crate::targets::Target::memory_factor) in addition.
pub const MEMORY: usize = 64 << 20;

/// Stack of the thread that reads, bytes: that of the threads of the viewer, which are the smallest of the product.
pub const STACK: usize = 2 << 20;

/// Memory of a process that reads, KiB, as `ulimit -v` takes it: beyond it, allocations fail instead of exhausting the machine.
pub const PROCESS_KIB: usize = 8 << 20;

/// Limits of a reader.
pub fn of_reading() -> ResourceLimits {
    ResourceLimits { memory: MEMORY as u64, files: 1000, ..ResourceLimits::default() }
}
