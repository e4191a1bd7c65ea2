//! Errors of image files.

use std::io;

use glanz_job::{BudgetError, MemoryReservation, Resource, ResourceBudget};
use glanz_light::PixelsError;

use super::Format;

/// Errors of reading and writing images.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Neither content nor extension is that of a supported format.
    #[error("this image format is not supported (it starts with {start:02x?})")]
    Unknown {
        /// The first bytes, at most eight.
        start: Vec<u8>,
    },
    /// The budget is used up, or its flag raised. Sizes are compared with it before anything is decoded.
    #[error("{format}: {end}")]
    Budget {
        /// Of the file.
        format: Format,
        /// The reason.
        end: BudgetError,
    },
    /// The header declares far more pixels than the format can pack into the bytes that follow.
    #[error("{format}: {width} x {height} pixels are declared, but the file has only {bytes} bytes")]
    Unbacked {
        /// Of the file.
        format: Format,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// Length of the file.
        bytes: usize,
    },
    /// The bytes contradict the format.
    #[error("{format}: {message}{}", at(*.offset))]
    Damaged {
        /// Of the file.
        format: Format,
        /// Offset in bytes from the start of the file, if known.
        offset: Option<usize>,
        /// The fault.
        message: String,
    },
    /// The file is (or may be) valid, but uses an unsupported feature.
    #[error("{format}: {message}")]
    Unsupported {
        /// Of the file.
        format: Format,
        /// The unsupported feature.
        message: String,
    },
    /// A picture that the format cannot hold.
    #[error("{format}: {message}")]
    NotWritable {
        /// To be written.
        format: Format,
        /// The reason.
        message: String,
    },
    /// The file that is written fails, or the rows of its picture.
    #[error("{0}")]
    Write(#[from] io::Error),
    /// Channels that do not form a picture.
    #[error(transparent)]
    Pixels(#[from] PixelsError),
}

fn at(offset: Option<usize>) -> String {
    offset.map(|o| format!(" (at byte {o})")).unwrap_or_default()
}

/// Up to this number of values, 64 MiB, the size is not compared with the length of the file.
const FREE_SAMPLES: u64 = 1 << 24;

/// Refuses large pictures that `bytes` bytes cannot contain even if each of them unpacks to `ratio` values, and takes the pixels off the budget.
pub(super) fn check_size(
    format: Format,
    (width, height, channels): (u64, u64, u64),
    bytes: usize,
    ratio: u64,
    budget: &ResourceBudget,
) -> Result<(), ImageError> {
    let pixels = width.saturating_mul(height);
    let samples = pixels.saturating_mul(channels);
    if samples > FREE_SAMPLES && samples / ratio > bytes as u64 {
        return Err(ImageError::Unbacked { format, width, height, bytes });
    }
    let spent = budget.check_now().and_then(|()| budget.spend(Resource::Pixels, pixels));
    spent.map_err(|end| ImageError::Budget { format, end })
}

/// Reserves the memory of decoding: `decoder` bytes, and 4 for each of `samples` values.
pub(super) fn reserve(
    format: Format,
    decoder: u64,
    samples: u64,
    budget: &ResourceBudget,
) -> Result<MemoryReservation, ImageError> {
    let all = samples.saturating_mul(size_of::<f32>() as u64).saturating_add(decoder);
    budget.reserve(all).map_err(|end| ImageError::Budget { format, end })
}
