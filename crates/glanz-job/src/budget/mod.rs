//! A budget of resources, which bounds what the input of a job can cost.

mod limits;
mod machine;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::fmt;
use std::io;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

pub use limits::{LimitValueError, Resource, ResourceLimits, byte_size};

use crate::{CancelFlag, Interrupted, IoFault, ScratchFileError};

/// What a job may still use; clones share it.
///
/// A job spends from it before it allocates or works, and calls [`ResourceBudget::check`] in its loops. The first failure is kept: afterwards every call fails with it, so
/// that the other threads and the callers of a function that swallows errors end, too.
///
/// ```
/// use glanz_job::{BudgetError, CancelFlag, Resource, ResourceBudget, ResourceLimits};
///
/// let limits = ResourceLimits { files: 2, ..ResourceLimits::default() };
/// let budget = ResourceBudget::new(limits, CancelFlag::default());
/// assert_eq!(budget.spend(Resource::Files, 2), Ok(()));
/// let Err(BudgetError::Limit(limit)) = budget.spend(Resource::Files, 1) else { panic!() };
/// assert_eq!(limit.to_string(), "the limit of 2 files is exceeded");
/// ```
#[derive(Clone, Debug)]
pub struct ResourceBudget {
    shared: Arc<SharedBudget>,
    cancel: CancelFlag,
}

#[derive(Debug)]
struct SharedBudget {
    limits: ResourceLimits,
    used: [AtomicU64; Resource::ALL.len()],
    /// `None`: beyond the range of the clock.
    deadline: Option<Instant>,
    /// Calls of [`ResourceBudget::check`]. Threads may overwrite each other's counts, which does no harm.
    checks: AtomicU32,
    failure: OnceLock<BudgetError>,
}

/// The clock is read at the first of so many calls of [`ResourceBudget::check`].
const CHECKS_PER_CLOCK: u32 = 64;

/// Why a job with a budget has to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BudgetError {
    /// A limit was reached.
    Limit(LimitError),
    /// The cancel flag was raised.
    Interrupted,
    /// The temporary file of what is above the limit of memory failed.
    TemporaryFile {
        /// Kind of the fault; [`io::ErrorKind::Unsupported`] if the first folder is in memory.
        kind: io::ErrorKind,
        /// Number of the fault in the system, if it has one.
        code: Option<i32>,
    },
}

/// A limit that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitError {
    /// The resource.
    pub resource: Resource,
    /// Its limit, in the unit of [`ResourceLimits::get`].
    pub limit: u64,
    /// What is needed in all, at least, if it is known.
    pub needed: Option<u64>,
}

impl Default for ResourceBudget {
    /// The limits of the machine, never cancelled.
    fn default() -> Self {
        Self::new(ResourceLimits::default(), CancelFlag::default())
    }
}

impl ResourceBudget {
    /// A budget of which nothing is used. Its time begins now.
    #[must_use]
    pub fn new(limits: ResourceLimits, cancel: CancelFlag) -> Self {
        let deadline = Instant::now().checked_add(limits.time);
        let (used, checks, failure) = (Default::default(), AtomicU32::default(), OnceLock::new());
        Self { shared: Arc::new(SharedBudget { limits, used, deadline, checks, failure }), cancel }
    }

    /// A budget with the same limits and flag, which is independent from now on. The memory in use is that of this one; everything else begins anew.
    ///
    /// It serves the steps after reading, each of which may be repeated.
    #[must_use]
    pub fn for_next_step(&self) -> Self {
        self.for_next_step_within(self.shared.limits.clone(), self.cancel.clone())
    }

    /// As [`ResourceBudget::for_next_step`], with other limits and another flag.
    #[must_use]
    pub fn for_next_step_within(&self, limits: ResourceLimits, cancel: CancelFlag) -> Self {
        let next = Self::new(limits, cancel);
        let memory = Resource::Memory as usize;
        next.shared.used[memory].store(self.used(Resource::Memory), Ordering::Relaxed);
        next
    }

    /// The same budget, shared, with another flag that ends the job.
    #[must_use]
    pub fn with_cancel(self, cancel: CancelFlag) -> Self {
        Self { cancel, ..self }
    }

    /// The limits.
    #[must_use]
    pub fn limits(&self) -> &ResourceLimits {
        &self.shared.limits
    }

    /// The flag that ends the job.
    #[must_use]
    pub fn cancel(&self) -> &CancelFlag {
        &self.cancel
    }

    /// How much is used of a resource; 0 of [`Resource::Time`].
    #[must_use]
    pub fn used(&self, resource: Resource) -> u64 {
        self.shared.used[resource as usize].load(Ordering::Relaxed)
    }

    /// The first failure, if there was one.
    #[must_use]
    pub fn failure(&self) -> Option<BudgetError> {
        self.shared.failure.get().copied()
    }

    /// Uses `amount` of a resource for good.
    ///
    /// # Errors
    /// [`BudgetError::Limit`] if the limit is exceeded, or the first failure.
    pub fn spend(&self, resource: Resource, amount: u64) -> Result<(), BudgetError> {
        let before = self.shared.used[resource as usize].fetch_add(amount, Ordering::Relaxed);
        let (total, limit) = (before.saturating_add(amount), self.shared.limits.get(resource));
        if total > limit {
            // What does not fit is not kept, and the sum stays far from its overflow.
            self.shared.used[resource as usize].fetch_sub(amount, Ordering::Relaxed);
            // Of what comes piece by piece, the first piece too many is not all that is needed.
            let needed = (resource == Resource::Memory).then_some(total);
            return Err(self.fail(LimitError { resource, limit, needed }));
        }
        self.failure().map_or(Ok(()), Err)
    }

