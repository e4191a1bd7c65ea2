//! Where samples become pixels.

use glanz_light::{Pixels, PixelsError};

use crate::aov::{Aov, AovSet};
use crate::guide::{Guide, Training};
use crate::passes::Passes;
use crate::pixel::{FirstHit, PixelLayout, PixelSums, PixelValue, Rejects};
use crate::pixel_rect::PixelRect;
use crate::ranges::{OverlapError, SampleRanges};
use crate::settled::{Blend, FEWEST_SAMPLES};
use glanz_sampling::exact::MAX_TERMS;

/// Why a film cannot be made or joined with another.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// No pixels, or more than 2^31.
    #[error("a picture of {0} x {1} pixels cannot be held")]
    Size(u32, u32),
    /// A crop window that is empty or leaves the picture.
    #[error("the crop window {window:?} is empty or leaves the picture of {} x {} pixels", .resolution[0], .resolution[1])]
    Crop {
        /// Smallest and largest x, then y.
        window: [f64; 4],
        /// Width and height of the full picture.
        resolution: [u32; 2],
    },
    /// The sums do not fit in memory.
    #[error("there is no memory for a film of {0} bytes")]
    Memory(u64),
    /// Two films of different pictures.
    #[error("the films differ in {0}")]
    Layout(&'static str),
    /// Two films with common samples.
    #[error(transparent)]
    Overlap(#[from] OverlapError),
    /// A film that learns cannot take samples that were taken elsewhere.
    #[error("its samples build on one another")]
    Learning,
    /// More samples than the sums can hold exactly.
    #[error("{0} samples per pixel are more than the {MAX_TERMS} a film can hold")]
    Samples(u64),
}

/// Which pixels a film holds and what it adds up for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmFormat {
    /// Width and height of the full picture.
    pub resolution: [u32; 2],
    /// The part that is rendered.
    pub crop: PixelRect,
    /// Extra channels.
    pub aovs: AovSet,
    /// Whether the filter has negative lobes.
    pub signed: bool,
    /// Whether samples come in passes of different variance, from an integrator that
    /// [learns](crate::Integrator::learns).
    pub passes: bool,
}

impl FilmFormat {
    /// The whole picture without extra channels, for a filter without negative lobes.
    #[must_use]
    pub const fn plain(resolution: [u32; 2]) -> Self {
        Self {
            resolution,
            crop: PixelRect::full(resolution),
            aovs: AovSet::NONE,
            signed: false,
            passes: false,
        }
    }

    /// The sums of each pixel.
    #[must_use]
    pub fn layout(&self) -> PixelLayout {
        PixelLayout { aovs: self.aovs, signed: self.signed, passes: self.passes }
    }

    /// Number of 64 bit words that a film of this format holds.
    ///
    /// # Errors
    /// [`FilmError::Size`] and [`FilmError::Crop`] as [`Film::try_new`].
    pub fn words(&self) -> Result<u64, FilmError> {
        let [width, height] = self.crop.size;
        if self.crop.is_empty() || self.crop.len() > 1 << 31 {
            return Err(FilmError::Size(width, height));
        }
        let inside = (0..2).all(|i| {
            self.crop.min[i].checked_add(self.crop.size[i]).is_some_and(|end| end <= self.resolution[i])
        });
        if !inside {
            let [x, y] = self.crop.min.map(f64::from);
            let window = [x, x + f64::from(width), y, y + f64::from(height)];
            return Err(FilmError::Crop { window, resolution: self.resolution });
        }
        Ok(self.crop.len() * self.layout().words() as u64)
    }
}

/// The sums of all pixels, and which samples are in them.
///
/// Sums are exact: the film depends on which samples were added, not on when, by whom or in which portions.
///
/// A film with [passes](FilmFormat::passes) takes its samples in the order of their numbers. When a pass is over, its light is
/// put to that of the passes before with a weight that its variance decides, see `settled`, and what it learnt becomes the
/// guide of the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    format: FilmFormat,
    /// Pixel after pixel, tile after tile; every pixel as its layout says.
    words: Vec<u64>,
    samples: SampleRanges,
    rejects: Rejects,
    passes: Passes,
}

