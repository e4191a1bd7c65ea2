//! The film: accumulates samples into pixels.

mod format;
mod merge;
mod picture;
mod sums;

use std::borrow::Cow;
use std::ops::Range;

use crate::edges::EdgeLayer;
use crate::guide::{Guide, Training};
use crate::noise::{self, NOT_ENDED};
use crate::passes::Passes;
use crate::pixel::{PixelSums, Rejects};
use crate::pixel_rect::{PixelRect, TILE_SIDE};
use crate::ranges::SampleRanges;
use crate::sample_plan::{MissingSamples, SamplePlan, SamplePlans};
use crate::splat::SplatRows;
use crate::weighted_sums::{FEWEST_SAMPLES, PassWeights};
use glanz_sampling::exact::MAX_TERMS;

use self::sums::FilmSums;
pub use format::{FilmError, FilmFormat};
pub(crate) use sums::{FilmSumsWriter, to_bytes};

/// The buffers of a film, for threads to fill.
pub(crate) struct FilmParts<'a> {
    /// The tiles that have not ended, with their words.
    pub(crate) tiles: Vec<(PixelRect, &'a mut [u64])>,
    /// Target of splats.
    pub(crate) splats: SplatRows<'a>,
    /// Training state of the integrator.
    pub(crate) training: Option<&'a Training>,
}

/// The sums of all pixels, and the set of samples in them.
///
/// Sums are exact: the film depends on the added samples alone, not on the order, threads or portions.
///
/// A film with [passes](FilmFormat::passes) takes its samples in the order of their numbers. At the end of a pass, its light is
/// added to that of earlier passes with a weight that depends on its variance, see `weighted_sums`, and its training data become the
/// guide of the next pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    format: FilmFormat,
    /// The words of all pixels in their layout, tile after tile, then the splatted light, row by row.
    sums: FilmSums,
    samples: SampleRanges,
    rejects: Rejects,
    passes: Passes,
    /// Lines that are drawn over the picture.
    edges: Option<EdgeLayer>,
    /// Numbers of samples with which the tiles ended, or [`NOT_ENDED`]; empty without a noise level.
    tile_ends: Vec<u32>,
    /// Plans of samples that are rendered in parts, as long as samples are missing.
    plans: SamplePlans,
}

impl Film {
    /// A film without samples, in memory.
    ///
    /// # Errors
    /// [`FilmError::Size`], [`FilmError::Crop`] or [`FilmError::Noise`] for an invalid format, [`FilmError::Memory`] if memory is insufficient.
    pub fn try_new(format: FilmFormat) -> Result<Self, FilmError> {
        Self::try_new_within(format, u64::MAX)
    }

    /// A film without samples. Its sums are in memory if they take at most `memory` bytes, else in a temporary file: in the folder TMPDIR if that is set, else in /var/tmp or the usual one.
    ///
    /// # Errors
    /// As [`Film::try_new`]; [`FilmError::Limit`] if a film of the format [has to be in memory](FilmFormat::fits_in_file), and [`FilmError::File`] if
    /// the file cannot be made.
    pub fn try_new_within(format: FilmFormat, memory: u64) -> Result<Self, FilmError> {
        format.check_memory(memory)?;
        let sums = FilmSums::try_new(format.words()?, memory)?;
        let mut film = Self::without_samples(format, sums);
        let (layout, strips) = (format.layout(), film.strips());
        let mut first = vec![0; layout.words()];
        PixelSums::default().write(&layout, &mut first);
        // Not all sums start as zero bits: the shape's number starts as "none".
        if first.iter().any(|&word| word != 0) {
            let clear = |words: &mut [u64]| {
                words.chunks_exact_mut(first.len()).for_each(|pixel| pixel.copy_from_slice(&first))
            };
            strips.into_iter().try_for_each(|strip| film.sums.update(strip.words, clear))?;
        }
        Ok(film)
    }

