//! Pictures with mipmap levels.

use std::sync::Arc;

use glanz_light::Pixels;
use glanz_math::DVec2;

/// An error of [`MipMap::try_new`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MipMapError {
    /// The picture has neither R, G and B nor Y.
    #[error("the picture has the channels {0:?}; a texture needs R, G and B, or Y")]
    Channels(Vec<String>),
    /// A pixel is infinite or not a number.
    #[error("the picture's pixel at column {column}, row {row} is not finite")]
    NotFinite {
        /// Its column, from the left.
        column: usize,
        /// Its row, from the top.
        row: usize,
    },
}

/// Values outside a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ImageWrap {
    /// The picture repeated.
    #[default]
    Repeat,
    /// Zero.
    Black,
    /// The nearest border value.
    Clamp,
    /// The picture continues over its borders as the map of a sphere to a square does: turned by half a turn about the middle of the border.
    ///
    /// # Source
    /// @pbrt4 `RemapPixelCoords`; departure: pixels next to the left and lower borders continue in themselves, as at the others.
    OctahedralSphere,
}

/// Interpolation between pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ImageFilter {
    /// The nearest pixel.
    Point,
    /// Bilinear interpolation.
    #[default]
    Bilinear,
    /// Bilinear interpolation in the two levels of the mipmap whose pixels are nearest in size to the footprint.
    Trilinear,
}

#[derive(Debug)]
struct MipLevel {
    width: usize,
    height: usize,
    /// Rows from the top.
    texels: Vec<[f32; 3]>,
}

/// A picture with its mipmap levels; cheap to clone.
#[derive(Clone, Debug)]
pub struct MipMap {
    /// Levels from the full size down to one pixel, or the full size alone.
    levels: Arc<[MipLevel]>,
}

impl MipMap {
    /// A picture of linear values; smaller levels are built if `with_levels`, and take a third more memory.
    ///
    /// Levels halve in both directions, rounding down; each pixel is the exact mean over its area of the
    /// level before, so that all levels have the mean of the picture.
    ///
    /// # Errors
    /// [`MipMapError`] if the channels are missing or a pixel is not finite.
    pub fn try_new(pixels: &Pixels, with_levels: bool) -> Result<Self, MipMapError> {
        let texels = pixels.to_rgb().ok_or_else(|| {
            MipMapError::Channels(pixels.channels().iter().map(|c| c.name.clone()).collect())
        })?;
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        if let Some(i) = texels.iter().position(|t| t.iter().any(|x| !x.is_finite())) {
            return Err(MipMapError::NotFinite { column: i % width, row: i / width });
        }
        let mut levels = Vec::new();
        let mut next = Some(MipLevel { width, height, texels });
        while let Some(level) = next {
            next = (with_levels && level.width.max(level.height) > 1).then(|| level.halved());
            levels.push(level);
        }
        Ok(Self { levels: levels.into() })
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The value at `st`, (0, 0) the lower left and (1, 1) the upper right corner; black where `st` is not finite.
    ///
    /// `width`: extent of the footprint in the same units, only used by [`ImageFilter::Trilinear`].
    #[must_use]
    pub fn lookup(&self, st: DVec2, width: f64, wrap: ImageWrap, filter: ImageFilter) -> [f32; 3] {
        let Some(first) = self.levels.first() else {
            return [0.0; 3];
        };
        if !st.is_finite() {
            return [0.0; 3];
        }
        match filter {
            ImageFilter::Point => first.point(st, wrap),
            ImageFilter::Bilinear => first.bilinear(st, wrap),
            ImageFilter::Trilinear => {
                // Pixels of level k have the size of the footprint; NaN and 0 give level 0.
                let texels = width * first.width.max(first.height) as f64;
                let level = texels.max(1.0).log2().min((self.levels.len() - 1) as f64);
                let (fine, share) = (level.floor() as usize, level.fract() as f32);
                let at = |k: usize| self.levels.get(k).map_or([0.0; 3], |l| l.bilinear(st, wrap));
                if share == 0.0 {
                    return at(fine);
                }
                let (a, b) = (at(fine), at(fine + 1));
                std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
            }
        }
    }
}

impl MipLevel {
    fn texel(&self, column: i64, row: i64, wrap: ImageWrap) -> [f32; 3] {
        let (width, height) = (self.width as i64, self.height as i64);
        let (column, row) = match wrap {
            ImageWrap::Repeat => (column.rem_euclid(width), row.rem_euclid(height)),
            ImageWrap::Clamp => (column.clamp(0, width - 1), row.clamp(0, height - 1)),
            ImageWrap::Black if (0..width).contains(&column) && (0..height).contains(&row) => (column, row),
            ImageWrap::Black => return [0.0; 3],
            ImageWrap::OctahedralSphere => {
                let is_beyond = |i: i64, count: i64| i.div_euclid(count) & 1 != 0;
                let (across, along) = (is_beyond(column, width), is_beyond(row, height));
                // Over a border both coordinates are mirrored; the one across it continues in itself.
                let mirrored = |i: i64, count: i64| {
                    if across != along { count - 1 - i.rem_euclid(count) } else { i.rem_euclid(count) }
                };
                (mirrored(column, width), mirrored(row, height))
            }
        };
        self.texels.get((row * width + column) as usize).copied().unwrap_or([0.0; 3])
    }