impl Film {
    /// A film without samples.
    ///
    /// # Errors
    /// [`FilmError::Size`], [`FilmError::Crop`] for an impossible format, [`FilmError::Memory`] if there is not enough.
    pub fn try_new(format: FilmFormat) -> Result<Self, FilmError> {
        let count = format.words()?;
        let mut words = Vec::new();
        let memory = || FilmError::Memory(count.saturating_mul(8));
        let length = usize::try_from(count).map_err(|_| memory())?;
        words.try_reserve_exact(length).map_err(|_| memory())?;
        words.resize(length, 0);
        let layout = format.layout();
        // Not all sums start at the bits of zero: that of the shape's number starts at "none".
        for pixel in words.chunks_exact_mut(layout.words()) {
            PixelSums::default().write(&layout, pixel);
        }
        let (samples, rejects, passes) = Default::default();
        Ok(Self { format, words, samples, rejects, passes })
    }

    /// A film from what [`Film::words`] gave.
    ///
    /// # Errors
    /// As [`Film::try_new`]; [`FilmError::Layout`] if there are not as many words as the format needs.
    pub fn try_from_words(
        format: FilmFormat,
        words: Vec<u64>,
        samples: SampleRanges,
        rejects: Rejects,
    ) -> Result<Self, FilmError> {
        if format.words()? != words.len() as u64 {
            return Err(FilmError::Layout("size"));
        }
        if samples.total() > u64::from(MAX_TERMS) {
            return Err(FilmError::Samples(samples.total()));
        }
        Ok(Self { format, words, samples, rejects, passes: Passes::default() })
    }

    /// The film with such a state of its passes.
    pub(crate) fn with_passes(mut self, passes: Passes) -> Self {
        self.passes = passes;
        self
    }

    /// The state of its passes.
    pub(crate) fn passes(&self) -> &Passes {
        &self.passes
    }

    /// What an integrator that learns has learnt.
    #[must_use]
    pub fn training(&self) -> Option<&Training> {
        self.passes.training.as_deref()
    }

    /// Pixels and channels.
    #[must_use]
    pub fn format(&self) -> &FilmFormat {
        &self.format
    }

    /// The samples that every pixel has.
    #[must_use]
    pub fn samples(&self) -> &SampleRanges {
        &self.samples
    }

    /// Samples that could not be taken as they came.
    #[must_use]
    pub fn rejects(&self) -> Rejects {
        self.rejects
    }

    /// The sums as words, tile after tile.
    #[must_use]
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Begins to learn, if it has not.
    pub(crate) fn begin_training(&mut self, guide: Guide) {
        self.passes.training.get_or_insert_with(|| Box::new(Training::new(guide)));
    }

    /// Where the pass ends that sample `next` belongs to; only films with passes have an end.
    pub(crate) fn end_of_pass(&self, next: u32) -> Option<u32> {
        self.format.passes.then(|| self.passes.end_of_pass(next))
    }

    /// The tiles with their words, for threads to fill, and what an integrator has learnt. [`Film::finish_pass`] has to follow.
    pub(crate) fn parts_mut(&mut self) -> (Vec<(PixelRect, &mut [u64])>, Option<&Training>) {
        let stride = self.format.layout().words();
        let mut rest = self.words.as_mut_slice();
        let mut tiles = Vec::new();
        for tile in self.format.crop.tiles() {
            let (words, tail) = rest.split_at_mut(tile.len() as usize * stride);
            tiles.push((tile, words));
            rest = tail;
        }
        (tiles, self.passes.training.as_deref())
    }

    /// Notes that every pixel got the samples of `range`.
    pub(crate) fn finish_pass(
        &mut self,
        range: std::ops::Range<u32>,
        rejects: Rejects,
    ) -> Result<(), FilmError> {
        let over = self.format.passes && self.passes.end_of_pass(range.start) == range.end;
        self.samples.insert(range)?;
        self.rejects.merge(rejects);
        if over {
            self.settle();
        }
        Ok(())
    }

    /// Ends a pass of an integrator that learns.
    fn settle(&mut self) {
        self.passes.teach(self.brightness());
        let Some(blend) = self.passes.settled(self.samples.total(), self.precision()) else { return };
        let layout = self.format.layout();
        for words in self.words.chunks_exact_mut(layout.words()) {
            let mut sums = PixelSums::read(&layout, words);
            sums.settle(&blend);
            sums.write(&layout, words);
        }
    }

