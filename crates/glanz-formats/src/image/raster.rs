//! Formats with integers for pixels: PNG, JPEG, BMP, TGA, QOI, PNM.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Range;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::error::{check_size, reserve};
use super::{Encoding, Format, Image, ImageError, RowPicture, rgb_of};
use crate::budget_reader::BudgetReader;

/// Largest number of values per byte of these formats: deflate compresses 1032 to 1, JPEG stores 512 pixels of 3 values in a byte.
const RATIO: u64 = 2048;

/// Most bytes that the head of a picture may unpack to, such as a profile of its colours, beside those of the file.
const HEAD: u64 = 16 << 20;

/// Size of the parts of a PNG's data, bytes.
const CHUNK: usize = 1 << 18;

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
    let head = HEAD.min(budget.limits().memory / 8).saturating_add(bytes.len() as u64);
    // Only the decoder of PNG unpacks any of it.
    let is_png = format == Format::Png;
    limits.max_alloc = Some(if is_png { head } else { budget.limits().memory });
    let reserved = budget.reserve(if is_png { head } else { 0 });
    let _head = reserved.map_err(|end| ImageError::Budget { format, end })?;
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

/// Writes an 8 bit sRGB PNG of R, G, B (or Y) after the tone curve.
pub(super) fn write_png(
    picture: &RowPicture<'_>,
    out: &mut impl Write,
    mut rows: impl FnMut(Range<u32>) -> io::Result<Pixels>,
) -> Result<(), ImageError> {
    let strips = picture.ranges().map(|range| {
        let rgb = rgb_of(&rows(range)?, Format::Png)?;
        Ok(Cow::Owned(rgb.into_iter().map(|p| picture.tone.to_srgb8(p)).collect()))
    });
    write_strips(picture.size, strips, out)
}

/// Writes an 8 bit PNG of strips of sRGB bytes.
fn write_strips<'a>(
    [width, height]: [u32; 2],
    strips: impl Iterator<Item = Result<Cow<'a, [[u8; 3]]>, ImageError>>,
    out: &mut impl Write,
) -> Result<(), ImageError> {
    let failed = |error: png::EncodingError| match error {
        png::EncodingError::IoError(error) => ImageError::Write(error),
        other => ImageError::NotWritable { format: Format::Png, message: other.to_string() },
    };
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    let mut writer = encoder.write_header().map_err(failed)?;
    let mut stream = writer.stream_writer_with_size(CHUNK).map_err(failed)?;
    for strip in strips {
        stream.write_all(strip?.as_flattened())?;
    }
    stream.finish().map_err(failed)?;
    writer.finish().map_err(failed)
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
    write_strips([width, height], std::iter::once(Ok(Cow::Borrowed(colours))), &mut bytes)?;
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
