//! Radiance pictures: three bytes of mantissa and one of exponent per pixel (@wardrgbe).

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Range;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;
use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{DynamicImage, ImageDecoder};

use super::error::{check_size, reserve};
use super::raster::decoding_error;
use super::{Format, Image, ImageError, RowPicture, rgb_of};
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
pub(super) fn write(
    picture: &RowPicture<'_>,
    out: &mut impl Write,
    mut rows: impl FnMut(Range<u32>) -> io::Result<Pixels>,
) -> Result<(), ImageError> {
    let [width, height] = picture.size;
    for range in picture.ranges() {
        let rgb = rgb_of(&rows(range.clone())?, Format::Hdr)?;
        let rgb: Vec<image::Rgb<f32>> = rgb.into_iter().map(|p| image::Rgb(into_range(p))).collect();
        let mut bytes = Vec::new();
        let not_writable = |message| ImageError::NotWritable { format: Format::Hdr, message };
        HdrEncoder::new(&mut bytes)
            .encode(&rgb, width as usize, range.len())
            .map_err(|e| not_writable(e.to_string()))?;
        // Each row is coded by itself. The header, which ends with the line of the size, is written once.
        let split = split_header(&bytes).ok_or_else(|| not_writable("the header is broken".to_owned()))?;
        if range.start == 0 {
            out.write_all(split.attributes)?;
            writeln!(out, "-Y {height} +X {width}")?;
        }
        out.write_all(split.rows)?;
    }
    Ok(())
}

/// The parts of a file around the line of its size.
struct HdrParts<'a> {
    attributes: &'a [u8],
    rows: &'a [u8],
}

fn split_header(bytes: &[u8]) -> Option<HdrParts<'_>> {
    let size = bytes.windows(2).position(|pair| pair == b"\n\n")? + 2;
    let (attributes, rest) = bytes.split_at_checked(size)?;
    let line = rest.iter().position(|byte| *byte == b'\n')?;
    Some(HdrParts { attributes, rows: rest.get(line + 1..)? })
}

fn into_range(rgb: [f32; 3]) -> [f32; 3] {
    const MOST: f32 = 1.7e38;
    // The smallest normal f32, 2^-126: below it the exponent byte would wrap.
    let some = rgb.iter().any(|&x| x >= f32::MIN_POSITIVE);
    rgb.map(|x| if some && x > 0.0 { x.min(MOST) } else { 0.0 })
}
