//! Errors of building a model.

use std::num::TryFromIntError;

/// Errors of building the model of a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// More than a page can draw.
    #[error("the scene has {count} {what}; the viewer draws at most {most}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The number found.
        count: u64,
        /// The largest number allowed.
        most: u64,
    },
    /// The text of the model could not be written.
    #[error("the model cannot be written")]
    Text(#[from] serde_json::Error),
}

/// `count` as a number of 32 bits.
pub(super) fn number(what: &'static str, count: usize) -> Result<u32, ModelError> {
    let too_many =
        |_: TryFromIntError| ModelError::TooMany { what, count: count as u64, most: u64::from(u32::MAX) };
    u32::try_from(count).map_err(too_many)
}
