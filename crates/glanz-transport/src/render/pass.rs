//! Passes over all pixels.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use glanz_job::Interrupted;
use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_sampling::PixelSampler;
use glanz_scene::Scene;
use rayon::prelude::*;

use super::{RenderError, RenderSettings};
use crate::film::{Film, FilmError, FilmFormat};
use crate::guide::Training;
use crate::integrator::{Context, ContextOptions, Counters, FIRST_DIMENSION, Integrator};
use crate::photon::PhotonMap;
use crate::pixel::{PixelLayout, PixelSums, Rejects};
use crate::pixel_rect::PixelRect;
use crate::progress::{FinishedTile, TileSink};
use crate::splat::{SplatBuffer, SplatRows};

/// Results of a pass or a part of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PassWork {
    /// Samples over all pixels.
    pub(super) samples: u64,
    pub(super) counters: Counters,
    pub(super) rejects: Rejects,
}

impl PassWork {
    fn merged(mut self, other: Self) -> Self {
        self.samples += other.samples;
        self.counters.merge(other.counters);
        self.rejects.merge(other.rejects);
        self
    }
}

/// Memory that is reused by consecutive batches of samples.
#[derive(Default)]
struct SampleBatch<'a> {
    contexts: Vec<Context<'a>>,
    /// For each sample, whether the filter is negative there.
    negative: Vec<bool>,
    radiance: Vec<Spectrum>,
    /// Splats that are not in the film yet.
    splats: SplatBuffer,
}

/// Renderer of passes over a picture.
#[derive(Clone, Copy)]
pub(super) struct PassRenderer<'a> {
    scene: &'a Scene,
    integrator: &'a dyn Integrator,
    settings: &'a RenderSettings,
    options: ContextOptions,
}

/// What the tiles of a pass share.
struct PassState<'s, 'a> {
    splats: SplatRows<'s>,
    training: Option<&'a Training>,
    photons: Option<&'a PhotonMap>,
    /// Memory of batches that no thread uses at the moment.
    batches: Mutex<Vec<SampleBatch<'a>>>,
}

impl<'a> PassRenderer<'a> {
    /// A renderer for films of this format.
    pub(super) fn new(
        scene: &'a Scene,
        integrator: &'a dyn Integrator,
        settings: &'a RenderSettings,
        format: &FilmFormat,
    ) -> Self {
        let options = ContextOptions::new(format.aovs.needs_first_hit());
        let mut options = options.with_sensor(settings.sensor).with_spectral(settings.spectral);
        if format.splats {
            options = options.with_splats(&format.crop, &settings.filter);
        }
        Self { scene, integrator, settings, options }
    }

    /// Renders one pass: the samples of `range` for every pixel.
    ///
    /// # Errors
    /// [`RenderError::Interrupted`] if `sink` abandons the film, which is then incomplete, and [`RenderError::Film`] if the file of a film or of
    /// pictures fails.
    pub(super) fn expose(
        &self,
        film: &'a mut Film,
        photons: Option<&'a PhotonMap>,
        range: &Range<u32>,
        sink: &dyn TileSink,
    ) -> Result<PassWork, RenderError> {
        let format = *film.format();
        let samples = film.samples().total() + range.len() as u64;
        let batches = Mutex::default();
        if film.is_in_file() {
            let mut none = [];
            let splats = SplatRows::new(format.crop, format.splat_layout(), &mut none);
            let state = PassState { splats, training: None, photons, batches };
            let strips = film.update_strips(|tiles| {
                self.expose_tiles(tiles, &format, range, samples, &state, sink).map_err(RenderError::from)
            })?;
            self.scene.check_textures().map_err(FilmError::from)?;
            return Ok(strips.into_iter().fold(PassWork::default(), PassWork::merged));
        }
        let parts = film.parts_mut();
        let state = PassState { splats: parts.splats, training: parts.training, photons, batches };
        let work = self.expose_tiles(parts.tiles, &format, range, samples, &state, sink)?;
        self.scene.check_textures().map_err(FilmError::from)?;
        Ok(work)
    }

    /// Renders one pass over some tiles. `samples`: number of samples of each pixel after it.
    fn expose_tiles(
        &self,
        tiles: Vec<(PixelRect, &mut [u64])>,
        format: &FilmFormat,
        range: &Range<u32>,
        samples: u64,
        state: &PassState<'_, 'a>,
        sink: &dyn TileSink,
    ) -> Result<PassWork, Interrupted> {
        let layout = format.layout();
        tiles
            .into_par_iter()
            .with_max_len(1)
            .map(|(tile, words): (PixelRect, &mut [u64])| {
                let work = self.expose_tile(&tile, &layout, words, range, state, sink)?;
                sink.on_tile(&FinishedTile { rect: tile, pass: range.clone(), samples, layout, words });
                Ok(work)
            })
            // Counts are integers, so that the order of this sum is irrelevant.
            .try_reduce(PassWork::default, |a, b| Ok(a.merged(b)))
    }

