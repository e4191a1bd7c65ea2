//! A path from the camera with any sampler of directions.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::mis;
use glanz_scene::{Interaction, LightId, Scene};

use super::vertex::{PreviousVertex, ScatteredRay, Vertex};
use super::{Context, FIRST_DIMENSION, IntegratorSettings};

/// Number of scattering events before Russian roulette may end a path.
pub(super) const ROULETTE_FROM: u32 = 2;

/// Dimensions of the sampler per scattering event, so that an event has the same dimensions in every sample.
pub(super) const DIMENSIONS_PER_EVENT: u32 = 8;

/// Largest number of interfaces that a ray may pass between two scattering events; a ray with more is assumed not to advance.
pub(crate) const INTERFACE_LIMIT: u32 = 1000;

/// Sampler of the directions in which a path continues.
pub(super) trait DirectionSampler {
    /// Data of a vertex.
    type VertexData: Copy;

    /// The data of a vertex, computed once.
    fn vertex_data(&self, vertex: &Vertex<'_>) -> Self::VertexData;

    /// Selects a light by a number uniform in [0, 1); returns it with its probability.
    fn select_light(&self, _place: &Self::VertexData, scene: &Scene, xi: f64) -> Option<(LightId, f64)> {
        scene.select_light(xi)
    }

    /// The probability with which [`DirectionSampler::select_light`] selects the light `id`.
    fn light_probability(&self, _place: &Self::VertexData, scene: &Scene, id: LightId) -> f64 {
        scene.light_probability(id)
    }

    /// Records a sample of the light `id`: its luminance at the viewer, not yet divided by the `probability` of the selection.
    fn record_light(
        &mut self,
        _: &Self::VertexData,
        _: &Scene,
        _id: LightId,
        _probability: f64,
        _luminance: f64,
    ) {
    }

    /// Density per solid angle of `direction`; `bsdf_pdf`: that of the BSDF alone.
    fn pdf(&self, place: &Self::VertexData, direction: DVec3, bsdf_pdf: f64) -> f64;

    /// Samples a direction.
    fn sample(
        &mut self,
        place: &Self::VertexData,
        vertex: &Vertex<'_>,
        xi: DVec2,
        xi_lobe: f64,
    ) -> Option<ScatteredRay>;

    /// The probability of survival of a path in a direction of [`DirectionSampler::sample`], above 0 and at most 1.
    fn survival(
        &mut self,
        _: &Self::VertexData,
        _: &Vertex<'_>,
        _: &ScatteredRay,
        state: &RouletteState,
    ) -> f64 {
        state.by_throughput()
    }

    /// Records the direction of [`DirectionSampler::sample`] in which the path continues. `light`: the light so far; light from here on
    /// has the factor `throughput`, and beyond the vertex also `scattered.weight`.
    fn record_direction(
        &mut self,
        place: &Self::VertexData,
        vertex: &Vertex<'_>,
        scattered: &ScatteredRay,
        light: Spectrum,
        throughput: Spectrum,
    );
}

/// Input of Russian roulette.
#[derive(Clone, Copy, Debug)]
pub(super) struct RouletteState {
    /// Scattering events so far.
    pub(super) depth: u32,
    /// Throughput before and after the vertex.
    pub(super) before: Spectrum,
    pub(super) after: Spectrum,
    /// Throughput as if the BSDF alone had been sampled, without the scaling by refraction. A direction that a guide draws
    /// often has a small throughput because much light comes from there; to end such paths would undo the guide's work.
    pub(super) importance: Spectrum,
}

impl RouletteState {
    /// Survival by the remaining throughput, from the second event on (document 003 section 3.1.4).
    pub(super) fn by_throughput(&self) -> f64 {
        if self.depth < ROULETTE_FROM { 1.0 } else { f64::from(self.importance.max_component()).min(1.0) }
    }
}

/// Path tracing with any sampler of directions.
///
/// At every scattering event one light is sampled and the path continues in one direction; light that both techniques can find is
/// weighted by the power heuristic (@veach1995). Without light sampling, light is found by chance alone, and that of point
/// and directional lights never.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathTracer {
    max_depth: u32,
    light_sampling: bool,
}

impl PathTracer {
    /// With the depth and the light sampling of `settings`.
    pub(super) fn new(settings: &IntegratorSettings) -> Self {
        Self { max_depth: settings.max_depth, light_sampling: settings.light_sampling }
    }

