//! Particle tracing from the lights to the receivers.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, JobEnd, JobPart, JobProgress, ProgressSink, WorkCount};
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::Scene;
use glanz_transport::{Counters, ParticleTracer};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::division::CellDivision;
use crate::escaped_rays::block_of_escaped_light;
use crate::far_field::{EscapedLight, FarFieldGrid};
use crate::lux_parts::LuxParts;
use crate::receiver::Receivers;
use crate::replicates::{REPLICATES, first_in_replicate};
use crate::tally::{Tally, ThreadTally};

/// Particles that a thread traces together.
pub(crate) const BLOCK: u64 = 1 << 10;

/// Largest number of particles, far from an overflow of the counter that threads share.
const MAX_PARTICLES: u64 = 1 << 63;

/// Blocks of particles that show which directions need a fine grid.
const PILOT_BLOCKS: u64 = 1 << 8;

/// Wall time of a round, after which progress is reported and cancelling takes effect.
const ROUND_SECONDS: f64 = 0.5;

/// Particles of the first round.
const FIRST_ROUND: u64 = 1 << 14;

/// Conditions for the end; the first that is met ends the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TraceGoal {
    /// Particles in all, from number 0, those of earlier runs included.
    pub particles: Option<u64>,
    /// Wall time of this run.
    pub time: Option<Duration>,
    /// Largest relative standard error of the brightest cell, of the darkest cell and of the mean of every receiver that light comes to; that of the darkest
    /// cell is relative to a tenth of the mean at least, and cells of less than a twentieth of the largest do not count. Without a receiver that light comes to, that of the peak of the far field. A run also
    /// ends after four million particles without either.
    pub error: Option<f64>,
}

/// Settings of particle tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSettings {
    /// Seed of the particles.
    pub seed: u64,
    /// Largest number of scattering events of a particle.
    pub max_events: u32,
    /// Threads; 0 for one per processor.
    pub threads: usize,
    /// Conditions for the end.
    pub goal: TraceGoal,
    /// The part of all particles that is traced; `None` for all of them.
    pub part: Option<JobPart>,
}

