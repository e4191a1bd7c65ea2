//! Perfect mirrors and refraction, with all their directions.

use glanz_light::Spectrum;
use glanz_math::Ray;
use glanz_scene::{ParametricPoint, RayDifferential};

use super::path_tracer::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT};
use super::vertex::Vertex;
use super::{Context, FIRST_DIMENSION};

/// Smallest weight at the viewer of a ray that is traced; less than 8 bits per channel can show (1/255).
///
/// Weights at a surface sum to at most 1, so that at most 1 / `SMALLEST_WEIGHT` rays per depth are alive.
pub const SMALLEST_WEIGHT: f32 = 1.0 / 4096.0;

/// A ray yet to be traced.
struct DeferredRay {
    ray: Ray,
    /// In scenes with filtered textures.
    differential: Option<RayDifferential>,
    weight: Spectrum,
    /// Factor that undoes the scaling of radiance by all refractions, so that the weight of rays in glass is not underestimated.
    eta_scale: f32,
    /// Whether the hero of its wavelengths is left alone.
    is_dispersed: bool,
    depth: u32,
}

/// Light along the camera ray, with reflections in mirrors and refraction in glass.
///
/// All their directions are traced with their Fresnel weights, up to `max_depth` and while the weight of a ray at the viewer is at least
/// [`SMALLEST_WEIGHT`]. `rough`: the light that a rough surface scatters to the viewer, from its vertex and parameters.
pub(super) fn radiance(
    context: &mut Context<'_>,
    max_depth: u32,
    rough: &impl Fn(&mut Context<'_>, &Vertex<'_>, &ParametricPoint) -> Spectrum,
) -> Spectrum {
    let mut light = Spectrum::BLACK;
    let mut stack = Vec::new();
    let differential = context.start_differential();
    let first = |ray| DeferredRay {
        ray,
        differential,
        weight: Spectrum::ONE,
        eta_scale: 1.0,
        is_dispersed: false,
        depth: 0,
    };
    let mut next = context.start().map(first);
    while let Some(pending) = next {
        light += pending.weight * follow(context, pending, max_depth, rough, &mut stack);
        next = stack.pop();
    }
    light
}

/// Light of the first surface on the ray, and the rays that continue from it.
fn follow(
    context: &mut Context<'_>,
    mut pending: DeferredRay,
    max_depth: u32,
    rough: &impl Fn(&mut Context<'_>, &Vertex<'_>, &ParametricPoint) -> Spectrum,
    stack: &mut Vec<DeferredRay>,
) -> Spectrum {
    let mut light = Spectrum::BLACK;
    for _ in 0..INTERFACE_LIMIT {
        let found = context.intersect_parametric(&pending.ray, pending.differential.as_ref());
        let Some((hit, place)) = found else {
            return light
                + match pending.depth {
                    0 => context.backdrop_radiance(&pending.ray),
                    _ => context.scene.environment_radiance(&pending.ray, &context.wavelengths),
                };
        };
        light += context.emitted(&hit);
        let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
            pending.ray = hit.spawn(pending.ray.direction);
            pending.differential = hit.differential.map(|differential| differential.passed());
            continue;
        };
        let vertex = Vertex::new(&hit, bsdf);
        context.note_first_hit(&vertex);
        if pending.depth >= max_depth {
            return light;
        }
        let mut here = Spectrum::ONE;
        vertex.disperse(&mut here, &mut pending.is_dispersed);
        stack.extend(vertex.delta_branches().filter_map(|branch| {
            let weight = pending.weight * here * branch.weight;
            let eta_scale = pending.eta_scale * branch.eta_scale;
            let enough = weight.max_component() * eta_scale >= SMALLEST_WEIGHT;
            let (ray, differential) = (hit.spawn(branch.direction), vertex.differential(&branch));
            let (is_dispersed, depth) = (pending.is_dispersed, pending.depth + 1);
            enough.then_some(DeferredRay { ray, differential, weight, eta_scale, is_dispersed, depth })
        }));
        if vertex.is_delta() {
            return light;
        }
        let dimension = FIRST_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(pending.depth);
        context.sampler.skip_to_dimension(dimension);
        return light + here * rough(context, &vertex, &place);
    }
    light
}
