//! The state of a path between its vertices.

use glanz_geometry::BoundedRay;
use glanz_light::Spectrum;
use glanz_math::{DVec3, Ray};
use glanz_scene::{LightId, LightSampleContext, MAX_LIGHT_GROUPS, MediumId, RayDifferential, SelectedLight};

use super::Context;
use super::path_tracer::DirectionSampler;
use super::tracking::shadow_transmittance;
use super::vertex::{PreviousVertex, ScatteredRay};

/// Sampling state of the current ray.
#[derive(Clone, Copy)]
pub(super) struct PathRay {
    pub(super) origin: PreviousVertex,
    /// Weights of the groups of lights at its origin, see [`DirectionSampler::light_groups`]; 0 where no light was selected.
    pub(super) light_groups: [f64; MAX_LIGHT_GROUPS],
}

/// State of a path.
#[derive(Clone, Copy)]
pub(super) struct PathState<P> {
    /// The index of its sample in the batch.
    pub(super) sample: u32,
    /// The sample index of its random numbers; that of its sample until it divides, see [`PathState::branch`].
    pub(super) sampler_index: u32,
    /// Number of paths into which it divides at its first rough vertex.
    pub(super) branches: u32,
    /// Whether it continues.
    pub(super) is_active: bool,
    pub(super) ray: Ray,
    /// Of the ray, up to the first rough vertex in scenes with filtered textures.
    pub(super) differential: Option<RayDifferential>,
    /// The light so far.
    pub(super) light: Spectrum,
    pub(super) throughput: Spectrum,
    /// Throughput as if the BSDF alone had been sampled: the probability of survival. A direction that a guide draws
    /// often has a small throughput because much light comes from there; to end such paths would undo the guide's work.
    pub(super) importance: Spectrum,
    pub(super) eta_scale: f32,
    /// Whether the hero of its wavelengths is left alone.
    pub(super) is_dispersed: bool,
    /// `None` after delta lobes only: light sampling cannot find their light.
    pub(super) origin: Option<PathRay>,
    /// Whether the surface that the ray comes from has a finish.
    pub(super) has_finish: bool,
    /// [`PhotonMap::odds`](crate::photon::PhotonMap::odds) at the last scattering event at which photons were added, if only delta lobes followed; 0 without photons.
    pub(super) photon_odds: f64,
    pub(super) depth: u32,
    pub(super) interfaces: u32,
    /// The medium in which the ray starts.
    pub(super) medium: MediumId,
    pub(super) pending: PendingVertex<P>,
}

/// What waits at a vertex until its shadow ray is traced.
#[derive(Clone, Copy)]
pub(super) struct PendingVertex<P> {
    pub(super) place: Option<P>,
    pub(super) light: Option<PendingLight>,
    pub(super) direction: Option<SampledDirection>,
}

/// Light sampled at a vertex.
#[derive(Clone, Copy)]
pub(super) struct PendingLight {
    pub(super) selected: SelectedLight,
    /// The light that is scattered to the viewer, not divided by the probability.
    pub(super) light: Spectrum,
    /// Throughput up to the vertex.
    pub(super) throughput: Spectrum,
    pub(super) shadow: BoundedRay,
    /// The medium in which the shadow ray starts, and a number uniform in [0, 1) for its way through media.
    pub(super) medium: MediumId,
    pub(super) xi_medium: f64,
}

impl<P> PathState<P> {
    /// Whether the path leaves out the light `id` that its ray hits.
    pub(super) fn leaves_out(&self, context: &Context<'_>, id: LightId) -> bool {
        // The first scattering event is that at the start of the path.
        context.known.is_some_and(|known| {
            known.includes(id, self.depth.saturating_sub(1), self.origin.is_none() || self.has_finish)
        })
    }
}

impl<P: Copy> PathState<P> {
    /// A path that starts at the camera. `sample`: the index of its sample in the batch.
    pub(super) fn new(context: &Context<'_>, sample: u32, branches: u32) -> Self {
        Self {
            sample,
            sampler_index: context.sampler.sample_index(),
            branches,
            is_active: context.camera_ray.is_some(),
            ray: context.start().unwrap_or(Ray::new(DVec3::ZERO, DVec3::Z)),
            differential: context.start_differential(),
            light: Spectrum::BLACK,
            throughput: Spectrum::one(&context.wavelengths),
            importance: Spectrum::one(&context.wavelengths),
            eta_scale: 1.0,
            is_dispersed: false,
            origin: None,
            has_finish: false,
            photon_odds: 0.0,
            depth: 0,
            interfaces: 0,
            medium: context.scene.camera_medium(),
            pending: PendingVertex { place: None, light: None, direction: None },
        }
    }

    /// Branch `branch` of a path, with its fraction of the throughput and without the light so far. The branches of all samples of a
    /// pixel have consecutive indices: Sobol' points stratify those of one sample and those of all samples. Indices repeat after
    /// 2^32 branches.
    pub(super) fn branch(&self, branch: u32) -> Self {
        Self {
            sampler_index: self.sampler_index.wrapping_mul(self.branches).wrapping_add(branch),
            branches: 1,
            light: Spectrum::BLACK,
            throughput: self.throughput * (1.0 / self.branches as f32),
            ..*self
        }
    }

    /// Adds the sampled light of the last vertex, unless its shadow ray is `occluded`, and passes what it learnt to the sampler.
    pub(super) fn add_pending<D: DirectionSampler<VertexData = P>>(
        &mut self,
        context: &mut Context<'_>,
        directions: &mut D,
        occluded: bool,
    ) {
        let PendingVertex { place, light, direction } = &mut self.pending;
        let Some(place) = place.take() else { return };
        if let Some(PendingLight { selected, light, throughput, shadow, medium, xi_medium }) = light.take() {
            context.counters.shadow += 1;
            let light = if occluded {
                Spectrum::BLACK
            } else if context.scene.has_media() && context.known.is_none() {
                light * shadow_transmittance(context, &shadow, medium, xi_medium)
            } else {
                light
            };
            let luminance = f64::from(light.luminance(&context.wavelengths));
            directions.record_light(&place, &selected, luminance);
            self.light += throughput * (light * (1.0 / selected.probability) as f32);
        }
        if let Some(sampled) = direction.take() {
            directions.record_direction(&place, &sampled, self.light);
        }
    }
}

/// A direction in which a path continues.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledDirection {
    /// Position of the vertex.
    pub(super) from: LightSampleContext,
    pub(super) scattered: ScatteredRay,
    /// |cos| between direction and shading normal.
    pub(super) cosine: f64,
    /// Throughput up to the vertex.
    pub(super) throughput: Spectrum,
    /// Whether the hero of its wavelengths is left alone in the throughput.
    pub(super) is_dispersed: bool,
}