impl TraceSettings {
    /// Numbers of the particles that may be traced.
    #[must_use]
    pub fn range(&self) -> Range<u64> {
        let all = 0..self.goal.particles.unwrap_or(u64::MAX).min(MAX_PARTICLES);
        self.part.map_or(all.clone(), |part| part.share(all))
    }
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct TraceOutcome {
    /// Sums of all particles so far.
    pub tally: Tally,
    /// Reason for the end.
    pub end: JobEnd,
    /// Particles of this run.
    pub particles: u64,
    /// Rays of this run.
    pub counters: Counters,
    /// The largest of the relative standard errors that [`TraceGoal::error`] names, of all particles so far; infinite without any light.
    pub error: f64,
    /// Wall time of this run.
    pub elapsed: Duration,
}

/// Threads cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start threads: {0}")]
pub struct ThreadsError(#[from] pub rayon::ThreadPoolBuildError);

/// Traces particles until a goal is reached and adds them to `tally`.
///
/// Particles are numbered, and a run traces those that `tally` lacks, in order: the sums depend on the seed and on which particles were traced
/// alone, not on threads, interruptions or parts. A cancelled run returns its sums so far, of at least one round of particles.
/// The error in its progress is that of [`TraceOutcome::error`].
///
/// # Errors
/// [`ThreadsError`] before the first particle.
pub fn trace(
    scene: &Scene,
    receivers: &Receivers,
    settings: &TraceSettings,
    mut tally: Tally,
    sink: &mut dyn ProgressSink<Tally>,
    cancel: &CancelFlag,
) -> Result<TraceOutcome, ThreadsError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let start = Instant::now();
    let (goal, range) = (&settings.goal, settings.range());
    let first = tally.particles.total();
    let mut counters = Counters::default();
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    let (end, error) = loop {
        let error = LuxParts::of_particles(&tally, receivers).worst_error();
        let elapsed = start.elapsed();
        let gaps = tally.particles.missing(range.clone());
        let work = TraceWork {
            done: tally.particles.total(),
            left: gaps.iter().map(|gap| gap.end - gap.start).sum(),
            elapsed,
            pace: pace(tally.particles.total() - first, elapsed),
        };
        let has_traced = work.done > first;
        if has_traced {
            let length = range.end - range.start;
            let of_goal = goal.particles.map(|_| length);
            let done = of_goal.map_or(work.done, |length| length - work.left);
            let count = WorkCount { done, wanted: of_goal, unit: ["particle", "particles"] };
            let remaining = goal.remaining(&work, error);
            let progress = JobProgress::by_time("particles from lights", elapsed, remaining);
            sink.on_progress(&progress.with_count(count).with_error(error));
            if timer.is_due() {
                timer.save(|| sink.on_checkpoint(&tally));
            }
        }
        let Some(gap) = gaps.first() else { break (JobEnd::Complete, error) };
        let is_dark = error == f64::INFINITY && work.done >= DARK_PARTICLES;
        if goal.error.is_some_and(|goal| error <= goal || is_dark) {
            break (JobEnd::Complete, error);
        }
        if cancel.is_cancelled() && work.done > 0 {
            break (JobEnd::Interrupted, error);
        }
        if has_traced && goal.time.is_some_and(|limit| elapsed >= limit) {
            break (JobEnd::TimeUp, error);
        }
        let next = gap.start..gap.end.min(gap.start.saturating_add(goal.round(&work)));
        counters.merge(pool.install(|| round(scene, receivers, settings, None, &mut tally, next)));
    };
    let particles = tally.particles.total() - first;
    Ok(TraceOutcome { tally, end, particles, counters, error, elapsed: start.elapsed() })
}

/// Particles after which a run ends that waits for a smaller error, if none of them reached a receiver.
pub(crate) const DARK_PARTICLES: u64 = 1 << 22;

/// Progress of a run.
pub(crate) struct TraceWork {
    /// Particles so far, those of earlier runs included.
    pub(crate) done: u64,
    /// Particles that are still missing.
    pub(crate) left: u64,
    /// Wall time of the run.
    pub(crate) elapsed: Duration,
    /// Particles per second; `None` before the first.
    pub(crate) pace: Option<f64>,
}

/// Particles per second; `None` before the first.
pub(crate) fn pace(particles: u64, elapsed: Duration) -> Option<f64> {
    (particles > 0).then(|| particles as f64 / elapsed.as_secs_f64().max(1e-9))
}

impl TraceGoal {
    /// Particles of the next round, if so many are missing.
    fn round(&self, &TraceWork { done, elapsed, pace, .. }: &TraceWork) -> u64 {
        let Some(pace) = pace else { return FIRST_ROUND };
        let mut seconds = ROUND_SECONDS;
        if let Some(limit) = self.time {
            seconds = seconds.min(limit.saturating_sub(elapsed).as_secs_f64());
        }
        let length = ((pace * seconds) as u64).max(BLOCK);
        // Not many more than the error requires, which is uncertain after few particles.
        if self.error.is_some() { length.min(done.max(FIRST_ROUND)) } else { length }
    }

