//! Illuminance by three methods, each of which computes the light that it is best at.
//!
//! Light that arrives straight or by a mirror is integrated before; see [`LightDivision`]. Of the rest, paths from the cells and particles from the lights
//! are traced in turns: always that method next which reduces the error more for its time. Both have the same replicates, whose sums are added, so that their
//! spread is the error of both.

use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, CheckpointTimer, JobEnd, JobProgress, ProgressSink, WorkCount};
use glanz_scene::Scene;
use glanz_transport::Counters;
use glanz_transport::codec::{Decoder, Encoder};

use crate::balance::FluxBalance;
use crate::division::{CellDivision, LightDivision};
use crate::gather::{CellPaths, GatheredFlux};
use crate::lux_map::LuxMap;
use crate::lux_parts::{ErrorSources, IntegratedLux, LuxParts};
use crate::receiver::Receivers;
use crate::replicates::REPLICATES;
use crate::tally::Tally;
use crate::trace::{DARK_PARTICLES, ThreadsError, TraceSettings, TraceWork, pace, round};

/// Particles that show where flux goes, and whether any light is left to particles.
const PILOT: u64 = 1 << 16;

/// Paths of each replicate of each cell in the first round.
const FIRST_PATHS: u32 = 4;

/// Wall time of a round, after which cancelling takes effect with all its paths.
const ROUND_SECONDS: f64 = 2.0;

/// Illuminance as the sum of what integration, paths and particles found.
#[derive(Clone, Debug, PartialEq)]
pub struct CombinedLight {
    integrated: Vec<IntegratedLux>,
    gathered: GatheredFlux,
    tally: Tally,
    /// Whether any light may be left to particles.
    needs_particles: bool,
}

/// Result of [`combine()`].
#[derive(Clone, Debug)]
pub struct CombinedOutcome {
    /// The light.
    pub light: CombinedLight,
    /// Reason for the end.
    pub end: JobEnd,
    /// Rays of this run.
    pub counters: Counters,
    /// The largest of the relative errors that [`TraceGoal::error`](crate::TraceGoal::error) names; infinite without any light.
    pub error: f64,
    /// Wall time of this run.
    pub elapsed: Duration,
}

impl CombinedLight {
    /// Integrated light alone, of all cells of all receivers; where it did not converge, it is left to paths and particles.
    #[must_use]
    pub fn new(receivers: &Receivers, integrated: Vec<IntegratedLux>) -> Self {
        let kept = |cell: IntegratedLux| if cell.converged { cell } else { IntegratedLux::default() };
        let integrated = integrated.into_iter().map(kept).collect();
        let gathered = GatheredFlux::new(receivers.cell_count());
        Self { integrated, gathered, tally: Tally::new(receivers, None), needs_particles: false }
    }

    /// Whether it is light on these receivers.
    #[must_use]
    pub fn fits(&self, receivers: &Receivers) -> bool {
        let cells = [self.integrated.len(), self.gathered.len()];
        cells == [receivers.cell_count(); 2] && self.tally.fits(receivers, false)
    }

    /// Number of paths from the cells.
    #[must_use]
    pub fn paths(&self) -> u64 {
        self.gathered.len() as u64 * REPLICATES as u64 * u64::from(self.gathered.samples())
    }

    /// Number of particles.
    #[must_use]
    pub fn particles(&self) -> u64 {
        self.tally.particles().total()
    }

    /// Paths and particles.
    fn count(&self) -> u64 {
        self.paths() + self.particles()
    }

