//! Distributed ray tracing.

use glanz_light::Spectrum;
use glanz_math::{DVec2, Ray};
use glanz_scene::{Interaction, LightId};

use super::path_tracer::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT, ROULETTE_FROM};
use super::vertex::{PreviousVertex, Vertex, roulette};
use super::{Context, FIRST_DIMENSION, Integrator, IntegratorSettings};

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
#[derive(Clone, Copy)]
struct DistributedTracer {
    ray: Ray,
    /// Factor on the light of the path, relative to the point where it branched off.
    throughput: Spectrum,
    eta_scale: f32,
    /// The last vertex with a rough lobe; `None` after the camera or a delta lobe.
    origin: Option<PreviousVertex>,
    depth: u32,
    /// Number of paths into which it may still branch.
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

    /// Direct light of all lights, with `rays` shadow rays but at least one for each light.
    fn direct_light(&self, context: &mut Context<'_>, vertex: &Vertex<'_>, rays: u32) -> Spectrum {
        let lights = context.scene.lights().len() as u32;
        let each = rays.div_ceil(lights.max(1));
        let mut light = Spectrum::BLACK;
        for id in (0..lights).map(LightId) {
            let shift = context.sampler.next_2d();
            // A delta light needs one ray only.
            let is_delta = context.scene.light(id).is_some_and(glanz_scene::Light::is_delta);
            let count = if is_delta { 1 } else { each };
            let sum: Spectrum =
                (0..count).map(|j| vertex.light(context, id, spread(j, count, shift), |_, _, _| 1.0)).sum();
            light += sum * (1.0 / count as f32);
        }
        light
    }

    /// Radiance estimate of the path.
    fn follow(&self, context: &mut Context<'_>, mut path: DistributedTracer) -> Spectrum {
        let mut light = Spectrum::BLACK;
        let mut interfaces = 0;
        loop {
            let Some(hit) = context.intersect(&path.ray) else {
                return light + path.throughput * self.escaped(context, &path.ray, path.origin.as_ref());
            };
            light += path.throughput * self.emitted(context, &hit, path.origin.as_ref());
            let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
                interfaces += 1;
                if interfaces > INTERFACE_LIMIT {
                    return light;
                }
                path.ray = hit.spawn(path.ray.direction);
                continue;
            };
            let vertex = Vertex::new(&hit, bsdf);
            context.note_first_hit(&vertex);
            if path.depth >= self.max_depth {
                return light;
            }
            path.depth += 1;
            interfaces = 0;
            context.sampler.skip_to_dimension(path.dimension);
            path.dimension = path.dimension.wrapping_add(DIMENSIONS_PER_EVENT);
            let (xi, xi_lobe) = (context.sampler.next_2d(), context.sampler.next_1d());
            let xi_roulette = context.sampler.next_1d();
            if self.light_sampling && !bsdf.is_delta() {
                light += path.throughput * self.direct_light(context, &vertex, path.budget);
            }
            if path.budget > 1 {
                let scattered = if bsdf.is_delta() {
                    self.divide(context, &path, &vertex)
                } else {
                    self.branch(context, &path, &vertex, xi, xi_lobe)
                };
                return light + path.throughput * scattered;
            }
            let Some(scattered) = vertex.sample(xi, xi_lobe) else { return light };
            path.throughput *= scattered.weight;
            path.eta_scale *= scattered.eta_scale;
            if path.depth >= ROULETTE_FROM {
                match roulette(path.throughput * path.eta_scale, xi_roulette) {
                    Some(factor) => path.throughput *= factor,
                    None => return light,
                }
            }
            path.ray = hit.spawn(scattered.direction);
            path.origin = (!scattered.is_delta)
                .then_some(PreviousVertex { from: hit.light_sample_context(), pdf: scattered.pdf });
        }
    }

    /// The mean over the paths of the budget, from a rough surface.
    fn branch(
        &self,
        context: &mut Context<'_>,
        path: &DistributedTracer,
        vertex: &Vertex<'_>,
        shift: DVec2,
        shift_lobe: f64,
    ) -> Spectrum {
        let count = path.budget;
        let mut sum = Spectrum::BLACK;
        for j in 0..count {
            // The order of the strata of the lobe differs from that of the direction.
            let xi_lobe = (radical_inverse_3(j) + shift_lobe).fract();
            let Some(scattered) = vertex.sample(spread(j, count, shift), xi_lobe) else { continue };
            let next = DistributedTracer {
                ray: vertex.at.spawn(scattered.direction),
                throughput: scattered.weight,
                eta_scale: path.eta_scale * scattered.eta_scale,
                origin: (!scattered.is_delta)
                    .then_some(PreviousVertex { from: vertex.at.light_sample_context(), pdf: scattered.pdf }),
                budget: 1,
                dimension: self.lane(path, j),
                ..*path
            };
            sum += self.follow(context, next);
        }
        sum * (1.0 / count as f32)
    }

    /// Light along the directions of all delta lobes, with the budget divided between them.
    fn divide(&self, context: &mut Context<'_>, path: &DistributedTracer, vertex: &Vertex<'_>) -> Spectrum {
        let count = vertex.delta_branches().count() as u32;
        let mut sum = Spectrum::BLACK;
        for (j, branch) in (0..).zip(vertex.delta_branches()) {
            let next = DistributedTracer {
                ray: vertex.at.spawn(branch.direction),
                throughput: branch.weight,
                eta_scale: path.eta_scale * branch.eta_scale,
                origin: None,
                budget: path.budget / count,
                dimension: self.lane(path, j),
                ..*path
            };
            sum += self.follow(context, next);
        }
        sum
    }

    /// First sampler dimension of the `j`th branch: every branch has its own dimensions, the same in every sample.
    fn lane(&self, path: &DistributedTracer, j: u32) -> u32 {
        let length = DIMENSIONS_PER_EVENT.wrapping_mul(self.max_depth.wrapping_add(1));
        path.dimension.wrapping_add(length.wrapping_mul(j.wrapping_add(1)))
    }
}

impl Integrator for Distributed {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        let path = DistributedTracer {
            ray: context.camera_ray,
            throughput: Spectrum::ONE,
            eta_scale: 1.0,
            origin: None,
            depth: 0,
            budget: self.branching,
            dimension: FIRST_DIMENSION,
        };
        self.follow(context, path)
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