    /// Time until the end; `None` if it is unknown.
    pub(crate) fn remaining(&self, work: &TraceWork, error: f64) -> Option<Duration> {
        let mut seconds = f64::INFINITY;
        let by_pace = |particles: f64| particles / work.pace.unwrap_or(f64::INFINITY);
        if self.particles.is_some() {
            seconds = seconds.min(by_pace(work.left as f64));
        }
        if let Some(goal) = self.error {
            // The error decreases with the square root of the number of particles.
            seconds = seconds.min(by_pace(work.done as f64 * ((error / goal).powi(2) - 1.0).max(0.0)));
        }
        if let Some(limit) = self.time {
            seconds = seconds.min(limit.saturating_sub(work.elapsed).as_secs_f64());
        }
        Duration::try_from_secs_f64(seconds).ok()
    }
}

/// Traces particles that `tally` lacks with all threads of the pool, and adds them to it. `division`: if other methods compute a part of the light.
pub(crate) fn round(
    scene: &Scene,
    receivers: &Receivers,
    settings: &TraceSettings,
    division: Option<CellDivision<'_>>,
    tally: &mut Tally,
    range: Range<u64>,
) -> Counters {
    let far_field = tally.far_field.clone();
    let numbers =
        |replicate| first_in_replicate(replicate, range.start)..first_in_replicate(replicate, range.end);
    // Blocks of one replicate after the other, so that a thread seldom changes it. Replicates differ by one particle at most.
    let blocks = (range.end - range.start).div_ceil(REPLICATES as u64).div_ceil(BLOCK);
    let next = AtomicU64::new(0);
    let sums = Mutex::new(&mut *tally);
    let add = |replicate: usize, thread: &mut ThreadTally<'_>| {
        sums.lock().unwrap_or_else(PoisonError::into_inner).add_sums(replicate, &thread.take());
    };
    let works = rayon::broadcast(|_| {
        let mut thread = ThreadTally::new(receivers, far_field.as_ref(), division);
        let mut tracer = ParticleTracer::new(scene, settings.max_events);
        let mut counters = Counters::default();
        let mut current = None;
        loop {
            let block = next.fetch_add(1, Ordering::Relaxed);
            let replicate = (block / blocks) as usize;
            if let Some(last) = current.filter(|last| *last != replicate) {
                add(last, &mut thread);
            }
            if replicate >= REPLICATES {
                return counters;
            }
            current = Some(replicate);
            let all = numbers(replicate);
            let from = all.start + block % blocks * BLOCK;
            let mut rest = from..(from + BLOCK).min(all.end);
            while !rest.is_empty() {
                // Up to the end of a sequence.
                let count = (rest.end - rest.start).min((1 << 32) - (rest.start & 0xffff_ffff)) as u32;
                let first = particle_sampler(settings.seed, replicate, rest.start);
                tracer.trace(first, count, &mut counters, |_, arrival| thread.arrival(arrival));
                tracer.paths().flatten().for_each(|path| thread.end(&path));
                rest.start += u64::from(count);
            }
        }
    });
    // The range was missing, so that it is inserted.
    tally.particles.try_insert(range).unwrap_or_default();
    let mut counters = Counters::default();
    works.into_iter().for_each(|work| counters.merge(work));
    counters
}

/// A grid of directions that is fine where the intensity of light that leaves the scene bends.
///
/// Particles that [`trace`] does not trace show where that is. The grid depends on the scene, the seed and the largest number of scattering
/// events alone, so that tallies of all parts of a calculation have the same. `None` if it was cancelled. Between its angles, linear interpolation misses
/// smooth intensities by about one per cent of the peak; edges of beams are as sharp as a sixtieth of their light allows.
///
/// # Errors
/// [`ThreadsError`].
pub fn adapted_grid(
    scene: &Scene,
    settings: &TraceSettings,
    cancel: &CancelFlag,
) -> Result<Option<FarFieldGrid>, ThreadsError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let new = || ParticleTracer::new(scene, settings.max_events);
    let block = |tracer: &mut ParticleTracer<'_>, number: u64| -> Vec<EscapedLight> {
        if cancel.is_cancelled() {
            return Vec::new();
        }
        let place = (settings.seed, REPLICATES, number * BLOCK);
        let rays = block_of_escaped_light(tracer, place, BLOCK as u32);
        rays.map(|ray| EscapedLight::new(ray.direction, ray.lumens)).collect()
    };
    // In the order of their numbers, whatever thread traced them.
    let blocks = pool.install(|| (0..PILOT_BLOCKS).into_par_iter().map_init(new, block).collect::<Vec<_>>());
    Ok((!cancel.is_cancelled()).then(|| FarFieldGrid::adapted(&blocks.concat())))
}

/// The sampler of a particle by its number in the sequence of its replicate: a scramble for every 2^32 particles of each.
pub(crate) fn particle_sampler(seed: u64, replicate: usize, number: u64) -> PixelSampler {
    let scramble = [(number >> 32) as u32, replicate as u32];
    PixelSampler::new(SamplerKind::Sobol, 1, seed, scramble, number as u32)
}
