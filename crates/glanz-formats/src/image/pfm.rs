//! Portable float map: a text header and 32 bit floats, bottom row first (@debevecpfm).

use std::collections::BTreeMap;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;

use super::error::{check_size, reserve};
use super::{Format, Image, ImageError, rgb_of};

/// Reads a PFM; values are multiplied by the magnitude of the header's scale.
pub(super) fn read(bytes: &[u8], budget: &ResourceBudget) -> Result<(Image, MemoryReservation), ImageError> {
    let mut offset = 0;
    let mut word = |what: &str| -> Result<(&str, usize), ImageError> {
        let start = offset + bytes[offset..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        let length = bytes[start..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let text = std::str::from_utf8(&bytes[start..start + length]).unwrap_or("");
        // A single white space after the last word ends the header; data follow.
        offset = start + length;
        if text.is_empty() { Err(damaged(start, format!("{what} is missing"))) } else { Ok((text, start)) }
    };
    let number = |(text, at): (&str, usize)| -> Result<u64, ImageError> {
        text.parse().map_err(|_| damaged(at, format!("\"{text}\" is no number of pixels")))
    };
    let channels = match word("the mark")? {
        ("PF", _) => 3,
        ("Pf", _) => 1,
        (other, at) => return Err(damaged(at, format!("\"{other}\" is not PF or Pf"))),
    };
    let width = number(word("the width")?)?;
    let height = number(word("the height")?)?;
    let (text, at) = word("the scale")?;
    let scale: f32 = text.parse().unwrap_or(0.0);
    if scale == 0.0 || !scale.is_finite() {
        return Err(damaged(at, format!("\"{text}\" is no scale")));
    }
    check_size(Format::Pfm, (width, height, channels), bytes.len(), 1, budget)?;
    let data = bytes.get(offset + 1..).unwrap_or(&[]);
    let samples = width.saturating_mul(height).saturating_mul(channels);
    let memory = reserve(Format::Pfm, 0, samples, budget)?;
    let samples = samples as usize;
    if data.len() / 4 < samples {
        return Err(damaged(bytes.len(), format!("{} bytes of pixels, {} needed", data.len(), samples * 4)));
    }
    let planes = planes(&data[..samples * 4], width as usize, channels as usize, scale);
    let side = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
    let mut pixels = Pixels::try_new(side(width), side(height))?;
    let names: &[&str] = if channels == 3 { &["R", "G", "B"] } else { &["Y"] };
    for (name, plane) in names.iter().zip(planes) {
        pixels.add_channel(name, plane)?;
    }
    let attributes = BTreeMap::new();
    Ok((Image { pixels, format: Format::Pfm, attributes, skipped_layers: Vec::new() }, memory))
}

/// The rows of `data`, top one first, channel by channel.
fn planes(data: &[u8], width: usize, channels: usize, scale: f32) -> Vec<Vec<f32>> {
    let value = |bytes: &[u8]| {
        let word = <[u8; 4]>::try_from(bytes).unwrap_or([0; 4]);
        let stored = if scale < 0.0 { f32::from_le_bytes(word) } else { f32::from_be_bytes(word) };
        stored * scale.abs()
    };
    let rows = || data.chunks_exact((width * channels * 4).max(1)).rev();
    (0..channels)
        .map(|channel| {
            let mut plane = Vec::with_capacity(data.len() / 4 / channels);
            plane.extend(
                rows().flat_map(|row| row.chunks_exact(4).skip(channel).step_by(channels).map(value)),
            );
            plane
        })
        .collect()
}

/// Writes a little-endian PFM of the channels R, G, B, or of Y alone.
pub(super) fn write(pixels: &Pixels) -> Result<Vec<u8>, ImageError> {
    let (width, height) = (pixels.width(), pixels.height());
    let rgb = rgb_of(pixels, Format::Pfm)?;
    let grey = pixels.channel("R").is_none();
    let mut bytes = format!("{}\n{width} {height}\n-1.0\n", if grey { "Pf" } else { "PF" }).into_bytes();
    for row in rgb.chunks(width as usize).rev() {
        for pixel in row {
            let used = if grey { &pixel[..1] } else { &pixel[..] };
            bytes.extend(used.iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    Ok(bytes)
}

fn damaged(offset: usize, message: String) -> ImageError {
    ImageError::Damaged { format: Format::Pfm, offset: Some(offset), message }
}
