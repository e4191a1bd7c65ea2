//! Renders what is to be measured, and tells how far that is.

use std::sync::Arc;
use std::time::Duration;

use glanz_job::{JobProgress, ProgressSink};
use glanz_light::Pixels;
use glanz_sampling::exact::MAX_TERMS;
use glanz_transport::{Film, PictureIdentity, RenderSink};

use super::cache::{Kept, Run};
use super::curve::{Error, Point};
use super::method::{Entry, FROZEN_SAMPLES, Method};
use super::room::{Exposed, Room, Way};
use crate::study::{StudyError, StudyProgress};

/// Seeds of references, of measured pictures, of pictures by frozen guides and at equal time are apart by this, so that no two
/// share their samples.
const SEED_STEP: u64 = 1 << 32;

/// Time between two checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);

/// How much of the work is done; its unit is one sample of each pixel.
pub(super) struct Work<'a, 'p> {
    progress: &'a mut StudyProgress<'p>,
    done: f64,
    total: f64,
}

impl<'a, 'p> Work<'a, 'p> {
    pub(super) fn new(progress: &'a mut StudyProgress<'p>, total: f64) -> Self {
        Self { progress, done: 0.0, total: total.max(1.0) }
    }

    /// Reports what comes next.
    pub(super) fn report(&mut self, more: f64, what: &str) {
        self.progress.report(((self.done + more) / self.total).min(1.0), what);
    }

    /// `more` of the work is done.
    pub(super) fn finish(&mut self, more: f64) {
        self.done += more;
    }
}

/// One render, a part of the work.
struct Part<'a, 'b, 'p> {
    work: &'a mut Work<'b, 'p>,
    what: &'a str,
    /// Work of the render, samples.
    weight: f64,
    /// What to do with the film now and then.
    keep: Option<&'a dyn Fn(&Film)>,
}

impl RenderSink for Part<'_, '_, '_> {}

impl ProgressSink<Film> for Part<'_, '_, '_> {
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

/// What the errors of a room are measured against.
pub(super) struct Reference {
    pub(super) pixels: Pixels,
    /// Samples of each pixel.
    pub(super) samples: u64,
}

/// The way to a reference, the name of its file, and what it depends on.
fn reference_plan(room: &Room<'_>, seed: u64) -> Result<(Way, String, PictureIdentity), StudyError> {
    let way = room.way(&Method::path(), true, seed.wrapping_add(SEED_STEP))?;
    let identity = room.identity(&way)?;
    Ok((way, format!("reference-{}", room.label()), identity))
}

/// Samples per pixel of the reference that is kept.
///
/// # Errors
/// A kept file that cannot be gone on with.
pub(super) fn reference_samples(room: &Room<'_>, seed: u64, kept: &Kept) -> Result<u64, StudyError> {
    let (_, name, identity) = reference_plan(room, seed)?;
    Ok(kept.film(&name, &identity)?.map_or(0, |film| film.samples().total()))
}

/// A picture by `path` with light sampling and at least `samples` samples per pixel. It is kept as a checkpoint, so that more
/// samples add to those there are.
///
/// # Errors
/// A kept file that cannot be gone on with; an end that was wanted.
pub(super) fn reference(
    room: &Room<'_>,
    samples: u32,
    seed: u64,
    kept: &Kept,
    work: &mut Work<'_, '_>,
) -> Result<Reference, StudyError> {
    let (way, name, identity) = reference_plan(room, seed)?;
    let mut film = match kept.film(&name, &identity)? {
        Some(film) => film,
        None => room.film(&way)?,
    };
    let missing = u64::from(samples).saturating_sub(film.samples().total());
    if missing > 0 {
        let what = format!("{}, reference", room.name);
        // The last checkpoint has to succeed, those before need not.
        let keep = |film: &Film| drop(kept.keep_film(&name, &identity, film));
        let mut part = Part { work, what: &what, weight: missing as f64, keep: Some(&keep) };
        let exposed = room.expose(&way, film, 0..samples, None, &mut part)?;
        kept.keep_film(&name, &identity, &exposed.outcome.film)?;
        film = exposed.complete()?.outcome.film;
        work.finish(missing as f64);
    }
    Ok(Reference { pixels: film.to_pixels()?, samples: film.samples().total() })
}

/// A run of one method.
pub(super) struct Case<'a> {
    pub(super) room: &'a Room<'a>,
    pub(super) entry: &'a Entry,
    /// Whether lights are sampled.
    pub(super) lights: bool,
    /// Number of the run; only the first measures frozen guides.
    pub(super) round: u32,
    pub(super) seed: u64,
}

