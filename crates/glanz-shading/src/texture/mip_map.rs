//! Pictures with mipmap levels.

use std::fmt;
use std::sync::{Arc, OnceLock};

use glanz_job::{ContentHash, ScratchFileError};
use glanz_light::Pixels;
use glanz_math::DVec2;

use super::footprint::FootprintEllipse;
use super::mip_level::MipLevel;
use super::texels::TexelValues;
use super::texture_cache::TextureCache;

/// Smaller levels of pictures in a file are stored from this one on; those above take most of the room, and a tile of them is made of few of the full size.
const FIRST_STORED: usize = 3;

/// Levels with at most so many texels along both sides are always in memory.
const SMALL: usize = 32;

/// An error of a [`MipMap`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MipMapError {
    /// The picture has neither R, G and B nor Y.
    #[error("the picture has the channels {0:?}; textures and lights need R, G and B, or Y")]
    Channels(Vec<String>),
    /// A pixel is infinite or not a number.
    #[error("the picture's pixel at column {column}, row {row} is not finite")]
    NotFinite {
        /// Its column, from the left.
        column: usize,
        /// Its row, from the top.
        row: usize,
    },
    /// The picture is to be in a temporary file, which failed.
    #[error(transparent)]
    File(#[from] ScratchFileError),
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

/// A picture of linear values with its mipmap levels; cheap to clone.
///
/// Levels halve in both directions, rounding down, to one pixel; each pixel is the exact mean over its area of the level before, so that all
/// levels have the mean of the picture. A picture without more than 256 different values per colour takes a byte for each, its smaller levels four.
#[derive(Clone)]
pub struct MipMap(Arc<MipLevels>);

struct MipLevels {
    full: Arc<MipLevel>,
    /// The levels below the full size: of a picture in memory made when one is read for the first time.
    smaller: OnceLock<Vec<Arc<MipLevel>>>,
    /// The cache of a picture in a file.
    cache: Option<TextureCache>,
    /// The value that all texels and colours have.
    uniform: Option<f32>,
    /// Column and row of the first pixel that is not finite.
    not_finite: Option<[usize; 2]>,
}

impl fmt::Debug for MipMap {
    /// The size and a hash of the values, the same in memory and in a file, and whether smaller levels are made yet or not: hashes of descriptions are those of this
    /// text.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut hash = ContentHash::default();
        self.0.full.add_to(&mut hash);
        f.debug_struct("MipMap")
            .field("size", &self.size())
            .field("values", &hash.value())
            .finish_non_exhaustive()
    }
}

impl MipMap {
    /// A picture in memory. Its pixels may be infinite or not a number: see [`MipMap::check_finite`].
    ///
    /// # Errors
    /// [`MipMapError::Channels`] if it has neither R, G and B nor Y.
    pub fn try_new(pixels: &Pixels) -> Result<Self, MipMapError> {
        Self::try_new_in(pixels, &TextureCache::default())
    }

