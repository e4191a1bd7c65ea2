//! Distributed ray tracing.

use glanz_geometry::BoundedRay;
use glanz_light::Spectrum;
use glanz_math::{DVec2, Ray};
use glanz_scene::{BatchedPath, Interaction, Light, LightId, RayDifferential, SceneHit};

use super::path_tracer::{BATCH, DIMENSIONS_PER_EVENT, ROULETTE_FROM};
use super::vertex::{PreviousVertex, ScatteredRay, Vertex, carried, pass_interface, roulette};
use super::{Context, FIRST_DIMENSION, Integrator, IntegratorSettings, radiance_of_one};

/// Distributed ray tracing: several rays from a hit instead of one.
///
/// At the first rough surface of a camera ray, m rays are traced, stratified over the numbers of the BSDF sample; at
/// each of their hits one ray continues (with m rays everywhere, document 003 section 3.1.1, their number would grow exponentially). Before the
/// rough surface, glass divides the m rays between reflection and refraction. A camera ray never has more than m paths.
///
/// With light sampling, the hemisphere is stratified by the second method of section 3.1.3: every light is a stratum of its own,
/// the lights share m shadow rays, at least one for each, and the other rays carry reflected light only, as well as light that
/// light sampling cannot find (through a mirror, from a surface without area sampling).
///
/// Paths end by depth or by Russian roulette (section 3.1.4).
#[derive(Clone, Copy, Debug)]
pub struct Distributed {
    max_depth: u32,
    light_sampling: bool,
    branching: u32,
}

/// State of a path.
struct DistributedPath {
    /// Position of its sample in the batch.
    sample: usize,
    /// `None` if it has ended.
    ray: Option<Ray>,
    /// Of the ray, up to the first rough vertex in scenes with filtered textures.
    differential: Option<RayDifferential>,
    /// The light so far.
    light: Spectrum,
    /// Factor on the light of the path, the fraction of its branch included.
    throughput: Spectrum,
    /// Throughput since the path branched off, by which Russian roulette decides.
    branch_throughput: Spectrum,
    eta_scale: f32,
    /// Whether the hero of its wavelengths is left alone.
    is_dispersed: bool,
    /// The last vertex with a rough lobe; `None` after the camera or a delta lobe.
    origin: Option<PreviousVertex>,
    depth: u32,
    interfaces: u32,
    /// Number of paths into which it may still branch.
    budget: u32,
    /// Sampler dimension of its first event.
    dimension: u32,
    /// Light that arrives unless its shadow ray is occluded.
    pending: Vec<(BoundedRay, Spectrum)>,
}

/// Samples whose paths are traced together.
struct DistributedSamples<'a, 'b> {
    integrator: Distributed,
    contexts: &'b mut [Context<'a>],
}

