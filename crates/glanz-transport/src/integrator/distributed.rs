//! Distributed ray tracing.

use glanz_light::Spectrum;
use glanz_math::{DVec2, Ray};
use glanz_scene::{Interaction, LightId};

use super::path_tracer::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT, ROULETTE_FROM};
use super::vertex::{PreviousVertex, Vertex, roulette};
use super::{Context, FIRST_DIMENSION, Integrator, IntegratorSettings};

/// Several rays from a hit instead of one.
///
/// The first rough surface that a camera ray reaches sends m rays on, spread over the numbers of the BSDF sample; from
/// each of their hits one ray goes on (document 003 section 3.1.1; m rays everywhere would grow exponentially). On the way
/// there, glass divides the m rays between reflection and refraction. A camera ray never becomes more than m paths.
///
/// With light sampling the hemisphere is stratified as section 3.1.3 says, second way: every light is a stratum sampled
/// by itself, m shadow rays shared between them, one for each at least; the other rays bring reflected light only. What
/// light sampling cannot find (through a mirror, a surface without area sampling) the other rays bring.
///
/// Paths end by depth or by Russian roulette (section 3.1.4).
#[derive(Clone, Copy, Debug)]
pub struct Distributed {
    max_depth: u32,
    light_sampling: bool,
    branching: u32,
}

/// A path under way.
#[derive(Clone, Copy)]
struct DistributedTracer {
    ray: Ray,
    /// Factor on what it finds, relative to where it branched off.
    throughput: Spectrum,
    eta_scale: f32,
    /// The last vertex with a rough lobe; `None` after the camera or a delta lobe.
    origin: Option<PreviousVertex>,
    depth: u32,
    /// Paths that it may still become.
    budget: u32,
    /// Sampler dimension of its first event.
    dimension: u32,
}

