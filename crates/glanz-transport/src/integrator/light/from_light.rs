//! Paths from a light.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};
use glanz_scene::{Light, LightId, LightRay, LightSampleContext};

use super::weights::LightPathWeights;
use super::{LightPaths, turn};
use crate::integrator::path_tracer::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT, ROULETTE_FROM};
use crate::integrator::vertex::{Vertex, roulette};
use crate::integrator::{Context, DEPTH_LIMIT, FIRST_DIMENSION};

/// The sampler's first dimension of light paths, after all those of camera paths.
const FIRST_LIGHT_DIMENSION: u32 = FIRST_DIMENSION + DIMENSIONS_PER_EVENT * (DEPTH_LIMIT + 1);

/// First vertex of a light path.
struct LightPathStart {
    id: LightId,
    /// Probability of selecting the light.
    probability: f64,
    light: LightRay,
    is_delta: bool,
}

impl LightPathStart {
    /// Samples the first vertex by the first group of numbers: direction and position, then the light.
    fn pick(context: &mut Context<'_>) -> Option<Self> {
        context.sampler.skip_to_dimension(FIRST_LIGHT_DIMENSION);
        let (direction, place) = (context.sampler.next_2d(), context.sampler.next_2d());
        let scene = context.scene;
        let (id, probability) = scene.select_emitter(context.sampler.next_1d())?;
        let light = scene.emit(id, place, direction)?;
        let is_delta = !scene.light(id).is_some_and(Light::can_be_hit);
        (probability > 0.0).then_some(Self { id, probability, light, is_delta })
    }

    /// Weights at the first vertex.
    fn weights(&self, context: &Context<'_>, vertex: &Vertex<'_>) -> LightPathWeights {
        let at = vertex.at.point.position;
        let pdf = context.scene.emission_pdf(self.id, at, vertex.at.wo, self.light.area_pdf());
        LightPathWeights::new(context.light_paths(), self.probability * pdf, self.is_delta)
    }

    /// Density of light sampling from the first vertex, as `seen` from the camera.
    fn sampled(&self, context: &Context<'_>, seen: &LightSampleContext) -> f64 {
        let scene = context.scene;
        scene.light_probability(self.id) * scene.light_pdf_of_ray(self.id, seen, &self.light).0
    }
}

impl LightPaths {
    /// Traces one path from a light and splats its connections to the camera.
    pub(super) fn send(&self, context: &mut Context<'_>) {
        if context.light_paths() <= 0.0 {
            return;
        }
        let Some(start) = LightPathStart::pick(context) else { return };
        let mut ray = start.light.ray;
        let mut flux = start.light.power * (1.0 / start.probability) as f32;
        let mut left = Spectrum::ONE;
        let mut weights: Option<LightPathWeights> = None;
        let (mut depth, mut interfaces) = (0, 0);
        while depth < self.max_depth {
            let Some(hit) = context.intersect(&ray) else { return };
            let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
                interfaces += 1;
                if interfaces > INTERFACE_LIMIT {
                    return;
                }
                ray = hit.spawn(ray.direction);
                continue;
            };
            depth += 1;
            interfaces = 0;
            let vertex = Vertex::new(&hit, bsdf);
            let known = match weights {
                Some(known) => known,
                None => {
                    flux *=
                        start.light.range.attenuation((hit.point.position - start.light.ray.origin).length());
                    start.weights(context, &vertex)
                }
            };
            let dimension = FIRST_LIGHT_DIMENSION.wrapping_add(DIMENSIONS_PER_EVENT.wrapping_mul(depth));
            context.sampler.skip_to_dimension(dimension);
            let [x, y, xi_lobe, xi_roulette] = context.sampler.next_group();
            let xi = DVec2::new(x, y);
            let [x, y, xi_pixel, _] = context.sampler.next_group();
            let xi_lens = DVec2::new(x, y);
            if !vertex.is_delta() {
                connect(context, &vertex, flux, &start, &known, xi_lens, xi_pixel);
            }
            let Some((direction, weight, next)) = go_on(context, &vertex, &start, &known, xi, xi_lobe) else {
                return;
            };
            flux *= weight;
            left *= weight;
            weights = Some(next);
            if depth >= ROULETTE_FROM {
                let Some(factor) = roulette(left, xi_roulette) else { return };
                flux *= factor;
                left *= factor;
            }
            ray = hit.spawn(direction);
        }
    }
}

/// Connects `vertex`, at which `flux` arrives, to a point of the lens.
fn connect(
    context: &mut Context<'_>,
    vertex: &Vertex<'_>,
    flux: Spectrum,
    start: &LightPathStart,
    weights: &LightPathWeights,
    xi_lens: DVec2,
    xi_pixel: f64,
) {
    let (at, to_light) = (vertex.at, vertex.at.wo);
    let Some(seen) = context.scene.camera().project(at.point.position, xi_lens) else { return };
    let Some(to_camera) = (seen.origin - at.point.position).try_normalize() else { return };
    if !context.takes_splats_at(seen.film) {
        return;
    }
    // The vertex for a viewer at the camera: both kinds of paths use the same BSDF.
    let (value, light_pdf) = vertex.seen_from(to_camera).eval(to_light);
    let light = flux * value;
    if light.is_black() || !context.is_free(&at.spawn_to(seen.origin, None), 1.0) {
        return;
    }
    let turn = turn(vertex, to_light, to_camera, light_pdf);
    let reference = LightSampleContext { wo: to_camera, ..at.light_sample_context() };
    let weight = weights.weight_of_sent(&turn, seen.density, || start.sampled(context, &reference));
    // `value` contains the cosine to the shading normal, as needed for incident radiance; flux already contains the geometric cosine
    // (@veach1997 section 5.3.2).
    let factor = seen.density * turn.camera_cos / turn.light_cos * weight;
    context.splat(seen.film, light * factor as f32, xi_pixel);
}

/// Samples the direction in which flux continues, with its factor and the weights at the next vertex.
fn go_on(
    context: &Context<'_>,
    vertex: &Vertex<'_>,
    start: &LightPathStart,
    weights: &LightPathWeights,
    xi: DVec2,
    xi_lobe: f64,
) -> Option<(DVec3, Spectrum, LightPathWeights)> {
    let scattered = vertex.sample_flux(xi, xi_lobe)?;
    let (to_light, to_camera) = (vertex.at.wo, scattered.direction);
    if scattered.is_delta {
        // No path from the camera could take this direction.
        let both_ways = vertex.is_seen_alike(to_camera);
        return both_ways.then(|| (to_camera, scattered.weight, weights.mirrored()));
    }
    let (value, light_pdf) = vertex.seen_from(to_camera).eval(to_light);
    let turn = turn(vertex, to_light, to_camera, light_pdf);
    let factor = turn.camera_cos / (turn.light_cos * scattered.pdf);
    let reference = LightSampleContext { wo: to_camera, ..vertex.at.light_sample_context() };
    let next = weights.scattered(&turn, || start.sampled(context, &reference));
    let weight = value * factor as f32;
    (weight.is_finite() && !weight.is_black()).then_some((to_camera, weight, next))
}
