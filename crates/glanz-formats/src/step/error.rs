//! Errors.

use glanz_job::BudgetError;

/// Errors of reading a STEP file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The first line of a STEP file is missing.
    #[error("the file does not begin with ISO-10303-21; it is no STEP file")]
    NotStep,
    /// There is no data section.
    #[error("the file has no section DATA; it may be incomplete")]
    NoData,
    /// The file is too large.
    #[error("the file has {0} bytes; fewer than 2^32 can be read")]
    TooLarge(usize),
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}
