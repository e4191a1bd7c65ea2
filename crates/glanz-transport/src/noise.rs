//! Adaptive numbers of samples: tiles of the film take samples until their noise is at a level.
//!
//! After 32 samples, and each time their number has grown by half, every tile is checked. Its noise is the root mean square of the standard
//! errors of its pixels' luminance, relative to the mean luminance of the tile, or to a tenth of that of the picture if the tile is darker. A tile
//! ends when the noise of it and of the tiles around it is at most the level, or was when they ended. Checks take place at fixed numbers of samples, so that the
//! picture depends on scene, settings, seed and level alone.
//!
//! A tile whose samples happen to be even ends early, so that its mean is not strictly unbiased: for 256 pixels of skewness s and n samples by about
//! s / (300 sqrt(n)) of the standard error of a pixel, more in smaller tiles. Light that all samples of a tile and of the eight around it miss (73728 at
//! the first check) is lost; photons are common to all pixels of a sample number, so that a caustic that 32 maps miss is lost as well, and their blur, which is no
//! noise, stays as it is where a tile ends.

use crate::film::Film;
use crate::pixel::PixelValue;
use crate::pixel_rect::{PixelRect, TILE_SIDE};

/// Number of samples of the first check.
const FIRST_CHECK: u32 = 32;

/// Mean luminance below which a tile is judged as if it had this, relative to that of the picture.
const DARK: f64 = 0.1;

/// Stands for the end of a tile that has not ended.
pub(crate) const NOT_ENDED: u32 = u32::MAX;

/// A relative standard error, in millionths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoiseLevel(u32);

impl NoiseLevel {
    /// The level of a relative standard error in [10^-6, 1]; `None` for other numbers.
    #[must_use]
    pub fn try_new(error: f64) -> Option<Self> {
        (1e-6..=1.0).contains(&error).then(|| Self((1e6 * error).round() as u32))
    }

    /// The relative standard error.
    #[must_use]
    pub fn error(self) -> f64 {
        f64::from(self.0) / 1e6
    }

    /// In millionths.
    pub(crate) fn millionths(self) -> u32 {
        self.0
    }
}

/// The number of samples of the first check after `samples`.
pub(crate) fn next_check(samples: u32) -> u32 {
    let mut check = FIRST_CHECK;
    while check <= samples {
        check = check.saturating_add(check / 2);
        if check == u32::MAX {
            break;
        }
    }
    check
}

/// Whether tiles are checked at this number of samples.
pub(crate) fn is_check(samples: u32) -> bool {
    samples > 0 && next_check(samples - 1) == samples
}

/// Noise of the tiles of a film that takes samples until a [`NoiseLevel`] is reached.
#[derive(Clone, Copy, Debug, Default)]
struct TileNoise {
    /// Sums over pixels of the luminance, and of the variance of its mean.
    luminance: f64,
    variance: f64,
    pixels: f64,
}

impl TileNoise {
    fn add(&mut self, bands: &[PixelValue; 3]) {
        let [r, g, b] = bands.map(|band| band.mean);
        // The errors of the bands are assumed to be the same light: an upper bound.
        let [dr, dg, db] = bands.map(|band| band.variance.max(0.0).sqrt());
        self.luminance += glanz_light::rgb::luminance([r, g, b]);
        self.variance += glanz_light::rgb::luminance([dr, dg, db]).powi(2);
        self.pixels += 1.0;
    }

    /// Relative standard error of a pixel. `picture`: mean luminance of the picture.
    fn relative_error(&self, picture: f64) -> f64 {
        let error = (self.variance / self.pixels).sqrt();
        let reference = (self.luminance / self.pixels).max(DARK * picture);
        // A black picture has no noise.
        if error == 0.0 { 0.0 } else { error / reference }
    }
}

/// Relative standard error of every tile.
fn noise_of_tiles(film: &Film) -> Vec<f64> {
    let mut tiles = vec![TileNoise::default(); film.format().crop.tiles().count()];
    for (tile, _, sums) in film.pixels() {
        if let Some(noise) = tiles.get_mut(tile) {
            noise.add(&sums.radiance(film.samples_of_tile(tile)));
        }
    }
    let pixels: f64 = tiles.iter().map(|tile| tile.pixels).sum();
    let picture = tiles.iter().map(|tile| tile.luminance).sum::<f64>() / pixels;
    tiles.iter().map(|tile| tile.relative_error(picture)).collect()
}