    /// The film with the sums that were written.
    pub(crate) fn with_sums(self, sums: FilmSumsWriter) -> Result<Self, FilmError> {
        let sums = sums.finish();
        match self.format.words()? == sums.len() as u64 {
            true => Ok(Self { sums, ..self }),
            false => Err(FilmError::Layout("size")),
        }
    }

    /// A film with these samples, without their sums.
    pub(crate) fn try_from_state(
        format: FilmFormat,
        samples: SampleRanges,
        rejects: Rejects,
    ) -> Result<Self, FilmError> {
        format.words()?;
        if samples.total() > u64::from(MAX_TERMS) {
            return Err(FilmError::Samples(samples.total()));
        }
        Ok(Self { samples, rejects, ..Self::without_samples(format, FilmSums::Memory(Vec::new())) })
    }

    fn without_samples(format: FilmFormat, sums: FilmSums) -> Self {
        let (samples, rejects, passes) = Default::default();
        let tile_ends = format.noise.map_or(Vec::new(), |_| vec![NOT_ENDED; format.crop.tiles().count()]);
        Self { format, sums, samples, rejects, passes, edges: None, tile_ends, plans: SamplePlans::default() }
    }

    /// The film with these numbers of samples with which its tiles ended; `None` if they are not those of a film of its format and samples.
    pub(crate) fn with_tile_ends(mut self, tile_ends: Vec<u32>) -> Option<Self> {
        let total = self.samples.total();
        let fine =
            tile_ends.iter().all(|&end| end == NOT_ENDED || noise::is_check(end) && u64::from(end) <= total);
        if !fine || tile_ends.len() != self.tile_ends.len() {
            return None;
        }
        self.tile_ends = tile_ends;
        Some(self)
    }

    /// Numbers of samples with which the tiles ended, or [`NOT_ENDED`]; empty without a noise level.
    pub(crate) fn tile_ends(&self) -> &[u32] {
        &self.tile_ends
    }

    /// Number of samples of each pixel of a tile.
    pub(crate) fn samples_of_tile(&self, tile: usize) -> u64 {
        let total = self.samples.total();
        self.tile_ends.get(tile).map_or(total, |&end| u64::from(end).min(total))
    }

    /// Mean number of samples over all pixels.
    #[must_use]
    pub fn mean_samples(&self) -> f64 {
        let tiles = self.format.crop.tiles().enumerate();
        let samples: u64 = tiles.map(|(number, tile)| tile.len() * self.samples_of_tile(number)).sum();
        samples as f64 / self.format.crop.len() as f64
    }

    /// Number of tiles that have not ended at the noise level; 0 without one.
    #[must_use]
    pub fn open_tiles(&self) -> u64 {
        self.tile_ends.iter().filter(|&&end| end == NOT_ENDED).count() as u64
    }

    /// Whether all tiles have reached the noise level.
    pub(crate) fn is_converged(&self) -> bool {
        !self.tile_ends.is_empty() && self.tile_ends.iter().all(|&end| end != NOT_ENDED)
    }

    /// The film with this state of its passes.
    pub(crate) fn with_passes(mut self, passes: Passes) -> Self {
        self.passes = passes;
        self
    }

    /// The film with lines over its picture, drawn for its format, or without.
    ///
    /// # Errors
    /// [`FilmError::Edges`] if they are drawn for other pixels.
    pub fn with_edges(mut self, edges: Option<EdgeLayer>) -> Result<Self, FilmError> {
        let crop = self.format.crop;
        if let Some(layer) = edges.as_ref().filter(|layer| layer.crop != crop) {
            return Err(FilmError::Edges { drawn: layer.crop, crop });
        }
        self.edges = edges;
        Ok(self)
    }

    pub(crate) fn drop_edges(&mut self) {
        self.edges = None;
    }

    /// The lines over its picture.
    #[must_use]
    pub fn edges(&self) -> Option<&EdgeLayer> {
        self.edges.as_ref()
    }

    /// The state of its passes.
    pub(crate) fn passes(&self) -> &Passes {
        &self.passes
    }

    /// Training state of an integrator that learns.
    #[must_use]
    pub fn training(&self) -> Option<&Training> {
        self.passes.training.as_deref()
    }

