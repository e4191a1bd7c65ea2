//! Pictures that are written some rows at a time.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, Write};
use std::ops::Range;

use glanz_light::{Pixels, PixelsError, Tone};

use super::{Format, ImageError, exr, hdr, pfm, raster};

/// Number of rows that are asked for at a time: that of a block of OpenEXR.
pub(super) const ROWS: u32 = 16;

/// A picture whose rows are not in memory yet.
#[derive(Clone, Copy, Debug)]
pub struct RowPicture<'a> {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Names of the channels that all its rows have.
    pub channels: &'a [&'a str],
    /// Conversion to the colours of a display, for PNG.
    pub tone: &'a Tone,
    /// Texts for the header of OpenEXR, by name.
    pub attributes: &'a BTreeMap<String, String>,
}

impl RowPicture<'_> {
    /// Ranges of its rows, from the top.
    pub(super) fn ranges(&self) -> impl DoubleEndedIterator<Item = Range<u32>> + use<> {
        let height = self.size[1];
        (0..height.div_ceil(ROWS)).map(move |part| part * ROWS..height.min((part + 1) * ROWS))
    }
}

/// Writes the file of a picture from the beginning of `out` on, which is empty. `rows` returns the picture of some rows, 16 at a time from the top, for PFM from
/// the bottom. The bytes depend on the arguments alone.
///
/// # Errors
/// [`ImageError::NotWritable`] for a format that is only read, or that cannot store the picture's channels; [`ImageError::Write`] for errors of `out` and of
/// `rows`.
pub fn write_rows(
    picture: &RowPicture<'_>,
    format: Format,
    out: &mut (impl Read + Write + Seek),
    mut rows: impl FnMut(Range<u32>) -> io::Result<Pixels> + Send,
) -> Result<(), ImageError> {
    let [width, height] = picture.size;
    if width == 0 || height == 0 {
        return Err(PixelsError::Size(width, height).into());
    }
    let rows = |range: Range<u32>| {
        let part = rows(range.clone())?;
        let fits = [part.width(), part.height()] == [width, range.end - range.start];
        if fits { Ok(part) } else { Err(io::Error::other("rows of another picture")) }
    };
    match format {
        Format::Exr => exr::write(picture, out, rows),
        Format::Hdr => hdr::write(picture, out, rows),
        Format::Pfm => pfm::write(picture, out, rows),
        Format::Png => raster::write_png(picture, out, rows),
        _ => Err(ImageError::NotWritable { format, message: "this format cannot be written".to_owned() }),
    }
}
