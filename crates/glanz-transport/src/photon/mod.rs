//! Photons: light that mirrors and glass send on, stored where it arrives.
//!
//! A [`PhotonMap`] holds the light that arrives on scattering surfaces after one or more delta lobes (mirrors, smooth glass) and nothing else since it left its light.
//! Paths from the camera, which cannot sample such light and hit its lights by chance only, add it at every scattering event by a density estimate: the photons within
//! a small radius, divided by the area of the disk. Of lights that no ray can hit, this is the only technique that finds caustics seen by mirror or glass.
//!
//! The map of a sample number is a function of the scene, the settings and the seed alone, and all pixels share it. The estimate has a bias: caustics are blurred by a
//! disk, and too dark by half at a straight border, by more at corners and on parts that are narrower or more curved than the disk. The radius of sample i is `r (i + 1)^(-1/6)`, by which the squared bias and the
//! variance of the mean both vanish, as n^(-2/3).
//!
//! # Weights
//! The same light is found by a path from the camera that is scattered at x, follows mirrors and glass and hits a light by chance. For given x and lobes both techniques
//! sample a direction at x. With N photon paths, the density e of emission per square metre across the ray and steradian
//! ([`Scene::emission_pdf`](glanz_scene::Scene::emission_pdf)), which mirrors and glass keep (up to refractive indices), the cosine a between the direction and
//! the normal and the density p per solid angle of the direction at x,
//!
//! ```text
//! merged / hit = pi r^2 N e a / p,
//! ```
//!
//! the expected number of photons over that of paths. The weights are those of the power heuristic; as both sides use the same numbers they add up to 1.
//!
//! # Source
//! @jensen2001 for photon maps; @georgiev2012 for the weights, of which these are the part that concerns caustics; @knaus2011 for independent maps with shrinking radii.
//! Departures: the power of the radius in closed form; only caustics are stored, everything else is light that path tracing samples well.

use std::ops::RangeInclusive;

use glanz_job::Interrupted;
use glanz_light::Spectrum;
use glanz_math::DVec3;
use glanz_math::glam::Vec3;
use glanz_scene::Scene;
use glanz_scene::description::PhotonSettings;

use self::emission::EmissionDensity;
use self::trace::PhotonArrival;
use crate::integrator::Counters;

mod emission;
mod map;
mod radius;
mod trace;

pub use map::PhotonMap;

/// Largest number of photon paths of a map. A map takes up to 90 bytes for each photon, and 250 while it is made; a path leaves
/// one at every surface that both scatters and mirrors.
pub const PHOTON_LIMIT: u32 = 1 << 24;

/// Radii of density estimates, metres: cells of the map stay within integers in scenes of up to 10^8 m, and areas within `f32`.
pub const PHOTON_RADII: RangeInclusive<f64> = 1e-9..=1e9;

/// Bounds of the number of photon paths if it is not given: that of the pixels, but enough to be traced by all threads, and at most 250 MB.
const DEFAULT_PHOTONS: [u64; 2] = [1 << 12, 1 << 20];

/// Exponent of the radius over the number of the sample: that of the smallest error, as the ratio 2/3 of @knaus2011.
const RADIUS_EXPONENT: f64 = -1.0 / 6.0;

/// Rounds in which the density of emission is fitted, and bounds of the number of paths of each.
const TRAINING_ROUNDS: u32 = 2;
const TRAINING_PATHS: [u32; 2] = [1 << 13, 1 << 16];

/// Light that arrives after mirrors and glass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Photon {
    /// Unit direction from which it arrives.
    from: Vec3,
    /// Unit normal of the surface, on any side.
    normal: Vec3,
    /// Flux divided by the number of photon paths, W.
    flux: Spectrum,
    /// Density of emission, per square metre across the ray and steradian, times the probability of the light; infinite for lights that no ray can hit.
    emission: f32,
    /// Number of scattering events since its light.
    events: u32,
}