    /// Adds plans of which the film has a part of the samples.
    pub fn add_plans(&mut self, plans: impl IntoIterator<Item = SamplePlan>) {
        self.plans.add(plans);
        self.plans.drop_finished(&self.samples);
    }

    /// Plans of which samples are missing.
    pub(crate) fn plans(&self) -> &SamplePlans {
        &self.plans
    }

    /// What is missing of the samples that are rendered in parts.
    #[must_use]
    pub fn missing_samples(&self) -> Vec<MissingSamples> {
        self.plans.missing(&self.samples)
    }

    /// Pixels and channels.
    #[must_use]
    pub fn format(&self) -> &FilmFormat {
        &self.format
    }

    /// The samples of every pixel; tiles that have ended have the first of them.
    #[must_use]
    pub fn samples(&self) -> &SampleRanges {
        &self.samples
    }

    /// Samples that were changed or dropped.
    #[must_use]
    pub fn rejects(&self) -> Rejects {
        self.rejects
    }

    /// Whether the sums are in a file, see [`Film::try_new_within`].
    #[must_use]
    pub fn is_in_file(&self) -> bool {
        self.sums.in_memory().is_none()
    }

    /// Number of words of all sums.
    pub(crate) fn word_count(&self) -> usize {
        self.sums.len()
    }

