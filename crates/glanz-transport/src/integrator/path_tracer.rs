//! Paths from the camera with any sampler of directions.

use glanz_geometry::BoundedRay;
use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Ray};
use glanz_sampling::mis;
use glanz_scene::{
    BatchedPath, Interaction, LightId, LightSampleContext, MAX_LIGHT_GROUPS, MediumId, Scene, SceneHit,
    SelectedLight,
};

use super::path_state::{PathRay, PathState, PendingLight, SampledDirection};
use super::sppm::{lit_by, photon_odds};
use super::vertex::{PreviousVertex, ScatteredRay, Vertex, carried};
use super::{Context, FIRST_DIMENSION, IntegratorSettings};
use crate::photon::PhotonMap;

/// Number of scattering events after which Russian roulette may end a path. The first bounces carry most of the variance of indirect light, and
/// ending them saves little time.
pub(crate) const ROULETTE_FROM: u32 = 4;

/// Dimensions of the sampler per scattering event, so that an event has the same dimensions in every sample.
pub(super) const DIMENSIONS_PER_EVENT: u32 = 8;

/// Largest number of interfaces that a ray may pass between two scattering events; a ray with more is assumed not to advance.
pub(crate) const INTERFACE_LIMIT: u32 = 1000;

/// Paths that are traced together: enough for batches of rays, few enough for caches.
pub(super) const BATCH: usize = 1024;

/// Sampler of the directions in which a path continues.
pub(super) trait DirectionSampler {
    /// Data of a vertex.
    type VertexData: Copy;

    /// Whether [`DirectionSampler::record_direction`] records anything.
    const RECORDS_DIRECTIONS: bool;

    /// The data of a vertex, computed once.
    fn vertex_data(&self, vertex: &Vertex<'_>) -> Self::VertexData;

    /// The probabilities with which the groups of lights are selected at a vertex, or weights in proportion to them.
    fn light_groups(
        &self,
        _place: &Self::VertexData,
        scene: &Scene,
        from: &LightSampleContext,
    ) -> [f64; MAX_LIGHT_GROUPS] {
        scene.light_group_probabilities(from)
    }

    /// Records a sample of a light: its luminance at the viewer, not yet divided by the probability of the selection.
    fn record_light(&mut self, _: &Self::VertexData, _: &SelectedLight, _luminance: f64) {}

    /// Records that a medium changed the throughput of the path between two vertices.
    fn record_medium(&mut self, _before: Spectrum, _after: Spectrum) {}

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
    /// has the factor `sampled.throughput`, and beyond the vertex also `sampled.scattered.weight`.
    fn record_direction(&mut self, place: &Self::VertexData, sampled: &SampledDirection, light: Spectrum);
}

/// Input of Russian roulette.
#[derive(Clone, Copy, Debug)]
pub(super) struct RouletteState {
    /// Scattering events so far.
    pub(super) depth: u32,
    /// Throughput before and after the vertex.
    pub(super) before: Spectrum,
    pub(super) after: Spectrum,
    /// [`PathState::importance`] after the vertex, without the scaling by refraction.
    pub(super) importance: Spectrum,
}

impl RouletteState {
    /// Survival by the remaining throughput, from event [`ROULETTE_FROM`] on (document 003 section 3.1.4).
    pub(super) fn by_throughput(&self) -> f64 {
        if self.depth < ROULETTE_FROM { 1.0 } else { f64::from(self.importance.max_component()).min(1.0) }
    }
}

/// Samples whose paths are traced together.
pub(super) struct TracedSamples<'a, 'b, D> {
    tracer: PathTracer,
    contexts: &'b mut [Context<'a>],
    /// The sampler of each sample.
    directions: &'b mut [D],
}

impl<'a, 'b, D: DirectionSampler> BatchedPath<TracedSamples<'a, 'b, D>> for PathState<D::VertexData> {
    fn ray(&self) -> Option<Ray> {
        self.is_active.then_some(self.ray)
    }

    fn advance(
        &mut self,
        samples: &mut TracedSamples<'a, 'b, D>,
        hit: Option<&SceneHit>,
        branches: &mut Vec<Self>,
    ) {
        let at = self.sample as usize;
        let (context, directions) = (&mut samples.contexts[at], &mut samples.directions[at]);
        context.counters.closest += 1;
        self.is_active = samples.tracer.scatter(context, directions, self, hit, branches);
    }

    fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
        rays.extend(self.pending.light.as_ref().map(|light| light.shadow));
    }

    fn complete_vertex(&mut self, samples: &mut TracedSamples<'a, 'b, D>, occluded: &[bool]) {
        let at = self.sample as usize;
        self.add_pending(&mut samples.contexts[at], &mut samples.directions[at], occluded == [true]);
    }
}

/// Path tracing with any sampler of directions.
///
/// At every scattering event, at surfaces and in media, one light is sampled and the path continues in one direction; at its first rough vertex it first
/// divides into `branching` paths (splitting, @pharr2023 section 2.2.5). Light that both techniques can find is
/// weighted by the power heuristic (@veach1995). Without light sampling, light is found by chance alone, and that of point
/// and directional lights never.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathTracer {
    pub(super) max_depth: u32,
    light_sampling: bool,
    branching: u32,
}

impl PathTracer {
    /// With depth, light sampling and branching of `settings`.
    pub(super) fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { max_depth, light_sampling, branching, .. } = *settings;
        // The field is public: 0 counts as 1.
        Self { max_depth, light_sampling, branching: branching.max(1) }
    }

    /// With light sampling, without branching.
    pub(super) fn with_depth(max_depth: u32) -> Self {
        Self { max_depth, light_sampling: true, branching: 1 }
    }

    /// Number of samples with which it is fastest.
    pub(super) fn batch(&self) -> usize {
        (BATCH / self.branching as usize).max(1)
    }

    /// Radiance estimates of paths. `directions`: the sampler of each sample.
    ///
    /// The estimate of a sample does not depend on the others.
    pub(super) fn radiance<'a, D: DirectionSampler>(
        &self,
        contexts: &mut [Context<'a>],
        directions: &mut [D],
        radiance: &mut Vec<Spectrum>,
    ) {
        radiance.clear();
        let Some(scene) = contexts.first().map(|context| context.scene) else { return };
        let new = |(sample, context)| PathState::new(context, sample, self.branching);
        let mut paths: Vec<PathState<D::VertexData>> = (0..).zip(contexts.iter()).map(new).collect();
        self.continue_paths(scene, contexts, directions, &mut paths);
        radiance.resize(contexts.len(), Spectrum::BLACK);
        for path in &paths {
            radiance[path.sample as usize] += path.light;
        }
    }

    /// Traces paths to their ends. `contexts`, `directions`: of each sample.
    pub(super) fn continue_paths<'a, D: DirectionSampler>(
        &self,
        scene: &Scene,
        contexts: &mut [Context<'a>],
        directions: &mut [D],
        paths: &mut Vec<PathState<D::VertexData>>,
    ) {
        scene.trace_paths(paths, &mut TracedSamples { tracer: *self, contexts, directions });
    }

    /// Continues a path from the hit of its ray: adds emitted light, samples a light and the next direction. Returns whether the path
    /// continues. The other branches of a path that divides are added to `branches`.
    fn scatter<D: DirectionSampler>(
        &self,
        context: &mut Context<'_>,
        directions: &mut D,
        path: &mut PathState<D::VertexData>,
        hit: Option<&SceneHit>,
        branches: &mut Vec<PathState<D::VertexData>>,
    ) -> bool {
        // Illuminance leaves media out.
        if path.medium != MediumId::VACUUM && context.known.is_none() {
            let end = hit.map_or(f64::INFINITY, SceneHit::t);
            if let Some(continues) = self.pass_medium(context, directions, path, end, branches) {
                return continues;
            }
        }
        let Some(hit) = hit else {
            path.light += match path.depth {
                0 => path.throughput * context.backdrop_radiance(&path.ray),
                _ => path.throughput * self.escaped(context, path),
            };
            return false;
        };
        let hit = context.scene.interaction_differential(&path.ray, hit, path.differential.as_ref());
        path.light += path.throughput * self.emitted(context, &hit, path);
        let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
            path.interfaces += 1;
            path.medium = hit.medium_towards(path.ray.direction, path.medium);
            path.ray = hit.spawn(path.ray.direction);
            path.differential = hit.differential.map(|differential| differential.passed());
            return path.interfaces <= INTERFACE_LIMIT;
        };
        let vertex = Vertex::new(&hit, bsdf);
        // After scattering in a medium, what the path hits is not what the camera sees.
        if path.depth == 0 {
            context.note_first_hit(&vertex);
        }
        if path.depth >= self.max_depth {
            return false;
        }
        vertex.disperse(&mut path.throughput, &mut path.is_dispersed);
        self.scatter_at_or_divide(context, directions, path, &vertex, branches)
    }

    /// As [`PathTracer::scatter_at`]; at its first rough vertex, a path divides.
    pub(super) fn scatter_at_or_divide<D: DirectionSampler>(
        &self,
        context: &mut Context<'_>,
        directions: &mut D,
        path: &mut PathState<D::VertexData>,
        vertex: &Vertex<'_>,
        branches: &mut Vec<PathState<D::VertexData>>,
    ) -> bool {
        if path.branches > 1 && !vertex.is_delta() {
            let first = PathState { light: path.light, ..path.branch(0) };
            for branch in 1..path.branches {
                let mut other = path.branch(branch);
                other.is_active = self.scatter_at(context, directions, &mut other, vertex);
                branches.push(other);
            }
            *path = first;
        }
        self.scatter_at(context, directions, path, vertex)
    }

    /// Samples a light and the next direction at a vertex. Returns whether the path continues.
    pub(super) fn scatter_at<D: DirectionSampler>(
        &self,
        context: &mut Context<'_>,
        directions: &mut D,
        path: &mut PathState<D::VertexData>,
        vertex: &Vertex<'_>,
    ) -> bool {
        let mut sampler = context.sampler.with_index(path.sampler_index);
        sampler.skip_to_dimension(FIRST_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(path.depth));
        path.depth += 1;
        path.interfaces = 0;
        // Related decisions use one group of dimensions: lobe, direction and survival; light and point on it.
        let [x, y, xi_lobe, xi_roulette] = sampler.next_group();
        let xi = DVec2::new(x, y);
        let place = directions.vertex_data(vertex);
        path.pending.place = Some(place);
        path.light += self.photon_light(context, directions, path, vertex, &place);
        let from = vertex.light_sample_context(vertex.at.wo);
        let mut light_groups = [0.0; MAX_LIGHT_GROUPS];
        if self.light_sampling && !vertex.is_delta() {
            let [x, y, xi_light, xi_medium] = sampler.next_group();
            light_groups = directions.light_groups(&place, context.scene, &from);
            let selected = context.scene.select_light_by_groups(&from, &light_groups, xi_light);
            let is_known = |id| {
                context.known.is_some_and(|known| known.includes(id, path.depth - 1, vertex.has_finish()))
            };
            let selected = selected.filter(|selected| !is_known(selected.id));
            path.pending.light = selected.and_then(|selected| {
                direct_light(context, vertex, directions, &place, path, selected, [x, y, xi_medium])
            });
        }
        let Some(scattered) = directions.sample(&place, vertex, xi, xi_lobe) else { return false };
        let cosine = vertex.cosine(scattered.direction).abs();
        let before = path.throughput;
        if D::RECORDS_DIRECTIONS {
            let (throughput, is_dispersed) = (before, path.is_dispersed);
            path.pending.direction =
                Some(SampledDirection { from, scattered, cosine, throughput, is_dispersed });
        }
        path.throughput *= scattered.weight;
        path.importance *= scattered.bsdf_weight;
        path.eta_scale *= scattered.eta_scale;
        let importance = carried(path.importance, path.throughput) * path.eta_scale;
        let state = RouletteState { depth: path.depth, before, after: path.throughput, importance };
        let survival = directions.survival(&place, vertex, &scattered, &state);
        if survival < 1.0 {
            if xi_roulette >= survival {
                return false;
            }
            path.throughput *= (1.0 / survival) as f32;
            path.importance *= (1.0 / survival) as f32;
        }
        path.ray = vertex.at.spawn(scattered.direction);
        path.differential = vertex.differential(&scattered);
        path.medium = vertex.at.medium_towards(scattered.direction, path.medium);
        if let Some(photons) = context.photons {
            path.photon_odds = photon_odds(photons, vertex, &scattered, path.photon_odds);
        }
        let from = PreviousVertex { from, pdf: scattered.pdf };
        path.origin = (!scattered.is_delta).then_some(PathRay { origin: from, light_groups });
        path.has_finish = vertex.has_finish();
        true
    }

    /// Light of photons that is scattered at a vertex, by the throughput of `path`.
    fn photon_light<D: DirectionSampler>(
        &self,
        context: &Context<'_>,
        directions: &D,
        path: &PathState<D::VertexData>,
        vertex: &Vertex<'_>,
        place: &D::VertexData,
    ) -> Spectrum {
        let left = self.max_depth - path.depth;
        // Photons have had one scattering event or more.
        let Some(photons) = context.photons.filter(|_| left > 0 && !vertex.is_delta()) else {
            return Spectrum::BLACK;
        };
        let pdf = |direction, bsdf_pdf| directions.pdf(place, direction, bsdf_pdf);
        path.throughput * lit_by(photons, vertex, left, pdf)
    }

    /// Light of the infinite lights along the ray of `path`.
    fn escaped<P>(&self, context: &Context<'_>, path: &PathState<P>) -> Spectrum {
        let (scene, ray) = (context.scene, &path.ray);
        let density = |id| move |o: &PreviousVertex| o.compensated_infinite_pdf(context, id, ray.direction);
        let weight = |id| self.weight(context, id, path, None, density(id));
        // Most rays miss the sun, whose probability costs as much as that of any light.
        let weighted = |(id, radiance): (LightId, Spectrum)| radiance * weight(id);
        let ids = scene.infinite_lights().iter().filter(|&&id| !path.leaves_out(context, id));
        let lights = ids.map(|&id| (id, context.infinite_radiance(id, ray)));
        lights.filter(|(_, radiance)| !radiance.is_black()).map(weighted).sum()
    }

    /// Light emitted by the surface at `hit`.
    fn emitted<P>(&self, context: &Context<'_>, hit: &Interaction, path: &PathState<P>) -> Spectrum {
        match hit.light() {
            None => Spectrum::BLACK,
            Some(id) => {
                let emitted = context.emitted(hit);
                if emitted.is_black() || path.leaves_out(context, id) {
                    return Spectrum::BLACK;
                }
                let density = |o: &PreviousVertex| o.area_light_pdf(context, id, hit);
                emitted * self.weight(context, id, path, hit.area_pdf(), density)
            }
        }
    }

    /// Weight of light `id`, which the ray of `path` hits, against light sampling or photons. `area_pdf`: density of the point on the light, if that is a surface.
    fn weight<P>(
        &self,
        context: &Context<'_>,
        id: LightId,
        path: &PathState<P>,
        area_pdf: Option<AreaPdf>,
        light_pdf: impl FnOnce(&PreviousVertex) -> f64,
    ) -> f32 {
        match &path.origin {
            Some(PathRay { origin, light_groups }) if self.light_sampling => {
                let probability = context.scene.light_probability_by_groups(id, &origin.from, light_groups);
                mis::power(origin.pdf, light_pdf(origin) * probability) as f32
            }
            None if path.photon_odds > 0.0 => {
                PhotonMap::weight_of_hit(context.scene, path.photon_odds, id, &path.ray, area_pdf) as f32
            }
            _ => 1.0,
        }
    }
}

