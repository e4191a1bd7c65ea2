//! Errors.

use glanz_job::BudgetError;

/// Errors of reading an IGES file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IgesError {
    /// The first record does not belong to a section.
    #[error("the file does not begin with a record of 80 characters of section S; it is no IGES file")]
    NotIges,
    /// The file is in the compressed form.
    #[error(
        "the file is in the compressed form of IGES, which is not read; save it with records of 80 characters"
    )]
    Compressed,
    /// There is no directory section.
    #[error("the file has no directory entries (section D); it may be incomplete")]
    NoDirectory,
    /// The file is too large.
    #[error("the file has {0} bytes; fewer than 2^32 can be read")]
    TooLarge(usize),
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}
