//! Path tracing with photons.

use glanz_light::Spectrum;
use glanz_scene::Scene;
use glanz_scene::description::PhotonSettings;

use super::path::BsdfDirections;
use super::path_tracer::PathTracer;
use super::{Context, Integrator, IntegratorSettings, radiance_of_one};
use crate::photon::PhotonTracer;

/// As [`Path`](super::Path), and light that mirrors and glass send on arrives as photons.
///
/// Every sample of the picture has photons of its own (see [`crate::photon`]), which are added at all scattering events of its paths. This finds caustics, also from point
/// lights, and also where they are seen by mirror or glass, or light other surfaces; their edges are blurred by the radius of the density estimates, which shrinks
/// with the number of the sample. Chains of rough glass are left to path tracing, and so is everything in scenes with participating media, which photons do not see.
#[derive(Clone, Copy, Debug)]
pub struct Sppm {
    tracer: PathTracer,
    max_depth: u32,
    photons: PhotonSettings,
}

impl Sppm {
    /// With the depth, the light sampling and the photons of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { max_depth, photons, .. } = *settings;
        Self { tracer: PathTracer::new(settings), max_depth, photons }
    }
}

impl Integrator for Sppm {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        self.tracer.batch()
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        let mut directions: Vec<_> = contexts.iter().map(|_| BsdfDirections).collect();
        self.tracer.radiance(contexts, &mut directions, radiance);
    }

    fn photon_tracer(&self, scene: &Scene, seed: u64, resolution: [u32; 2]) -> Option<PhotonTracer> {
        if scene.has_media() {
            return None;
        }
        PhotonTracer::new(scene, &self.photons, self.max_depth, seed, resolution)
    }
}
