//! Rectangles of pixels: parts of a picture.

use crate::film::FilmError;

/// Side of a tile, pixels. Part of the checkpoint format, which stores pixels tile by tile.
pub const TILE_SIDE: u32 = 16;

/// A rectangle of pixels; the picture's upper left pixel is (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column and row.
    pub min: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl PixelRect {
    /// The whole picture.
    #[must_use]
    pub const fn full(resolution: [u32; 2]) -> Self {
        Self { min: [0, 0], size: resolution }
    }

    /// The pixels of a crop window given as fractions of the picture: smallest and largest x, then y, from the top left.
    ///
    /// A border at fraction f lies before pixel `ceil(f * resolution)`, so that windows with a common border
    /// share no pixel and omit none.
    ///
    /// # Errors
    /// [`FilmError::Crop`] if the window has no pixel, or a fraction is outside [0, 1].
    ///
    /// # Source
    /// @pharr2023 section 5.4.2.
    pub fn from_fractions(resolution: [u32; 2], window: [f64; 4]) -> Result<Self, FilmError> {
        let border = |axis: usize, fraction: f64| {
            let inside = (0.0..=1.0).contains(&fraction);
            inside.then(|| (f64::from(resolution[axis]) * fraction).ceil() as u32)
        };
        let axis = |axis: usize| {
            let (low, high) = (border(axis, window[2 * axis])?, border(axis, window[2 * axis + 1])?);
            (low < high).then_some((low, high - low))
        };
        match (axis(0), axis(1)) {
            (Some(x), Some(y)) => Ok(Self { min: [x.0, y.0], size: [x.1, y.1] }),
            _ => Err(FilmError::Crop { window, resolution }),
        }
    }

    /// Number of pixels.
    #[must_use]
    pub fn len(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Whether the rectangle is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let Self { min, size } = *self;
        (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [min[0] + x, min[1] + y]))
    }

    /// The rectangle cut into squares of [`TILE_SIDE`], row by row; those at the right and lower border may be smaller.
    pub fn tiles(&self) -> impl Iterator<Item = Self> + use<> {
        let Self { min, size } = *self;
        let counts = size.map(|s| s.div_ceil(TILE_SIDE));
        (0..counts[1]).flat_map(move |ty| {
            (0..counts[0]).map(move |tx| {
                let offset = [tx * TILE_SIDE, ty * TILE_SIDE];
                Self {
                    min: [min[0] + offset[0], min[1] + offset[1]],
                    size: [(size[0] - offset[0]).min(TILE_SIDE), (size[1] - offset[1]).min(TILE_SIDE)],
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        let crop = PixelRect { min: [3, 5], size: [37, 18] };
        let mut seen: Vec<_> = crop.tiles().flat_map(|t| t.pixels()).map(|[x, y]| [y, x]).collect();
        seen.sort_unstable();
        let rows: Vec<_> = crop.pixels().map(|[x, y]| [y, x]).collect();
        assert_eq!(seen, rows);
        assert!(crop.tiles().all(|t| t.size[0] <= TILE_SIDE && t.size[1] <= TILE_SIDE && !t.is_empty()));
    }

    #[test]
    fn neighbouring_crop_windows_share_no_pixel_and_omit_none() {
        let resolution = [101, 7];
        let left = PixelRect::from_fractions(resolution, [0.0, 0.37, 0.0, 1.0]).unwrap();
        let right = PixelRect::from_fractions(resolution, [0.37, 1.0, 0.0, 1.0]).unwrap();
        assert_eq!(left.min[0] + left.size[0], right.min[0]);
        assert_eq!(left.size[0] + right.size[0], 101);
        assert!(PixelRect::from_fractions(resolution, [0.5, 0.5, 0.0, 1.0]).is_err());
        assert!(PixelRect::from_fractions(resolution, [0.0, f64::NAN, 0.0, 1.0]).is_err());
    }
}
