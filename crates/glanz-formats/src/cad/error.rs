//! Errors.

use glanz_job::BudgetError;

use crate::iges::IgesError;
use crate::step::StepError;

/// Errors of reading a CAD file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum CadError {
    #[error(transparent)]
    Step(#[from] StepError),
    #[error(transparent)]
    Iges(#[from] IgesError),
    #[error(transparent)]
    Budget(#[from] BudgetError),
}
