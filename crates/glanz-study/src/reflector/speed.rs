//! Number of particles per second that one or two mirrors reflect, of one and of many patches.

use std::time::{Duration, Instant};

use glanz_geometry::SurfaceError;
use glanz_geometry::bezier::{Barycentric, TrianglePatch};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_scene::description::ShapeDescription;
use glanz_scene::{Scene, SceneBuilder};
use rayon::prelude::*;

use super::particles::{ConeSource, ParticleEnd, follow};
use super::room::{material, mirror};
use crate::clock::{SHORTEST, Stopwatch, TimeScope};
use crate::report::Report;
use crate::study::{Settings, StudyError};
use glanz_report::Table;
use glanz_report::number::{grouped, significant};

/// Parts of an edge of a mirror: 1, 100 and 10 000 patches each.
pub(super) const EDGES: [u32; 3] = [1, 10, 100];

/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];

/// Numbers of reflections.
const BOUNCES: [u8; 2] = [1, 2];

/// Number of particles that are traced repeatedly.
const PARTICLES: usize = 20_000;

/// Largest number of candidates for these.
const TRIED: u32 = 1_000_000;

/// Particles that a thread takes at a time.
const CHUNK: usize = 256;

/// Result of one configuration.
pub(super) struct Speed {
    bounces: u8,
    patches: u64,
    threads: usize,
    /// Particles per second of wall time.
    per_second: f64,
    /// Processor time of one particle.
    each: Duration,
}

/// The same surface divided into n^2 patches.
///
/// # Errors
/// None in practice: the parts are inside.
fn divided(patch: &TrianglePatch, n: u32) -> Result<Vec<TrianglePatch>, SurfaceError> {
    let at =
        |i: u32, j: u32| Barycentric::from_parameters(DVec2::new(f64::from(i), f64::from(j)) / f64::from(n));
    let mut parts = Vec::with_capacity((n as usize).pow(2));
    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
        parts.push(patch.sub_triangle([at(i, j), at(i + 1, j), at(i, j + 1)])?);
        if i + j + 1 < n {
            parts.push(patch.sub_triangle([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])?);
        }
    }
    Ok(parts)
}

/// A second mirror, under the ceiling in the light of the first: a quadratic triangle that bulges downwards.
///
/// # Errors
/// None in practice: the control points are valid.
fn second() -> Result<TrianglePatch, SurfaceError> {
    let (z, low) = (9.8, 9.4);
    let points = [
        DVec3::new(-4.0, 0.0, z),
        DVec3::new(2.0, 0.0, low),
        DVec3::new(-4.0, 7.0, low),
        DVec3::new(8.0, 0.0, z),
        DVec3::new(2.0, 7.0, low),
        DVec3::new(-4.0, 14.0, z),
    ];
    TrianglePatch::try_from_points(2, &points, None)
}

/// Measures all configurations; `edges`: numbers of parts of the mirrors' edges.
///
/// # Errors
/// [`StudyError::Interrupted`]; [`StudyError::Threads`].
pub(super) fn measure(edges: &[u32], settings: &Settings) -> Result<Vec<Speed>, StudyError> {
    let mut speeds = Vec::new();
    for bounces in BOUNCES {
        let mirrors = [mirror()?, second()?];
        let mirrors = mirrors.get(..usize::from(bounces)).unwrap_or_default();
        let mut particles = Vec::new();
        for &n in edges {
            let scene = scene(mirrors, n)?;
            if particles.is_empty() {
                particles = select_particles(&scene, bounces, settings)?;
            }
            for threads in THREADS {
                let (per_second, each) = timed(&scene, &particles, threads, settings)?;
                let patches = u64::from(n).pow(2) * mirrors.len() as u64;
                speeds.push(Speed { bounces, patches, threads, per_second, each });
            }
        }
    }
    Ok(speeds)
}

fn scene(mirrors: &[TrianglePatch], n: u32) -> Result<Scene, StudyError> {
    let mut builder = SceneBuilder::new();
    for patch in mirrors {
        builder = builder.shape(ShapeDescription::bezier_triangles(&divided(patch, n)?), material());
    }
    Ok(builder.resolve()?.0)
}

