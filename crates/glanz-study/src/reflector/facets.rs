//! Light reflected by facets, compared with that reflected by the exact mirror.

use std::time::Duration;

use glanz_geometry::bezier::TrianglePatch;
use glanz_math::DVec3;
use glanz_scene::Scene;
use glanz_scene::description::ShapeDescription;

use super::mesh;
use super::particles::{ALL_CELLS, CELLS, ConeSource, ParticleEnd, follow};
use super::room::{self, SIDE, alone};
use crate::clock::{self, Stopwatch, TimeScope};
use crate::study::{Settings, StudyError};

/// Triangles along an edge of the mirror: about 100, 1000, 10^4, 10^5 and 10^6 in all.
pub(super) const EDGES: [u32; 5] = [10, 32, 100, 316, 1000];

/// Number of particles that are generated before each timed block.
const BLOCK: u32 = 1 << 16;

/// Results of the exact mirror or of a mesh in its place.
#[derive(Clone, Debug)]
pub(super) struct MirrorCase {
    /// `None` for the exact one.
    pub(super) triangles: Option<u64>,
    /// Whether normals are interpolated.
    pub(super) smooth: bool,
    /// Time from control points to the scene with its hierarchy.
    pub(super) build: Duration,
    /// Time for all particles.
    pub(super) time: Duration,
    pub(super) error: MapError,
}

/// Errors of a map of the mirror's light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MapError {
    /// Root mean square over the lit cells, lx.
    pub(super) rms: f64,
    /// Its random part with this number of particles: root of the mean variance, lx.
    pub(super) noise: f64,
    /// Largest error, lx.
    pub(super) largest: f64,
    /// Standard error in that cell, lx.
    pub(super) largest_noise: f64,
    /// Share of the particles on either mirror that end in different cells.
    pub(super) moved: f64,
}

impl MapError {
    /// The systematic error, lx; 0 if it is below the noise.
    pub(super) fn systematic(&self) -> f64 {
        (self.rms * self.rms - self.noise * self.noise).max(0.0).sqrt()
    }
}

/// The light of the exact mirror.
#[derive(Clone, Debug)]
pub(super) struct ExactMirror {
    /// End of each particle.
    ends: Vec<ParticleEnd>,
    /// Illuminance by the mirror alone in all cells, lx.
    pub(super) lux: Vec<f64>,
    /// Mean over the lit cells, lx.
    pub(super) mean: f64,
    /// Largest illuminance, lx.
    pub(super) peak: f64,
    /// Root of the mean variance of the lit cells, lx.
    pub(super) noise: f64,
    /// Share of the particles that hit the mirror.
    pub(super) met: f64,
}

/// Results of all mirrors, the exact one first.
pub(super) struct FacetOutcome {
    pub(super) particles: u32,
    pub(super) exact: ExactMirror,
    pub(super) cases: Vec<MirrorCase>,
}

/// Traces `particles` reflected by the exact mirror and by its meshes; `on_progress` receives the completed share, [0, 1], and the next step.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(super) fn measure(
    particles: u32,
    edges: &[u32],
    settings: &Settings,
    on_progress: &mut dyn FnMut(f64, String),
) -> Result<FacetOutcome, StudyError> {
    let patch = room::mirror()?;
    let aim = ConeSource::at(ball(&patch), settings.seed);
    let each = aim.flux() / f64::from(particles);
    let parts = (1 + 2 * edges.len()) as f64;
    on_progress(0.0, "the exact mirror".to_owned());
    let (exact_case, exact) = {
        let (scene, build) = built(|| ShapeDescription::bezier_triangles(std::slice::from_ref(&patch)))?;
        let (ends, time) = run(&scene, &aim, particles, settings)?;
        let case = MirrorCase { triangles: None, smooth: false, build, time, error: MapError::default() };
        (case, ExactMirror::of(ends, each))
    };
    let mut cases = vec![exact_case];
    for (number, (smooth, &n)) in
        (1..).zip([false, true].into_iter().flat_map(|smooth| edges.iter().map(move |n| (smooth, n))))
    {
        let triangles = u64::from(n).pow(2);
        on_progress(f64::from(number) / parts, format!("the mirror as {triangles} triangles"));
        let (scene, build) = built(|| mesh::triangles(&patch, n, smooth).into())?;
        let (ends, time) = run(&scene, &aim, particles, settings)?;
        let error = exact.error(&ends, each);
        cases.push(MirrorCase { triangles: Some(triangles), smooth, build, time, error });
    }
    Ok(FacetOutcome { particles, exact, cases })
}

