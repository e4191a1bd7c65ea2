//! Long computations: progress, cancelling, budgets of resources, checkpoints and identity.
//!
//! Rendering, baking, illuminating, conversions and studies are *jobs*. A function that runs one takes two arguments:
//!
//! - a [`ProgressSink`], which receives [`JobProgress`] periodically and, at its
//!   [`ProgressSink::checkpoint_interval`], the state to save; [`Silent`] ignores both;
//! - a [`CancelFlag`], which a signal handler, another thread or the sink itself may raise.
//!
//! A cancelled job that has a partial result returns it with [`JobEnd::Interrupted`]; one that has none returns an error whose variant
//! `Interrupted` holds [`Interrupted`]. A saved state belongs to a [`JobIdentity`]: resuming under another one is refused by an
//! [`IdentityMismatch`], which names the first field that differs. A [`ContentHash`] represents the scene in it, and
//! [`write_atomically`] replaces the file of a state as a whole, which a [`CheckpointLock`] keeps from other processes. An [`IoFault`] is an error of a file in words. A [`JobPart`] is one of several parts of a job that are computed separately. Reports name the
//! program by [`current_version`] and the machine by [`processor_name`]. A [`ResourceBudget`] bounds what the input of a job can cost: memory, files, time and so on.
//! A [`ScratchFile`] holds data above the limit of memory.
//!
//! ```
//! use std::time::{Duration, Instant};
//!
//! use glanz_job::{CancelFlag, CheckpointTimer, Interrupted, JobProgress, ProgressSink};
//!
//! fn sum(numbers: &[u64], sink: &mut dyn ProgressSink<u64>, cancel: &CancelFlag) -> Result<u64, Interrupted> {
//!     let begun = Instant::now();
//!     let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
//!     let mut sum = 0;
//!     for (done, number) in numbers.iter().enumerate() {
//!         cancel.check()?;
//!         sum += number;
//!         let fraction = (done + 1) as f64 / numbers.len() as f64;
//!         sink.on_progress(&JobProgress::by_work("summation", fraction, begun.elapsed()));
//!         if timer.is_due() {
//!             timer.save(|| sink.on_checkpoint(&sum));
//!         }
//!     }
//!     Ok(sum)
//! }
//!
//! /// Cancels the job after the first checkpoint.
//! struct Stopper {
//!     cancel: CancelFlag,
//!     saved: u64,
//! }
//!
//! impl ProgressSink<u64> for Stopper {
//!     fn checkpoint_interval(&self) -> Option<Duration> {
//!         Some(Duration::ZERO)
//!     }
//!
//!     fn on_checkpoint(&mut self, state: &u64) {
//!         self.saved = *state;
//!         self.cancel.cancel();
//!     }
//! }
//!
//! let cancel = CancelFlag::default();
//! let mut stopper = Stopper { cancel: cancel.clone(), saved: 0 };
//! assert_eq!(sum(&[3, 4, 5], &mut stopper, &cancel), Err(Interrupted));
//! assert_eq!(stopper.saved, 3);
//! ```

mod atomic;
mod budget;
mod cancel;
mod checkpoint;
mod content_hash;
mod identity;
mod io_fault;
mod part;
mod processor;
mod progress;
mod scratch_file;

pub use atomic::{
    CheckpointLock, CheckpointLockError, WriteError, check_creatable, make_folder, remove_orphans,
    write_atomically, write_atomically_with, write_file_atomically,
};
pub use budget::{
    BudgetError, LimitError, LimitValueError, MemoryReservation, Resource, ResourceBudget, ResourceLimits,
    byte_size,
};
pub use cancel::{CancelFlag, Interrupted, JobEnd};
pub use checkpoint::CheckpointTimer;
pub use content_hash::ContentHash;
pub use identity::{IdentityMismatch, JobIdentity, current_version};
pub use io_fault::IoFault;
pub use part::{JobPart, JobPartError, MAX_PARTS};
pub use processor::processor_name;
pub use progress::{JobProgress, ProgressSink, Silent, WorkCount, grouped};
pub use scratch_file::{ScratchFile, ScratchFileError};