    /// Renders one pass over a tile, whose sums are `words`.
    fn expose_tile(
        &self,
        tile: &PixelRect,
        layout: &PixelLayout,
        words: &mut [u64],
        range: &Range<u32>,
        state: &PassState<'_, 'a>,
        sink: &dyn TileSink,
    ) -> Result<PassWork, Interrupted> {
        let (mut work, stride) = (PassWork::default(), layout.words());
        work.samples = tile.len() * range.len() as u64;
        let PassState { splats, batches, .. } = state;
        // A thread that panicked with the lock has ended the render; the list is valid between two calls.
        let mut batch = batches.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        let limit = self.integrator.batch().max(1);
        let pixels: Vec<_> = tile.pixels().collect();
        let together = (limit / range.len().max(1)).max(1);
        for (pixels, words) in pixels.chunks(together).zip(words.chunks_mut(together * stride)) {
            let mut sums: Vec<_> =
                words.chunks_exact(stride).map(|words| PixelSums::read(layout, words)).collect();
            let step = (limit / pixels.len()).max(1);
            for start in range.clone().step_by(step) {
                if sink.is_abandoned() {
                    return Err(Interrupted);
                }
                let part = start..range.end.min(start.saturating_add(step as u32));
                self.sample(pixels, &part, state, &mut batch);
                let light = batch.radiance.iter().zip(&batch.negative);
                for (position, (context, (light, negative))) in
                    batch.contexts.iter_mut().zip(light).enumerate()
                {
                    if let Some(sums) = sums.get_mut(position / part.len()) {
                        sums.add(layout, &context.pixel_sample(*light, *negative), &mut work.rejects);
                    }
                    work.counters.merge(context.counters);
                    if !context.splats.is_empty() {
                        let exposure = (&self.settings.filter, &self.settings.sensor);
                        batch.splats.take(&context.splats, exposure, splats, &mut work.rejects);
                        context.splats.clear();
                    }
                }
            }
            for (sums, words) in sums.iter().zip(words.chunks_exact_mut(stride)) {
                sums.write(layout, words);
            }
        }
        batch.splats.flush(splats, &mut work.rejects);
        batches.lock().unwrap_or_else(PoisonError::into_inner).push(batch);
        Ok(work)
    }

    /// Renders the samples `range` of each of `pixels`, pixel after pixel.
    fn sample(
        &self,
        pixels: &[[u32; 2]],
        range: &Range<u32>,
        state: &PassState<'_, 'a>,
        batch: &mut SampleBatch<'a>,
    ) {
        let (settings, camera) = (self.settings, self.scene.camera());
        let filters_textures = self.scene.textures().use_footprints();
        batch.negative.clear();
        let samples = pixels.iter().flat_map(|&pixel| range.clone().map(move |index| (pixel, index)));
        for (position, (pixel, index)) in samples.enumerate() {
            let mut sampler =
                PixelSampler::new(settings.sampler, settings.samples_per_pixel, settings.seed, pixel, index);
            let place = settings.filter.sample(sampler.pixel_2d());
            let middle = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
            let lens = if camera.has_lens() { sampler.next_2d() } else { DVec2::splat(0.5) };
            let film = middle + place.offset;
            let ray = if filters_textures {
                camera.ray_with_differential(film, lens, spacing(index))
            } else {
                camera.ray(film, lens)
            };
            sampler.skip_to_dimension(FIRST_DIMENSION);
            batch.negative.push(place.negative);
            match batch.contexts.get_mut(position) {
                Some(context) => context.restart(ray, sampler),
                None => batch.contexts.push(
                    Context::new(self.scene, ray, sampler, self.options)
                        .with_training(state.training)
                        .with_photons(state.photons),
                ),
            }
        }
        batch.contexts.truncate(batch.negative.len());
        self.integrator.radiance_batch(&mut batch.contexts, &mut batch.radiance);
    }
}

/// Distance of samples on the film, pixels, by which textures are filtered for the sample with this number.
///
/// It is that of as many samples per pixel as precede, not of the planned number: the film depends on the set of its samples alone, and may be
/// given more.
///
/// # Source
/// @pbrt4 `CameraBase`: the smallest distance. Departure: there it is that of the planned number.
fn spacing(index: u32) -> f64 {
    (1.0 / (f64::from(index) + 1.0).sqrt()).max(0.125)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_samples_sharpen_textures_to_an_eighth_of_a_pixel() {
        assert_eq!([0, 3, 63, 1000].map(spacing), [1.0, 0.5, 0.125, 0.125]);
    }
}