impl Case<'_> {
    fn frozen(&self) -> &[u32] {
        if self.round == 0 { &self.entry.frozen } else { &[] }
    }

    /// Samples per pixel that it takes.
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

    fn way(&self) -> Result<Way, StudyError> {
        self.room.way(&self.entry.method, self.lights, self.seed.wrapping_add(u64::from(self.round)))
    }

    /// What its figures depend on, one line.
    fn about(&self, way: &Way, reference: u64) -> Result<String, StudyError> {
        let identity = self.room.identity(way)?;
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

    /// What was measured before, if all of it was; `reference`: its samples.
    ///
    /// # Errors
    /// A way of rendering that is refused.
    pub(super) fn measured(&self, reference: u64, kept: &Kept) -> Result<Option<Run>, StudyError> {
        let about = self.about(&self.way()?, reference)?;
        Ok(kept.run(&self.name(), &about).and_then(|run| run.part(&self.entry.steps(), self.frozen())))
    }

    /// What was measured before, or is now.
    ///
    /// # Errors
    /// As [`Case::measure`].
    pub(super) fn result(
        &self,
        reference: &Reference,
        kept: &Kept,
        work: &mut Work<'_, '_>,
    ) -> Result<Run, StudyError> {
        match self.measured(reference.samples, kept)? {
            Some(run) => Ok(run),
            None => self.measure(reference, kept, work),
        }
    }

    /// Measures, and keeps what comes out.
    ///
    /// # Errors
    /// A way of rendering that is refused; an end that was wanted.
    fn measure(
        &self,
        reference: &Reference,
        kept: &Kept,
        work: &mut Work<'_, '_>,
    ) -> Result<Run, StudyError> {
        let way = self.way()?;
        let what = self.what();
        let mut film = self.room.film(&way)?;
        let mut run = Run::default();
        let (mut wall, mut processors, mut before) = (Duration::ZERO, Duration::ZERO, 0);
        for end in self.entry.steps() {
            let weight = f64::from(end - before);
            let mut part = Part { work, what: &what, weight, keep: None };
            let exposed = self.room.expose(&way, film, before..end, None, &mut part)?.complete()?;
            work.finish(weight);
            wall += exposed.outcome.elapsed;
            processors += exposed.processors;
            film = exposed.outcome.film;
            run.curve.push(point(end, wall, processors, &film, reference)?);
            before = end;
            if self.frozen().contains(&end) {
                run.frozen.push(self.by_frozen(&film, &way, end, reference, work)?);
            }
        }
        kept.keep_run(&self.name(), &self.about(&way, reference.samples)?, &run)?;
        Ok(run)
    }

    /// The error of a picture of [`FROZEN_SAMPLES`] samples by what was learnt from `learnt` samples for `film`.
    fn by_frozen(
        &self,
        film: &Film,
        way: &Way,
        learnt: u32,
        reference: &Reference,
        work: &mut Work<'_, '_>,
    ) -> Result<Point, StudyError> {
        let guide = film.training().map(|training| Arc::new(training.guide().clone()));
        let way = Way { seed: way.seed.wrapping_add(2 * SEED_STEP), guide, ..way.clone() };
        let what = format!("{}, frozen after {learnt} samples", self.what());
        let weight = f64::from(FROZEN_SAMPLES);
        let mut part = Part { work, what: &what, weight, keep: None };
        let empty = self.room.film(&way)?;
        let exposed = self.room.expose(&way, empty, 0..FROZEN_SAMPLES, None, &mut part)?.complete()?;
        work.finish(weight);
        let Exposed { outcome, processors } = exposed;
        point(learnt, outcome.elapsed, processors, &outcome.film, reference)
    }

    /// The picture of so many `seconds`, and its samples per pixel; kept.
    ///
    /// # Errors
    /// A way of rendering that is refused; an end that was wanted.
    pub(super) fn picture(
        &self,
        seconds: f64,
        kept: &Kept,
        work: &mut Work<'_, '_>,
    ) -> Result<(Pixels, u64), StudyError> {
        let way = Way { seed: self.seed.wrapping_add(3 * SEED_STEP), ..self.way()? };
        let about = format!("{} {seconds} s", self.about(&way, 0)?);
        let name = format!("{}-picture", self.short_name());
        if let Some(found) = kept.picture(&name, &about) {
            return Ok(found);
        }
        let what = format!("{}, {seconds} s", self.what());
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        let mut part = Part { work, what: &what, weight: 0.0, keep: None };
        let exposed = self.room.expose(&way, self.room.film(&way)?, 0..MAX_TERMS, Some(limit), &mut part)?;
        let film = exposed.complete()?.outcome.film;
        let (pixels, samples) = (film.to_pixels()?, film.samples().total());
        kept.keep_picture(&name, &about, &pixels, samples)?;
        Ok((pixels, samples))
    }
}

fn point(
    samples: u32,
    wall: Duration,
    processors: Duration,
    film: &Film,
    reference: &Reference,
) -> Result<Point, StudyError> {
    let error = Error::of(&film.to_pixels()?, &reference.pixels)?;
    Ok(Point { samples, wall: wall.as_secs_f64(), processors: processors.as_secs_f64(), error })
}
