//! Pictures side by side, each with two lines of text above.

use glanz_light::{Pixels, PixelsError};

use crate::raster::{LETTER_HEIGHT, Raster, fitting};

/// Width up to which pictures are enlarged, in whole steps.
const WIDTH: u32 = 320;

/// Pixels between pictures, and around letters.
const GAP: u32 = 6;

/// Linear grey of the background and of the letters.
const PAPER: [f32; 3] = [0.02; 3];
const INK: [f32; 3] = [0.9; 3];

/// A picture of a contact sheet.
#[derive(Clone, Debug)]
pub struct SheetPanel {
    /// The lines above it.
    pub lines: [String; 2],
    /// The picture, in linear light.
    pub pixels: Pixels,
}

/// Rows of pictures as one picture in linear light. All pictures have the size of the first one; rows may have different
/// lengths.
///
/// # Errors
/// [`PixelsError`] if the sheet is too large.
pub fn contact_sheet(rows: &[Vec<SheetPanel>]) -> Result<Pixels, PixelsError> {
    let size = rows.iter().flatten().next().map_or([1, 1], |p| [p.pixels.width(), p.pixels.height()]);
    let scale = WIDTH.div_ceil(size[0]);
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as u32;
    let letter = if scale * size[0] >= WIDTH { 2 } else { 1 };
    let head = 2 * (LETTER_HEIGHT * letter + GAP) + GAP;
    let cell = [scale * size[0] + GAP, scale * size[1] + head];
    let (width, height) = (columns * cell[0] + GAP, rows.len().max(1) as u32 * cell[1] + GAP);
    // Checks the size before anything is allocated for it.
    let _ = Pixels::try_new(width, height)?;
    let mut raster = Raster::new([width, height], PAPER);
    for (y, row) in (0_u32..).zip(rows) {
        for (x, panel) in (0_u32..).zip(row) {
            let corner = [GAP + x * cell[0], y * cell[1]];
            for (line, text) in (0_u32..).zip(&panel.lines) {
                let top = corner[1] + GAP + line * (LETTER_HEIGHT * letter + GAP);
                raster.write([corner[0], top], &fitting(text, cell[0] - GAP, letter), letter, INK);
            }
            let colours = panel.pixels.to_rgb().unwrap_or_default();
            for (i, colour) in (0_u32..).zip(colours) {
                let (px, py) = (i % size[0], i / size[0]);
                let place = [corner[0] + scale * px, corner[1] + head + scale * py];
                raster.fill(place, [scale, scale], colour);
            }
        }
    }
    Pixels::try_from_rgb(width, height, raster.pixels())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side_under_their_names() {
        let grey = |value: f32| Pixels::try_from_rgb(2, 1, &[[value; 3]; 2]).unwrap();
        let (dark, bright) = (grey(0.25), grey(0.5));
        let panel =
            |pixels: &Pixels| SheetPanel { lines: ["I".into(), String::new()], pixels: pixels.clone() };
        let sheet = contact_sheet(&[vec![panel(&dark), panel(&bright)], vec![panel(&bright)]]).unwrap();
        // Pixels of 160 x 160 under two lines of letters of 14 rows, with 6 around everything.
        assert_eq!((sheet.width(), sheet.height()), (2 * 326 + 6, 2 * (160 + 46) + 6));
        let rgb = sheet.to_rgb().unwrap();
        let at = |x: usize, y: usize| rgb[y * 658 + x][0];
        assert_eq!((at(6, 46), at(325, 205), at(326, 100), at(332, 46)), (0.25, 0.25, 0.02, 0.5));
        assert_eq!((at(6, 252), at(332, 252)), (0.5, 0.02));
        // The letter I: its upper bar begins in the second of its five dots.
        assert_eq!((at(7, 6), at(8, 6), at(13, 7), at(14, 6)), (0.02, 0.9, 0.9, 0.02));
    }
}