    /// Whether paths and particles have begun: before, a part of the light is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.gathered.samples() > 0 && self.particles() >= PILOT
    }

    /// Flux that the lights emit and where it ends, by the particles.
    #[must_use]
    pub fn balance(&self) -> FluxBalance {
        self.tally.balance()
    }

    /// Flux on the side of a receiver that is not counted, by the particles, lm.
    #[must_use]
    pub fn on_other_side(&self, receiver: usize) -> f64 {
        self.tally.on_other_side(receiver)
    }

    /// Illuminance on every receiver. Errors are standard errors, from the spread of replicates, plus the bounds of what is integrated.
    #[must_use]
    pub fn lux_maps(&self, receivers: &Receivers) -> Vec<LuxMap> {
        self.parts(receivers).lux_maps()
    }

    fn parts<'a>(&'a self, receivers: &'a Receivers) -> LuxParts<'a> {
        LuxParts {
            receivers,
            integrated: &self.integrated,
            gathered: Some(&self.gathered),
            tally: &self.tally,
            may_be_uncounted: self.tally.has_light_in_cells()
                || self.needs_particles && self.particles() < DARK_PARTICLES,
            errors: ErrorSources::ALL,
        }
    }

    /// Appends the integrated light, that of paths and the tally.
    pub fn encode(&self, encoder: &mut Encoder) {
        encoder.u64(self.integrated.len() as u64);
        self.integrated.iter().for_each(|cell| {
            encoder.f64(cell.lux);
            encoder.f64(cell.error);
            encoder.u8(u8::from(cell.converged));
        });
        encoder.u8(u8::from(self.needs_particles));
        self.gathered.encode(encoder);
        self.tally.encode(encoder);
    }

    /// Reads the output of [`CombinedLight::encode`]; `None` if malformed.
    #[must_use]
    pub fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let count = usize::try_from(decoder.u64()?).ok()?;
        if decoder.0.len() / 17 < count {
            return None;
        }
        let integrated = (0..count).map(|_| {
            let [lux, error] = [f64::from_bits(decoder.u64()?), f64::from_bits(decoder.u64()?)];
            let converged = decode_flag(decoder)?;
            Some(IntegratedLux { lux, error, converged })
        });
        let integrated = integrated.collect::<Option<_>>()?;
        let needs_particles = decode_flag(decoder)?;
        let (gathered, tally) = (GatheredFlux::decode(decoder)?, Tally::decode(decoder)?);
        Some(Self { integrated, gathered, tally, needs_particles })
    }
}

fn decode_flag(decoder: &mut Decoder<'_>) -> Option<bool> {
    [false, true].get(usize::from(decoder.u8()?)).copied()
}

/// A method and what it has cost.
#[derive(Clone, Copy, Debug, Default)]
struct MethodCost {
    seconds: f64,
    count: u64,
}

impl MethodCost {
    fn add(&mut self, start: Instant, count: u64) {
        self.seconds += start.elapsed().as_secs_f64();
        self.count += count;
    }

    /// Number of paths or particles of a round of about this time: at most `most`, at least `least`.
    fn round(&self, seconds: f64, most: u64, least: u64) -> u64 {
        let by_time = seconds * self.count as f64 / self.seconds.max(1e-9);
        (by_time as u64).min(most).max(least)
    }

    /// Variance that an equal effort again would remove, for its time.
    fn gain(&self, error: f64) -> f64 {
        error * error / self.seconds.max(1e-6)
    }
}