/// The tiles whose noise, and that of those around them, is at most `level` or was when they ended, in the order of [`PixelRect::tiles`].
pub(crate) fn converged_tiles(film: &Film, level: NoiseLevel) -> Vec<bool> {
    let noise = noise_of_tiles(film);
    let PixelRect { size, .. } = film.format().crop;
    let [columns, rows] = size.map(|side| side.div_ceil(TILE_SIDE) as usize);
    let is_converged = |column: usize, row: usize| {
        let tile = row * columns + column;
        // The picture, to which dark tiles are compared, may get darker after a tile has ended: it must not hold up its neighbours then.
        film.tile_ends().get(tile).is_some_and(|&end| end != NOT_ENDED)
            || noise.get(tile).is_none_or(|&noise| noise <= level.error())
    };
    let around = |middle: usize, count: usize| middle.saturating_sub(1)..(middle + 2).min(count);
    let all_converged =
        |column, row| around(row, rows).all(|y| around(column, columns).all(|x| is_converged(x, y)));
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (column, row)))
        .map(|(x, y)| all_converged(x, y))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aov::{Aov, AovSet};
    use crate::film::FilmFormat;
    use crate::pixel::{PixelSample, PixelSums, Rejects};

    #[test]
    fn checks_come_at_32_samples_and_after_each_growth_by_half() {
        let mut checks = vec![];
        let mut samples = 0;
        while samples < 300 {
            samples = next_check(samples);
            checks.push(samples);
        }
        assert_eq!(checks, [32, 48, 72, 108, 162, 243, 364]);
        assert!((0..400).all(|n| is_check(n) == checks.contains(&n)));
        assert_eq!(next_check(u32::MAX), u32::MAX);
    }

    #[test]
    fn tiles_that_have_ended_do_not_hold_up_their_neighbours() {
        let level = NoiseLevel::try_new(0.02);
        let aovs = AovSet::NONE.with(Aov::Variance);
        let format = FilmFormat { aovs, noise: level, ..FilmFormat::plain([3 * TILE_SIDE, TILE_SIDE]) };
        let (mut film, layout) = (Film::try_new(format).unwrap(), format.layout());
        let mut rejects = Rejects::default();
        for (tile, words) in film.parts_mut().tiles {
            for words in words.chunks_exact_mut(layout.words()) {
                let mut sums = PixelSums::read(&layout, words);
                for index in 0..FIRST_CHECK {
                    // In the middle 0.01 +- 0.01 in turn: a standard error of 0.0018, 2.6 % of a tenth of the picture.
                    let is_dark = tile.min[0] == TILE_SIDE;
                    let value = if is_dark { 0.02 * (index % 2) as f32 } else { 1.0 };
                    let sample = PixelSample { index, rgb: [value; 3], negative: false, first_hit: None };
                    sums.add(&layout, &sample, &mut rejects);
                }
                sums.write(&layout, words);
            }
        }
        film.finish_pass(0..FIRST_CHECK, rejects).unwrap();
        assert_eq!(film.tile_ends(), [NOT_ENDED; 3]);
        assert_eq!(converged_tiles(&film, level.unwrap()), [false; 3]);
        let film = film.with_tile_ends(vec![NOT_ENDED, FIRST_CHECK, NOT_ENDED]).unwrap();
        assert_eq!(converged_tiles(&film, level.unwrap()), [true; 3]);
    }

    #[test]
    fn levels_are_errors_above_zero() {
        for error in [0.02, 0.05, 0.07, 0.1, 1.0] {
            assert_eq!(NoiseLevel::try_new(error).map(NoiseLevel::error), Some(error));
        }
        for error in [0.0, -1.0, 1.5, f64::NAN, f64::INFINITY] {
            assert_eq!(NoiseLevel::try_new(error), None);
        }
    }
}