    /// One over the mean variance of a sample of the pass under way, if that is known well.
    fn precision(&self) -> Option<f64> {
        let count = self.samples.total() - self.passes.samples;
        let pixels = self.format.crop.len();
        if count < 2 || count.saturating_mul(pixels) < FEWEST_SAMPLES {
            return None;
        }
        let variance: f64 = self.pixels().map(|(_, sums)| sums.sample_variance(count)).sum();
        let mean = variance / pixels as f64;
        (mean > 0.0 && mean.is_finite()).then(|| 1.0 / mean)
    }

    /// How the samples of the pass under way count beside those of passes that are over.
    fn blend(&self) -> Blend {
        if !self.format.passes {
            return Blend::plain(self.samples.total());
        }
        self.passes.blend(self.samples.total(), self.precision())
    }

    /// Mean of all pixels and bands.
    fn brightness(&self) -> f64 {
        let blend = self.blend();
        let sum: f64 = self.pixels().flat_map(|(_, sums)| sums.blended(&blend)).map(|value| value.mean).sum();
        sum / (3.0 * self.format.crop.len() as f64)
    }

    /// Adds the samples of another film of the same picture.
    ///
    /// # Errors
    /// [`FilmError::Layout`] if the formats differ, [`FilmError::Overlap`] if a sample is in both, and
    /// [`FilmError::Samples`] if there would be too many, [`FilmError::Learning`] for films with passes; this film is unchanged
    /// then.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.format != other.format {
            return Err(FilmError::Layout("size, crop, filter or channels"));
        }
        if self.format.passes {
            return Err(FilmError::Learning);
        }
        let total = self.samples.total() + other.samples.total();
        if total > u64::from(MAX_TERMS) {
            return Err(FilmError::Samples(total));
        }
        let mut samples = self.samples.clone();
        for range in other.samples.as_slice() {
            samples.insert(range.clone())?;
        }
        let layout = self.format.layout();
        let stride = layout.words();
        for (mine, theirs) in self.words.chunks_exact_mut(stride).zip(other.words.chunks_exact(stride)) {
            let mut sums = PixelSums::read(&layout, mine);
            sums.merge(&PixelSums::read(&layout, theirs));
            sums.write(&layout, mine);
        }
        self.samples = samples;
        self.rejects.merge(other.rejects);
        Ok(())
    }

    /// The sums of every pixel with its place in the crop window.
    fn pixels(&self) -> impl Iterator<Item = ([u32; 2], PixelSums)> {
        let layout = self.format.layout();
        let origin = self.format.crop.min;
        let places = self.format.crop.tiles().flat_map(|tile| tile.pixels());
        places
            .zip(self.words.chunks_exact(layout.words()))
            .map(move |([x, y], words)| ([x - origin[0], y - origin[1]], PixelSums::read(&layout, words)))
    }

    /// The picture of the crop window: `R G B` and the channels asked for.
    ///
    /// What [`PixelSums::radiance`] and [`PixelSums::first_hit`] say, rounded to `f32`. Where no sample hit anything,
    /// geometry and albedo are 0 and `id` is -1. A film without samples is black.
    ///
    /// # Errors
    /// [`PixelsError`] if the picture cannot be held.
    pub fn to_pixels(&self) -> Result<Pixels, PixelsError> {
        let [width, height] = self.format.crop.size;
        let mut pixels = Pixels::try_new(width, height)?;
        let names = channel_names(self.format.aovs);
        let mut planes: Vec<Vec<f32>> = names.iter().map(|_| vec![0.0; pixels.len()]).collect();
        let blend = self.blend();
        for ([x, y], sums) in self.pixels() {
            let at = y as usize * width as usize + x as usize;
            let values = channel_values(self.format.aovs, &sums.blended(&blend), sums.first_hit().as_ref());
            for (plane, value) in planes.iter_mut().zip(values) {
                plane[at] = value;
            }
        }
        for (name, plane) in names.iter().zip(planes) {
            pixels.add_channel(name, plane)?;
        }
        Ok(pixels)
    }
}