    /// A picture in memory or in the file of `cache`, as there is room.
    ///
    /// # Errors
    /// [`MipMapError::Channels`] if it has neither R, G and B nor Y; [`MipMapError::File`].
    pub fn try_new_in(pixels: &Pixels, cache: &TextureCache) -> Result<Self, MipMapError> {
        let names = || pixels.channels().iter().map(|channel| channel.name.clone()).collect();
        let planes = match ["R", "G", "B"].map(|name| pixels.channel(name)) {
            [Some(r), Some(g), Some(b)] => vec![r, g, b],
            _ => vec![pixels.channel("Y").ok_or_else(|| MipMapError::Channels(names()))?],
        };
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        let not_finite = planes.iter().filter_map(|plane| plane.iter().position(|x| !x.is_finite())).min();
        let not_finite = not_finite.map(|i| [i % width, i / width]);
        let first = planes.first().and_then(|plane| plane.first()).copied();
        let uniform = first.filter(|first| planes.iter().all(|plane| plane.iter().all(|x| x == first)));
        let full = Arc::new(MipLevel::new(width, height, TexelValues::of_planes(&planes)));
        // The smaller levels are floats, a third as many as there are texels.
        let smaller_bytes = (size_of::<f32>() * full.planes() * pixels.len() / 3) as u64;
        let is_small = width.max(height) <= SMALL;
        let levels = if is_small || cache.take(full.memory() + smaller_bytes) {
            MipLevels { full, smaller: OnceLock::new(), cache: None, uniform, not_finite }
        } else {
            let (full, smaller) = in_file(&full, cache)?;
            let cache = Some(cache.clone());
            MipLevels { full, smaller: smaller.into(), cache, uniform, not_finite }
        };
        Ok(Self(Arc::new(levels)))
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.0.full.width, self.0.full.height]
    }

    /// Memory of the picture and of its smaller levels, bytes, without what a cache holds of it.
    #[must_use]
    pub fn memory(&self) -> u64 {
        let full = &self.0.full;
        match self.0.cache {
            Some(_) => {
                let smaller = self.0.smaller.get().into_iter().flatten();
                full.memory() + smaller.map(|level| level.memory()).sum::<u64>()
            }
            None => full.memory() + (size_of::<f32>() * full.planes() * full.width * full.height / 3) as u64,
        }
    }

    /// The cache of the picture, if it is in a file.
    #[must_use]
    pub fn cache(&self) -> Option<&TextureCache> {
        self.0.cache.as_ref()
    }

    /// Checks that all values are finite, as a texture needs them.
    ///
    /// # Errors
    /// [`MipMapError::NotFinite`].
    pub fn check_finite(&self) -> Result<(), MipMapError> {
        self.0.not_finite.map_or(Ok(()), |[column, row]| Err(MipMapError::NotFinite { column, row }))
    }

    /// The value that all pixels and colours have, if there is one.
    #[must_use]
    pub fn uniform(&self) -> Option<f32> {
        self.0.uniform
    }

    /// All pixels, row by row from the top left.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the file of its cache fails.
    pub fn to_rgb(&self) -> Result<Vec<[f32; 3]>, ScratchFileError> {
        let all = self.0.full.to_rgb();
        self.0.cache.as_ref().map_or(Ok(()), TextureCache::check).map(|()| all)
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        let [width, height] = self.size();
        width.max(height).checked_ilog2().map_or(1, |halvings| halvings as usize + 1)
    }

    /// The level with this number, or the last one; the full size is level 0.
    fn level(&self, number: usize) -> &MipLevel {
        let MipLevels { full, smaller, .. } = &*self.0;
        let Some(index) = number.checked_sub(1) else { return full };
        let smaller = smaller
            .get_or_init(|| std::iter::successors(full.next(), MipLevel::next).map(Arc::new).collect());
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

/// The full size and the smaller levels of a picture in the file of `cache`.
fn in_file(
    picture: &MipLevel,
    cache: &TextureCache,
) -> Result<(Arc<MipLevel>, Vec<Arc<MipLevel>>), ScratchFileError> {
    let full = Arc::new(picture.stored(cache)?);
    let mut levels: Vec<Arc<MipLevel>> = Vec::new();
    let in_memory = std::iter::successors(picture.next(), MipLevel::next);
    for (number, level) in (1..).zip(in_memory) {
        let kept = match levels.last().unwrap_or(&full) {
            _ if level.width.max(level.height) <= SMALL => level,
            larger if number < FIRST_STORED => larger.halved_in(cache),
            _ => level.stored(cache)?,
        };
        levels.push(Arc::new(kept));
    }
    Ok((full, levels))
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
            let texels = level.to_rgb();
            let m = texels.iter().map(|t| t[0]).sum::<f32>() / texels.len() as f32;
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
        let bad = Pixels::try_from_rgb(2, 1, &[[0.0; 3], [0.0, f32::NAN, 0.0]]).unwrap();
        let bad = MipMap::try_new(&bad).unwrap();
        assert_eq!(bad.check_finite(), Err(MipMapError::NotFinite { column: 1, row: 0 }));
        assert_eq!(six().check_finite(), Ok(()));
    }

    #[test]
    fn a_picture_of_one_value_says_so() {
        let of =
            |rgb: [f32; 3]| MipMap::try_new(&Pixels::try_from_rgb(2, 1, &[[0.5; 3], rgb]).unwrap()).unwrap();
        assert_eq!([of([0.5; 3]), of([0.5, 0.5, 0.6])].map(|picture| picture.uniform()), [Some(0.5), None]);
    }

    /// Bytes and floats, grey and colours, sides that are no multiples of a tile, and memory for a few tiles only.
    #[test]
    fn pictures_in_a_file_have_the_values_of_those_in_memory() {
        for (width, height) in [(700, 333), (1, 5000), (5000, 1), (64, 128), (65, 33)] {
            assert_same_in_file_and_memory(width, height);
        }
    }

    fn assert_same_in_file_and_memory(width: usize, height: usize) {
        let count = width * height;
        let steps = |i: usize, k: usize| ((i * (37 + k)) % 251) as f32 / 250.0;
        let grey = |i: usize| [steps(i, 0); 3];
        let bytes = |i: usize| [steps(i, 0), steps(i, 1), steps(i, 2)];
        let floats = |i: usize| [(i as f32).sqrt(), steps(i, 1), -steps(i, 2)];
        for (kind, texel) in [&grey as &dyn Fn(usize) -> [f32; 3], &bytes, &floats].into_iter().enumerate() {
            let rgb: Vec<_> = (0..count).map(texel).collect();
            let pixels = Pixels::try_from_rgb(width as u32, height as u32, &rgb).unwrap();
            let (whole, cache) = (MipMap::try_new(&pixels).unwrap(), TextureCache::new(2 * count as u64));
            let stored = MipMap::try_new_in(&pixels, &cache).unwrap();
            assert!(whole.cache().is_none() && stored.cache().is_some());
            assert!(cache.file_size() >= [count, 3 * count, 12 * count][kind] as u64);
            assert!(stored.memory() < 20_000, "{}", stored.memory());
            // No more than a tile's row and column beyond the picture.
            let bound = (width + 64) * (height + 64) * [1, 3, 12][kind] * 3;
            assert!(cache.file_size() <= bound as u64, "{width} x {height}: {}", cache.file_size());
            assert_eq!(format!("{whole:?}"), format!("{stored:?}"));
            assert_eq!(stored.to_rgb().unwrap(), rgb);
            for number in 0..whole.levels() {
                assert_eq!(whole.level(number).to_rgb(), stored.level(number).to_rgb(), "{kind}: {number}");
            }
            for i in 0..2000 {
                let [s, t, side] = [12.9898, 78.233, 37.719].map(|k: f64| (f64::from(i) * k).fract());
                let look = |picture: &MipMap| {
                    let (footprint, filter) = (square(side.powi(4)), ImageFilter::ANISOTROPIC);
                    picture.lookup(DVec2::new(s, t), footprint, ImageWrap::Repeat, filter)
                };
                assert_eq!(look(&whole), look(&stored));
            }
            assert_eq!(format!("{whole:?}"), format!("{:?}", MipMap::try_new(&pixels).unwrap()));
            assert_eq!(cache.check(), Ok(()));
        }
    }
}
