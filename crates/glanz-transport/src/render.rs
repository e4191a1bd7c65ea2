//! The render loop.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, Interrupted, JobEnd, JobProgress, WorkCount};
use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::Scene;
use rayon::prelude::*;

use crate::film::{Film, FilmError};
use crate::filter::Filter;
use crate::guide::{GridError, Training};
use crate::integrator::{Context, ContextOptions, Counters, FIRST_DIMENSION, Integrator};
use crate::photon::{PhotonMap, PhotonTracer};
use crate::pixel::{PixelLayout, PixelSums, Rejects};
use crate::pixel_rect::PixelRect;
use crate::progress::{FinishedTile, RenderSink, TileSink};
use crate::sensor::FilmSensor;
use crate::splat::{SplatBuffer, SplatRows};
use glanz_sampling::exact::MAX_TERMS;

/// Desired time of a pass over the picture: short enough for cancelling, long enough to keep threads busy.
const PASS_SECONDS: f64 = 0.5;

/// Settings of a render.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// The pixel filter.
    pub filter: Filter,
    /// The sensor.
    pub sensor: FilmSensor,
    /// The sampler.
    pub sampler: SamplerKind,
    /// Seed of the samples.
    pub seed: u64,
    /// Planned samples per pixel; relevant for samplers that divide the pixel into this number of strata.
    pub samples_per_pixel: u32,
    /// The samples to render; those in the film are skipped.
    pub samples: Range<u32>,
    /// Number of threads; 0 for all processors of the machine. Does not affect the picture.
    pub threads: usize,
    /// Whether each sample carries light at wavelengths of its own instead of red, green and blue.
    pub spectral: bool,
    /// Time limit: no pass starts that would end later, except the first.
    pub time_limit: Option<Duration>,
}

/// Film and statistics of a render.
#[derive(Clone, Debug)]
pub struct RenderOutcome {
    /// The film; every pixel has the same samples, whatever the reason for the end, unless it has a [noise level](crate::FilmFormat::noise).
    pub film: Film,
    /// Reason for the end; the time limit counts as reached if another pass would not fit.
    pub end: JobEnd,
    /// Wall time of the loop.
    pub elapsed: Duration,
    /// Rays traced.
    pub counters: Counters,
    /// Samples taken, over all pixels.
    pub samples: u64,
}

