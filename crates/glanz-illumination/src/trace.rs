//! Particle tracing from the lights to the receivers.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, JobEnd, JobProgress, ProgressSink, WorkCount};
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::Scene;
use glanz_transport::{Counters, ParticleTracer};

use crate::receiver::Receivers;
use crate::tally::{Tally, ThreadTally};

/// Particles that a thread traces together.
const BLOCK: u64 = 1 << 10;

/// Wall time of a round, after which progress is reported and cancelling takes effect.
const ROUND_SECONDS: f64 = 0.5;

/// Particles of the first round.
const FIRST_ROUND: u64 = 1 << 14;

/// Conditions for the end; the first that is met ends the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TraceGoal {
    /// Particles in all, those of earlier runs included.
    pub particles: Option<u64>,
    /// Wall time of this run.
    pub time: Option<Duration>,
    /// Largest relative standard error of the brightest cell and of the mean of every receiver that light comes to.
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
    /// Wall time of this run.
    pub elapsed: Duration,
}

/// Threads cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start threads: {0}")]
pub struct ThreadsError(#[from] pub rayon::ThreadPoolBuildError);

/// Traces particles until a goal is reached and adds them to `tally`.
///
/// Particles are numbered, and a run continues after the last one of `tally`: the sums depend on seed and number of
/// particles alone, not on threads or interruptions. A cancelled run returns its sums so far, of at least one round of particles.
/// The error in its progress is the largest of the relative standard errors that [`TraceGoal::error`] names.
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
    let first = tally.particles();
    let mut counters = Counters::default();
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    let end = loop {
        let error = worst_error(&tally, receivers);
        let done = tally.particles();
        let elapsed = start.elapsed();
        let pace = pace(done - first, elapsed);
        if done > first {
            let remaining = settings.goal.remaining(done, error, elapsed, pace);
            let unit = ["particle", "particles"];
            let count = WorkCount { done, wanted: settings.goal.particles, unit };
            let progress = JobProgress::by_time("particles from lights", elapsed, remaining);
            sink.on_progress(&progress.with_count(count).with_error(error));
            if timer.is_due() {
                sink.on_checkpoint(&tally);
                timer.restart();
            }
        }
        let goal = &settings.goal;
        if goal.particles.is_some_and(|wanted| done >= wanted) || goal.error.is_some_and(|e| error <= e) {
            break JobEnd::Complete;
        }
        if cancel.is_cancelled() && done > 0 {
            break JobEnd::Interrupted;
        }
        if done > first && goal.time.is_some_and(|limit| elapsed >= limit) {
            break JobEnd::TimeUp;
        }
        let length = settings.goal.round(done, elapsed, pace);
        let (brought, work) = pool.install(|| round(scene, receivers, settings, &tally, done..done + length));
        tally.merge(&brought);
        counters.merge(work);
    };
    let particles = tally.particles() - first;
    Ok(TraceOutcome { tally, end, particles, counters, elapsed: start.elapsed() })
}

/// Particles per second; `None` before the first.
fn pace(particles: u64, elapsed: Duration) -> Option<f64> {
    (particles > 0).then(|| particles as f64 / elapsed.as_secs_f64().max(1e-9))
}

impl TraceGoal {
    /// Particles of the next round.
    fn round(&self, done: u64, elapsed: Duration, pace: Option<f64>) -> u64 {
        let Some(pace) = pace else {
            return self.particles.map_or(FIRST_ROUND, |wanted| (wanted - done).min(FIRST_ROUND));
        };
        let mut seconds = ROUND_SECONDS;
        if let Some(limit) = self.time {
            seconds = seconds.min(limit.saturating_sub(elapsed).as_secs_f64());
        }
        let length = ((pace * seconds) as u64).max(BLOCK);
        // Not many more than the error requires, which is uncertain after few particles.
        let length = if self.error.is_some() { length.min(done.max(FIRST_ROUND)) } else { length };
        self.particles.map_or(length, |wanted| length.min(wanted - done))
    }

    /// Time until the end; `None` if it is unknown.
    fn remaining(&self, done: u64, error: f64, elapsed: Duration, pace: Option<f64>) -> Option<Duration> {
        let mut seconds = f64::INFINITY;
        let by_pace = |particles: f64| particles / pace.unwrap_or(f64::INFINITY);
        if let Some(wanted) = self.particles {
            seconds = seconds.min(by_pace(wanted.saturating_sub(done) as f64));
        }
        if let Some(goal) = self.error {
            // The error decreases with the square root of the number of particles.
            seconds = seconds.min(by_pace(done as f64 * ((error / goal).powi(2) - 1.0).max(0.0)));
        }
        if let Some(limit) = self.time {
            seconds = seconds.min(limit.saturating_sub(elapsed).as_secs_f64());
        }
        Duration::try_from_secs_f64(seconds).ok()
    }
}

/// Traces the particles of a range with all threads of the pool.
fn round(
    scene: &Scene,
    receivers: &Receivers,
    settings: &TraceSettings,
    tally: &Tally,
    range: std::ops::Range<u64>,
) -> (Tally, Counters) {
    let far_field = tally.far_field.as_ref().map(|sums| sums.grid);
    let next = AtomicU64::new(range.start);
    let works = rayon::broadcast(|_| {
        let mut tally = ThreadTally::new(receivers, far_field);
        let mut tracer = ParticleTracer::new(scene, settings.max_events);
        let mut counters = Counters::default();
        loop {
            let from = next.fetch_add(BLOCK, Ordering::Relaxed);
            if from >= range.end {
                return (tally.into_tally(), counters);
            }
            let mut rest = from..(from + BLOCK).min(range.end);
            while !rest.is_empty() {
                // Up to the end of a sequence.
                let count = (rest.end - rest.start).min((1 << 32) - (rest.start & 0xffff_ffff)) as u32;
                let first = particle_sampler(settings.seed, rest.start);
                tracer
                    .trace(first, count, &mut counters, |particle, arrival| tally.arrival(particle, arrival));
                tally.end(tracer.paths());
                rest.start += u64::from(count);
            }
        }
    });
    // Sums are exact: their order does not matter.
    let mut all = (Tally::new(receivers, far_field), Counters::default());
    for (brought, counters) in works {
        all.0.merge(&brought);
        all.1.merge(counters);
    }
    all
}

/// The sampler of a particle: one sequence for every 2^32 particles.
fn particle_sampler(seed: u64, number: u64) -> PixelSampler {
    PixelSampler::new(SamplerKind::Sobol, 1, seed, [(number >> 32) as u32, 0], number as u32)
}

/// The largest relative standard error of the brightest cell and of the mean of any receiver that light comes to; infinity if it
/// comes to none.
fn worst_error(tally: &Tally, receivers: &Receivers) -> f64 {
    let mut worst = None;
    for (number, receiver) in receivers.as_slice().iter().enumerate() {
        let (mean, error) = tally.received(number);
        if mean <= 0.0 {
            continue;
        }
        let sums = tally.cells.get(receivers.cells_of(number)).unwrap_or_default();
        let cells = sums.iter().zip(receiver.areas()).filter(|(_, area)| **area > 0.0);
        let lux = |(sums, &area): (&crate::tally::TallySums, &f64)| {
            let (lumens, error) = sums.mean(tally.particles());
            (lumens / area, error / lumens)
        };
        let brightest = cells.map(lux).max_by(|a, b| a.0.total_cmp(&b.0));
        let peak = brightest.map_or(0.0, |(_, relative)| relative);
        worst = Some(f64::max(worst.unwrap_or(0.0), peak.max(error / mean)));
    }
    worst.unwrap_or(f64::INFINITY)
}
