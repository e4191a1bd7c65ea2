//! Radiance pictures: three bytes of mantissa and one of exponent per pixel (@wardrgbe).

use std::collections::BTreeMap;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;
use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{DynamicImage, ImageDecoder};

use super::error::{check_size, reserve};
use super::raster::decoding_error;
use super::{Format, Image, ImageError, rgb_of};
use crate::budget_reader::BudgetReader;

/// Run lengths pack at most 127 values into two bytes.
const RATIO: u64 = 64;

/// Reads a Radiance picture. As in other renderers, the header's exposure is returned as an attribute and not applied.
pub(super) fn read(bytes: &[u8], budget: &ResourceBudget) -> Result<(Image, MemoryReservation), ImageError> {
    let reader = BudgetReader::new(bytes, budget);
    let decoder = HdrDecoder::new(reader).map_err(|e| decoding_error(Format::Hdr, e))?;
    let (width, height) = decoder.dimensions();
    check_size(Format::Hdr, (width.into(), height.into(), 3), bytes.len(), RATIO, budget)?;
    let memory =
        reserve(Format::Hdr, decoder.total_bytes(), u64::from(width) * u64::from(height) * 3, budget)?;
    let attributes: BTreeMap<String, String> = decoder.metadata().custom_attributes.into_iter().collect();
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| decoding_error(Format::Hdr, e))?;
    let values = decoded.into_rgb32f().into_raw();
    let mut pixels = Pixels::try_new(width, height)?;
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        pixels.add_channel(name, values.iter().skip(channel).step_by(3).copied().collect())?;
    }
    Ok((Image { pixels, format: Format::Hdr, attributes, skipped_layers: Vec::new() }, memory))
}

/// A Radiance picture of R, G, B (or Y). The format has no negative light, no infinity, no values above 2^127 or
/// below 2^-128: such values and NaN are brought into range.
pub(super) fn write(pixels: &Pixels) -> Result<Vec<u8>, ImageError> {
    let rgb: Vec<image::Rgb<f32>> =
        rgb_of(pixels, Format::Hdr)?.into_iter().map(|p| image::Rgb(into_range(p))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes)
        .encode(&rgb, pixels.width() as usize, pixels.height() as usize)
        .map_err(|e| ImageError::NotWritable { format: Format::Hdr, message: e.to_string() })?;
    Ok(bytes)
}

fn into_range(rgb: [f32; 3]) -> [f32; 3] {
    const MOST: f32 = 1.7e38;
    // The smallest normal f32, 2^-126: below it the exponent byte would wrap.
    let some = rgb.iter().any(|&x| x >= f32::MIN_POSITIVE);
    rgb.map(|x| if some && x > 0.0 { x.min(MOST) } else { 0.0 })
}
