//! Rays of the light that leaves a scene.

use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, JobEnd, JobProgress, ProgressSink, WorkCount};
use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::DVec3;
use glanz_scene::Scene;
use glanz_transport::{Counters, ParticleFate, ParticleTracer};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::replicates::{REPLICATES, first_in_replicate};
use crate::trace::{BLOCK, TraceSettings, particle_sampler};

/// Blocks of particles per thread whose rays are in memory together.
const BLOCKS: u64 = 16;

/// Time between two reports of progress.
const REPORT_INTERVAL: Duration = Duration::from_millis(500);

/// A ray along which light leaves a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EscapedRay {
    /// Where it left the last surface or its light, metres.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Its luminous flux, lm; above 0.
    pub lumens: f64,
}

/// Traces `particles` particles, from number 0, and passes the rays of those that leave the scene to `visit`.
///
/// The particles are those of [`trace`](crate::trace()) with the seed and the largest number of scattering events of `settings`, whose other fields do
/// not matter, so that the flux of all rays is [`FluxBalance::escaped`](crate::FluxBalance::escaped). Their order does not depend on threads, which are those
/// of the current pool. Memory does not grow with the number of particles. The end is reported to `sink`, too. Returns whether all were traced.
///
/// # Errors
/// Those of `visit`.
pub fn escaped_rays<E>(
    scene: &Scene,
    settings: &TraceSettings,
    particles: u64,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
    mut visit: impl FnMut(&EscapedRay) -> Result<(), E>,
) -> Result<JobEnd, E> {
    let (start, mut reported) = (Instant::now(), Instant::now());
    let new = || ParticleTracer::new(scene, settings.max_events);
    let share = 1.0 / particles as f64;
    let batch = BLOCKS * BLOCK * rayon::current_num_threads() as u64;
    let mut done = 0;
    for replicate in 0..REPLICATES {
        let end = first_in_replicate(replicate, particles);
        for first in (0..end).step_by(batch as usize) {
            if cancel.is_cancelled() {
                return Ok(JobEnd::Interrupted);
            }
            let last = end.min(first + batch);
            let block = |tracer: &mut ParticleTracer<'_>, number: u64| {
                let from = first + number * BLOCK;
                // Blocks begin at multiples of their size, so that none goes on in another sequence.
                let place = (settings.seed, replicate, from);
                let light = block_of_escaped_light(tracer, place, BLOCK.min(last - from) as u32);
                light.map(|ray| EscapedRay { lumens: ray.lumens * share, ..ray }).collect::<Vec<_>>()
            };
            let blocks: Vec<Vec<EscapedRay>> =
                (0..(last - first).div_ceil(BLOCK)).into_par_iter().map_init(new, block).collect();
            blocks.iter().flatten().try_for_each(&mut visit)?;
            done += last - first;
            if done == particles || reported.elapsed() >= REPORT_INTERVAL {
                reported = Instant::now();
                let fraction = done as f64 / particles as f64;
                let progress = JobProgress::by_work("rays that leave the scene", fraction, start.elapsed());
                let unit = ["particle", "particles"];
                sink.on_progress(&progress.with_count(WorkCount { done, wanted: Some(particles), unit }));
            }
        }
    }
    Ok(JobEnd::Complete)
}

/// Traces a block of particles; returns those that leave the scene, with all of their flux. `place`: seed, replicate and the number of the first.
pub(crate) fn block_of_escaped_light(
    tracer: &mut ParticleTracer<'_>,
    (seed, replicate, first): (u64, usize, u64),
    count: u32,
) -> impl Iterator<Item = EscapedRay> {
    let wavelengths = Wavelengths::default();
    tracer.trace(particle_sampler(seed, replicate, first), count, &mut Counters::default(), |_, _| {});
    tracer.paths().flatten().filter_map(move |path| match path.end {
        ParticleFate::Escaped { ray, power } => {
            let lumens = photometric(power, &wavelengths);
            (lumens > 0.0).then_some(EscapedRay { origin: ray.origin, direction: ray.direction, lumens })
        }
        ParticleFate::Absorbed | ParticleFate::GivenUp(_) => None,
    })
}
