//! Pictures with mipmap levels.

use std::sync::{Arc, OnceLock};

use glanz_light::Pixels;
use glanz_math::DVec2;

use super::footprint::FootprintEllipse;

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
    /// Bilinear interpolation in the two levels of the mipmap whose pixels are nearest in size to the longer axis of the footprint.
    Trilinear,
    /// The mean of trilinear values along the longer axis of the footprint, each as wide as the shorter one.
    ///
    /// # Source
    /// The extension EXT_texture_filter_anisotropic of OpenGL. Departure: the axes of the ellipse instead of the derivatives along x and y.
    Anisotropic {
        /// Largest number of values, at least 1; where the axes differ more, the values are wider.
        most: u8,
    },
}

impl ImageFilter {
    /// The filter of pictures that name none, with pbrt's default for `maxanisotropy`.
    pub const ANISOTROPIC: Self = Self::Anisotropic { most: 8 };
}

#[derive(Debug)]
struct MipLevel {
    width: usize,
    height: usize,
    /// Rows from the top.
    texels: Vec<[f32; 3]>,
}

/// A picture with its mipmap levels; cheap to clone.
///
/// Levels halve in both directions, rounding down, to one pixel; each pixel is the exact mean over its area of the level before, so that all
/// levels have the mean of the picture.
#[derive(Clone, Debug)]
pub struct MipMap(Arc<MipLevels>);

#[derive(Debug)]
struct MipLevels {
    full: MipLevel,
    /// The levels below the full size, which take a third of its memory: made when one is read for the first time.
    smaller: OnceLock<Vec<MipLevel>>,
}

impl MipMap {
    /// A picture of linear values.
    ///
    /// # Errors
    /// [`MipMapError`] if the channels are missing or a pixel is not finite.
    pub fn try_new(pixels: &Pixels) -> Result<Self, MipMapError> {
        let texels = pixels.to_rgb().ok_or_else(|| {
            MipMapError::Channels(pixels.channels().iter().map(|c| c.name.clone()).collect())
        })?;
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        if let Some(i) = texels.iter().position(|t| t.iter().any(|x| !x.is_finite())) {
            return Err(MipMapError::NotFinite { column: i % width, row: i / width });
        }
        let full = MipLevel { width, height, texels };
        Ok(Self(Arc::new(MipLevels { full, smaller: OnceLock::new() })))
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        let MipLevel { width, height, .. } = self.0.full;
        width.max(height).checked_ilog2().map_or(1, |halvings| halvings as usize + 1)
    }

    /// The level with this number, or the last one; the full size is level 0.
    fn level(&self, number: usize) -> &MipLevel {
        let MipLevels { full, smaller } = &*self.0;
        let Some(index) = number.checked_sub(1) else { return full };
        let smaller =
            smaller.get_or_init(|| std::iter::successors(Some(full.halved()), MipLevel::next).collect());
        smaller.get(index).or(smaller.last()).unwrap_or(full)
    }

    /// The value at `st`, (0, 0) the lower left and (1, 1) the upper right corner; black where `st` is not finite.
    ///
    /// `footprint`: sides of the parallelogram to average over in the same units, for [`ImageFilter::Trilinear`] and [`ImageFilter::Anisotropic`].
    #[must_use]
    pub fn lookup(&self, st: DVec2, footprint: [DVec2; 2], wrap: ImageWrap, filter: ImageFilter) -> [f32; 3] {
        let full = &self.0.full;
        if !st.is_finite() {
            return [0.0; 3];
        }
        let most = match filter {
            ImageFilter::Point => return full.point(st, wrap),
            ImageFilter::Bilinear => return full.bilinear(st, wrap),
            _ if footprint == [DVec2::ZERO; 2] => return full.bilinear(st, wrap),
            ImageFilter::Trilinear => 1,
            ImageFilter::Anisotropic { most } => most.max(1),
        };
        let size = DVec2::new(full.width as f64, full.height as f64);
        let FootprintEllipse { major, lengths: [long, short] } =
            FootprintEllipse::new(footprint.map(|side| side * size));
        if long.is_infinite() {
            return self.trilinear(st, f64::INFINITY, wrap);
        }
        // Values narrower than a pixel are the same as one of its width.
        let count = (long / short.max(1.0)).ceil().clamp(1.0, f64::from(most));
        // Wide enough to leave no gaps along the longer axis, and for the whole of the shorter one; together they are as long as the longer one.
        let width = (long / count).max(short);
        let value = |i: u8| {
            let place = match count > 1.0 {
                true => (f64::from(i) / (count - 1.0) - 0.5) * (1.0 - width / long),
                false => 0.0,
            };
            self.trilinear(st + place * major / size, width, wrap)
        };
        let mut sum = [0.0; 3];
        for i in 0..count as u8 {
            let value = value(i);
            sum = std::array::from_fn(|k| sum[k] + value[k]);
        }
        sum.map(|x| x / count as f32)
    }

