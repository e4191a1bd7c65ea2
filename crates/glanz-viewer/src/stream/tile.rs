//! Encoded tiles.

use glanz_light::Pixels;
use half::f16;

/// Bytes before the pixels.
const HEADER: usize = 20;

/// Side of the tiles of a whole picture, pixels: few messages, none of them long.
const SIDE: u32 = 128;

/// A rectangle of a view's picture, ready to be sent; `docs/viewer.md` has the layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    /// First column and row.
    pub(crate) min: [u16; 2],
    pub(crate) bytes: Vec<u8>,
}

impl Tile {
    /// `min`, `size`: first column and row, columns and rows, all below 65536; `samples`: that each pixel has; `radiance`: linear Rec. 709,
    /// row by row from the top. Values beyond the range of half floats are clamped, NaN becomes black.
    pub(crate) fn new(
        id: u32,
        min: [u32; 2],
        size: [u32; 2],
        samples: u64,
        radiance: impl Iterator<Item = [f32; 3]>,
    ) -> Self {
        let short = |n: u32| u16::try_from(n).unwrap_or(u16::MAX);
        let min = min.map(short);
        let mut bytes = Vec::with_capacity(HEADER + 6 * size[0] as usize * size[1] as usize);
        bytes.extend([1, 0, 0, 0]);
        bytes.extend(id.to_le_bytes());
        for number in [min[0], min[1], short(size[0]), short(size[1])] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(u32::try_from(samples).unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend(radiance.flatten().flat_map(|value| half(value).to_le_bytes()));
        Self { min, bytes }
    }

    /// The same tile, marked as one without noise.
    pub(crate) fn denoised(mut self) -> Self {
        if let Some(mark) = self.bytes.get_mut(1) {
            *mark = 1;
        }
        self
    }
}

fn half(value: f32) -> f16 {
    if value.is_nan() {
        return f16::ZERO;
    }
    f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

/// An image cut into tiles.
pub(crate) fn tiles(id: u32, pixels: &Pixels, samples: u64) -> Vec<Tile> {
    let [width, height] = [pixels.width(), pixels.height()];
    let bands = ["R", "G", "B"].map(|name| pixels.channel(name).unwrap_or_default());
    let at = |x: u32, y: u32| {
        let index = y as usize * width as usize + x as usize;
        bands.map(|band| band.get(index).copied().unwrap_or_default())
    };
    let starts = |length: u32| (0..length).step_by(SIDE as usize);
    let places = starts(height).flat_map(|y| starts(width).map(move |x| [x, y]));
    let tile = |[x, y]: [u32; 2]| {
        let size = [(width - x).min(SIDE), (height - y).min(SIDE)];
        let radiance = (y..y + size[1]).flat_map(|row| (x..x + size[0]).map(move |column| at(column, row)));
        Tile::new(id, [x, y], size, samples, radiance)
    };
    places.map(tile).collect()
}

/// The message that carries a file.
pub(crate) fn file(id: u32, content: &[u8]) -> Vec<u8> {
    [&[2, 0, 0, 0], id.to_le_bytes().as_slice(), content].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_laid_out_as_the_contract_says() {
        let radiance = [[1.0, -2.0, 0.5], [1e9, f32::NAN, f32::NEG_INFINITY]];
        let tile = Tile::new(0x0102_0304, [5, 258], [2, 1], 77, radiance.into_iter());
        // 1 = 0x3c00, -2 = 0xc000, 0.5 = 0x3800, the largest 0x7bff.
        let expected: [u8; 32] = [
            1, 0, 0, 0, 4, 3, 2, 1, 5, 0, 2, 1, 2, 0, 1, 0, 77, 0, 0, 0, 0x00, 0x3c, 0x00, 0xc0, 0x00, 0x38,
            0xff, 0x7b, 0x00, 0x00, 0xff, 0xfb,
        ];
        assert_eq!(tile.bytes, expected);
        assert_eq!(tile.min, [5, 258]);
        assert_eq!(tile.denoised().bytes, [&[1, 1], &expected[2..]].concat());
    }

    #[test]
    fn tiles_of_a_picture_cover_it_once_in_rows() {
        let (width, height) = (300, 130);
        let rgb: Vec<[f32; 3]> =
            (0..width * height).map(|i| [(i % 300) as f32, (i / 300) as f32, 1.0]).collect();
        let pixels = Pixels::try_from_rgb(width, height, &rgb).unwrap();
        let tiles = tiles(9, &pixels, 5);
        let places: Vec<_> = tiles.iter().map(|tile| tile.min).collect();
        assert_eq!(places, [[0, 0], [128, 0], [256, 0], [0, 128], [128, 128], [256, 128]]);
        // 20 bytes before the pixels, 6 each: 44 x 2 pixels in the last corner.
        assert_eq!(tiles[5].bytes.len(), 20 + 6 * 44 * 2);
        // Its second row begins at (256, 129). 256 and 129 as half floats: 2^8 is 0x5c00, 129 = 2^7 (1 + 8/1024) is 0x5808.
        let second = 20 + 6 * 44;
        assert_eq!(tiles[5].bytes[second..second + 4], [0x00, 0x5c, 0x08, 0x58]);
    }

    #[test]
    fn a_file_follows_its_number() {
        assert_eq!(file(3, b"exr"), [2, 0, 0, 0, 3, 0, 0, 0, b'e', b'x', b'r']);
    }
}
