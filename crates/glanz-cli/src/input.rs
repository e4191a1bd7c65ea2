//! Input files that are read whole, within limits.

use std::path::Path;

use glanz::formats::read_file;
use glanz::job::{BudgetError, ResourceBudget};
use glanz::{Error, FileFault};
use glanz_terminal::messages::{CommandError, Messages};

use crate::command_error::{command_error, limit_help};

/// The bytes of a regular file, which is taken off the budget.
///
/// # Errors
/// A file that cannot be read, or exceeds a limit.
pub(crate) fn read(
    path: &Path,
    budget: &ResourceBudget,
    messages: Messages,
) -> Result<Vec<u8>, CommandError> {
    read_file(path, budget).map_err(|error| match budget.failure() {
        Some(end) => with_limit_help(CommandError::new(format!("{}: {end}", path.display())), end),
        None => command_error(messages)(Error::File { path: path.to_owned(), fault: FileFault::Io(error) }),
    })
}

/// The error of an input with the option that raises the limit which ended reading.
pub(crate) fn with_limit_help(error: CommandError, end: BudgetError) -> CommandError {
    match end {
        BudgetError::Limit(limit) => error.with_help(limit_help(limit)),
        BudgetError::Interrupted => CommandError::interrupted("interrupted; nothing was written"),
        BudgetError::TemporaryFile { .. } => error.with_help(end.help().unwrap_or_default()),
    }
}
