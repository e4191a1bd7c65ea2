//! Formats with integers for pixels: PNG, JPEG, BMP, TGA, QOI, PNM.

use std::collections::BTreeMap;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::{Pixels, Tone};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits,
};

use super::error::{check_size, reserve};
use super::{Encoding, Format, Image, ImageError, rgb_of};
use crate::budget_reader::BudgetReader;

/// Largest number of values per byte of these formats: deflate compresses 1032 to 1, JPEG stores 512 pixels of 3 values in a byte.
const RATIO: u64 = 2048;

/// Reads one of the formats; integers are scaled to [0, 1] and decoded.
pub(super) fn read(
    bytes: &[u8],
    format: Format,
    encoding: Encoding,
    budget: &ResourceBudget,
) -> Result<(Image, MemoryReservation), ImageError> {
    let which = match format {
        Format::Png => ImageFormat::Png,
        Format::Jpeg => ImageFormat::Jpeg,
        Format::Bmp => ImageFormat::Bmp,
        Format::Tga => ImageFormat::Tga,
        Format::Qoi => ImageFormat::Qoi,
        Format::Pnm => ImageFormat::Pnm,
        Format::Exr | Format::Hdr | Format::Pfm => {
            return Err(ImageError::Unsupported { format, message: "not stored as integers".to_owned() });
        }
    };
    let mut reader = ImageReader::with_format(BudgetReader::new(bytes, budget), which);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget.limits().memory);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| decoding_error(format, e))?;
    let (width, height) = decoder.dimensions();
    let channels = decoder.color_type().channel_count();
    check_size(format, (width.into(), height.into(), channels.into()), bytes.len(), RATIO, budget)?;
    let decoded_bytes =
        decoder.total_bytes().saturating_mul(copies(format)).saturating_add(bytes.len() as u64);
    let samples = u64::from(width) * u64::from(height) * u64::from(channels);
    let memory = reserve(format, decoded_bytes, samples, budget)?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| decoding_error(format, e))?;
    let mut pixels = Pixels::try_new(width, height)?;
    let names: &[&str] = match channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    for (lane, name) in names.iter().enumerate() {
        budget.check().map_err(|end| ImageError::Budget { format, end })?;
        let linear = if *name == "A" { Encoding::Linear } else { encoding };
        pixels.add_channel(name, plane(&decoded, lane, names.len(), linear))?;
    }
    Ok((Image { pixels, format, attributes: BTreeMap::new(), skipped_layers: Vec::new() }, memory))
}

/// Copies of the pixels that a decoder needs, beside the bytes of the file.
fn copies(format: Format) -> u64 {
    match format {
        // Progressive pictures have two bytes for each coefficient.
        Format::Jpeg => 4,
        Format::Tga | Format::Pnm => 2,
        _ => 1,
    }
}

/// The linear values of one of `lanes` channels.
fn plane(decoded: &DynamicImage, lane: usize, lanes: usize, encoding: Encoding) -> Vec<f32> {
    let bytes = decoded.as_bytes();
    match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let table: Vec<f32> = (0..=255).map(|b| encoding.decode(b as f32 / 255.0)).collect();
            bytes.iter().skip(lane).step_by(lanes).map(|&b| table[usize::from(b)]).collect()
        }
        // The rest are 16 bit integers.
        _ => {
            let value = |word: &[u8; 2]| encoding.decode(f32::from(u16::from_ne_bytes(*word)) / 65535.0);
            bytes.as_chunks().0.iter().skip(lane).step_by(lanes).map(value).collect()
        }
    }
}

/// An 8 bit sRGB PNG of R, G, B (or Y) after `tone`.
pub(super) fn write_png(pixels: &Pixels, tone: &Tone) -> Result<Vec<u8>, ImageError> {
    let rgb = rgb_of(pixels, Format::Png)?;
    let colours: Vec<[u8; 3]> = rgb.into_iter().map(|p| tone.to_srgb8(p)).collect();
    write_srgb8(pixels.width(), pixels.height(), &colours)
}

/// An 8 bit PNG of sRGB bytes, row by row from the top left.
///
/// # Errors
/// [`ImageError::NotWritable`] if there are not `width` times `height` colours, or none.
pub fn write_srgb8(width: u32, height: u32, colours: &[[u8; 3]]) -> Result<Vec<u8>, ImageError> {
    let not_writable = |message: String| ImageError::NotWritable { format: Format::Png, message };
    let expected = u64::from(width) * u64::from(height);
    if colours.len() as u64 != expected {
        return Err(not_writable(format!("there are {} colours; {expected} are needed", colours.len())));
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(colours.as_flattened(), width, height, ExtendedColorType::Rgb8)
        .map_err(|e| not_writable(e.to_string()))?;
    Ok(bytes)
}

/// The error of the decoder as [`ImageError`].
pub(super) fn decoding_error(format: Format, error: image::ImageError) -> ImageError {
    let message = error.to_string();
    match error {
        image::ImageError::Unsupported(_) => ImageError::Unsupported { format, message },
        _ => ImageError::Damaged { format, offset: None, message },
    }
}