    /// The value of the levels whose pixels are nearest to a square with sides of `width` pixels of the full size.
    fn trilinear(&self, st: DVec2, width: f64, wrap: ImageWrap) -> [f32; 3] {
        let level = width.max(1.0).log2().min((self.levels() - 1) as f64);
        let (fine, share) = (level.floor() as usize, level.fract() as f32);
        let a = self.level(fine).bilinear(st, wrap);
        if share == 0.0 {
            return a;
        }
        let b = self.level(fine + 1).bilinear(st, wrap);
        std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
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

    /// The next smaller level; `None` after one pixel.
    fn next(&self) -> Option<Self> {
        (self.width.max(self.height) > 1).then(|| self.halved())
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

    const NONE: [DVec2; 2] = [DVec2::ZERO; 2];

    /// A square of this side.
    fn square(side: f64) -> [DVec2; 2] {
        [DVec2::new(side, 0.0), DVec2::new(0.0, side)]
    }

    /// Two rows of three: top 1 2 3, bottom 4 5 6.
    fn six() -> MipMap {
        image(3, 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    }

    fn image(width: u32, height: u32, values: &[f32]) -> MipMap {
        let rgb: Vec<[f32; 3]> = values.iter().map(|&v| [v, 10.0 * v, 0.0]).collect();
        MipMap::try_new(&Pixels::try_from_rgb(width, height, &rgb).unwrap()).unwrap()
    }

    fn at(image: &MipMap, s: f64, t: f64, wrap: ImageWrap, filter: ImageFilter) -> f32 {
        image.lookup(DVec2::new(s, t), NONE, wrap, filter)[0]
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
            image.lookup(st, NONE, ImageWrap::OctahedralSphere, ImageFilter::Point)[0]
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
        let anisotropic = ImageFilter::Anisotropic { most: 0 };
        for filter in [ImageFilter::Point, ImageFilter::Bilinear, ImageFilter::Trilinear, anisotropic] {
            for wrap in [ImageWrap::Repeat, ImageWrap::Black, ImageWrap::Clamp, ImageWrap::OctahedralSphere] {
                for s in [1e300, -1e300, f64::NAN, f64::INFINITY, 1e18] {
                    let v = six().lookup(DVec2::new(s, 0.3), square(f64::NAN), wrap, filter);
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
        for level in (0..3).map(|number| image.level(number)) {
            let m = level.texels.iter().map(|t| t[0]).sum::<f32>() / level.texels.len() as f32;
            assert!((m - mean).abs() < 1e-5, "{} x {}", level.width, level.height);
        }
        let whole =
            image.lookup(DVec2::new(0.2, 0.9), square(1.0), ImageWrap::Repeat, ImageFilter::Trilinear);
        assert!((whole[0] - mean).abs() < 1e-5);
    }

    #[test]
    fn trilinear_without_footprint_is_bilinear_and_between_levels_is_between() {
        let values: Vec<f32> = (0..64).map(|i| if (i / 8 + i % 8) % 2 == 0 { 1.0 } else { 0.0 }).collect();
        let image = image(8, 8, &values);
        let st = DVec2::new(0.5 / 8.0, 0.5 / 8.0);
        let f = |width: f64| image.lookup(st, square(width), ImageWrap::Repeat, ImageFilter::Trilinear)[0];
        let exact = image.lookup(st, NONE, ImageWrap::Repeat, ImageFilter::Bilinear)[0];
        assert_eq!(f(0.0), exact);
        assert_eq!(f(1.0 / 8.0), exact);
        // Level 1 is 0.5 everywhere; at sqrt(2) pixels the two levels have equal shares.
        assert_eq!(f(2.0 / 8.0), 0.5);
        assert!((f(2.0_f64.sqrt() / 8.0) - 0.5 * (exact + 0.5)).abs() < 1e-6);
    }

    #[test]
    fn smaller_levels_are_made_when_a_footprint_needs_them() {
        let image = image(8, 8, &[0.5; 64]);
        let look =
            |side: f64, filter| image.lookup(DVec2::splat(0.3), square(side), ImageWrap::Repeat, filter);
        let (few, none) = (ImageFilter::Anisotropic { most: 4 }, ImageFilter::Bilinear);
        assert_eq!(
            [look(1.0, none), look(0.1, few), look(0.1, ImageFilter::Trilinear)],
            [[0.5, 5.0, 0.0]; 3]
        );
        assert!(image.0.smaller.get().is_none());
        assert_eq!(look(0.2, few), [0.5, 5.0, 0.0]);
        assert!(image.0.smaller.get().is_some());
    }

    /// Stripes along s: a footprint long in s and narrow in t keeps them apart, and one long in t averages over them.
    #[test]
    fn anisotropic_values_average_along_the_longer_axis_only() {
        let values: Vec<f32> = (0..64 * 64).map(|i| if (i / 64) % 2 == 0 { 1.0 } else { 0.0 }).collect();
        let image = image(64, 64, &values);
        let anisotropic = ImageFilter::Anisotropic { most: 8 };
        // The middle of a row of ones.
        let st = DVec2::new(0.4, 1.0 - 10.5 / 64.0);
        let value = |long: f64, wide: f64, filter| {
            image.lookup(
                st,
                [DVec2::new(long / 64.0, 0.0), DVec2::new(0.0, wide / 64.0)],
                ImageWrap::Repeat,
                filter,
            )[0]
        };
        assert_eq!(value(8.0, 1.0, anisotropic), 1.0);
        assert_eq!(value(8.0, 1.0, ImageFilter::Trilinear), 0.5);
        // Eight rows, four of them ones.
        assert!((value(1.0, 8.0, anisotropic) - 0.5).abs() < 1e-6);
        // At twice the ratio its values are two pixels wide, as are those of a square.
        assert_eq!(value(16.0, 1.0, anisotropic), 0.5);
        assert_eq!(value(2.0, 2.0, anisotropic), 0.5);
        // Nothing jumps where the axes change places.
        assert!((value(2.000_001, 2.0, anisotropic) - 0.5).abs() < 1e-5);
        assert!((value(2.0, 2.000_001, anisotropic) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn grey_pictures_are_textures_and_others_are_refused() {
        let mut depth = Pixels::try_new(1, 1).unwrap();
        depth.add_channel("Z", vec![1.0]).unwrap();
        assert_eq!(MipMap::try_new(&depth).unwrap_err(), MipMapError::Channels(vec!["Z".to_owned()]));
        depth.add_channel("Y", vec![0.5]).unwrap();
        assert_eq!(MipMap::try_new(&depth).unwrap().levels(), 1);
        let bad = Pixels::try_from_rgb(2, 1, &[[0.0; 3], [f32::NAN; 3]]).unwrap();
        assert_eq!(MipMap::try_new(&bad).unwrap_err(), MipMapError::NotFinite { column: 1, row: 0 });
    }
}