/// Traces paths from the cells and particles until the goal of `settings` is reached, and adds their light to `light`.
///
/// [`TraceGoal::particles`](crate::TraceGoal::particles) counts both, of which there are at least those of a first round. A cancelled run returns its sums so far, see
/// [`CombinedLight::is_whole`]. The first rounds have the same bits by any number of threads; which method later rounds take, and how many paths, depends on the clock.
///
/// # Errors
/// [`ThreadsError`] before the first path.
pub fn combine(
    scene: &Scene,
    receivers: &Receivers,
    division: &LightDivision<'_>,
    settings: &TraceSettings,
    mut light: CombinedLight,
    sink: &mut dyn ProgressSink<CombinedLight>,
    cancel: &CancelFlag,
) -> Result<CombinedOutcome, ThreadsError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let start = Instant::now();
    let integrated = light.integrated.clone();
    light.needs_particles = division.needs_particles();
    let all = receivers.as_slice().iter();
    let cells = all.flat_map(|receiver| (0..receiver.len()).map(move |cell| (receiver, cell)));
    let only_particles: Vec<bool> = cells.map(|(receiver, cell)| !receiver.has_places(cell)).collect();
    let division = CellDivision { division, integrated: &integrated, only_particles: &only_particles };
    let paths = CellPaths::new(scene, receivers, division, settings.seed, settings.max_events);
    let goal = &settings.goal;
    let mut counters = Counters::default();
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    let mut costs = [MethodCost::default(); 2];
    let first = light.count();
    let (end, error) = loop {
        let (error, errors) = errors(&light, receivers);
        let elapsed = start.elapsed();
        let done = light.count();
        let left = goal.particles.map_or(0, |all| all.saturating_sub(done));
        let work = TraceWork { done, left, elapsed, pace: pace(done - first, elapsed) };
        let count = WorkCount { done, wanted: goal.particles, unit: ["path", "paths"] };
        let remaining = goal.remaining(&work, error);
        let progress = JobProgress::by_time("light between surfaces", elapsed, remaining).with_count(count);
        let progress = if error.is_finite() { progress.with_error(error) } else { progress };
        sink.on_progress(&progress);
        if timer.is_due() {
            timer.save(|| sink.on_checkpoint(&light));
        }
        let is_begun = light.is_whole();
        // Without any light there is nothing to wait for.
        let is_dark = error == f64::INFINITY && light.particles() >= DARK_PARTICLES;
        // Where the integration has most of the error, more paths do not help.
        let random = errors[0].hypot(errors[1]);
        if is_begun && goal.error.is_some_and(|goal| error <= goal || is_dark || random <= 0.25 * goal) {
            break (JobEnd::Complete, error);
        }
        if is_begun && goal.particles.is_some_and(|all| done >= all) {
            break (JobEnd::Complete, error);
        }
        if cancel.is_cancelled() {
            break (JobEnd::Interrupted, error);
        }
        if is_begun && goal.time.is_some_and(|limit| elapsed >= limit) {
            break (JobEnd::TimeUp, error);
        }
        let [by_paths, by_particles] = [0, 1].map(|method| costs[method].gain(errors[method]));
        let (begin, before) = (Instant::now(), done);
        let both_unknown = by_paths == f64::INFINITY && by_particles == f64::INFINITY;
        let is_cheaper = both_unknown && costs[1].seconds <= costs[0].seconds;
        let is_by_particles = light.particles() < PILOT
            || light.gathered.samples() > 0 && (by_particles > by_paths || is_cheaper);
        let seconds = goal.time.map_or(ROUND_SECONDS, |limit| limit.saturating_sub(elapsed).as_secs_f64());
        let seconds = seconds.min(ROUND_SECONDS);
        if is_by_particles {
            let traced = light.particles();
            let length = costs[1].round(seconds, traced.max(PILOT), PILOT);
            let next = traced..traced + length;
            counters.merge(
                pool.install(|| round(scene, receivers, settings, Some(division), &mut light.tally, next)),
            );
        } else {
            let samples = light.gathered.samples();
            let per_sample = paths.len() as u64 * REPLICATES as u64;
            let most =
                costs[0].round(seconds, u64::from(samples) * per_sample, per_sample) / per_sample.max(1);
            let more = (most as u32).clamp(1, samples.max(FIRST_PATHS));
            let more = if samples == 0 { FIRST_PATHS } else { more };
            let mut between = |share: f64| {
                // The first round may take long.
                if samples == 0 {
                    sink.on_progress(&JobProgress::by_work("light between surfaces", share, begin.elapsed()));
                }
                !cancel.is_cancelled()
            };
            match light.gathered.add(&pool, &paths, more, &mut between) {
                Some(rays) => counters.merge(rays),
                None => break (JobEnd::Interrupted, error),
            }
        }
        costs[usize::from(is_by_particles)].add(begin, light.count() - before);
    };
    Ok(CombinedOutcome { light, end, counters, error, elapsed: start.elapsed() })
}

/// The largest relative error, and those that would be left if the other method had none: of paths, and of particles.
fn errors(light: &CombinedLight, receivers: &Receivers) -> (f64, [f64; 2]) {
    let parts = light.parts(receivers);
    let of = |errors| LuxParts { errors, ..light.parts(receivers) }.worst_error();
    (parts.worst_error(), [of(ErrorSources::PATHS), of(ErrorSources::PARTICLES)])
}
