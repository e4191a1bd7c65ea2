//! Renders and measures the pictures of a room, with progress.

use std::sync::Arc;
use std::time::Duration;

use glanz_job::{JobProgress, ProgressSink};
use glanz_light::Pixels;
use glanz_sampling::exact::MAX_TERMS;
use glanz_transport::{Film, PictureIdentity, RenderSink};

use super::cache::{ResultCache, RunResult};
use super::curve::{CurvePoint, PictureError};
use super::method::{FROZEN_SAMPLES, MethodEntry, RenderMethod};
use super::room::{GuidingRoom, RenderProgress, RenderSetup};
use crate::study::{StudyError, StudyProgress};

/// Distance between the seeds of references, of measured pictures, of pictures by frozen guides and at equal time, so that no two
/// share samples.
const SEED_STEP: u64 = 1 << 32;

/// Longest time between two checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(30);

/// Completed share of the work, in samples per pixel.
pub(super) struct Work<'a, 'p> {
    progress: &'a mut StudyProgress<'p>,
    done: f64,
    total: f64,
}

impl<'a, 'p> Work<'a, 'p> {
    pub(super) fn new(progress: &'a mut StudyProgress<'p>, total: f64) -> Self {
        Self { progress, done: 0.0, total: total.max(1.0) }
    }

    /// Reports the next step, with `more` of its work done.
    pub(super) fn report(&mut self, more: f64, what: &str) {
        self.progress.report(((self.done + more) / self.total).min(1.0), what);
    }

    /// Adds `more` to the completed work.
    pub(super) fn finish(&mut self, more: f64) {
        self.done += more;
    }
}

/// Progress sink of one render, a part of the work.
struct RenderTask<'a, 'b, 'p> {
    work: &'a mut Work<'b, 'p>,
    what: &'a str,
    /// Work of the render, samples.
    weight: f64,
    /// Stores the film at every checkpoint.
    keep: Option<&'a dyn Fn(&Film)>,
}

impl RenderSink for RenderTask<'_, '_, '_> {}

impl ProgressSink<Film> for RenderTask<'_, '_, '_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.work.report(self.weight * progress.fraction, self.what);
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        self.keep.map(|_| CHECKPOINT_INTERVAL)
    }

    fn on_checkpoint(&mut self, film: &Film) {
        if let Some(keep) = self.keep {
            keep(film);
        }
    }
}

/// The picture against which the errors of a room are measured.
pub(super) struct ReferencePicture {
    pub(super) pixels: Pixels,
    /// Samples of each pixel.
    pub(super) samples: u64,
}

/// Setup, file name and identity of a reference.
fn reference_plan(
    room: &GuidingRoom<'_>,
    seed: u64,
) -> Result<(RenderSetup, String, PictureIdentity), StudyError> {
    let setup = room.setup(&RenderMethod::path(), true, seed.wrapping_add(SEED_STEP))?;
    let identity = room.identity(&setup)?;
    Ok((setup, format!("reference-{}", room.label()), identity))
}

/// Samples per pixel of the cached reference.
///
/// # Errors
/// [`StudyError::Cache`].
pub(super) fn reference_samples(
    room: &GuidingRoom<'_>,
    seed: u64,
    cache: &ResultCache,
) -> Result<u64, StudyError> {
    let (_, name, identity) = reference_plan(room, seed)?;
    Ok(cache.film(&name, &identity)?.map_or(0, |film| film.samples().total()))
}