/// Direct light of a selected light, with the weight of the power heuristic against BSDF sampling, until its shadow ray is traced. The numbers, uniform
/// in [0, 1), select the point on the light and the way through media.
fn direct_light<D: DirectionSampler>(
    context: &mut Context<'_>,
    vertex: &Vertex<'_>,
    directions: &mut D,
    place: &D::VertexData,
    path: &PathState<D::VertexData>,
    selected: SelectedLight,
    [x, y, xi_medium]: [f64; 3],
) -> Option<PendingLight> {
    let scene = context.scene;
    let SelectedLight { id, probability, .. } = selected;
    let weight = |direction, light: f64, bsdf_pdf| {
        mis::power(light * probability, directions.pdf(place, direction, bsdf_pdf))
    };
    let sample = scene.sample_light_compensated(id, vertex.at, DVec2::new(x, y));
    let sample = match context.known {
        Some(known) => sample.filter(|sample| !known.includes_near(id, sample.distance())),
        None => sample,
    };
    let Some((light, shadow)) = vertex.sampled_light(context, id, sample, weight) else {
        directions.record_light(place, &selected, 0.0);
        return None;
    };
    let medium = vertex.at.medium_towards(shadow.ray.direction, path.medium);
    Some(PendingLight { selected, light, throughput: path.throughput, shadow, medium, xi_medium })
}