    /// Position in columns and rows from the top left corner, with fractions.
    fn place(&self, st: DVec2, wrap: ImageWrap) -> DVec2 {
        // The fraction is taken first, to keep its digits where the coordinates are large.
        let st = if wrap == ImageWrap::Repeat { st - st.floor() } else { st };
        DVec2::new(st.x * self.width as f64, (1.0 - st.y) * self.height as f64)
    }

    fn point(&self, st: DVec2, wrap: ImageWrap) -> [f32; 3] {
        let p = self.place(st, wrap);
        // Rows count downwards: a value on the border between two belongs to the upper one, as columns do to
        // the right.
        self.texel(p.x.floor() as i64, (p.y.ceil() as i64).saturating_sub(1), wrap)
    }

    fn bilinear(&self, st: DVec2, wrap: ImageWrap) -> [f32; 3] {
        let p = self.place(st, wrap) - 0.5;
        let corner = p.floor();
        let (column, row) = (corner.x as i64, corner.y as i64);
        let (fx, fy) = ((p.x - corner.x) as f32, (p.y - corner.y) as f32);
        let at = |dc: i64, dr: i64| self.texel(column.saturating_add(dc), row.saturating_add(dr), wrap);
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + fx * (b[i] - a[i]), c[i] + fx * (d[i] - c[i]));
            top + fy * (bottom - top)
        })
    }

    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let (columns, rows) = (overlaps(self.width, width), overlaps(self.height, height));
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0_f64; 3];
                for &(r, wr) in row {
                    for &(c, wc) in column {
                        let texel = self.texel(c as i64, r as i64, ImageWrap::Clamp);
                        for (s, t) in sum.iter_mut().zip(texel) {
                            *s += wr * wc * f64::from(t);
                        }
                    }
                }
                texels.push(sum.map(|s| s as f32));
            }
        }
        Self { width, height, texels }
    }
}

