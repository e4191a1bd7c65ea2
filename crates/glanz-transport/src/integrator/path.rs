//! Unidirectional path tracing.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};

use super::path_state::SampledDirection;
use super::path_tracer::{DirectionSampler, PathTracer};
use super::vertex::{ScatteredRay, Vertex};
use super::{Context, Integrator, IntegratorSettings, radiance_of_one};

/// Path tracing from the camera with BSDF sampling.
///
/// At every scattering event one light is sampled, too; light that both techniques can find is weighted by the power heuristic
/// (@veach1995). Without light sampling, light is found by chance alone, and that of point and directional lights never.
///
/// At its first rough surface, or where a medium first scatters it, a camera ray divides into [`IntegratorSettings::branching`] paths, each with a light and a direction of
/// its own. Camera ray, first hit and film are then paid once for several paths, which is worth it where most variance is that of
/// indirect light.
#[derive(Clone, Copy, Debug)]
pub struct Path(PathTracer);

impl Path {
    /// With depth, light sampling and branching of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self(PathTracer::new(settings))
    }
}

impl Integrator for Path {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        self.0.batch()
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        let mut directions: Vec<_> = contexts.iter().map(|_| BsdfDirections).collect();
        self.0.radiance(contexts, &mut directions, radiance);
    }
}

/// Direction sampler of the BSDF alone.
pub(super) struct BsdfDirections;

impl DirectionSampler for BsdfDirections {
    type VertexData = ();
    const RECORDS_DIRECTIONS: bool = false;

    fn vertex_data(&self, _: &Vertex<'_>) {}

    fn pdf(&self, (): &(), _: DVec3, bsdf_pdf: f64) -> f64 {
        bsdf_pdf
    }

    fn sample(&mut self, (): &(), vertex: &Vertex<'_>, xi: DVec2, xi_lobe: f64) -> Option<ScatteredRay> {
        vertex.sample(xi, xi_lobe)
    }

    fn record_direction(&mut self, (): &(), _: &SampledDirection, _: Spectrum) {}
}
