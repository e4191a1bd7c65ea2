//! Classical ray tracing.

use glanz_light::Spectrum;
use glanz_math::Ray;
use glanz_scene::{Light, LightId};
use glanz_shading::Bsdf;
use glanz_shading::model::phong::{ClassicLight, Coefficients, classic, classic_ambient};

use super::vertex::Vertex;
use super::walk::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT};
use super::{Context, FIRST_DIMENSION, Integrator, IntegratorSettings};

/// Direct light, perfect mirrors and refraction; no light is scattered twice by a rough surface.
///
/// - `Phong` materials are shaded as document 001 section 3.4 says (with the corrections of `ERRATA.md`). The intensity L of a
///   light is the radiance of a white diffuse surface that faces it, irradiance / pi, so that the diffuse part is that of
///   Lambert's law; the ambient light S is that of the infinite lights, which shine without shadows here.
/// - Other rough materials are lit by every light: exactly by points and directions, by one random direction to each
///   surface and to each infinite light.
/// - Every light is tested for shadow by one ray.
/// - Mirrors and glass are followed into all their directions with their Fresnel weights, up to the depth limit and as
///   long as a ray carries at least [`SMALLEST_WEIGHT`] of what the viewer sees.
#[derive(Clone, Copy, Debug)]
pub struct Whitted {
    max_depth: u32,
}

/// Rays that would carry a smaller share to the viewer are not followed: below what 8 bits per channel can show (1/255).
///
/// Weights at a surface sum to at most 1, so that at most 1 / `SMALLEST_WEIGHT` rays per depth are alive.
pub const SMALLEST_WEIGHT: f32 = 1.0 / 4096.0;

/// A ray still to be followed.
struct Pending {
    ray: Ray,
    weight: Spectrum,
    /// Product of all refractions undone, so that light in glass is not taken for weak.
    eta_scale: f32,
    depth: u32,
}

impl Whitted {
    /// With the depth of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self { max_depth: settings.max_depth }
    }

    /// Light from the first surface on the ray, and the rays to go on with.
    fn follow(&self, context: &mut Context<'_>, mut pending: Pending, stack: &mut Vec<Pending>) -> Spectrum {
        let mut light = Spectrum::BLACK;
        for _ in 0..INTERFACE_LIMIT {
            let Some(hit) = context.intersect(&pending.ray) else {
                return light + context.scene.escaped(&pending.ray);
            };
            light += context.scene.emitted(&hit, hit.wo);
            let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
                pending.ray = hit.spawn(pending.ray.direction);
                continue;
            };
            let vertex = Vertex::new(&hit, bsdf);
            context.note_first_hit(&vertex);
            if pending.depth >= self.max_depth {
                return light;
            }
            if bsdf.is_delta() {
                stack.extend(vertex.delta_branches().filter_map(|branch| {
                    let weight = pending.weight * branch.weight;
                    let eta_scale = pending.eta_scale * branch.eta_scale;
                    let enough = weight.max_component() * eta_scale >= SMALLEST_WEIGHT;
                    let ray = hit.spawn(branch.direction);
                    enough.then_some(Pending { ray, weight, eta_scale, depth: pending.depth + 1 })
                }));
                return light;
            }
            let dimension = FIRST_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(pending.depth);
            context.sampler.skip_to_dimension(dimension);
            return light
                + match bsdf {
                    Bsdf::Phong(phong) => phong_light(context, &vertex, phong.coefficients()),
                    _ => direct_light(context, &vertex),
                };
        }
        light
    }
}

impl Integrator for Whitted {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        let mut light = Spectrum::BLACK;
        let mut stack = Vec::new();
        let mut next =
            Some(Pending { ray: context.camera_ray, weight: Spectrum::ONE, eta_scale: 1.0, depth: 0 });
        while let Some(pending) = next {
            light += pending.weight * self.follow(context, pending, &mut stack);
            next = stack.pop();
        }
        light
    }
}

fn light_ids(context: &Context<'_>) -> impl Iterator<Item = LightId> + use<> {
    (0..context.scene.lights().len() as u32).map(LightId)
}

/// Light of every light that a rough surface scatters to the viewer.
fn direct_light(context: &mut Context<'_>, vertex: &Vertex<'_>) -> Spectrum {
    light_ids(context)
        .map(|id| {
            let xi = context.sampler.next_2d();
            vertex.light(context, id, xi, |_, _, _| 1.0)
        })
        .sum()
}

/// Document 001 section 3.4.
fn phong_light(context: &mut Context<'_>, vertex: &Vertex<'_>, surface: &Coefficients) -> Spectrum {
    let normal = vertex.normal_to_viewer();
    let mut ambient = Spectrum::BLACK;
    let mut light = Spectrum::BLACK;
    for id in light_ids(context) {
        if let Some(Light::Infinite(infinite)) = context.scene.light(id) {
            ambient += infinite.radiance();
            continue;
        }
        let xi = context.sampler.next_2d();
        let Some(sample) = context.scene.sample_light(id, vertex.at, xi, &context.wavelengths) else {
            continue;
        };
        // The back of the surface itself shades, as in `Vertex::eval`.
        let lit = vertex.at.point.normal.dot(sample.wi) * vertex.at.point.normal.dot(vertex.at.wo) > 0.0;
        let intensity = sample.radiance * (std::f64::consts::FRAC_1_PI / sample.pdf.0) as f32;
        let source = ClassicLight { direction: sample.wi, diffuse: intensity, specular: intensity };
        let scattered = classic(surface, normal, vertex.at.wo, &source);
        if lit && !scattered.is_black() && context.is_free(&sample.shadow, sample.t_max) {
            light += scattered;
        }
    }
    light + classic_ambient(surface, ambient)
}