/// Errors of rendering.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The film and the filter differ in whether there are negative lobes.
    #[error("the film was made for another kind of filter")]
    Filter,
    /// The film and the integrator differ in whether there are passes or splats.
    #[error("the film was made for another kind of integrator")]
    Passes,
    /// A camera to which light cannot be connected, for an integrator that splats.
    #[error(
        "the integrator connects light to points of the film, which a realistic camera does not allow; use another integrator"
    )]
    Camera,
    /// Samples out of order, for a learning integrator or a film with a noise level.
    #[error("samples depend on earlier ones, so that they must be rendered in order; the next is {next}")]
    Order {
        /// The next sample.
        next: u32,
    },
    /// The threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The guide of the integrator cannot be built.
    #[error(transparent)]
    Guide(#[from] GridError),
    /// The film refused a pass.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The film was abandoned during a pass, see [`TileSink::is_abandoned`].
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Renders the samples of `settings` that are not in `film`.
///
/// Every pass over all pixels renders one or more samples of every pixel, as many as fit in about half a
/// second. Sums are exact, so that the film depends on its set of samples, not on passes, threads, interruptions or
/// earlier runs. A learning integrator renders samples in order, and a pass over the picture ends with a training pass,
/// so that the same holds. A film with a noise level takes samples in order, too, and the render ends when all tiles have reached it. After each pass `sink` receives the film and the progress, and the loop ends if `cancel` is
/// raised and the film is not empty. If the tile sink abandons the film, the render ends at once, and the film is lost.
///
/// # Errors
/// [`RenderError`] before the first pass, if the film does not match the filter or the integrator, the camera does not suit it, samples are out of order, it would have
/// more samples than it can hold, its guide cannot be made, or the threads cannot be started; [`RenderError::Interrupted`] at any time.
pub fn render(
    scene: &Scene,
    integrator: &dyn Integrator,
    settings: &RenderSettings,
    mut film: Film,
    sink: &mut dyn RenderSink,
    cancel: &CancelFlag,
) -> Result<RenderOutcome, RenderError> {
    if film.format().signed != settings.filter.is_signed() {
        return Err(RenderError::Filter);
    }
    if film.format().passes != integrator.learns() || film.format().splats != integrator.splats() {
        return Err(RenderError::Passes);
    }
    if integrator.splats() && !scene.camera().can_project() {
        return Err(RenderError::Camera);
    }
    if film.format().is_ordered() {
        check_order(&film, settings)?;
    }
    if integrator.learns() {
        film.begin_training(integrator.new_guide(scene)?);
    }
    let new = missing(&film, settings);
    if film.samples().total() + new > u64::from(MAX_TERMS) {
        return Err(FilmError::Samples(film.samples().total() + new).into());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let options = ContextOptions::new(film.format().aovs.needs_first_hit());
    let mut options = options.with_sensor(settings.sensor).with_spectral(settings.spectral);
    if film.format().splats {
        options = options.with_splats(&film.format().crop, &settings.filter);
    }
    let exposure = PassRenderer { scene, integrator, settings, options };
    let start = Instant::now();
    let mut clock = PassClock::new(settings.time_limit);
    let resolution = film.format().resolution;
    // Photons carry red, green and blue.
    let tracer = match settings.spectral {
        true => None,
        false => pool.install(|| integrator.photon_tracer(scene, settings.seed, resolution)),
    };
    let mut counters = tracer.as_ref().map(PhotonTracer::counters).unwrap_or_default();
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    let mut samples = 0;
    let end = loop {
        let gap = film.samples().missing(settings.samples.clone()).into_iter().next();
        let Some(gap) = gap.filter(|_| !film.is_converged()) else {
            break JobEnd::Complete;
        };
        // A cancelled render returns a picture with at least one sample per pixel.
        if cancel.is_cancelled() && !film.samples().is_empty() {
            break JobEnd::Interrupted;
        }
        if samples > 0 && timer.is_due() {
            sink.on_checkpoint(&film);
            timer.restart();
        }
        let Some(length) = clock.next_pass(gap.end - gap.start, start.elapsed()) else {
            break JobEnd::TimeUp;
        };
        let mut range = gap.start..gap.start + length;
        if let Some(end) = film.end_of_pass(range.start) {
            range.end = range.end.min(end);
        }
        let begun = Instant::now();
        let photons = tracer.as_ref().map(|tracer| pool.install(|| tracer.map(scene, range.start)));
        if let Some(photons) = &photons {
            // The photons of one sample number are in memory at a time.
            range.end = range.start + 1;
            counters.merge(photons.counters());
        }
        let length = range.end - range.start;
        let tiles = sink.tiles();
        let work = pool.install(|| exposure.expose(&mut film, photons.as_ref(), &range, tiles))?;
        clock.note(length, begun.elapsed());
        film.finish_pass(range, work.rejects)?;
        counters.merge(work.counters);
        samples += work.samples;
        sink.on_pass(&film);
        sink.on_progress(&progress(&film, settings, &clock, start.elapsed()));
    };
    Ok(RenderOutcome { film, end, elapsed: start.elapsed(), counters, samples })
}

/// Checks that a learning integrator renders samples in the order of their numbers, without a gap.
fn check_order(film: &Film, settings: &RenderSettings) -> Result<(), RenderError> {
    let done = film.samples().as_slice();
    let next = done.first().map_or(0, |range| range.end);
    let in_turn = done.len() <= 1 && done.first().is_none_or(|range| range.start == 0);
    if in_turn && settings.samples.start <= next { Ok(()) } else { Err(RenderError::Order { next }) }
}

/// Number of requested samples per pixel that are not in the film.
fn missing(film: &Film, settings: &RenderSettings) -> u64 {
    let missing = film.samples().missing(settings.samples.clone());
    missing.iter().map(|r| u64::from(r.end - r.start)).sum()
}

/// The progress after a pass. The number of samples is known only if there is no time limit and no noise level.
fn progress(
    film: &Film,
    settings: &RenderSettings,
    clock: &PassClock,
    elapsed: Duration,
) -> JobProgress<'static> {
    let missing = missing(film, settings);
    let wanted = u64::from(settings.samples.end.saturating_sub(settings.samples.start));
    let remaining = clock.remaining(missing, elapsed);
    // How many samples a noise level takes is not known.
    let is_adaptive = film.format().noise.is_some();
    let is_timed = settings.time_limit.is_some();
    let remaining = (is_timed || !is_adaptive).then_some(remaining);
    JobProgress::by_time("rendering", elapsed, remaining).with_count(WorkCount {
        done: wanted - missing,
        wanted: (!is_timed && !is_adaptive).then_some(wanted),
        unit: ["sample per pixel", "samples per pixel"],
    })
}

/// Scheduler of passes: chooses their numbers of samples.
#[derive(Clone, Copy, Debug)]
struct PassClock {
    limit: Option<Duration>,
    /// Seconds for one sample of every pixel: the larger of the last pass and the mean.
    per_sample: Option<f64>,
    samples: u64,
    seconds: f64,
}

impl PassClock {
    fn new(limit: Option<Duration>) -> Self {
        Self { limit, per_sample: None, samples: 0, seconds: 0.0 }
    }

    /// Number of samples of the next pass, at most `missing` (> 0); `None` if there is no time for a pass.
    fn next_pass(&self, missing: u32, elapsed: Duration) -> Option<u32> {
        // The first pass measures the time.
        let Some(per_sample) = self.per_sample else { return Some(1) };
        let mut fitting = (PASS_SECONDS / per_sample).clamp(1.0, f64::from(missing));
        if let Some(limit) = self.limit {
            let left = limit.saturating_sub(elapsed).as_secs_f64() / per_sample;
            if left < 1.0 {
                return None;
            }
            fitting = fitting.min(left);
        }
        Some(fitting as u32)
    }

    fn note(&mut self, length: u32, duration: Duration) {
        // The lower bound avoids endless passes if the clock does not advance.
        let seconds = duration.as_secs_f64().max(1e-9);
        self.samples += u64::from(length);
        self.seconds += seconds;
        self.per_sample = Some((seconds / f64::from(length)).max(self.seconds / self.samples as f64));
    }

    /// Time for `missing` samples, or until the limit.
    fn remaining(&self, missing: u64, elapsed: Duration) -> Duration {
        let mean = self.seconds / self.samples.max(1) as f64;
        let work = Duration::try_from_secs_f64(mean * missing as f64).unwrap_or(Duration::MAX);
        self.limit.map_or(work, |limit| work.min(limit.saturating_sub(elapsed)))
    }
}

/// Results of a pass or a part of it.
#[derive(Clone, Copy, Debug, Default)]
struct PassWork {
    /// Samples over all pixels.
    samples: u64,
    counters: Counters,
    rejects: Rejects,
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

#[derive(Clone, Copy)]
struct PassRenderer<'a> {
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
    /// Renders one pass: the samples of `range` for every pixel.
    ///
    /// # Errors
    /// [`Interrupted`] if `sink` abandons the film, which is then incomplete.
    fn expose(
        &self,
        film: &'a mut Film,
        photons: Option<&'a PhotonMap>,
        range: &Range<u32>,
        sink: &dyn TileSink,
    ) -> Result<PassWork, Interrupted> {
        let layout = film.format().layout();
        let samples = film.samples().total() + range.len() as u64;
        let parts = film.parts_mut();
        let tiles = parts.tiles;
        let (splats, training) = (parts.splats, parts.training);
        let state = PassState { splats, training, photons, batches: Mutex::default() };
        tiles
            .into_par_iter()
            .with_max_len(1)
            .map(|(tile, words): (PixelRect, &mut [u64])| {
                let work = self.expose_tile(&tile, &layout, words, range, &state, sink)?;
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
        batch.negative.clear();
        let samples = pixels.iter().flat_map(|&pixel| range.clone().map(move |index| (pixel, index)));
        for (position, (pixel, index)) in samples.enumerate() {
            let mut sampler =
                PixelSampler::new(settings.sampler, settings.samples_per_pixel, settings.seed, pixel, index);
            let place = settings.filter.sample(sampler.pixel_2d());
            let middle = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
            let lens = if camera.has_lens() { sampler.next_2d() } else { DVec2::splat(0.5) };
            let ray = camera.ray(middle + place.offset, lens);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(s: f64) -> Duration {
        Duration::from_secs_f64(s)
    }

    #[test]
    fn first_pass_measures_and_the_next_ones_take_half_a_second() {
        let mut clock = PassClock::new(None);
        assert_eq!(clock.next_pass(1000, Duration::ZERO), Some(1));
        clock.note(1, seconds(0.01));
        assert_eq!(clock.next_pass(1000, seconds(0.01)), Some(50));
        assert_eq!(clock.next_pass(7, seconds(0.01)), Some(7));
        clock.note(50, seconds(50.0));
        assert_eq!(clock.next_pass(1000, seconds(51.0)), Some(1));
    }

    #[test]
    fn no_pass_starts_that_would_end_too_late() {
        let mut clock = PassClock::new(Some(seconds(2.0)));
        // The first pass completes regardless of the limit.
        assert_eq!(clock.next_pass(1000, Duration::ZERO), Some(1));
        clock.note(1, seconds(0.1));
        assert_eq!(clock.next_pass(1000, seconds(1.75)), Some(2));
        assert_eq!(clock.next_pass(1000, seconds(1.95)), None);
        assert_eq!(clock.next_pass(1000, seconds(2.5)), None);
    }

    #[test]
    fn remaining_time_is_that_of_the_samples_or_of_the_limit() {
        let mut clock = PassClock::new(Some(seconds(10.0)));
        clock.note(4, seconds(2.0));
        assert_eq!(clock.remaining(6, seconds(2.0)), seconds(3.0));
        assert_eq!(clock.remaining(600, seconds(2.0)), seconds(8.0));
    }
}
