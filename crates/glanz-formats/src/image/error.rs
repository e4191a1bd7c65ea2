//! Errors of image files.

use std::io;

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
    /// The picture has more pixels or samples than the limits allow.
    #[error("{format}: {width} x {height} pixels with {channels} channels are more than the limit")]
    TooLarge {
        /// Of the file.
        format: Format,
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// Values per pixel.
        channels: u64,
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

/// Largest number of pixels of a picture: more than any camera or map in use has, and within available memory.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Largest number of values (pixels times channels) of a picture.
pub const MAX_SAMPLES: u64 = 1 << 30;

/// Up to this number of values, 64 MiB, the size is not compared with the length of the file.
const FREE_SAMPLES: u64 = 1 << 24;

/// Refuses pictures that are too large, and large ones that `bytes` bytes cannot contain even if each of them
/// unpacks to `ratio` values.
pub(super) fn check_size(
    format: Format,
    (width, height, channels): (u64, u64, u64),
    bytes: usize,
    ratio: u64,
) -> Result<(), ImageError> {
    let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS);
    let samples = pixels.and_then(|n| n.checked_mul(channels)).filter(|&n| n <= MAX_SAMPLES);
    let Some(samples) = samples else {
        return Err(ImageError::TooLarge { format, width, height, channels });
    };
    if samples > FREE_SAMPLES && samples / ratio > bytes as u64 {
        return Err(ImageError::Unbacked { format, width, height, bytes });
    }
    Ok(())
}
