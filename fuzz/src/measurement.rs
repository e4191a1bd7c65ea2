//! Reading one file, measured.

use std::any::Any;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;

use crate::limits;
use crate::targets::{ReadOutcome, Target, read_scene};

/// The allocator of every program of this package, which counts bytes.
#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// A case that broke a limit or a promise.
#[derive(Clone, Debug, PartialEq)]
pub enum CaseFault {
    /// A panic, with its message and its place.
    Panic(String),
    /// It took longer than [`limits::TIME`], each time that it was measured.
    Time(Duration),
    /// The peak of its memory, bytes, above the limit for its size.
    Memory {
        /// Peak above the memory before, bytes.
        peak: usize,
        /// Largest permitted peak, bytes.
        limit: usize,
    },
}

impl CaseFault {
    /// What distinguishes it from others: only one file is kept of each.
    #[must_use]
    pub fn signature(&self) -> String {
        match self {
            // The place, which the message begins with.
            Self::Panic(message) => format!("panic at {}", message.split(": ").next().unwrap_or_default()),
            Self::Time(_) => "time".to_owned(),
            Self::Memory { .. } => "memory".to_owned(),
        }
    }
}

impl fmt::Display for CaseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Panic(message) => write!(f, "panic at {message}"),
            Self::Time(time) => write!(f, "{:.2} s", time.as_secs_f64()),
            Self::Memory { peak, limit } => {
                write!(f, "{:.1} MB at the peak, of {:.1} MB", *peak as f64 * 1e-6, *limit as f64 * 1e-6)
            }
        }
    }
}

/// One file, read and measured.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The outcome, unless reading panicked.
    pub outcome: Option<ReadOutcome>,
    /// Shortest time of its measurements.
    pub time: Duration,
    /// Peak of its memory above the memory before, bytes.
    pub peak: usize,
    /// The limit or the promise that was broken.
    pub fault: Option<CaseFault>,
}

/// The place and message of the last panic of any thread.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// The place and message of the last panic, if [`record_panics`] was called before.
#[must_use]
pub fn last_panic() -> String {
    LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Keeps panics quiet, and their places.
pub fn record_panics() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(|l| format!("{}:{}", l.file(), l.line())).unwrap_or_default();
        let payload: &(dyn Any + Send) = info.payload();
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or_default();
        *LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner) = format!("{place}: {text}");
    }));
}

impl Measurement {
    /// Reads `bytes`. Nothing else may run in the process.
    #[must_use]
    pub fn of(target: &Target, bytes: &[u8]) -> Self {
        Self::least(target.memory_factor * bytes.len(), || (target.run)(bytes))
    }

    /// Reads a scene with all files in its folder.
    #[must_use]
    pub fn of_scene(target: &Target, file: &Path) -> Self {
        let files = file.parent().and_then(|folder| folder.read_dir().ok()).into_iter().flatten().flatten();
        let size: u64 = files.filter_map(|file| file.metadata().ok()).map(|data| data.len()).sum();
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        Self::least(target.memory_factor.saturating_mul(size), || read_scene(file, size))
    }

    /// The shortest of up to three readings, if the first is slow, since the machine may have been busy; one that is very slow is not repeated, since the process
    /// would be ended meanwhile. `memory`: peak that the size permits, bytes.
    fn least(memory: usize, run: impl Fn() -> ReadOutcome) -> Self {
        let mut found = Self::once(memory, &run);
        for _ in 0..2 {
            if !matches!(found.fault, Some(CaseFault::Time(time)) if time <= limits::HANG / 4) {
                break;
            }
            let again = Self::once(memory, &run);
            if again.time < found.time {
                found = again;
            }
        }
        found
    }

    fn once(memory: usize, run: impl Fn() -> ReadOutcome) -> Self {
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(run));
        let time = start.elapsed();
        let peak = ALLOCATOR.peak_usage().saturating_sub(before);
        let limit = limits::MEMORY.saturating_add(memory);
        let fault = match &outcome {
            Err(_) => Some(CaseFault::Panic(last_panic())),
            Ok(_) if time > limits::TIME => Some(CaseFault::Time(time)),
            Ok(_) if peak > limit => Some(CaseFault::Memory { peak, limit }),
            Ok(_) => None,
        };
        Self { outcome: outcome.ok(), time, peak, fault }
    }
}
