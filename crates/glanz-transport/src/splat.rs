//! Splats: light of paths from lights, at any position of the film.
//!
//! A sample of the film traces one path from a light for each pixel, together with the pixel's own sample; these paths may contribute
//! to any pixel. Their sums are separate from those of the pixels' own samples. They are exact as well, so that they do not depend
//! on threads and order.

use std::sync::{Mutex, PoisonError};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_sampling::exact::{SquareSum, WideSum, fits_wide};

use crate::filter::Filter;
use crate::pixel::{PixelValue, Rejects};
use crate::pixel_rect::PixelRect;
use crate::sensor::FilmSensor;
use crate::word_merge::WordMerge;

/// Number of splats that a thread collects before it adds them to the film.
const BUFFERED: usize = 4096;

/// Light of one path at a point of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Splat {
    /// Position in pixels from the top left of the full picture.
    pub(crate) film: DVec2,
    /// Radiance of a pixel that receives all of it.
    pub(crate) light: Spectrum,
    /// A number uniform in [0, 1) that selects the pixel.
    pub(crate) xi: f64,
}

/// Layout of the sums of splats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SplatLayout {
    /// Whether squares are summed for the variance.
    pub(crate) squares: bool,
}

impl SplatLayout {
    /// Number of 64 bit words of one pixel.
    pub(crate) fn words(self) -> usize {
        self.merges().into_iter().map(WordMerge::words).sum()
    }

    /// How the sums of two pixels are merged, in the order of their words.
    pub(crate) fn merges(self) -> Vec<WordMerge> {
        let squares = if self.squares { 3 } else { 0 };
        [vec![WordMerge::Add(2); 3], vec![WordMerge::Add(3); squares]].concat()
    }
}

/// The sums of splats of one pixel.
///
/// Each has room for at least 2^30 terms of the largest magnitude, and for accordingly more smaller terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SplatSums {
    light: [WideSum; 3],
    squares: [SquareSum; 3],
}

impl SplatSums {
    /// The sums in `words`, whose length is [`SplatLayout::words`].
    pub(crate) fn read(words: &[u64]) -> Self {
        let mut words = words.iter().copied();
        let mut next = || words.next().unwrap_or_default();
        let light = std::array::from_fn(|_| WideSum::from_words([next(), next()]));
        let squares = std::array::from_fn(|_| SquareSum::from_words([next(), next(), next()]));
        Self { light, squares }
    }

    /// Writes the sums to `words`.
    pub(crate) fn write(self, words: &mut [u64]) {
        let light = self.light.into_iter().flat_map(WideSum::to_words);
        let squares = self.squares.into_iter().flat_map(SquareSum::to_words);
        words.iter_mut().zip(light.chain(squares)).for_each(|(slot, word)| *slot = word);
    }

    /// Adds the contribution of one path to the pixel. Values that are not finite are dropped and counted.
    fn add(&mut self, rgb: [f32; 3], rejects: &mut Rejects) {
        if !rgb.iter().all(|v| v.is_finite()) {
            rejects.dropped += 1;
            return;
        }
        rejects.cut += u64::from(!rgb.iter().all(|&v| fits_wide(f64::from(v))));
        for (i, value) in rgb.into_iter().enumerate() {
            self.light[i].add(f64::from(value));
            self.squares[i].add_square(value);
        }
    }

    /// Splatted radiance of the pixel and its variance, per band, after `samples` of the film of `pixels` each.
    ///
    /// With s samples of N pixels there are n = s N light paths; path i contributes y_i (mostly 0), and the pixel is Y = sum y_i / s.
    /// The y_i are independent and identically distributed, so Var Y = n Var(y) / s^2, with the estimate (sum y_i^2 - (sum y_i)^2 / n) / (n
    /// - 1) of Var(y).
    pub(crate) fn values(&self, samples: u64, pixels: u64) -> [PixelValue; 3] {
        let s = samples.max(1) as f64;
        let n = s * pixels as f64;
        std::array::from_fn(|i| {
            let (sum, squares) = (self.light[i].to_f64(), self.squares[i].to_f64());
            let deviation = (squares - sum * sum / n).max(0.0);
            let variance = if n > 1.0 { n / (n - 1.0) * deviation / (s * s) } else { f64::INFINITY };
            PixelValue { mean: sum / s, variance }
        })
    }
}

/// The sums of a film, for threads to add to.
pub(crate) struct SplatRows<'a> {
    crop: PixelRect,
    layout: SplatLayout,
    rows: Vec<Mutex<&'a mut [u64]>>,
}

impl<'a> SplatRows<'a> {
    /// `words`: those of all pixels of `crop`, row by row; empty if the film takes no splats.
    pub(crate) fn new(crop: PixelRect, layout: SplatLayout, words: &'a mut [u64]) -> Self {
        let row = layout.words() * crop.size[0] as usize;
        let rows = words.chunks_exact_mut(row.max(1)).map(Mutex::new).collect();
        Self { crop, layout, rows }
    }
}

/// Buffer for the splats of one thread.
#[derive(Debug, Default)]
pub(crate) struct SplatBuffer {
    /// Row, column and light.
    splats: Vec<(u32, u32, [f32; 3])>,
    /// Index of the last path's first splat.
    path: usize,
}