/// Channels of a picture with `aovs`, in their order.
#[must_use]
pub fn channel_names(aovs: AovSet) -> Vec<&'static str> {
    let mut names = vec!["R", "G", "B"];
    for aov in Aov::ALL.into_iter().filter(|&a| aovs.contains(a)) {
        names.extend_from_slice(match aov {
            Aov::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
            Aov::Position => &["P.X", "P.Y", "P.Z"],
            Aov::Normal => &["N.X", "N.Y", "N.Z"],
            Aov::ShadingNormal => &["Ns.X", "Ns.Y", "Ns.Z"],
            Aov::Uv => &["u", "v"],
            Aov::Distance => &["Z"],
            Aov::Id => &["id"],
            Aov::Variance => &["Variance.R", "Variance.G", "Variance.B"],
        });
    }
    names
}

fn channel_values(aovs: AovSet, radiance: &[PixelValue; 3], hit: Option<&FirstHit>) -> Vec<f32> {
    let mut values: Vec<f32> = radiance.iter().map(|v| v.mean as f32).collect();
    let vector =
        |get: fn(&FirstHit) -> glanz_math::DVec3| hit.map_or([0.0; 3], |h| get(h).as_vec3().to_array());
    for aov in Aov::ALL.into_iter().filter(|&a| aovs.contains(a)) {
        match aov {
            Aov::Albedo => values.extend(hit.map_or([0.0; 3], |h| h.albedo)),
            Aov::Position => values.extend(vector(|h| h.position)),
            Aov::Normal => values.extend(vector(|h| h.normal)),
            Aov::ShadingNormal => values.extend(vector(|h| h.shading_normal)),
            Aov::Uv => values.extend(hit.map_or([0.0; 2], |h| h.uv.as_vec2().to_array())),
            Aov::Distance => values.push(hit.map_or(0.0, |h| h.distance as f32)),
            Aov::Id => values.push(hit.map_or(-1.0, |h| h.object as f32)),
            Aov::Variance => values.extend(radiance.iter().map(|v| v.variance as f32)),
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pixel::Sample;

    /// Fills samples `range` with values that differ by pixel and sample.
    fn expose(film: &mut Film, range: std::ops::Range<u32>) {
        let layout = film.format().layout();
        let mut rejects = Rejects::default();
        for (tile, words) in film.parts_mut().0 {
            for ([x, y], words) in tile.pixels().zip(words.chunks_exact_mut(layout.words())) {
                let mut sums = PixelSums::read(&layout, words);
                for index in range.clone() {
                    let value = (x * 100 + y) as f32 + (index as f32 * 0.7).sin();
                    let rgb = [value, value * 1e-6, value * 1e6];
                    let negative = layout.signed && index % 7 == 3;
                    sums.add(&layout, &Sample { index, rgb, negative, first_hit: None }, &mut rejects);
                }
                sums.write(&layout, words);
            }
        }
        film.finish_pass(range, rejects).unwrap();
    }

    fn format() -> FilmFormat {
        let crop = PixelRect { min: [3, 5], size: [37, 18] };
        FilmFormat { resolution: [60, 40], crop, aovs: AovSet::ALL, signed: true, passes: false }
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
    fn pixels_land_where_they_belong() {
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

    #[test]
    fn films_of_other_pictures_and_common_samples_are_refused() {
        let mut film = Film::try_new(format()).unwrap();
        let other = Film::try_new(FilmFormat { aovs: AovSet::NONE, ..format() }).unwrap();
        assert!(matches!(film.merge(&other), Err(FilmError::Layout(_))));
        expose(&mut film, 0..4);
        let same = film.clone();
        assert_eq!(film.merge(&same), Err(FilmError::Overlap(OverlapError(0..4))));
        assert_eq!(film, same);
    }

    #[test]
    fn impossible_formats_are_refused() {
        assert_eq!(Film::try_new(FilmFormat::plain([0, 5])), Err(FilmError::Size(0, 5)));
        assert_eq!(
            Film::try_new(FilmFormat::plain([u32::MAX, u32::MAX])),
            Err(FilmError::Size(u32::MAX, u32::MAX))
        );
        let outside = FilmFormat { crop: PixelRect { min: [50, 0], size: [11, 1] }, ..format() };
        assert!(matches!(Film::try_new(outside), Err(FilmError::Crop { .. })));
    }
}