/// A picture by `path` with light sampling and at least `samples` samples per pixel. It is cached as a checkpoint, to which
/// further samples are added.
///
/// # Errors
/// [`StudyError::Cache`]; [`StudyError::File`] if another process adds to it; [`StudyError::Interrupted`].
pub(super) fn reference(
    room: &GuidingRoom<'_>,
    samples: u32,
    seed: u64,
    cache: &ResultCache,
    work: &mut Work<'_, '_>,
) -> Result<ReferencePicture, StudyError> {
    let (setup, name, identity) = reference_plan(room, seed)?;
    let _claim = cache.claim(&name)?;
    let mut film = match cache.film(&name, &identity)? {
        Some(film) => film,
        None => room.film(&setup)?,
    };
    let missing = u64::from(samples).saturating_sub(film.samples().total());
    if missing > 0 {
        let what = format!("{}, reference", room.name);
        // Only the last checkpoint must succeed.
        let keep = |film: &Film| drop(cache.store_film(&name, &identity, film));
        let mut part = RenderTask { work, what: &what, weight: missing as f64, keep: Some(&keep) };
        let rendered = room.render(&setup, film, 0..samples, None, &mut part)?;
        cache.store_film(&name, &identity, &rendered.outcome.film)?;
        film = rendered.complete()?.outcome.film;
        work.finish(missing as f64);
    }
    Ok(ReferencePicture { pixels: film.to_pixels()?, samples: film.samples().total() })
}

/// A run of one method.
pub(super) struct MethodRun<'a> {
    pub(super) room: &'a GuidingRoom<'a>,
    pub(super) entry: &'a MethodEntry,
    /// Whether lights are sampled.
    pub(super) lights: bool,
    /// Number of the run, from 0; only the first measures frozen guides.
    pub(super) round: u32,
    pub(super) seed: u64,
}