    /// Reserves `bytes` of memory until the reservation is dropped.
    ///
    /// # Errors
    /// [`BudgetError::Limit`] if the limit is exceeded, or the first failure.
    pub fn reserve(&self, bytes: u64) -> Result<MemoryReservation, BudgetError> {
        self.spend(Resource::Memory, bytes)?;
        Ok(MemoryReservation { budget: self.clone(), bytes })
    }

    /// Fails with a limit that the job measures itself, such as a depth.
    pub fn fail(&self, limit: LimitError) -> BudgetError {
        self.fail_with(BudgetError::Limit(limit))
    }

    /// Fails for this reason, if it is the first.
    pub fn fail_with(&self, reason: BudgetError) -> BudgetError {
        *self.shared.failure.get_or_init(|| reason)
    }

    /// Whether the job may go on. It costs a few loads, often enough in an inner loop; the clock is read now and then.
    ///
    /// # Errors
    /// [`BudgetError::Interrupted`] if the flag is raised, [`BudgetError::Limit`] if the time is over, or the first failure.
    #[inline]
    pub fn check(&self) -> Result<(), BudgetError> {
        if self.cancel.is_cancelled() || self.shared.failure.get().is_some() {
            return Err(self.stopped());
        }
        let checks = self.shared.checks.load(Ordering::Relaxed);
        self.shared.checks.store(checks.wrapping_add(1), Ordering::Relaxed);
        if checks.is_multiple_of(CHECKS_PER_CLOCK) { self.check_clock() } else { Ok(()) }
    }

    /// As [`ResourceBudget::check`], but reads the clock each time: before parts that take long, such as a file, a picture or a shape.
    ///
    /// # Errors
    /// As of [`ResourceBudget::check`].
    pub fn check_now(&self) -> Result<(), BudgetError> {
        if self.cancel.is_cancelled() || self.shared.failure.get().is_some() {
            return Err(self.stopped());
        }
        self.check_clock()
    }

    #[cold]
    fn stopped(&self) -> BudgetError {
        *self.shared.failure.get_or_init(|| BudgetError::Interrupted)
    }

    fn check_clock(&self) -> Result<(), BudgetError> {
        if self.shared.deadline.is_none_or(|deadline| Instant::now() < deadline) {
            return Ok(());
        }
        let limit = self.shared.limits.get(Resource::Time);
        Err(self.fail(LimitError { resource: Resource::Time, limit, needed: None }))
    }
}

/// Memory of a budget that is given back when this is dropped.
#[derive(Debug)]
pub struct MemoryReservation {
    budget: ResourceBudget,
    bytes: u64,
}

impl MemoryReservation {
    /// Its size.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Gives back all but `bytes`.
    pub fn shrink(&mut self, bytes: u64) {
        let rest = self.bytes.saturating_sub(bytes);
        self.budget.shared.used[Resource::Memory as usize].fetch_sub(rest, Ordering::Relaxed);
        self.bytes -= rest;
    }

    /// Leaves the memory in use for good.
    pub fn keep(mut self) {
        self.bytes = 0;
    }
}

impl Drop for MemoryReservation {
    fn drop(&mut self) {
        self.budget.shared.used[Resource::Memory as usize].fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl LimitError {
    /// The remedy for a program that uses the library.
    #[must_use]
    pub fn help(&self) -> String {
        format!("raise ResourceLimits::{}", self.resource.name())
    }

    /// A value of the limit that is worth a try, as [`ResourceLimits::set`] takes it: at least twice as much, and enough for what is needed as far as it is known.
    #[must_use]
    pub fn suggestion(&self) -> String {
        let twice = self.limit.saturating_mul(2).max(1);
        let needed = self.needed.map_or(0, |needed| needed.saturating_add(needed / 4));
        self.resource.value_above(twice.max(needed))
    }

    /// The option of the command line that sets the limit to the [suggestion](Self::suggestion).
    #[must_use]
    pub fn option(&self) -> String {
        let value = self.suggestion();
        match self.resource {
            Resource::Memory => format!("--memory {value}"),
            resource => format!("--limit {}={value}", resource.name()),
        }
    }
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { resource, limit, needed } = self;
        write!(f, "the limit of {} is exceeded", resource.amount(*limit))?;
        match needed {
            Some(needed) => write!(f, ": at least {} are needed", resource.amount(*needed)),
            None => Ok(()),
        }
    }
}

impl Error for LimitError {}

impl fmt::Display for BudgetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limit(limit) => limit.fmt(f),
            Self::Interrupted => Interrupted.fmt(f),
            Self::TemporaryFile { kind, code } => {
                write!(f, "the temporary file of large pictures fails: ")?;
                match code {
                    Some(code) => IoFault::sentence(&io::Error::from_raw_os_error(*code)).fmt(f),
                    None if *kind == io::ErrorKind::Unsupported => write!(f, "its folder is in memory"),
                    None => write!(f, "{kind}"),
                }
            }
        }
    }
}

impl Error for BudgetError {}

impl BudgetError {
    /// Its name in messages for programs: "limit", "interrupted" or "temporary-file".
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Limit(_) => "limit",
            Self::Interrupted => "interrupted",
            Self::TemporaryFile { .. } => "temporary-file",
        }
    }

    /// The remedy for a program that uses the library; `None` where none is needed.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Limit(limit) => Some(limit.help()),
            Self::Interrupted => None,
            Self::TemporaryFile { .. } => Some(
                "set TMPDIR to a folder with more room, or allow more memory, of which pictures take half"
                    .to_owned(),
            ),
        }
    }
}

impl From<ScratchFileError> for BudgetError {
    fn from(error: ScratchFileError) -> Self {
        Self::TemporaryFile { kind: error.kind, code: error.code }
    }
}
