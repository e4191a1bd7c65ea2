//! Formats with integers for pixels: PNG, JPEG, BMP, TGA, QOI, PNM.

use std::collections::BTreeMap;
use std::io::Cursor;

use glanz_light::{Pixels, Tone};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits,
};

use super::error::check_size;
use super::{Encoding, Format, Image, ImageError, MAX_SAMPLES, rgb_of};

/// Largest number of values per byte of these formats: deflate compresses 1032 to 1, JPEG stores 512 pixels of 3 values in a byte.
const RATIO: u64 = 2048;

/// Reads one of the formats; integers are scaled to [0, 1] and decoded.
pub(super) fn read(bytes: &[u8], format: Format, encoding: Encoding) -> Result<Image, ImageError> {
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
    let mut reader = ImageReader::with_format(Cursor::new(bytes), which);
    let mut limits = Limits::no_limits();
    // A decoder may store the picture twice, with 2 bytes per value.
    limits.max_alloc = Some(4 * MAX_SAMPLES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| decoding_error(format, e))?;
    let (width, height) = decoder.dimensions();
    let channels = decoder.color_type().channel_count();
    check_size(format, (width.into(), height.into(), channels.into()), bytes.len(), RATIO)?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| decoding_error(format, e))?;
    let mut pixels = Pixels::try_new(width, height)?;
    for (name, values) in planes(&decoded, encoding) {
        pixels.add_channel(name, values)?;
    }
    Ok(Image { pixels, format, attributes: BTreeMap::new(), skipped_layers: Vec::new() })
}

/// Names and linear values of the channels of `decoded`.
fn planes(decoded: &DynamicImage, encoding: Encoding) -> Vec<(&'static str, Vec<f32>)> {
    let names: &[&'static str] = match decoded.color().channel_count() {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let decode = |name: &str, stored: f32| if name == "A" { stored } else { encoding.decode(stored) };
    let each = |value: &dyn Fn(&str, usize) -> Vec<f32>| {
        names.iter().enumerate().map(|(i, &name)| (name, value(name, i))).collect()
    };
    match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => each(&|name, i| {
            let table: Vec<f32> = (0..=255).map(|b| decode(name, b as f32 / 255.0)).collect();
            let bytes = decoded.as_bytes().iter().skip(i).step_by(names.len());
            bytes.map(|&b| table[usize::from(b)]).collect()
        }),
        _ => {
            // The rest are 16 bit integers; the conversion to float divides by 65535.
            let wide = decoded.to_rgba32f();
            let grey_alpha = names == ["Y", "A"];
            each(&|name, i| {
                let lane = if grey_alpha && i == 1 { 3 } else { i };
                wide.pixels().map(|p| decode(name, p.0[lane])).collect()
            })
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
