//! The render loop.

mod pass;
mod pass_clock;

use std::ops::Range;
use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, Interrupted, JobEnd, JobProgress, WorkCount};
use glanz_sampling::SamplerKind;
use glanz_sampling::exact::MAX_TERMS;
use glanz_scene::Scene;

use self::pass::PassRenderer;
use self::pass_clock::PassClock;
use crate::film::{Film, FilmError};
use crate::filter::Filter;
use crate::guide::GridError;
use crate::integrator::{Counters, Integrator};
use crate::photon::PhotonTracer;
use crate::progress::RenderSink;
use crate::sensor::FilmSensor;

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
    /// Whether each sample carries light at wavelengths of its own instead of red, green and blue: that of [`IntegratorSettings`](crate::IntegratorSettings), by which the picture is identified.
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
    /// The film was abandoned during a pass, see [`TileSink::is_abandoned`](crate::TileSink::is_abandoned).
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Renders the samples of `settings` that are not in `film`.
///
/// Every pass over all pixels renders one or more samples of every pixel, as many as fit in about half a
/// second. Sums are exact, so that the film depends on its set of samples, not on passes, threads, interruptions or
/// earlier runs. A learning integrator renders samples in order, and a pass over the picture ends with a training pass,
/// so that the same holds. A film with a noise level takes samples in order, too, and the render ends when all tiles have reached it. After each pass `sink` receives the film and the progress,
/// and the loop ends if `cancel` is raised and the film is not empty, also while photons are traced. If the tile sink abandons the film, the render ends at once, and the film is lost.
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
    check(scene, integrator, settings, &film)?;
    if integrator.learns() {
        film.begin_training(integrator.new_guide(scene)?);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let renderer = PassRenderer::new(scene, integrator, settings, film.format());
    let start = Instant::now();
    let mut clock = PassClock::new(settings.time_limit);
    let resolution = film.format().resolution;
    // Photons carry red, green and blue.
    let photons = || pool.install(|| integrator.photon_tracer(scene, settings.seed, resolution));
    let mut tracer = (!settings.spectral).then(photons).flatten();
    let mut counters = Counters::default();
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    let mut samples = 0;
    let end = loop {
        let gap = film.samples().missing(settings.samples.clone()).into_iter().next();
        let Some(gap) = gap.filter(|_| !film.is_converged()) else {
            break JobEnd::Complete;
        };
        // A cancelled render returns a picture with at least one sample per pixel.
        let has_picture = !film.samples().is_empty();
        let is_cancelled = || has_picture && cancel.is_cancelled();
        if is_cancelled() {
            break JobEnd::Interrupted;
        }
        if samples > 0 && timer.is_due() {
            timer.save(|| sink.on_checkpoint(&film));
        }
        let Some(mut range) = next_range(&film, &clock, &gap, start.elapsed()) else {
            break JobEnd::TimeUp;
        };
        let mut begun = Instant::now();
        let tiles = sink.tiles();
        let is_stopped = || is_cancelled() || tiles.is_abandoned();
        let mut trace = |tracer: &mut PhotonTracer| {
            if samples == 0 {
                tracer.fit(scene, &is_stopped)?;
                // No other pass takes this time.
                begun = Instant::now();
            }
            tracer.map(scene, range.start, &is_stopped)
        };
        let map = tracer.as_mut().map(|tracer| pool.install(|| trace(tracer)));
        let photons = match map.transpose() {
            Ok(photons) => photons,
            Err(Interrupted) if is_cancelled() => break JobEnd::Interrupted,
            Err(Interrupted) => return Err(Interrupted.into()),
        };
        if let Some(photons) = &photons {
            // The photons of one sample number are in memory at a time.
            range.end = range.start + 1;
            counters.merge(photons.counters());
        }
        let length = range.end - range.start;
        let work = pool.install(|| renderer.expose(&mut film, photons.as_ref(), &range, tiles))?;
        clock.note(length, begun.elapsed());
        film.finish_pass(range, work.rejects)?;
        counters.merge(work.counters);
        samples += work.samples;
        sink.on_pass(&film);
        sink.on_progress(&progress(&film, settings, &clock, start.elapsed()));
    };
    Ok(RenderOutcome { film, end, elapsed: start.elapsed(), counters, samples })
}

/// Samples of the next pass, the first of `gap`; `None` if there is no time for one.
fn next_range(film: &Film, clock: &PassClock, gap: &Range<u32>, elapsed: Duration) -> Option<Range<u32>> {
    let end = gap.start + clock.next_pass(gap.end - gap.start, elapsed)?;
    Some(gap.start..film.end_of_pass(gap.start).map_or(end, |last| end.min(last)))
}

/// Checks that the film suits the settings, the integrator and the scene.
fn check(
    scene: &Scene,
    integrator: &dyn Integrator,
    settings: &RenderSettings,
    film: &Film,
) -> Result<(), RenderError> {
    let format = film.format();
    if format.signed != settings.filter.is_signed() {
        return Err(RenderError::Filter);
    }
    if format.passes != integrator.learns() || format.splats != integrator.splats() {
        return Err(RenderError::Passes);
    }
    if integrator.splats() && !scene.camera().can_project() {
        return Err(RenderError::Camera);
    }
    if format.is_ordered() {
        check_order(film, settings)?;
    }
    let samples = film.samples().total() + missing(film, settings);
    if samples > u64::from(MAX_TERMS) {
        return Err(FilmError::Samples(samples).into());
    }
    Ok(())
}

/// Checks that samples that depend on earlier ones are in the order of their numbers, without a gap.
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