/// Middle and radius of a ball around a patch, metres.
fn ball(patch: &TrianglePatch) -> (DVec3, f64) {
    let middle = patch.bounds().center();
    let distances = patch.control_points().iter().map(|p| (p.truncate() / p.w).distance(middle));
    (middle, distances.fold(0.0, f64::max))
}

/// A scene of the mirror, and the time of one thread from control points to the scene.
fn built(make: impl Fn() -> ShapeDescription + Sync) -> Result<(Scene, Duration), StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| clock::repeated(|| (), |()| alone(make())))
}

/// Ends of all particles, and the time of this thread to follow them.
fn run(
    scene: &Scene,
    aim: &ConeSource,
    particles: u32,
    settings: &Settings,
) -> Result<(Vec<ParticleEnd>, Duration), StudyError> {
    let mut ends = Vec::with_capacity(particles as usize);
    let mut time = Duration::ZERO;
    let mut from = 0;
    while from < particles {
        settings.cancel.check()?;
        let to = from.saturating_add(BLOCK).min(particles);
        let rays: Vec<_> = (from..to).map(|number| aim.particle(number)).collect();
        let watch = Stopwatch::start(TimeScope::Thread);
        ends.extend(rays.iter().map(|ray| follow(scene, ray)));
        time += watch.elapsed();
        from = to;
    }
    Ok((ends, time))
}

/// Area of a cell, m^2.
fn area() -> f64 {
    (SIDE / f64::from(CELLS)).powi(2)
}

impl ExactMirror {
    /// The light of particles that carry `each` lm.
    fn of(ends: Vec<ParticleEnd>, each: f64) -> Self {
        let mut lux = vec![0.0; ALL_CELLS];
        let mut variance = vec![0.0; ALL_CELLS];
        let mut met = 0_u64;
        for end in &ends {
            met += u64::from(*end != ParticleEnd::Missed);
            if let Some((cell, share)) = end.arriving()
                && let (Some(lux), Some(variance)) = (lux.get_mut(cell), variance.get_mut(cell))
            {
                let arriving = share * each / area();
                *lux += arriving;
                *variance += arriving * arriving;
            }
        }
        let lit = lux.iter().filter(|lux| **lux > 0.0).count().max(1) as f64;
        Self {
            mean: lux.iter().sum::<f64>() / lit,
            peak: lux.iter().copied().fold(0.0, f64::max),
            noise: (variance.iter().sum::<f64>() / lit).sqrt(),
            met: met as f64 / ends.len().max(1) as f64,
            lux,
            ends,
        }
    }