    /// The words of all sums in blocks: tile after tile, then those of splatted light, row by row.
    pub(crate) fn word_blocks(&self) -> impl Iterator<Item = Result<Cow<'_, [u64]>, FilmError>> {
        self.sums.blocks()
    }

    /// Number of words before those of the splats.
    fn own_words(&self) -> usize {
        (self.format.crop.len() as usize * self.format.layout().words()).min(self.sums.len())
    }

    /// The words of splatted light of a film in memory; a film in a file has none.
    fn splatted_words(&self) -> &[u64] {
        self.sums.in_memory().and_then(|words| words.get(self.own_words()..)).unwrap_or_default()
    }

    /// The parts of the pixels' own sums that are in memory at a time: all of a film in memory.
    pub(crate) fn strips(&self) -> Vec<FilmStrip> {
        self.strips_of(&(0..self.format.crop.size[1]))
    }

    /// As [`Film::strips`], of the tiles with these rows.
    fn strips_of(&self, rows: &Range<u32>) -> Vec<FilmStrip> {
        let [width, height] = self.format.crop.size;
        let stride = width as usize * self.format.layout().words();
        let side = TILE_SIDE as usize;
        let together = match self.sums.limit() {
            Some(limit) => (limit / (stride * side)).max(1) * side,
            None => height.next_multiple_of(TILE_SIDE) as usize,
        };
        let columns = width.div_ceil(TILE_SIDE) as usize;
        let first = (rows.start / TILE_SIDE * TILE_SIDE) as usize;
        let height = rows.end.next_multiple_of(TILE_SIDE).min(height) as usize;
        let starts = (first..height).step_by(together);
        let strips = starts.map(|start| {
            let end = height.min(start + together);
            FilmStrip {
                rows: start as u32..end as u32,
                words: start * stride..(end * stride).min(self.own_words()),
                first_tile: start / side * columns,
            }
        });
        strips.collect()
    }

    /// Calls `work` with the tiles of a film in a file, strip after strip.
    pub(crate) fn update_strips<T, E: From<FilmError>>(
        &mut self,
        mut work: impl FnMut(Vec<(PixelRect, &mut [u64])>) -> Result<T, E>,
    ) -> Result<Vec<T>, E> {
        let (format, strips) = (self.format, self.strips());
        let update = |strip: FilmStrip| {
            let rect = strip.rect(&format);
            self.sums.update(strip.words, |words| work(tiles_of(&rect, &format, words)))?
        };
        strips.into_iter().map(update).collect()
    }

    /// Begins the training if it has not begun.
    pub(crate) fn begin_training(&mut self, guide: Guide) {
        self.passes.training.get_or_insert_with(|| Box::new(Training::new(guide)));
    }

    /// End of the pass that contains sample `next`, or the next check of noise; `None` for films without passes and noise level.
    pub(crate) fn end_of_pass(&self, next: u32) -> Option<u32> {
        let check = self.format.noise.map(|_| noise::next_check(next));
        check.or_else(|| self.format.passes.then(|| self.passes.end_of_pass(next)))
    }

    /// Buffers of a film in memory for threads to fill, without those of tiles that have ended. [`Film::finish_pass`] must follow.
    pub(crate) fn parts_mut(&mut self) -> FilmParts<'_> {
        let (format, own) = (self.format, self.own_words());
        let words = self.sums.in_memory_mut().unwrap_or_default();
        let (own, splats) = words.split_at_mut(own.min(words.len()));
        let tiles = tiles_of(&format.crop, &format, own).into_iter().enumerate();
        let is_open = |tile: usize| self.tile_ends.get(tile).is_none_or(|&end| end == NOT_ENDED);
        let tiles = tiles.filter(|(number, _)| is_open(*number)).map(|(_, tile)| tile).collect();
        let splats = SplatRows::new(format.crop, format.splat_layout(), splats);
        FilmParts { tiles, splats, training: self.passes.training.as_deref() }
    }

    /// Records that every pixel of a tile that has not ended has the samples of `range`.
    pub(crate) fn finish_pass(&mut self, range: Range<u32>, rejects: Rejects) -> Result<(), FilmError> {
        let over = self.format.passes && self.passes.end_of_pass(range.start) == range.end;
        self.samples.insert(range)?;
        self.plans.drop_finished(&self.samples);
        self.rejects.merge(rejects);
        if over {
            self.settle();
        }
        let total = u32::try_from(self.samples.total()).unwrap_or(NOT_ENDED);
        if let Some(level) = self.format.noise.filter(|_| noise::is_check(total)) {
            let converged = noise::converged_tiles(self, level);
            let ending = self
                .tile_ends
                .iter_mut()
                .zip(converged)
                .filter(|(end, converged)| *converged && **end == NOT_ENDED);
            ending.for_each(|(end, _)| *end = total);
        }
        Ok(())
    }

    /// Ends a pass of a learning integrator.
    fn settle(&mut self) {
        self.passes.fit_guide(self.brightness());
        let Some(blend) = self.passes.settled(self.samples.total(), self.precision()) else { return };
        let layout = self.format.layout();
        let own = self.own_words();
        let words = self.sums.in_memory_mut().and_then(|words| words.get_mut(..own)).unwrap_or_default();
        for words in words.chunks_exact_mut(layout.words()) {
            let mut sums = PixelSums::read(&layout, words);
            sums.settle(&blend);
            sums.write(&layout, words);
        }
    }

    /// Reciprocal of the mean variance of a sample of the current pass, if that is known well enough.
    fn precision(&self) -> Option<f64> {
        let count = self.samples.total() - self.passes.samples;
        let pixels = self.format.crop.len();
        if count < 2 || count.saturating_mul(pixels) < FEWEST_SAMPLES {
            return None;
        }
        let variance: f64 = self.pixels().map(|(_, _, sums)| sums.sample_variance(count)).sum();
        let mean = variance / pixels as f64;
        (mean > 0.0 && mean.is_finite()).then(|| 1.0 / mean)
    }

    /// Weights of the samples of the current pass and of finished passes.
    fn blend(&self) -> PassWeights {
        if !self.format.passes {
            return PassWeights::plain(self.samples.total());
        }
        self.passes.blend(self.samples.total(), self.precision())
    }

    /// Mean of all pixels and bands.
    fn brightness(&self) -> f64 {
        let blend = self.blend();
        let sum: f64 =
            self.pixels().flat_map(|(_, _, sums)| sums.blended(&blend)).map(|value| value.mean).sum();
        sum / (3.0 * self.format.crop.len() as f64)
    }

    /// Whether no sample and no splat brought light to any pixel.
    ///
    /// # Errors
    /// [`FilmError::File`] if a film in a file cannot be read.
    pub fn is_black(&self) -> Result<bool, FilmError> {
        let blend = self.blend();
        let is_dark = |sums: PixelSums| sums.blended(&blend).iter().all(|value| value.mean == 0.0);
        if self.splatted_words().iter().any(|&word| word != 0) {
            return Ok(false);
        }
        for strip in self.strips() {
            let words = self.sums.get(strip.words.clone())?;
            if !self.pixels_of(&strip, &words).all(|(_, _, sums)| is_dark(sums)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The sums of every pixel of a film in memory with the number of its tile and its position in the crop window.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (usize, [u32; 2], PixelSums)> {
        let words = self.sums.in_memory().unwrap_or_default();
        let rows = 0..self.format.crop.size[1];
        let strip = FilmStrip { rows, words: 0..self.own_words(), first_tile: 0 };
        self.pixels_of(&strip, &words[..self.own_words().min(words.len())])
    }

    /// As [`Film::pixels`], of a strip with these words.
    fn pixels_of<'w>(
        &self,
        strip: &FilmStrip,
        words: &'w [u64],
    ) -> impl Iterator<Item = (usize, [u32; 2], PixelSums)> + use<'w> {
        let layout = self.format.layout();
        let origin = self.format.crop.min;
        let tiles = strip.rect(&self.format).tiles().zip(strip.first_tile..);
        let places = tiles.flat_map(|(rect, tile)| rect.pixels().map(move |pixel| (tile, pixel)));
        places.zip(words.chunks_exact(layout.words())).map(move |((tile, [x, y]), words)| {
            (tile, [x - origin[0], y - origin[1]], PixelSums::read(&layout, words))
        })
    }
}