/// For each of `to` equal intervals, the indices of the `from` equal intervals that overlap it, with their fractions of it.
fn overlaps(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    (0..to)
        .map(|i| {
            // In units of 1 / (from * to) everything is an integer.
            let (low, high) = (i * from, (i + 1) * from);
            (low / to..high.div_ceil(to))
                .map(|j| {
                    let shared = high.min((j + 1) * to) - low.max(j * to);
                    (j, shared as f64 / from as f64)
                })
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of three: top 1 2 3, bottom 4 5 6.
    fn six() -> MipMap {
        image(3, 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    }

    fn image(width: u32, height: u32, values: &[f32]) -> MipMap {
        let rgb: Vec<[f32; 3]> = values.iter().map(|&v| [v, 10.0 * v, 0.0]).collect();
        MipMap::try_new(&Pixels::try_from_rgb(width, height, &rgb).unwrap(), true).unwrap()
    }

    fn at(image: &MipMap, s: f64, t: f64, wrap: ImageWrap, filter: ImageFilter) -> f32 {
        image.lookup(DVec2::new(s, t), 0.0, wrap, filter)[0]
    }

    #[test]
    fn origin_is_the_lower_left_pixel() {
        let (wrap, filter) = (ImageWrap::Clamp, ImageFilter::Point);
        assert_eq!(at(&six(), 0.0, 0.0, wrap, filter), 4.0);
        assert_eq!(at(&six(), 0.99, 0.0, wrap, filter), 6.0);
        assert_eq!(at(&six(), 0.0, 0.99, wrap, filter), 1.0);
        assert_eq!(at(&six(), 1.0, 1.0, wrap, filter), 3.0);
    }

    #[test]
    fn bilinear_is_exact_at_pixel_centres_and_linear_between() {
        let f = |s, t| at(&six(), s, t, ImageWrap::Clamp, ImageFilter::Bilinear);
        assert_eq!(f(0.5 / 3.0, 0.25), 4.0);
        assert_eq!(f(0.5, 0.75), 2.0);
        assert_eq!(f(0.5, 0.5), 3.5);
        assert!((f(1.0 / 3.0, 0.75) - 1.5).abs() < 1e-6);
    }

    #[test]
    fn outside_follows_the_wrap_mode() {
        let point = ImageFilter::Point;
        assert_eq!(at(&six(), 1.1, 0.0, ImageWrap::Repeat, point), 4.0);
        assert_eq!(at(&six(), -0.1, -0.1, ImageWrap::Repeat, point), 3.0);
        assert_eq!(at(&six(), 1.1, 0.0, ImageWrap::Clamp, point), 6.0);
        assert_eq!(at(&six(), 1.1, 0.0, ImageWrap::Black, point), 0.0);
        assert_eq!(at(&six(), 0.5, -0.1, ImageWrap::Black, point), 0.0);
        // Halfway between the border pixel 6 and black, or 4 on the other side.
        let linear = ImageFilter::Bilinear;
        assert!((at(&six(), 1.0, 0.25, ImageWrap::Black, linear) - 3.0).abs() < 1e-6);
        assert!((at(&six(), 1.0, 0.25, ImageWrap::Repeat, linear) - 5.0).abs() < 1e-6);
        assert!((at(&six(), 1.0, 0.25, ImageWrap::Clamp, linear) - 6.0).abs() < 1e-6);
    }

    /// Over the right border, the upper half of the last column meets the lower half of it; at the corners, all four corners of the picture
    /// are one point of the sphere.
    #[test]
    fn octahedral_pictures_continue_over_their_borders_turned() {
        let image = image(4, 4, &std::array::from_fn::<f32, 16, _>(|i| i as f32));
        let at = |column: f64, row: f64| {
            let st = DVec2::new((column + 0.5) / 4.0, 1.0 - (row + 0.5) / 4.0);
            image.lookup(st, 0.0, ImageWrap::OctahedralSphere, ImageFilter::Point)[0]
        };
        assert_eq!([at(0.0, 0.0), at(3.0, 2.0)], [0.0, 11.0]);
        for row in 0..4 {
            let (row, other) = (f64::from(row), f64::from(3 - row));
            assert_eq!([at(4.0, row), at(5.0, row)], [at(3.0, other), at(2.0, other)]);
            assert_eq!([at(-1.0, row), at(-2.0, row)], [at(0.0, other), at(1.0, other)]);
            assert_eq!([at(row, 4.0), at(row, -1.0)], [at(other, 3.0), at(other, 0.0)]);
        }
        assert_eq!([at(-1.0, -1.0), at(4.0, 4.0), at(8.0, 1.0)], [at(3.0, 3.0), at(0.0, 0.0), at(0.0, 1.0)]);
    }

    #[test]
    fn coordinates_without_bounds_give_values() {
        for filter in [ImageFilter::Point, ImageFilter::Bilinear, ImageFilter::Trilinear] {
            for wrap in [ImageWrap::Repeat, ImageWrap::Black, ImageWrap::Clamp, ImageWrap::OctahedralSphere] {
                for s in [1e300, -1e300, f64::NAN, f64::INFINITY, 1e18] {
                    let v = six().lookup(DVec2::new(s, 0.3), f64::NAN, wrap, filter);
                    assert!((0.0..=6.0).contains(&v[0]), "{s}: {v:?}");
                }
            }
        }
    }

    #[test]
    fn every_level_of_the_pyramid_has_the_mean_of_the_picture() {
        let values: Vec<f32> = (0..35).map(|i| ((i * 37) % 17) as f32).collect();
        let mean = values.iter().sum::<f32>() / 35.0;
        let image = image(7, 5, &values);
        assert_eq!(image.levels(), 3, "7 x 5, 3 x 2, 1 x 1");
        for level in image.levels.iter() {
            let m = level.texels.iter().map(|t| t[0]).sum::<f32>() / level.texels.len() as f32;
            assert!((m - mean).abs() < 1e-5, "{} x {}", level.width, level.height);
        }
        let whole = image.lookup(DVec2::new(0.2, 0.9), 1.0, ImageWrap::Repeat, ImageFilter::Trilinear);
        assert!((whole[0] - mean).abs() < 1e-5);
    }

    #[test]
    fn trilinear_without_footprint_is_bilinear_and_between_levels_is_between() {
        let values: Vec<f32> = (0..64).map(|i| if (i / 8 + i % 8) % 2 == 0 { 1.0 } else { 0.0 }).collect();
        let image = image(8, 8, &values);
        let st = DVec2::new(0.5 / 8.0, 0.5 / 8.0);
        let f = |width: f64| image.lookup(st, width, ImageWrap::Repeat, ImageFilter::Trilinear)[0];
        let exact = image.lookup(st, 0.0, ImageWrap::Repeat, ImageFilter::Bilinear)[0];
        assert_eq!(f(0.0), exact);
        assert_eq!(f(1.0 / 8.0), exact);
        // Level 1 is 0.5 everywhere; at sqrt(2) pixels the two levels have equal shares.
        assert_eq!(f(2.0 / 8.0), 0.5);
        assert!((f(2.0_f64.sqrt() / 8.0) - 0.5 * (exact + 0.5)).abs() < 1e-6);
    }

    #[test]
    fn grey_pictures_are_textures_and_others_are_refused() {
        let mut depth = Pixels::try_new(1, 1).unwrap();
        depth.add_channel("Z", vec![1.0]).unwrap();
        assert_eq!(MipMap::try_new(&depth, false).unwrap_err(), MipMapError::Channels(vec!["Z".to_owned()]));
        depth.add_channel("Y", vec![0.5]).unwrap();
        assert_eq!(MipMap::try_new(&depth, false).unwrap().levels(), 1);
        let bad = Pixels::try_from_rgb(2, 1, &[[0.0; 3], [f32::NAN; 3]]).unwrap();
        assert_eq!(MipMap::try_new(&bad, false).unwrap_err(), MipMapError::NotFinite { column: 1, row: 0 });
    }
}