    /// The error of the map of the same particles with another mirror. Only particles that end elsewhere contribute,
    /// independently: the variance is the sum of their squares.
    fn error(&self, others: &[ParticleEnd], each: f64) -> MapError {
        let mut difference = vec![0.0; ALL_CELLS];
        let mut variance = vec![0.0; ALL_CELLS];
        let (mut moved, mut at_either) = (0_u64, 0_u64);
        for (exact, other) in self.ends.iter().zip(others) {
            at_either += u64::from(*exact != ParticleEnd::Missed || *other != ParticleEnd::Missed);
            if exact == other {
                continue;
            }
            moved += 1;
            for (end, sign) in [(exact, -1.0), (other, 1.0)] {
                if let Some((cell, share)) = end.arriving()
                    && let (Some(sum), Some(variance)) = (difference.get_mut(cell), variance.get_mut(cell))
                {
                    let arriving = share * each / area();
                    *sum += sign * arriving;
                    *variance += arriving * arriving;
                }
            }
        }
        let mut error = MapError { moved: moved as f64 / at_either.max(1) as f64, ..MapError::default() };
        let (mut lit, mut squares, mut variances) = (0_u64, 0.0, 0.0);
        for ((lux, difference), variance) in self.lux.iter().zip(&difference).zip(&variance) {
            if *lux == 0.0 && *variance == 0.0 {
                continue;
            }
            lit += 1;
            squares += difference * difference;
            variances += variance;
            if difference.abs() > error.largest {
                (error.largest, error.largest_noise) = (difference.abs(), variance.sqrt());
            }
        }
        let lit = lit.max(1) as f64;
        (error.rms, error.noise) = ((squares / lit).sqrt(), (variances / lit).sqrt());
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_counts_what_ends_elsewhere() {
        // Reflectance 0.9: of 1 lm on a cell of (10 / 32)^2 m^2 each particle brings 0.9 * 10.24 lx.
        let lux = 0.9 * 10.24;
        let ends = vec![
            ParticleEnd::Cell(5, 1),
            ParticleEnd::Cell(5, 1),
            ParticleEnd::Cell(6, 1),
            ParticleEnd::Missed,
            ParticleEnd::Lost,
        ];
        let exact = ExactMirror::of(ends, 1.0);
        assert!((exact.lux[5] - 2.0 * lux).abs() < 1e-9 && (exact.mean - 1.5 * lux).abs() < 1e-9);
        assert!((exact.peak - 2.0 * lux).abs() < 1e-9 && exact.met == 0.8);
        // sqrt(3 / 2) of one particle.
        assert!((exact.noise - 1.5_f64.sqrt() * lux).abs() < 1e-9);
        let others = [
            ParticleEnd::Cell(5, 1),
            ParticleEnd::Cell(7, 1),
            ParticleEnd::Cell(6, 1),
            ParticleEnd::Missed,
            ParticleEnd::Cell(5, 1),
        ];
        let error = exact.error(&others, 1.0);
        // Cell 5 lost one and got one, cell 7 got one: squares 0, 1 over the three lit cells; variances 2 and 1.
        assert!((error.rms - (1.0_f64 / 3.0).sqrt() * lux).abs() < 1e-9, "{error:?}");
        assert!((error.noise - lux).abs() < 1e-9 && error.systematic() == 0.0, "{error:?}");
        assert!((error.largest - lux).abs() < 1e-9 && (error.largest_noise - lux).abs() < 1e-9);
        assert_eq!(error.moved, 0.5);
    }

    #[test]
    fn finer_facets_move_fewer_particles_and_interpolated_normals_fewer_still() {
        let found = measure(20_000, &[10, 100], &Settings::default(), &mut |_, _| {}).unwrap();
        let moved: Vec<f64> = found.cases.iter().map(|case| case.error.moved).collect();
        let [exact, coarse, fine, coarse_smooth, fine_smooth] = moved[..] else { panic!("{moved:?}") };
        assert_eq!(exact, 0.0);
        assert!(coarse > 3.0 * fine && coarse_smooth > 3.0 * fine_smooth, "{moved:?}");
        assert!(coarse > coarse_smooth && fine > 2.0 * fine_smooth, "{moved:?}");
    }

    #[test]
    fn mirrors_light_is_what_meets_it() {
        // Flux on the walls: that of the particles that meet the mirror times its reflectance, once or for a few twice.
        let found = measure(20_000, &[], &Settings::default(), &mut |_, _| {}).unwrap();
        let on_walls: f64 = found.exact.lux.iter().sum::<f64>() * area();
        let sent = ConeSource::at(ball(&room::mirror().unwrap()), 0).flux();
        assert!(on_walls <= sent * found.exact.met * room::REFLECTANCE * (1.0 + 1e-9));
        assert!(on_walls >= sent * found.exact.met * room::REFLECTANCE.powi(2));
    }
}
