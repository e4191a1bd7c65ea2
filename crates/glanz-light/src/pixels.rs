//! Pictures as named planes of pixels.

use std::ops::Range;

use crate::rgb::srgb_decode;

/// One named plane of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// `R`, `Albedo.G`, `Z`, ... as in OpenEXR.
    pub name: String,
    /// Row by row from the top left.
    pub values: Vec<f32>,
}

/// Errors of making a picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PixelsError {
    /// Width or height is zero, or there are more than 2^31 pixels.
    #[error("the picture has {0} x {1} pixels; it must have 1 to 2^31")]
    Size(u32, u32),
    /// The number of values is not width times height.
    #[error("channel \"{name}\" has {found} values; {expected} are needed")]
    Length {
        /// Name of the channel.
        name: String,
        /// Its number of values.
        found: usize,
        /// Width times height.
        expected: usize,
    },
    /// The picture already has a channel of that name.
    #[error("channel \"{0}\" exists already; names must be unique")]
    Duplicate(String),
}

/// A picture of named `f32` planes; R, G, B and Y are linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    width: u32,
    height: u32,
    channels: Vec<Channel>,
}

impl Pixels {
    /// A picture without channels.
    ///
    /// # Errors
    /// [`PixelsError::Size`] if width or height is zero or there are more than 2^31 pixels.
    pub fn try_new(width: u32, height: u32) -> Result<Self, PixelsError> {
        let count = u64::from(width) * u64::from(height);
        if count == 0 || count > 1 << 31 {
            return Err(PixelsError::Size(width, height));
        }
        Ok(Self { width, height, channels: Vec::new() })
    }

    /// A picture of the channels R, G and B.
    ///
    /// # Errors
    /// As [`Pixels::try_new`] and [`Pixels::add_channel`]; `rgb` holds width * height triples.
    pub fn try_from_rgb(width: u32, height: u32, rgb: &[[f32; 3]]) -> Result<Self, PixelsError> {
        let mut pixels = Self::try_new(width, height)?;
        for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
            pixels.add_channel(name, rgb.iter().map(|p| p[i]).collect())?;
        }
        Ok(pixels)
    }

    /// A picture of the channels R, G and B in linear light from sRGB bytes, row by row from the top left.
    ///
    /// # Errors
    /// As [`Pixels::try_from_rgb`].
    pub fn try_from_srgb8(width: u32, height: u32, colours: &[[u8; 3]]) -> Result<Self, PixelsError> {
        let light: [f32; 256] = std::array::from_fn(|byte| srgb_decode(byte as f32 / 255.0));
        let rgb: Vec<[f32; 3]> =
            colours.iter().map(|colour| colour.map(|byte| light[usize::from(byte)])).collect();
        Self::try_from_rgb(width, height, &rgb)
    }

    /// Adds the plane `name`.
    ///
    /// # Errors
    /// [`PixelsError::Length`] or [`PixelsError::Duplicate`].
    pub fn add_channel(&mut self, name: &str, values: Vec<f32>) -> Result<(), PixelsError> {
        let expected = self.len();
        if values.len() != expected {
            return Err(PixelsError::Length { name: name.to_owned(), found: values.len(), expected });
        }
        if self.channel(name).is_some() {
            return Err(PixelsError::Duplicate(name.to_owned()));
        }
        self.channels.push(Channel { name: name.to_owned(), values });
        Ok(())
    }

    /// Replaces the channels R, G and B, or adds them.
    ///
    /// # Errors
    /// As [`Pixels::add_channel`].
    pub fn set_rgb(&mut self, rgb: &[[f32; 3]]) -> Result<(), PixelsError> {
        for (band, name) in ["R", "G", "B"].into_iter().enumerate() {
            let values: Vec<f32> = rgb.iter().map(|pixel| pixel[band]).collect();
            let expected = self.len();
            match self.channels.iter_mut().find(|channel| channel.name == name) {
                Some(channel) if values.len() == expected => channel.values = values,
                Some(_) => {
                    return Err(PixelsError::Length { name: name.to_owned(), found: values.len(), expected });
                }
                None => self.add_channel(name, values)?,
            }
        }
        Ok(())
    }

    /// The picture of some of its rows.
    ///
    /// # Errors
    /// [`PixelsError::Size`] for no rows, and [`PixelsError::Length`] for rows that the picture has not.
    pub fn rows(&self, rows: Range<u32>) -> Result<Self, PixelsError> {
        let mut part = Self::try_new(self.width, rows.end.saturating_sub(rows.start))?;
        let values = rows.start as usize * self.width as usize..rows.end as usize * self.width as usize;
        for Channel { name, values: all } in &self.channels {
            part.add_channel(name, all.get(values.clone()).unwrap_or_default().to_vec())?;
        }
        Ok(part)
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of pixels.
    #[must_use]
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// `false`: a picture has at least one pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// All planes, in the order they were added.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The plane `name`.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| c.values.as_slice())
    }

    /// The planes R, G and B as triples, or the plane Y as grey; `None` if there are neither.
    #[must_use]
    pub fn to_rgb(&self) -> Option<Vec<[f32; 3]>> {
        if let (Some(r), Some(g), Some(b)) = (self.channel("R"), self.channel("G"), self.channel("B")) {
            return Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect());
        }
        self.channel("Y").map(|y| y.iter().map(|&y| [y; 3]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::Tone;

    #[test]
    fn every_srgb_byte_comes_back() {
        let colours: Vec<[u8; 3]> = (0..=255).map(|byte| [byte, 255 - byte, byte ^ 0x55]).collect();
        let pixels = Pixels::try_from_srgb8(16, 16, &colours).unwrap();
        let back: Vec<_> =
            pixels.to_rgb().unwrap().into_iter().map(|p| Tone::default().to_srgb8(p)).collect();
        assert_eq!(back, colours);
        assert!(Pixels::try_from_srgb8(2, 2, &colours[..3]).is_err());
    }
}