impl Distributed {
    /// With depth, light sampling and branching of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { max_depth, light_sampling, branching, .. } = *settings;
        // The field is public: 0 counts as 1.
        Self { max_depth, light_sampling, branching: branching.max(1) }
    }

    /// Fraction of emitted light that BSDF rays count: 1 for light that light sampling cannot find, else 0.
    fn weight(&self, origin: Option<&PreviousVertex>, light_pdf: impl FnOnce(&PreviousVertex) -> f64) -> f32 {
        match origin {
            Some(origin) if self.light_sampling && light_pdf(origin) > 0.0 => 0.0,
            _ => 1.0,
        }
    }

    fn escaped(&self, context: &Context<'_>, ray: &Ray, origin: Option<&PreviousVertex>) -> Spectrum {
        let scene = context.scene;
        let weight = |id| self.weight(origin, |o| o.infinite_light_pdf(context, id, ray.direction));
        scene.infinite_lights().iter().map(|&id| context.infinite_radiance(id, ray) * weight(id)).sum()
    }

    fn emitted(&self, context: &Context<'_>, hit: &Interaction, origin: Option<&PreviousVertex>) -> Spectrum {
        match hit.light() {
            None => Spectrum::BLACK,
            Some(id) => context.emitted(hit) * self.weight(origin, |o| o.area_light_pdf(context, id, hit)),
        }
    }

    /// Adds light samples of all lights to those that wait for shadow rays: the path's budget divided between the lights, at least one for
    /// each.
    fn sample_lights(&self, context: &mut Context<'_>, path: &mut DistributedPath, vertex: &Vertex<'_>) {
        let lights = context.scene.lights().len() as u32;
        let each = path.budget.div_ceil(lights.max(1));
        for id in (0..lights).map(LightId) {
            let shift = context.sampler.next_2d();
            // A delta light needs one ray only.
            let count = if context.scene.light(id).is_some_and(Light::is_delta) { 1 } else { each };
            let factor = path.throughput * (1.0 / count as f32);
            path.pending.extend((0..count).filter_map(|j| {
                let xi = spread(j, count, shift);
                let sample = context.scene.sample_light(id, vertex.at, xi);
                let (light, shadow) = vertex.sampled_light(context, id, sample, |_, _, _| 1.0)?;
                Some((shadow, factor * light))
            }));
        }
    }

    /// The ray that continues from the hit of `ray`; `None` if the path ends or branches.
    fn next_ray(
        &self,
        context: &mut Context<'_>,
        path: &mut DistributedPath,
        ray: &Ray,
        hit: Option<&SceneHit>,
        branches: &mut Vec<DistributedPath>,
    ) -> Option<Ray> {
        let Some(hit) = hit else {
            path.light += match path.depth {
                0 => path.throughput * context.backdrop_radiance(ray),
                _ => path.throughput * self.escaped(context, ray, path.origin.as_ref()),
            };
            return None;
        };
        let hit = context.scene.interaction_differential(ray, hit, path.differential.as_ref());
        path.light += path.throughput * self.emitted(context, &hit, path.origin.as_ref());
        let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
            path.differential = hit.differential.map(|differential| differential.passed());
            return pass_interface(&hit, ray.direction, &mut path.interfaces);
        };
        let vertex = Vertex::new(&hit, bsdf);
        context.note_first_hit(&vertex);
        if path.depth >= self.max_depth {
            return None;
        }
        vertex.disperse(&mut path.throughput, &mut path.is_dispersed);
        path.depth += 1;
        path.interfaces = 0;
        context.sampler.skip_to_dimension(path.dimension);
        path.dimension = path.dimension.wrapping_add(DIMENSIONS_PER_EVENT);
        let [x, y, xi_lobe, xi_roulette] = context.sampler.next_group();
        let xi = DVec2::new(x, y);
        if self.light_sampling && !vertex.is_delta() {
            self.sample_lights(context, path, &vertex);
        }
        if path.budget > 1 {
            if vertex.is_delta() {
                self.divide(path, &vertex, branches);
            } else {
                self.branch(path, &vertex, xi, xi_lobe, branches);
            }
            return None;
        }
        let scattered = vertex.sample(xi, xi_lobe)?;
        path.throughput *= scattered.weight;
        path.branch_throughput *= scattered.weight;
        path.eta_scale *= scattered.eta_scale;
        if path.depth >= ROULETTE_FROM {
            let left = carried(path.branch_throughput, path.throughput);
            let factor = roulette(left * path.eta_scale, xi_roulette)?;
            path.throughput *= factor;
            path.branch_throughput *= factor;
        }
        path.differential = vertex.differential(&scattered);
        path.origin = (!scattered.is_delta).then(|| previous(&vertex, &scattered));
        Some(hit.spawn(scattered.direction))
    }

    /// The paths of the budget, from a rough surface, each with its fraction of the throughput.
    fn branch(
        &self,
        path: &DistributedPath,
        vertex: &Vertex<'_>,
        shift: DVec2,
        shift_lobe: f64,
        branches: &mut Vec<DistributedPath>,
    ) {
        let count = path.budget;
        branches.extend((0..count).filter_map(|j| {
            // The order of the strata of the lobe differs from that of the direction.
            let xi_lobe = (radical_inverse_3(j) + shift_lobe).fract();
            let scattered = vertex.sample(spread(j, count, shift), xi_lobe)?;
            let branch = self.scattered(path, vertex, &scattered, j);
            Some(DistributedPath {
                throughput: branch.throughput * (1.0 / count as f32),
                budget: 1,
                ..branch
            })
        }));
    }

    /// Paths in the directions of all delta lobes, with the budget divided between them.
    fn divide(&self, path: &DistributedPath, vertex: &Vertex<'_>, branches: &mut Vec<DistributedPath>) {
        let count = vertex.delta_branches().count() as u32;
        branches.extend((0..).zip(vertex.delta_branches()).map(|(j, scattered)| DistributedPath {
            budget: path.budget / count,
            ..self.scattered(path, vertex, &scattered, j)
        }));
    }

    /// The `j`th branch of a path. Every branch has its own dimensions of the sampler, the same in every sample.
    fn scattered(
        &self,
        path: &DistributedPath,
        vertex: &Vertex<'_>,
        scattered: &ScatteredRay,
        j: u32,
    ) -> DistributedPath {
        let length = DIMENSIONS_PER_EVENT.wrapping_mul(self.max_depth.wrapping_add(1));
        DistributedPath {
            sample: path.sample,
            ray: Some(vertex.at.spawn(scattered.direction)),
            differential: vertex.differential(scattered),
            light: Spectrum::BLACK,
            throughput: path.throughput * scattered.weight,
            branch_throughput: scattered.weight,
            eta_scale: path.eta_scale * scattered.eta_scale,
            is_dispersed: path.is_dispersed,
            origin: (!scattered.is_delta).then(|| previous(vertex, scattered)),
            depth: path.depth,
            interfaces: 0,
            budget: path.budget,
            dimension: path.dimension.wrapping_add(length.wrapping_mul(j.wrapping_add(1))),
            pending: Vec::new(),
        }
    }
}