    /// Radiance estimate of one path.
    pub(super) fn radiance(
        &self,
        context: &mut Context<'_>,
        directions: &mut impl DirectionSampler,
    ) -> Spectrum {
        let mut ray = context.camera_ray;
        let mut light = Spectrum::BLACK;
        let mut throughput = Spectrum::ONE;
        // Throughput as if the BSDF alone had been sampled: the probability of survival. A direction that a guide draws
        // often has a small throughput because much light comes from there; to end such paths would undo the guide's work.
        let mut importance = Spectrum::ONE;
        let mut eta_scale = 1.0_f32;
        // `None` after delta lobes only: light sampling cannot find their light.
        let mut origin: Option<PathRay<_>> = None;
        let (mut depth, mut interfaces) = (0, 0);
        loop {
            let Some(hit) = context.intersect(&ray) else {
                return light + throughput * self.escaped(context, &ray, directions, origin.as_ref());
            };
            light += throughput * self.emitted(context, &hit, directions, origin.as_ref());
            let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
                interfaces += 1;
                if interfaces > INTERFACE_LIMIT {
                    return light;
                }
                ray = hit.spawn(ray.direction);
                continue;
            };
            let vertex = Vertex::new(&hit, bsdf);
            context.note_first_hit(&vertex);
            if depth >= self.max_depth {
                return light;
            }
            context.sampler.skip_to_dimension(FIRST_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(depth));
            depth += 1;
            interfaces = 0;
            // Related decisions use one group of dimensions: lobe, direction and survival; light and point on it.
            let (xi, xi_lobe) = (context.sampler.next_2d(), context.sampler.next_1d());
            let xi_roulette = context.sampler.next_1d();
            let place = directions.vertex_data(&vertex);
            if self.light_sampling && !bsdf.is_delta() {
                context.sampler.begin_group();
                let (xi_point, xi_light) = (context.sampler.next_2d(), context.sampler.next_1d());
                light += throughput * direct_light(context, &vertex, directions, &place, xi_light, xi_point);
            }
            let Some(scattered) = directions.sample(&place, &vertex, xi, xi_lobe) else { return light };
            directions.record_direction(&place, &vertex, &scattered, light, throughput);
            let before = throughput;
            throughput *= scattered.weight;
            importance *= scattered.bsdf_weight;
            eta_scale *= scattered.eta_scale;
            let state =
                RouletteState { depth, before, after: throughput, importance: importance * eta_scale };
            let survival = directions.survival(&place, &vertex, &scattered, &state);
            if survival < 1.0 {
                if xi_roulette >= survival {
                    return light;
                }
                throughput *= (1.0 / survival) as f32;
                importance *= (1.0 / survival) as f32;
            }
            ray = hit.spawn(scattered.direction);
            let from = PreviousVertex { from: hit.light_sample_context(), pdf: scattered.pdf };
            origin = (!scattered.is_delta).then_some(PathRay { origin: from, place });
        }
    }

    /// Light of the infinite lights along `ray`.
    fn escaped<D: DirectionSampler>(
        &self,
        context: &Context<'_>,
        ray: &Ray,
        directions: &D,
        origin: Option<&PathRay<D::VertexData>>,
    ) -> Spectrum {
        let scene = context.scene;
        let density = |id| move |o: &PreviousVertex| o.infinite_light_pdf(context, id, ray.direction);
        let weight = |id| self.weight(context, id, directions, origin, density(id));
        scene.infinite_lights().iter().map(|&id| scene.infinite_radiance(id, ray) * weight(id)).sum()
    }

    /// Light emitted by the surface at `hit`.
    fn emitted<D: DirectionSampler>(
        &self,
        context: &Context<'_>,
        hit: &Interaction,
        directions: &D,
        origin: Option<&PathRay<D::VertexData>>,
    ) -> Spectrum {
        match hit.light() {
            None => Spectrum::BLACK,
            Some(id) => {
                let emitted = context.scene.emitted(hit, hit.wo);
                if emitted.is_black() {
                    return emitted;
                }
                emitted * self.weight(context, id, directions, origin, |o| o.area_light_pdf(context, id, hit))
            }
        }
    }

    /// Weight of light `id` against light sampling.
    fn weight<D: DirectionSampler>(
        &self,
        context: &Context<'_>,
        id: LightId,
        directions: &D,
        origin: Option<&PathRay<D::VertexData>>,
        light_pdf: impl FnOnce(&PreviousVertex) -> f64,
    ) -> f32 {
        match origin {
            Some(PathRay { origin, place }) if self.light_sampling => {
                let probability = directions.light_probability(place, context.scene, id);
                mis::power(origin.pdf, light_pdf(origin) * probability) as f32
            }
            _ => 1.0,
        }
    }
}

/// Sampling state of the current ray, with the guide data of its origin.
#[derive(Clone, Copy)]
struct PathRay<P> {
    origin: PreviousVertex,
    place: P,
}

/// Direct light of one randomly selected light, with the weight of the power heuristic against BSDF sampling.
fn direct_light<D: DirectionSampler>(
    context: &mut Context<'_>,
    vertex: &Vertex<'_>,
    directions: &mut D,
    place: &D::VertexData,
    xi_light: f64,
    xi: DVec2,
) -> Spectrum {
    let scene = context.scene;
    let picked = directions.select_light(place, scene, xi_light);
    let Some((id, probability)) = picked.filter(|&(_, probability)| probability > 0.0) else {
        return Spectrum::BLACK;
    };
    let weight = |direction, light: f64, bsdf_pdf| {
        mis::power(light * probability, directions.pdf(place, direction, bsdf_pdf))
    };
    let light = vertex.light(context, id, xi, weight);
    directions.record_light(place, scene, id, probability, f64::from(light.luminance(&context.wavelengths)));
    light * (1.0 / probability) as f32
}
