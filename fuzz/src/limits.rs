//! The limits of one case.

use std::time::Duration;

/// Longest time.
pub const TIME: Duration = Duration::from_secs(1);

/// Time after which a case that has not ended is ended with its process.
pub const HANG: Duration = Duration::from_secs(20);

/// Peak of the memory of the smallest file, bytes; larger ones have [`Target::memory_factor`](crate::target::Target::memory_factor) in addition.
pub const MEMORY: usize = 64 << 20;

/// Stack of the thread that reads, bytes: that of the threads of the viewer, which are the smallest of the product.
pub const STACK: usize = 2 << 20;

/// Memory of a process that reads, KiB, as `ulimit -v` takes it: beyond it, allocations fail instead of exhausting the machine.
pub const PROCESS_KIB: usize = 8 << 20;