impl SplatBuffer {
    /// Adds the splats of one path, each to one pixel of `rows` around it, selected in proportion to the filter's magnitude.
    pub(crate) fn take(
        &mut self,
        splats: &[Splat],
        (filter, sensor): (&Filter, &FilmSensor),
        rows: &SplatRows<'_>,
        rejects: &mut Rejects,
    ) {
        self.path = self.splats.len();
        for splat in splats {
            let Some((pixel, weight)) = filter.pick_pixel(splat.film, &rows.crop, splat.xi) else { continue };
            let light = splat.light * weight as f32;
            self.splats.push((
                pixel[1] - rows.crop.min[1],
                pixel[0] - rows.crop.min[0],
                sensor.exposed(light.to_rgb(&Wavelengths::default())),
            ));
        }
        self.join();
        if self.splats.len() >= BUFFERED {
            self.flush(rows, rejects);
        }
    }

    /// Merges splats of the last path in the same pixel, which are correlated: the variance needs the square of their sum.
    fn join(&mut self) {
        let Some(own) = self.splats.get_mut(self.path..).filter(|own| own.len() > 1) else { return };
        own.sort_by_key(|&(y, x, _)| (y, x));
        let joined = own.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter_map(|same| {
            let &(y, x, _) = same.first()?;
            Some((y, x, std::array::from_fn(|i| same.iter().map(|&(_, _, rgb)| rgb[i]).sum())))
        });
        let joined: Vec<_> = joined.collect();
        self.splats.truncate(self.path);
        self.splats.extend(joined);
    }

    /// Adds all splats to the film.
    pub(crate) fn flush(&mut self, rows: &SplatRows<'_>, rejects: &mut Rejects) {
        // Row by row, so that each row is locked once.
        self.splats.sort_unstable_by_key(|&(y, _, _)| y);
        let stride = rows.layout.words();
        for same in self.splats.chunk_by(|a, b| a.0 == b.0) {
            let Some(row) = same.first().and_then(|&(y, _, _)| rows.rows.get(y as usize)) else { continue };
            // A thread that panicked with the lock has ended the render; sums are consistent between two calls.
            let mut words = row.lock().unwrap_or_else(PoisonError::into_inner);
            for &(_, x, rgb) in same {
                let start = x as usize * stride;
                if let Some(words) = words.get_mut(start..start + stride) {
                    let mut sums = SplatSums::read(words);
                    sums.add(rgb, rejects);
                    sums.write(words);
                }
            }
        }
        self.splats.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_scene::description::{FilterDescription, FilterKind};

    fn box_filter() -> Filter {
        Filter::try_new(&FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] }).unwrap()
    }

    /// The sums after one thread has added paths with these splats, over a crop window of 3 x 2 pixels at (10, 20).
    fn sums(paths: &[&[Splat]]) -> (Vec<SplatSums>, Rejects) {
        let (layout, crop) = (SplatLayout { squares: true }, PixelRect { min: [10, 20], size: [3, 2] });
        let mut words = vec![0; 6 * layout.words()];
        let rows = SplatRows::new(crop, layout, &mut words);
        let (mut buffer, mut rejects) = (SplatBuffer::default(), Rejects::default());
        for path in paths {
            buffer.take(path, (&box_filter(), &FilmSensor::default()), &rows, &mut rejects);
        }
        buffer.flush(&rows, &mut rejects);
        drop(rows);
        (words.chunks_exact(layout.words()).map(SplatSums::read).collect(), rejects)
    }

    fn splat(x: f64, y: f64, light: f32) -> Splat {
        Splat { film: DVec2::new(x, y), light: Spectrum::splat(light), xi: 0.5 }
    }

    #[test]
    fn splats_are_added_to_their_pixels_and_ignored_outside_the_window() {
        let (sums, rejects) =
            sums(&[&[splat(12.3, 21.9, 1.0), splat(9.9, 20.5, 1.0), splat(13.1, 20.5, 1.0)]]);
        let red: Vec<f64> = sums.iter().map(|s| s.values(1, 6)[0].mean).collect();
        assert_eq!(red, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(rejects, Rejects::default());
    }

    #[test]
    fn variance_is_that_of_the_contributions_of_whole_paths() {
        // Two samples of 6 pixels: 12 paths, of which one contributes 1 + 2 to pixel 0, one 5, the others 0. Y = 8 / 2;
        // (9 + 25 - 64 / 12) * 12 / 11 / 4.
        let (sums, _) = sums(&[&[splat(10.2, 20.2, 1.0), splat(10.8, 20.8, 2.0)], &[splat(10.5, 20.5, 5.0)]]);
        let value = sums[0].values(2, 6)[1];
        assert_eq!(value.mean, 4.0);
        assert!((value.variance - (34.0 - 64.0 / 12.0) * 12.0 / 11.0 / 4.0).abs() < 1e-14);
    }

    #[test]
    fn splats_that_are_not_finite_are_dropped_and_huge_ones_clamped_and_counted() {
        let path = [splat(10.5, 20.5, f32::NAN), splat(11.5, 20.5, f32::MAX / 4.0), splat(12.5, 20.5, 1.0)];
        let (sums, rejects) = sums(&[&path]);
        assert_eq!(rejects, Rejects { dropped: 1, cut: 1 });
        assert_eq!(sums[0], SplatSums::default());
        assert_eq!(sums[2].values(1, 6)[2].mean, 1.0);
    }

    #[test]
    fn order_of_paths_and_full_buffers_do_not_change_a_bit() {
        let paths: Vec<Splat> =
            (0..10_000).map(|i| splat(10.0 + f64::from(i % 7) * 0.4, 21.5, (i as f32).sin())).collect();
        let forwards: Vec<&[Splat]> = paths.chunks(1).collect();
        let backwards: Vec<&[Splat]> = paths.chunks(1).rev().collect();
        assert_eq!(sums(&forwards), sums(&backwards));
    }
}