impl MethodRun<'_> {
    fn frozen(&self) -> &[u32] {
        if self.round == 0 { &self.entry.frozen } else { &[] }
    }

    /// Samples per pixel of the run.
    pub(super) fn work(&self) -> f64 {
        f64::from(self.entry.samples) + f64::from(FROZEN_SAMPLES) * self.frozen().len() as f64
    }

    fn name(&self) -> String {
        format!("{}-{}", self.short_name(), self.round)
    }

    fn short_name(&self) -> String {
        let lights = if self.lights { "lights" } else { "chance" };
        format!("{}-{}-{lights}", self.room.label(), self.entry.method.key)
    }

    fn what(&self) -> String {
        let lights = if self.lights { "with" } else { "without" };
        format!("{}, {}, {lights} light sampling", self.room.name, self.entry.method.name)
    }

    fn setup(&self) -> Result<RenderSetup, StudyError> {
        self.room.setup(&self.entry.method, self.lights, self.seed.wrapping_add(u64::from(self.round)))
    }

    /// Everything that the figures depend on, one line.
    fn about(&self, setup: &RenderSetup, reference: u64) -> Result<String, StudyError> {
        let identity = self.room.identity(setup)?;
        Ok(format!(
            "{} {:032x} {} {:?} {} seed {} threads {} reference {reference}",
            identity.version,
            identity.scene,
            self.room.label(),
            identity.filter,
            identity.integrator,
            identity.seed,
            self.room.threads
        ))
    }

    /// The cached result, if it is complete; `reference`: samples of the reference.
    ///
    /// # Errors
    /// [`StudyError::Integrator`].
    pub(super) fn measured(
        &self,
        reference: u64,
        cache: &ResultCache,
    ) -> Result<Option<RunResult>, StudyError> {
        let about = self.about(&self.setup()?, reference)?;
        Ok(cache.run(&self.name(), &about).and_then(|run| run.part(&self.entry.steps(), self.frozen())))
    }

    /// The cached result, or a new measurement.
    ///
    /// # Errors
    /// As [`MethodRun::measure`].
    pub(super) fn result(
        &self,
        reference: &ReferencePicture,
        cache: &ResultCache,
        work: &mut Work<'_, '_>,
    ) -> Result<RunResult, StudyError> {
        match self.measured(reference.samples, cache)? {
            Some(run) => Ok(run),
            None => self.measure(reference, cache, work),
        }
    }

    /// Measures and stores the result.
    ///
    /// # Errors
    /// [`StudyError::Integrator`]; [`StudyError::Interrupted`].
    fn measure(
        &self,
        reference: &ReferencePicture,
        cache: &ResultCache,
        work: &mut Work<'_, '_>,
    ) -> Result<RunResult, StudyError> {
        let setup = self.setup()?;
        let what = self.what();
        let mut film = self.room.film(&setup)?;
        let mut run = RunResult::default();
        let (mut wall, mut processors, mut before) = (Duration::ZERO, Duration::ZERO, 0);
        for end in self.entry.steps() {
            let weight = f64::from(end - before);
            let mut part = RenderTask { work, what: &what, weight, keep: None };
            let rendered = self.room.render(&setup, film, before..end, None, &mut part)?.complete()?;
            work.finish(weight);
            wall += rendered.outcome.elapsed;
            processors += rendered.processors;
            film = rendered.outcome.film;
            run.curve.push(point(end, wall, processors, &film, reference)?);
            before = end;
            if self.frozen().contains(&end) {
                run.frozen.push(self.by_frozen(&film, &setup, end, reference, work)?);
            }
        }
        cache.store_run(&self.name(), &self.about(&setup, reference.samples)?, &run)?;
        Ok(run)
    }

    /// The error of a picture of [`FROZEN_SAMPLES`] samples by the guide of `film`, learnt from `learnt` samples.
    fn by_frozen(
        &self,
        film: &Film,
        setup: &RenderSetup,
        learnt: u32,
        reference: &ReferencePicture,
        work: &mut Work<'_, '_>,
    ) -> Result<CurvePoint, StudyError> {
        let guide = film.training().map(|training| Arc::new(training.guide().clone()));
        let setup = RenderSetup { seed: setup.seed.wrapping_add(2 * SEED_STEP), guide, ..setup.clone() };
        let what = format!("{}, frozen after {learnt} samples", self.what());
        let weight = f64::from(FROZEN_SAMPLES);
        let mut part = RenderTask { work, what: &what, weight, keep: None };
        let empty = self.room.film(&setup)?;
        let rendered = self.room.render(&setup, empty, 0..FROZEN_SAMPLES, None, &mut part)?.complete()?;
        work.finish(weight);
        let RenderProgress { outcome, processors } = rendered;
        point(learnt, outcome.elapsed, processors, &outcome.film, reference)
    }

    /// The picture rendered in `seconds`, and its samples per pixel; cached.
    ///
    /// # Errors
    /// [`StudyError::Integrator`]; [`StudyError::Interrupted`].
    pub(super) fn picture(
        &self,
        seconds: f64,
        cache: &ResultCache,
        work: &mut Work<'_, '_>,
    ) -> Result<(Pixels, u64), StudyError> {
        let setup = RenderSetup { seed: self.seed.wrapping_add(3 * SEED_STEP), ..self.setup()? };
        let about = format!("{} {seconds} s", self.about(&setup, 0)?);
        let name = format!("{}-picture", self.short_name());
        if let Some(found) = cache.picture(&name, &about) {
            return Ok(found);
        }
        let what = format!("{}, {seconds} s", self.what());
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        let mut part = RenderTask { work, what: &what, weight: 0.0, keep: None };
        let rendered =
            self.room.render(&setup, self.room.film(&setup)?, 0..MAX_TERMS, Some(limit), &mut part)?;
        let film = rendered.complete()?.outcome.film;
        let (pixels, samples) = (film.to_pixels()?, film.samples().total());
        cache.store_picture(&name, &about, &pixels, samples)?;
        Ok((pixels, samples))
    }
}

fn point(
    samples: u32,
    wall: Duration,
    processors: Duration,
    film: &Film,
    reference: &ReferencePicture,
) -> Result<CurvePoint, StudyError> {
    let error = PictureError::of(&film.to_pixels()?, &reference.pixels)?;
    Ok(CurvePoint { samples, wall: wall.as_secs_f64(), processors: processors.as_secs_f64(), error })
}