impl Distributed {
    /// With depth, light sampling and branching of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { max_depth, light_sampling, branching, .. } = *settings;
        Self { max_depth, light_sampling, branching }
    }

    /// Share of light that belongs to the rays of the BSDF: all that light sampling cannot find, and nothing else.
    fn weight(&self, origin: Option<&PreviousVertex>, light_pdf: impl FnOnce(&PreviousVertex) -> f64) -> f32 {
        match origin {
            Some(origin) if self.light_sampling && light_pdf(origin) > 0.0 => 0.0,
            _ => 1.0,
        }
    }

    fn escaped(&self, context: &Context<'_>, ray: &Ray, origin: Option<&PreviousVertex>) -> Spectrum {
        let scene = context.scene;
        let weight = |id| self.weight(origin, |o| o.infinite_light_pdf(context, id, ray.direction));
        scene.infinite_lights().iter().map(|&id| scene.infinite_radiance(id, ray) * weight(id)).sum()
    }

    fn emitted(&self, context: &Context<'_>, hit: &Interaction, origin: Option<&PreviousVertex>) -> Spectrum {
        match hit.light() {
            None => Spectrum::BLACK,
            Some(id) => {
                context.scene.emitted(hit, hit.wo)
                    * self.weight(origin, |o| o.area_light_pdf(context, id, hit))
            }
        }
    }

    /// Direct light of all lights by `rays` shadow rays or one for each light.
    fn direct_light(&self, context: &mut Context<'_>, vertex: &Vertex<'_>, rays: u32) -> Spectrum {
        let lights = context.scene.lights().len() as u32;
        let each = rays.div_ceil(lights.max(1));
        let mut light = Spectrum::BLACK;
        for id in (0..lights).map(LightId) {
            let shift = context.sampler.next_2d();
            // One direction says everything of a light that has no other.
            let is_delta = context.scene.light(id).is_some_and(glanz_scene::Light::is_delta);
            let count = if is_delta { 1 } else { each };
            let sum: Spectrum =
                (0..count).map(|j| vertex.light(context, id, spread(j, count, shift), |_, _, _| 1.0)).sum();
            light += sum * (1.0 / count as f32);
        }
        light
    }

    /// Light that the path brings home.
    fn follow(&self, context: &mut Context<'_>, mut walk: DistributedTracer) -> Spectrum {
        let mut light = Spectrum::BLACK;
        let mut interfaces = 0;
        loop {
            let Some(hit) = context.intersect(&walk.ray) else {
                return light + walk.throughput * self.escaped(context, &walk.ray, walk.origin.as_ref());
            };
            light += walk.throughput * self.emitted(context, &hit, walk.origin.as_ref());
            let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
                interfaces += 1;
                if interfaces > INTERFACE_LIMIT {
                    return light;
                }
                walk.ray = hit.spawn(walk.ray.direction);
                continue;
            };
            let vertex = Vertex::new(&hit, bsdf);
            context.note_first_hit(&vertex);
            if walk.depth >= self.max_depth {
                return light;
            }
            walk.depth += 1;
            interfaces = 0;
            context.sampler.skip_to_dimension(walk.dimension);
            walk.dimension = walk.dimension.wrapping_add(DIMENSIONS_PER_EVENT);
            let (xi, xi_lobe) = (context.sampler.next_2d(), context.sampler.next_1d());
            let xi_roulette = context.sampler.next_1d();
            if self.light_sampling && !bsdf.is_delta() {
                light += walk.throughput * self.direct_light(context, &vertex, walk.budget);
            }
            if walk.budget > 1 {
                let scattered = if bsdf.is_delta() {
                    self.divide(context, &walk, &vertex)
                } else {
                    self.branch(context, &walk, &vertex, xi, xi_lobe)
                };
                return light + walk.throughput * scattered;
            }
            let Some(scattered) = vertex.sample(xi, xi_lobe) else { return light };
            walk.throughput *= scattered.weight;
            walk.eta_scale *= scattered.eta_scale;
            if walk.depth >= ROULETTE_FROM {
                match roulette(walk.throughput * walk.eta_scale, xi_roulette) {
                    Some(factor) => walk.throughput *= factor,
                    None => return light,
                }
            }
            walk.ray = hit.spawn(scattered.direction);
            walk.origin = (!scattered.is_delta)
                .then_some(PreviousVertex { from: hit.light_sample_context(), pdf: scattered.pdf });
        }
    }

    /// The mean of as many paths as the budget allows, from a rough surface.
    fn branch(
        &self,
        context: &mut Context<'_>,
        walk: &DistributedTracer,
        vertex: &Vertex<'_>,
        shift: DVec2,
        shift_lobe: f64,
    ) -> Spectrum {
        let count = walk.budget;
        let mut sum = Spectrum::BLACK;
        for j in 0..count {
            // The lobe goes through its strata in another order than the direction.
            let xi_lobe = (radical_inverse_3(j) + shift_lobe).fract();
            let Some(scattered) = vertex.sample(spread(j, count, shift), xi_lobe) else { continue };
            let next = DistributedTracer {
                ray: vertex.at.spawn(scattered.direction),
                throughput: scattered.weight,
                eta_scale: walk.eta_scale * scattered.eta_scale,
                origin: (!scattered.is_delta)
                    .then_some(PreviousVertex { from: vertex.at.light_sample_context(), pdf: scattered.pdf }),
                budget: 1,
                dimension: self.lane(walk, j),
                ..*walk
            };
            sum += self.follow(context, next);
        }
        sum * (1.0 / count as f32)
    }

    /// Directions of all delta lobes, with the budget divided between them.
    fn divide(&self, context: &mut Context<'_>, walk: &DistributedTracer, vertex: &Vertex<'_>) -> Spectrum {
        let count = vertex.delta_branches().count() as u32;
        let mut sum = Spectrum::BLACK;
        for (j, branch) in (0..).zip(vertex.delta_branches()) {
            let next = DistributedTracer {
                ray: vertex.at.spawn(branch.direction),
                throughput: branch.weight,
                eta_scale: walk.eta_scale * branch.eta_scale,
                origin: None,
                budget: walk.budget / count,
                dimension: self.lane(walk, j),
                ..*walk
            };
            sum += self.follow(context, next);
        }
        sum
    }

    /// Sampler dimensions of the `j`th branch: every branch has its own, the same in every sample.
    fn lane(&self, walk: &DistributedTracer, j: u32) -> u32 {
        let length = DIMENSIONS_PER_EVENT.wrapping_mul(self.max_depth.wrapping_add(1));
        walk.dimension.wrapping_add(length.wrapping_mul(j.wrapping_add(1)))
    }
}

impl Integrator for Distributed {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        let walk = DistributedTracer {
            ray: context.camera_ray,
            throughput: Spectrum::ONE,
            eta_scale: 1.0,
            origin: None,
            depth: 0,
            budget: self.branching,
            dimension: FIRST_DIMENSION,
        };
        self.follow(context, walk)
    }
}

/// The `j`th of `count` points: the Hammersley set, turned round the torus by `shift` so that each point is uniform.
///
/// # Source
/// @cranley1976; @pharr2023 section 8.6.
fn spread(j: u32, count: u32, shift: DVec2) -> DVec2 {
    let x = f64::from(j) / f64::from(count);
    let y = f64::from(j.reverse_bits()) / 4_294_967_296.0;
    (DVec2::new(x, y) + shift).fract()
}

/// The digits of `j` in base 3, mirrored at the point.
fn radical_inverse_3(mut j: u32) -> f64 {
    let (mut digit, mut sum) = (1.0 / 3.0, 0.0);
    while j > 0 {
        sum += f64::from(j % 3) * digit;
        j /= 3;
        digit /= 3.0;
    }
    sum
}