impl Photon {
    /// Unit direction from which it arrives.
    pub(crate) fn direction(&self) -> DVec3 {
        self.from.as_dvec3()
    }

    /// Flux divided by the number of photon paths, W.
    pub(crate) fn flux(&self) -> Spectrum {
        self.flux
    }

    /// Number of scattering events since its light.
    pub(crate) fn events(&self) -> u32 {
        self.events
    }
}

/// Tracer of the photons of a picture.
#[derive(Debug)]
pub struct PhotonTracer {
    /// Radius of sample 0, metres.
    radius: f64,
    /// Number of photon paths per sample of every pixel.
    paths: u32,
    /// Largest number of scattering events of a whole path.
    max_depth: u32,
    seed: u64,
    /// Density of emission, fitted before the first map; `None` for uniform numbers.
    density: Option<EmissionDensity>,
    /// Rays traced to fit it, until the first map takes them.
    counters: Counters,
}

impl PhotonTracer {
    /// A tracer for a picture of `resolution` pixels. `max_depth`: largest number of scattering events of a whole path.
    ///
    /// `None` if no radius is given, no surface is seen and none has an extent.
    pub(crate) fn new(
        scene: &Scene,
        settings: &PhotonSettings,
        max_depth: u32,
        seed: u64,
        resolution: [u32; 2],
    ) -> Option<Self> {
        let [least, most] = DEFAULT_PHOTONS;
        let pixels = resolution.into_iter().map(u64::from).product::<u64>().clamp(least, most);
        let paths = settings.count.unwrap_or(pixels as u32);
        let automatic = || {
            radius::of_pixels(scene, resolution).map(|r| r.clamp(*PHOTON_RADII.start(), *PHOTON_RADII.end()))
        };
        let radius = settings.radius.or_else(automatic)?;
        Some(Self { radius, paths, max_depth, seed, density: None, counters: Counters::default() })
    }

    /// The photons for sample `sample` of every pixel, traced with the threads of the pool. `is_stopped`: asked before every batch of a
    /// thousand paths.
    ///
    /// # Errors
    /// [`Interrupted`] if `is_stopped`.
    pub(crate) fn map(
        &mut self,
        scene: &Scene,
        sample: u32,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<PhotonMap, Interrupted> {
        let radius = self.radius * (1.0 + f64::from(sample)).powf(RADIUS_EXPONENT);
        let (arrivals, traced) = self.batch(scene, sample, self.paths).trace(is_stopped)?;
        let mut counters = std::mem::take(&mut self.counters);
        counters.merge(traced);
        Ok(PhotonMap::new(radius, self.paths, &arrivals, counters))
    }

    /// Fits the density of emission, before the first map. `is_stopped`: as of [`PhotonTracer::map`].
    ///
    /// # Errors
    /// [`Interrupted`] if `is_stopped`.
    pub(crate) fn fit(
        &mut self,
        scene: &Scene,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Interrupted> {
        let [least, most] = TRAINING_PATHS;
        for round in 0..TRAINING_ROUNDS {
            // The last sample numbers of all, which are the last to be rendered.
            let batch = self.batch(scene, u32::MAX - round, self.paths.clamp(least, most));
            let (arrivals, traced) = batch.trace(is_stopped)?;
            let weighted = |arrival: &PhotonArrival| {
                (batch.numbers(arrival.path).0, f64::from(arrival.photon.flux.max_component()))
            };
            let density = EmissionDensity::fit(arrivals.iter().map(weighted));
            self.counters.merge(traced);
            self.density = density.or(self.density.take());
        }
        Ok(())
    }

    /// What the `paths` paths of a sample share.
    fn batch<'a>(&'a self, scene: &'a Scene, sample: u32, paths: u32) -> trace::PhotonPass<'a> {
        trace::PhotonPass::new(scene, self.density.as_ref(), self.max_depth, self.seed, [sample, paths])
    }
}
