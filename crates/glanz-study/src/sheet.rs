//! Pictures side by side, each with its name above.

use glanz_illumination::report::lettering::{ADVANCE, HEIGHT, dots};
use glanz_light::{Pixels, PixelsError};

/// Small pictures are shown with larger pixels until they are this wide.
const WIDTH: u32 = 320;

/// Pixels between pictures, and around letters.
const GAP: u32 = 6;

/// Linear grey of the background and of the letters.
const PAPER: [f32; 3] = [0.02; 3];
const INK: [f32; 3] = [0.9; 3];

/// A picture and the lines above it.
pub(crate) struct Panel {
    pub(crate) lines: [String; 2],
    pub(crate) pixels: Pixels,
}

/// Rows of panels in linear light; all pictures have one size, and rows may have different lengths.
///
/// # Errors
/// [`PixelsError`] if the sheet is too large.
pub(crate) fn sheet(rows: &[Vec<Panel>]) -> Result<Pixels, PixelsError> {
    let size = rows.iter().flatten().next().map_or([1, 1], |p| [p.pixels.width(), p.pixels.height()]);
    let scale = WIDTH.div_ceil(size[0]);
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as u32;
    let letter = if scale * size[0] >= WIDTH { 2 } else { 1 };
    let head = 2 * (HEIGHT * letter + GAP) + GAP;
    let cell = [scale * size[0] + GAP, scale * size[1] + head];
    let (width, height) = (columns * cell[0] + GAP, rows.len().max(1) as u32 * cell[1] + GAP);
    // Checks the size before anything is allocated for it.
    let _ = Pixels::try_new(width, height)?;
    let mut canvas = Canvas { width, rgb: vec![PAPER; width as usize * height as usize] };
    for (y, row) in (0_u32..).zip(rows) {
        for (x, panel) in (0_u32..).zip(row) {
            let corner = [GAP + x * cell[0], y * cell[1]];
            for (line, text) in (0_u32..).zip(&panel.lines) {
                let top = corner[1] + GAP + line * (HEIGHT * letter + GAP);
                let fitting = (cell[0] - GAP) / (ADVANCE * letter);
                let text: String = text.chars().take(fitting as usize).collect();
                for [dx, dy] in dots(&text) {
                    canvas.fill([corner[0] + letter * dx, top + letter * dy], letter, INK);
                }
            }
            let colours = panel.pixels.to_rgb().unwrap_or_default();
            for (i, colour) in (0_u32..).zip(colours) {
                let (px, py) = (i % size[0], i / size[0]);
                canvas.fill([corner[0] + scale * px, corner[1] + head + scale * py], scale, colour);
            }
        }
    }
    Pixels::try_from_rgb(width, height, &canvas.rgb)
}

struct Canvas {
    width: u32,
    rgb: Vec<[f32; 3]>,
}

impl Canvas {
    /// A square; what lies outside is left out.
    fn fill(&mut self, [left, top]: [u32; 2], side: u32, colour: [f32; 3]) {
        for y in top..top + side {
            for x in left..(left + side).min(self.width) {
                let index = y as usize * self.width as usize + x as usize;
                if let Some(pixel) = self.rgb.get_mut(index) {
                    *pixel = colour;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side_under_their_names() {
        let grey = |value: f32| Pixels::try_from_rgb(2, 1, &[[value; 3]; 2]).unwrap();
        let (dark, bright) = (grey(0.25), grey(0.5));
        let panel = |pixels: &Pixels| Panel { lines: ["I".into(), String::new()], pixels: pixels.clone() };
        let made = sheet(&[vec![panel(&dark), panel(&bright)], vec![panel(&bright)]]).unwrap();
        // Pixels of 160 x 160 under two lines of letters of 14 rows, with 6 around everything.
        assert_eq!((made.width(), made.height()), (2 * 326 + 6, 2 * (160 + 46) + 6));
        let rgb = made.to_rgb().unwrap();
        let at = |x: usize, y: usize| rgb[y * 658 + x][0];
        assert_eq!((at(6, 46), at(325, 205), at(326, 100), at(332, 46)), (0.25, 0.25, 0.02, 0.5));
        assert_eq!((at(6, 252), at(332, 252)), (0.5, 0.02));
        // The letter I: its upper bar begins in the second of its five dots.
        assert_eq!((at(7, 6), at(8, 6), at(13, 7), at(14, 6)), (0.02, 0.9, 0.9, 0.02));
    }
}