/// `vertex` as the origin of a scattered ray.
fn previous(vertex: &Vertex<'_>, scattered: &ScatteredRay) -> PreviousVertex {
    PreviousVertex { from: vertex.light_sample_context(vertex.at.wo), pdf: scattered.pdf }
}

impl<'a, 'b> BatchedPath<DistributedSamples<'a, 'b>> for DistributedPath {
    fn ray(&self) -> Option<Ray> {
        self.ray
    }

    fn advance(
        &mut self,
        samples: &mut DistributedSamples<'a, 'b>,
        hit: Option<&SceneHit>,
        branches: &mut Vec<Self>,
    ) {
        let context = &mut samples.contexts[self.sample];
        context.counters.closest += 1;
        let Some(ray) = self.ray.take() else { return };
        self.ray = samples.integrator.next_ray(context, self, &ray, hit, branches);
    }

    fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
        rays.extend(self.pending.iter().map(|&(shadow, _)| shadow));
    }

    fn complete_vertex(&mut self, samples: &mut DistributedSamples<'a, 'b>, occluded: &[bool]) {
        samples.contexts[self.sample].counters.shadow += self.pending.len() as u64;
        // Taken with its memory, which is much where there are many lights.
        let pending = std::mem::take(&mut self.pending).into_iter().zip(occluded);
        // Summed before it is added: many small parts would be lost beside much emitted light.
        let arrived: Spectrum =
            pending.filter(|&(_, &occluded)| !occluded).map(|((_, light), _)| light).sum();
        self.light += arrived;
    }
}

impl Integrator for Distributed {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        (BATCH / self.branching as usize).max(1)
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        radiance.clear();
        let Some(scene) = contexts.first().map(|context| context.scene) else { return };
        let start = |(sample, context): (usize, &Context<'_>)| DistributedPath {
            sample,
            ray: context.start(),
            differential: context.start_differential(),
            light: Spectrum::BLACK,
            throughput: Spectrum::one(&context.wavelengths),
            branch_throughput: Spectrum::one(&context.wavelengths),
            eta_scale: 1.0,
            is_dispersed: false,
            origin: None,
            depth: 0,
            interfaces: 0,
            budget: self.branching,
            dimension: FIRST_DIMENSION,
            pending: Vec::new(),
        };
        let mut paths: Vec<_> = contexts.iter().enumerate().map(start).collect();
        radiance.resize(contexts.len(), Spectrum::BLACK);
        let mut samples = DistributedSamples { integrator: *self, contexts };
        scene.trace_paths(&mut paths, &mut samples);
        for path in &paths {
            radiance[path.sample] += path.light;
        }
    }
}

/// The `j`th of `count` points: the Hammersley set, rotated on the torus by `shift` so that each point is uniform.
///
/// # Source
/// @cranley1976; @pharr2023 section 8.6.
fn spread(j: u32, count: u32, shift: DVec2) -> DVec2 {
    let x = f64::from(j) / f64::from(count);
    let y = f64::from(j.reverse_bits()) / 4_294_967_296.0;
    (DVec2::new(x, y) + shift).fract()
}

/// The radical inverse of `j` in base 3.
fn radical_inverse_3(mut j: u32) -> f64 {
    let (mut digit, mut sum) = (1.0 / 3.0, 0.0);
    while j > 0 {
        sum += f64::from(j % 3) * digit;
        j /= 3;
        digit /= 3.0;
    }
    sum
}
