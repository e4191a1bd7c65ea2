//! Rectangles and letters in a picture of one colour per pixel.

use crate::lettering::{ADVANCE, HEIGHT, dots};

/// Height of a line of letters, in dots.
pub const LETTER_HEIGHT: u32 = HEIGHT;

/// A picture to draw in.
#[derive(Clone, Debug)]
pub struct Raster<Colour> {
    width: u32,
    height: u32,
    pixels: Vec<Colour>,
}

impl<Colour: Copy> Raster<Colour> {
    /// A picture of one colour.
    #[must_use]
    pub fn new([width, height]: [u32; 2], colour: Colour) -> Self {
        Self { width, height, pixels: vec![colour; width as usize * height as usize] }
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

    /// The colours, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[Colour] {
        &self.pixels
    }

    /// Fills a rectangle of `[width, height]` pixels; what lies outside the picture is left out.
    pub fn fill(&mut self, [left, top]: [u32; 2], [width, height]: [u32; 2], colour: Colour) {
        let right = left.saturating_add(width).min(self.width);
        for y in top..top.saturating_add(height).min(self.height) {
            let row = y as usize * self.width as usize;
            if let Some(pixels) = self.pixels.get_mut(row + left as usize..row + right as usize) {
                pixels.fill(colour);
            }
        }
    }

    /// Writes capital letters of 5 x 7 dots, each a square of `dot` pixels.
    pub fn write(&mut self, [left, top]: [u32; 2], words: &str, dot: u32, colour: Colour) {
        for [x, y] in dots(words) {
            self.fill([left + dot * x, top + dot * y], [dot, dot], colour);
        }
    }
}

/// Pixels that `letters` letters take in a row, with the gap behind each.
#[must_use]
pub fn text_width(letters: usize, dot: u32) -> u32 {
    letters as u32 * ADVANCE * dot
}

/// The letters of `words` that fit into `width` pixels.
#[must_use]
pub fn fitting(words: &str, width: u32, dot: u32) -> String {
    words.chars().take((width / (ADVANCE * dot)) as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut raster = Raster::new([3, 2], 0);
        raster.fill([1, 1], [9, 9], 7);
        raster.fill([5, 0], [2, 2], 8);
        assert_eq!(raster.pixels(), [0, 0, 0, 0, 7, 7]);
        assert_eq!((fitting("letters", 25, 2), text_width(2, 2)), ("le".to_owned(), 24));
    }
}
