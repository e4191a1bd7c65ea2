//! Radiance pictures: three bytes of mantissa and one of exponent per pixel (@wardrgbe).

use std::collections::BTreeMap;
use std::io::Cursor;

use glanz_light::Pixels;
use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{DynamicImage, ImageDecoder};

use super::error::check_size;
use super::raster::decoding_error;
use super::{Format, Image, ImageError, rgb_of};

/// Run lengths pack at most 127 values into two bytes.
const RATIO: u64 = 64;

/// Reads a Radiance picture. As in other renderers, the header's exposure is returned as an attribute and not applied.
pub(super) fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|e| decoding_error(Format::Hdr, e))?;
    let (width, height) = decoder.dimensions();
    check_size(Format::Hdr, (width.into(), height.into(), 3), bytes.len(), RATIO)?;
    let attributes: BTreeMap<String, String> = decoder.metadata().custom_attributes.into_iter().collect();
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| decoding_error(Format::Hdr, e))?;
    let rgb: Vec<[f32; 3]> = decoded.into_rgb32f().pixels().map(|p| p.0).collect();
    let pixels = Pixels::try_from_rgb(width, height, &rgb)?;
    Ok(Image { pixels, format: Format::Hdr, attributes, skipped_layers: Vec::new() })
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