/// Particles with exactly `bounces` reflections.
fn select_particles(scene: &Scene, bounces: u8, settings: &Settings) -> Result<Vec<Ray>, StudyError> {
    settings.cancel.check()?;
    let bounds = mirror()?.bounds();
    let aim = ConeSource::at((bounds.center(), 0.5 * bounds.diagonal().length()), settings.seed);
    let mut particles = Vec::with_capacity(PARTICLES);
    for number in 0..TRIED {
        let ray = aim.particle(number);
        if matches!(follow(scene, &ray), ParticleEnd::Cell(_, reflections) if reflections == bounces) {
            particles.push(ray);
        }
        if particles.len() == PARTICLES {
            break;
        }
    }
    Ok(particles)
}

/// Particles per second of wall time, and processor time of one.
fn timed(
    scene: &Scene,
    particles: &[Ray],
    threads: usize,
    settings: &Settings,
) -> Result<(f64, Duration), StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    // Once to warm up.
    let send = || -> usize {
        pool.install(|| {
            let ended = |ray: &Ray| usize::from(follow(scene, ray) != ParticleEnd::Missed);
            particles.par_chunks(CHUNK).map(|chunk| chunk.iter().map(ended).sum::<usize>()).sum()
        })
    };
    let mut sent = 0;
    std::hint::black_box(send());
    let (watch, begun) = (Stopwatch::start(TimeScope::Process), Instant::now());
    while sent == 0 || begun.elapsed() < 4 * SHORTEST {
        settings.cancel.check()?;
        std::hint::black_box(send());
        sent += particles.len().max(1);
    }
    let each = watch.elapsed().as_secs_f64() / sent as f64;
    Ok((sent as f64 / begun.elapsed().as_secs_f64(), Duration::from_secs_f64(each)))
}

/// Adds the section to the report.
pub(super) fn add_to(speeds: &[Speed], report: &mut Report) {
    report.heading("Speed");
    report.paragraph(
        "Particles that are reflected by the mirror, or also by a second one under the ceiling, until they reach a wall. \
         Both mirrors are the same surfaces divided into increasing numbers of patches. Unlike wall time, processor time \
         does not depend on other work of the machine.",
    );
    let columns = [
        ("bounces", "reflections"),
        ("patches", "patches"),
        ("threads", "threads"),
        ("particles_per_s", "particles per second of wall time"),
        ("rays_per_s", "rays per second of wall time"),
        ("ns_per_particle", "processor time per particle, ns"),
    ];
    let mut table = Table::new("speed", "Particles reflected by mirrors.", &columns);
    for speed in speeds {
        table.push([
            u64::from(speed.bounces).into(),
            speed.patches.into(),
            (speed.threads as u64).into(),
            speed.per_second.into(),
            // One ray to each mirror, one to the wall.
            (speed.per_second * f64::from(speed.bounces + 1)).into(),
            (1e9 * speed.each.as_secs_f64()).into(),
        ]);
    }
    report.table(table);
    for bounces in BOUNCES {
        let mut alone = speeds.iter().filter(|speed| speed.bounces == bounces && speed.threads == 1);
        if let (Some(few), Some(many)) = (alone.next(), alone.next_back()) {
            report.paragraph(format!(
                "With {} one particle takes {} ns of processor time with {} and {} ns with {} patches.",
                if bounces == 1 { "one mirror" } else { "two mirrors" },
                significant(1e9 * few.each.as_secs_f64()),
                grouped(few.patches),
                significant(1e9 * many.each.as_secs_f64()),
                grouped(many.patches)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_in_parts_sends_particles_to_the_same_places() {
        let mirrors = [mirror().unwrap(), second().unwrap()];
        let (whole, parts) = (scene(&mirrors, 1).unwrap(), scene(&mirrors, 10).unwrap());
        let aim = ConeSource::at((DVec3::new(4.5, 4.5, 5.5), 3.0), 0);
        let (mut same, mut twice) = (0, 0);
        for number in 0..2000 {
            let ray = aim.particle(number);
            let [a, b] = [&whole, &parts].map(|scene| follow(scene, &ray));
            same += u32::from(a == b);
            twice += u32::from(matches!(a, ParticleEnd::Cell(_, 2)));
        }
        // But for roundings at the borders of cells.
        assert!(same >= 1999, "{same}");
        assert!(twice > 20, "{twice}");
        assert_eq!(divided(&mirrors[0], 10).unwrap().len(), 100);
    }
}
