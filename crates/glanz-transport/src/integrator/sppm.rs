//! Path tracing with photons.

use glanz_light::Spectrum;
use glanz_math::DVec3;
use glanz_scene::Scene;
use glanz_scene::description::PhotonSettings;

use super::vertex::{ScatteredRay, Vertex};
use super::{Context, Integrator, IntegratorSettings, Path, radiance_of_one};
use crate::photon::{PhotonMap, PhotonTracer};

/// Path tracing as by [`Path`], with photons for light that mirrors and glass send on.
///
/// Every sample of the picture has photons of its own (see [`crate::photon`]), which are added at all scattering events of its paths. This finds caustics, also from point
/// lights, and also where they are seen by mirror or glass, or light other surfaces; their edges are blurred by the radius of the density estimates, which shrinks
/// with the number of the sample. Chains of rough glass are left to path tracing, and so is everything in scenes with participating media and at sampled wavelengths, which photons do not see.
#[derive(Clone, Copy, Debug)]
pub struct Sppm {
    path: Path,
    max_depth: u32,
    photons: PhotonSettings,
}

impl Sppm {
    /// With the depth, the light sampling and the photons of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { max_depth, photons, .. } = *settings;
        Self { path: Path::new(settings), max_depth, photons }
    }
}

impl Integrator for Sppm {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        self.path.batch()
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        self.path.radiance_batch(contexts, radiance);
    }

    fn photon_tracer(&self, scene: &Scene, seed: u64, resolution: [u32; 2]) -> Option<PhotonTracer> {
        if scene.has_media() {
            return None;
        }
        PhotonTracer::new(scene, &self.photons, self.max_depth, seed, resolution)
    }
}

/// Light of `photons` with up to `most_events` scattering events that is scattered at a vertex. `pdf`: density per solid angle with which a path continues in a direction,
/// by the direction and the density of the BSDF.
pub(super) fn lit_by(
    photons: &PhotonMap,
    vertex: &Vertex<'_>,
    most_events: u32,
    pdf: impl Fn(DVec3, f64) -> f64,
) -> Spectrum {
    let (position, normal) = (vertex.at.point.position, vertex.at.point.normal);
    let mut light = Spectrum::BLACK;
    photons.visit(position, normal, |photon| {
        if photon.events() > most_events {
            return;
        }
        let direction = photon.direction();
        let (value, bsdf_pdf) = vertex.eval(direction);
        let cosine = normal.dot(direction).abs();
        if value.is_black() || cosine == 0.0 {
            return;
        }
        // `value` contains the cosine to the shading normal, as needed for incident radiance; flux already contains the geometric cosine
        // (@veach1997 section 5.3.2).
        let weight = PhotonMap::weight(photons.odds(cosine, pdf(direction, bsdf_pdf)), photon);
        light += value * photon.flux() * (weight / cosine) as f32;
    });
    light * (1.0 / photons.area()) as f32
}

/// Odds of photons after `scattered`; `before`: those before it.
pub(super) fn photon_odds(
    photons: &PhotonMap,
    vertex: &Vertex<'_>,
    scattered: &ScatteredRay,
    before: f64,
) -> f64 {
    match scattered.is_delta {
        false => photons.odds(vertex.at.point.normal.dot(scattered.direction).abs(), scattered.pdf),
        true if vertex.is_seen_alike(scattered.direction) => before,
        // No photon comes this way.
        true => 0.0,
    }
}