/// Some rows of tiles of a film.
#[derive(Clone, Debug)]
pub(crate) struct FilmStrip {
    /// Its rows in the crop window, those of whole tiles.
    pub(crate) rows: Range<u32>,
    /// Positions of its words among those of the film.
    words: Range<usize>,
    /// Number of its first tile.
    first_tile: usize,
}

impl FilmStrip {
    fn rect(&self, format: &FilmFormat) -> PixelRect {
        let PixelRect { min: [x, y], size: [width, _] } = format.crop;
        PixelRect { min: [x, y + self.rows.start], size: [width, self.rows.end - self.rows.start] }
    }
}

/// The tiles of a part of a film with these words.
fn tiles_of<'w>(
    part: &PixelRect,
    format: &FilmFormat,
    mut words: &'w mut [u64],
) -> Vec<(PixelRect, &'w mut [u64])> {
    let stride = format.layout().words();
    let mut tiles = Vec::new();
    for tile in part.tiles() {
        let Some((own, rest)) = words.split_at_mut_checked(tile.len() as usize * stride) else { break };
        tiles.push((tile, own));
        words = rest;
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aov::AovSet;
    use crate::pixel::PixelSample;
    use crate::ranges::OverlapError;

    /// Fills samples `range` with values that differ by pixel and sample.
    fn expose(film: &mut Film, range: Range<u32>) {
        let layout = film.format().layout();
        let mut rejects = Rejects::default();
        for (tile, words) in film.parts_mut().tiles {
            for ([x, y], words) in tile.pixels().zip(words.chunks_exact_mut(layout.words())) {
                let mut sums = PixelSums::read(&layout, words);
                for index in range.clone() {
                    let value = (x * 100 + y) as f32 + (index as f32 * 0.7).sin();
                    let rgb = [value, value * 1e-6, value * 1e6];
                    let negative = layout.signed && index % 7 == 3;
                    sums.add(&layout, &PixelSample { index, rgb, negative, first_hit: None }, &mut rejects);
                }
                sums.write(&layout, words);
            }
        }
        film.finish_pass(range, rejects).unwrap();
    }

    fn format() -> FilmFormat {
        let crop = PixelRect { min: [3, 5], size: [37, 18] };
        FilmFormat {
            resolution: [60, 40],
            crop,
            aovs: AovSet::ALL,
            signed: true,
            passes: false,
            splats: false,
            noise: None,
        }
    }

    #[test]
    fn merged_halves_are_the_whole_bit_for_bit() {
        let mut whole = Film::try_new(format()).unwrap();
        expose(&mut whole, 0..50);
        for cut in [1, 17, 49] {
            let (mut a, mut b) = (Film::try_new(format()).unwrap(), Film::try_new(format()).unwrap());
            expose(&mut b, cut..50);
            expose(&mut a, 0..cut);
            b.merge(&a).unwrap();
            assert_eq!(b, whole);
        }
        assert_eq!(whole.samples().total(), 50);
    }

    #[test]
    fn pixels_keep_their_positions() {
        let plain = FilmFormat { aovs: AovSet::NONE, signed: false, ..format() };
        let mut film = Film::try_new(plain).unwrap();
        expose(&mut film, 0..1);
        let picture = film.to_pixels().unwrap();
        assert_eq!((picture.width(), picture.height()), (37, 18));
        let red = picture.channel("R").unwrap();
        assert_eq!(red[0], 305.0);
        assert_eq!(red[36], 3905.0);
        assert_eq!(red[17 * 37 + 20], 2322.0);
    }

    #[test]
    fn channels_are_named_as_in_pbrt() {
        let film = Film::try_new(format()).unwrap();
        let picture = film.to_pixels().unwrap();
        let names: Vec<_> = picture.channels().iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names.len(), 3 + 3 + 3 + 3 + 3 + 2 + 1 + 1 + 3);
        for name in ["R", "Albedo.G", "P.X", "N.Z", "Ns.Y", "u", "v", "Z", "id", "Variance.B"] {
            assert!(names.contains(&name), "{name}");
        }
        assert!(picture.channel("id").unwrap().iter().all(|&id| id == -1.0));
    }

    fn lines(crop: PixelRect) -> EdgeLayer {
        EdgeLayer { crop, color: [0.0; 3], coverage: vec![0; crop.len() as usize] }
    }

    #[test]
    fn edges_for_other_pixels_are_refused() {
        let crop = format().crop;
        let [width, height] = crop.size;
        for size in [[width + 1, height], [width, height - 1], [height, width]] {
            let drawn = PixelRect { size, ..crop };
            let refused = Film::try_new(format()).unwrap().with_edges(Some(lines(drawn)));
            assert_eq!(refused, Err(FilmError::Edges { drawn, crop }));
        }
        let film = Film::try_new(format()).unwrap().with_edges(Some(lines(crop))).unwrap();
        assert!(film.edges().is_some() && film.with_edges(None).unwrap().edges().is_none());
    }

    #[test]
    fn films_of_other_pictures_and_common_samples_are_refused() {
        let mut film = Film::try_new(format()).unwrap();
        let other = Film::try_new(FilmFormat { aovs: AovSet::NONE, ..format() }).unwrap();
        assert!(matches!(film.merge(&other), Err(FilmError::Layout(_))));
        let other = Film::try_new(format()).unwrap().with_edges(Some(lines(format().crop))).unwrap();
        assert_eq!(film.merge(&other), Err(FilmError::Layout("edges over the picture")));
        expose(&mut film, 0..4);
        let same = film.clone();
        assert_eq!(film.merge(&same), Err(FilmError::Overlap(OverlapError(0..4))));
        assert_eq!(film, same);
    }

    #[test]
    fn invalid_formats_are_refused() {
        assert_eq!(Film::try_new(FilmFormat::plain([0, 5])), Err(FilmError::Size(0, 5)));
        assert_eq!(
            Film::try_new(FilmFormat::plain([u32::MAX, u32::MAX])),
            Err(FilmError::Size(u32::MAX, u32::MAX))
        );
        let outside = FilmFormat { crop: PixelRect { min: [50, 0], size: [11, 1] }, ..format() };
        assert!(matches!(Film::try_new(outside), Err(FilmError::Crop { .. })));
    }
}
