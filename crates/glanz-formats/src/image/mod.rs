//! Picture files.
//!
//! [`read`] takes the bytes of a file, recognises the format by content (by extension if the content has no signature)
//! and returns named planes of linear light. [`write()`] converts planes to bytes, [`write_srgb8`] display colours to a PNG, in memory; [`write_rows`] writes a file
//! of which some rows are in memory at a time.
//!
//! | format | read | written | planes |
//! |---|---|---|---|
//! | OpenEXR | 16 and 32 bit, all layers | 32 bit float, ZIP | any names |
//! | Radiance HDR | yes | yes | `R`, `G`, `B` |
//! | PFM | yes | yes | `R`, `G`, `B` or `Y` |
//! | PNG | 1 to 16 bit | 8 bit sRGB through a tone curve | `R`, `G`, `B` or `Y`, and `A` |
//! | JPEG, BMP, TGA, QOI, PNM | yes | no | as PNG |
//!
//! ```
//! use std::collections::BTreeMap;
//! use glanz_formats::image::{read, write, Encoding, Format};
//! use glanz_light::{Pixels, Tone};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let picture = Pixels::try_from_rgb(2, 1, &[[0.25, 0.5, 1.0], [4.0, 2.0, 0.0]])?;
//! let bytes = write(&picture, Format::Exr, &Tone::default(), &BTreeMap::new())?;
//! assert_eq!(Format::from_content(&bytes), Some(Format::Exr));
//! let again = read(&bytes, None, Encoding::Srgb)?;
//! assert_eq!(again.pixels.to_rgb(), picture.to_rgb());
//! # Ok(())
//! # }
//! ```
//!
//! For any bytes, [`read`] returns a picture or an [`ImageError`]. The size in the header is compared with a [`ResourceBudget`], and that of large pictures with the
//! length of the file, before anything is decoded: at the peak, the decoder's pixels and 4 bytes per value.

mod error;
mod exr;
mod hdr;
mod pfm;
mod raster;
mod rows;

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Cursor};
use std::path::Path;

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::rgb::srgb_decode;
use glanz_light::{Pixels, Tone};

pub use error::ImageError;
pub use raster::write_srgb8;
pub use rows::{RowPicture, write_rows};

/// A picture with the data of its file header.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The planes.
    pub pixels: Pixels,
    /// The file's format.
    pub format: Format,
    /// Texts in the file's header, by name.
    pub attributes: BTreeMap<String, String>,
    /// Layers of an OpenEXR file that are not in `pixels`, because their size differs from that of the first layer.
    pub skipped_layers: Vec<String>,
}

/// A file format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Radiance picture with shared exponents (RGBE).
    Hdr,
    /// Portable float map.
    Pfm,
    /// Portable network graphics.
    Png,
    /// JPEG (JFIF or Exif).
    Jpeg,
    /// Windows bitmap.
    Bmp,
    /// Truevision TGA, the only format without a signature at its start.
    Tga,
    /// Quite OK image format.
    Qoi,
    /// Portable bit, grey or pixel map, or PAM.
    Pnm,
}

impl Format {
    /// The format whose signature the bytes begin with. TGA has none and is never recognised.
    #[must_use]
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        const MARKS: &[(&[u8], Format)] = &[
            (&[0x76, 0x2f, 0x31, 0x01], Format::Exr),
            (b"#?RADIANCE", Format::Hdr),
            (b"#?RGBE", Format::Hdr),
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (&[0xff, 0xd8, 0xff], Format::Jpeg),
            (b"qoif", Format::Qoi),
            (b"BM", Format::Bmp),
        ];
        if let Some(&(_, format)) = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) {
            return Some(format);
        }
        match bytes {
            [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace() => Some(Self::Pfm),
            [b'P', b'1'..=b'7', space, ..] if space.is_ascii_whitespace() => Some(Self::Pnm),
            _ => None,
        }
    }

    /// The format by the extension of the file name `path`, in lower or upper case.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "exr" => Self::Exr,
            "hdr" | "pic" | "rgbe" => Self::Hdr,
            "pfm" => Self::Pfm,
            "png" => Self::Png,
            "jpg" | "jpeg" => Self::Jpeg,
            "bmp" => Self::Bmp,
            "tga" => Self::Tga,
            "qoi" => Self::Qoi,
            "pnm" | "pbm" | "pgm" | "ppm" | "pam" => Self::Pnm,
            _ => return None,
        })
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exr => "OpenEXR",
            Self::Hdr => "Radiance HDR",
            Self::Pfm => "PFM",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Bmp => "BMP",
            Self::Tga => "TGA",
            Self::Qoi => "QOI",
            Self::Pnm => "PNM",
        })
    }
}

/// Meaning of the integers in a file. Formats that store floats are always linear, as is the channel `A`.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Encoding {
    /// Colour for a display, decoded to linear light.
    #[default]
    Srgb,
    /// Linear light, or data (normals, roughness, masks).
    Linear,
    /// Linear light to the power of one over this.
    Gamma(f32),
}

impl Encoding {
    /// Linear value of a stored value, both in [0, 1].
    #[must_use]
    pub fn decode(self, stored: f32) -> f32 {
        match self {
            Self::Srgb => srgb_decode(stored),
            Self::Linear => stored,
            Self::Gamma(gamma) => stored.powf(gamma),
        }
    }
}

/// Reads a picture. `bytes`: the whole file; `path`: its name, where known, for formats without a signature.
///
/// # Errors
/// Every variant of [`ImageError`] except [`ImageError::NotWritable`]; the limits are those of the machine.
pub fn read(bytes: &[u8], path: Option<&Path>, encoding: Encoding) -> Result<Image, ImageError> {
    read_with(bytes, path, encoding, &ResourceBudget::default())
}

/// As [`read`] within a budget, from which the planes of the picture stay taken.
///
/// # Errors
/// Every variant of [`ImageError`] except [`ImageError::NotWritable`].
pub fn read_with(
    bytes: &[u8],
    path: Option<&Path>,
    encoding: Encoding,
    budget: &ResourceBudget,
) -> Result<Image, ImageError> {
    let (image, memory) = read_reserved(bytes, path, encoding, budget)?;
    memory.keep();
    Ok(image)
}

/// As [`read_with`], with the reserved memory of the planes.
pub(crate) fn read_reserved(
    bytes: &[u8],
    path: Option<&Path>,
    encoding: Encoding,
    budget: &ResourceBudget,
) -> Result<(Image, MemoryReservation), ImageError> {
    let format = Format::from_content(bytes).or_else(|| path.and_then(Format::from_path));
    let Some(format) = format else {
        return Err(ImageError::Unknown { start: bytes.iter().take(8).copied().collect() });
    };
    let read = match format {
        Format::Exr => exr::read(bytes, budget),
        Format::Hdr => hdr::read(bytes, budget),
        Format::Pfm => pfm::read(bytes, budget),
        _ => raster::read(bytes, format, encoding, budget),
    };
    // A decoder may report that its reader has ended as any other fault.
    let (image, mut memory) =
        read.map_err(|error| budget.failure().map_or(error, |end| ImageError::Budget { format, end }))?;
    let values = image.pixels.len() * image.pixels.channels().len();
    memory.shrink((values * size_of::<f32>()) as u64);
    Ok((image, memory))
}

/// The bytes of a file with the picture. `tone` applies only to formats that store bytes for a display (PNG);
/// `attributes` are written to the header of OpenEXR and ignored by the other formats. The bytes depend on the arguments
/// alone.
///
/// # Errors
/// [`ImageError::NotWritable`] for a format that is only read, or that cannot store the picture's channels.
pub fn write(
    pixels: &Pixels,
    format: Format,
    tone: &Tone,
    attributes: &BTreeMap<String, String>,
) -> Result<Vec<u8>, ImageError> {
    let channels: Vec<&str> = pixels.channels().iter().map(|channel| channel.name.as_str()).collect();
    let size = [pixels.width(), pixels.height()];
    let picture = RowPicture { size, channels: &channels, tone, attributes };
    let mut bytes = Cursor::new(Vec::new());
    write_rows(&picture, format, &mut bytes, |rows| pixels.rows(rows).map_err(io::Error::other))?;
    Ok(bytes.into_inner())
}

/// The colour of each pixel, or an error with the missing channels.
fn rgb_of(pixels: &Pixels, format: Format) -> Result<Vec<[f32; 3]>, ImageError> {
    pixels.to_rgb().ok_or_else(|| ImageError::NotWritable {
        format,
        message: "the picture has neither the channels R, G, B nor the channel Y".to_owned(),
    })
}

#[cfg(test)]
mod tests;
