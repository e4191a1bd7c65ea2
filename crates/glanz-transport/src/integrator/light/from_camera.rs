//! Paths from the camera.

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Ray};
use glanz_scene::{Interaction, LightId, LightSampleContext};

use super::weights::CameraPathWeights;
use super::{LightPaths, turn};
use crate::integrator::path_tracer::{DIMENSIONS_PER_EVENT, INTERFACE_LIMIT, ROULETTE_FROM};
use crate::integrator::vertex::{ScatteredRay, Vertex, roulette};
use crate::integrator::{Context, FIRST_DIMENSION};

/// Sampling state of the current ray.
struct CameraRay {
    /// Position of the vertex.
    from: LightSampleContext,
    /// Density per solid angle of its direction; infinite after a mirror.
    pdf: f64,
    weights: CameraPathWeights,
}

impl LightPaths {
    /// Radiance estimate of one path from the camera, with the same random decisions as [`Path`](crate::integrator::Path).
    pub(super) fn gather(&self, context: &mut Context<'_>) -> Spectrum {
        let mut ray = context.camera_ray;
        let (mut light, mut throughput) = (Spectrum::BLACK, Spectrum::ONE);
        let mut eta_scale = 1.0_f32;
        // `None` before the first scattering: no other technique finds directly visible light.
        let mut origin: Option<CameraRay> = None;
        let (mut depth, mut interfaces) = (0, 0);
        loop {
            let Some(hit) = context.intersect(&ray) else {
                return light + throughput * escaped(context, &ray, origin.as_ref());
            };
            light += throughput * emitted(context, &hit, origin.as_ref());
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
            let [x, y, xi_lobe, xi_roulette] = context.sampler.next_group();
            let xi = DVec2::new(x, y);
            let weights =
                origin.as_ref().map_or_else(|| first(context, &hit, ray.direction), |origin| origin.weights);
            if !vertex.is_delta() {
                let [x, y, xi_light, _] = context.sampler.next_group();
                light += throughput * sampled(context, &vertex, &weights, xi_light, DVec2::new(x, y));
            }
            let Some(scattered) = vertex.sample(xi, xi_lobe) else { return light };
            throughput *= scattered.weight;
            eta_scale *= scattered.eta_scale;
            if depth >= ROULETTE_FROM {
                let Some(factor) = roulette(throughput * eta_scale, xi_roulette) else { return light };
                throughput *= factor;
            }
            let weights = passed(&weights, &vertex, &scattered);
            origin = Some(CameraRay { from: hit.light_sample_context(), pdf: scattered.pdf, weights });
            ray = hit.spawn(scattered.direction);
        }
    }
}

/// Weights at the first vertex.
fn first(context: &Context<'_>, hit: &Interaction, direction: DVec3) -> CameraPathWeights {
    let density = context.scene.camera().density(hit.point.position, direction);
    CameraPathWeights::new(context.light_paths(), density)
}

/// Weights at the vertex that follows `vertex`.
fn passed(weights: &CameraPathWeights, vertex: &Vertex<'_>, scattered: &ScatteredRay) -> CameraPathWeights {
    if scattered.is_delta {
        weights.mirrored(vertex.is_seen_alike(scattered.direction))
    } else {
        weights.scattered(&turn(vertex, scattered.direction, vertex.at.wo, scattered.pdf))
    }
}

/// Light of the infinite lights along `ray`.
fn escaped(context: &Context<'_>, ray: &Ray, origin: Option<&CameraRay>) -> Spectrum {
    let scene = context.scene;
    let lights = scene.infinite_lights().iter();
    lights
        .map(|&id| {
            let sampled = |origin: &CameraRay| scene.infinite_pdf(id, &origin.from, ray.direction).0;
            scene.infinite_radiance(id, ray)
                * weight_of_hit(context, id, origin, ray.direction, None, sampled) as f32
        })
        .sum()
}

/// Light emitted by the surface at `hit`.
fn emitted(context: &Context<'_>, hit: &Interaction, origin: Option<&CameraRay>) -> Spectrum {
    let Some(id) = hit.light() else { return Spectrum::BLACK };
    let emitted = context.scene.emitted(hit, hit.wo);
    if emitted.is_black() {
        return emitted;
    }
    let sampled = |origin: &CameraRay| context.scene.light_pdf(id, &origin.from, hit).0;
    emitted * weight_of_hit(context, id, origin, -hit.wo, hit.area_pdf(), sampled) as f32
}

/// Weight of hitting the light `id` in the unit direction `wi`. `area_pdf`: area density of the hit point; `sampled`: density of light sampling.
fn weight_of_hit(
    context: &Context<'_>,
    id: LightId,
    origin: Option<&CameraRay>,
    wi: DVec3,
    area_pdf: Option<AreaPdf>,
    sampled: impl FnOnce(&CameraRay) -> f64,
) -> f64 {
    let Some(origin) = origin else { return 1.0 };
    let probability = context.scene.light_probability(id);
    let emission = context.scene.emitter_probability(id)
        * context.scene.emission_pdf(id, origin.from.position, wi, area_pdf);
    origin.weights.weight_of_hit(emission, probability * sampled(origin), origin.pdf)
}

/// Direct light of one randomly selected light.
fn sampled(
    context: &mut Context<'_>,
    vertex: &Vertex<'_>,
    weights: &CameraPathWeights,
    xi_light: f64,
    xi: DVec2,
) -> Spectrum {
    let scene = context.scene;
    let picked = scene.select_light(xi_light).filter(|&(_, probability)| probability > 0.0);
    let Some((id, probability)) = picked else { return Spectrum::BLACK };
    let Some(sample) = scene.sample_light(id, vertex.at, xi) else {
        return Spectrum::BLACK;
    };
    let (value, light_pdf) = vertex.eval(sample.wi);
    let light = value * sample.radiance;
    if light.is_black() || !context.is_free(&sample.shadow, sample.t_max) {
        return Spectrum::BLACK;
    }
    let position = vertex.at.point.position;
    let emission =
        scene.emitter_probability(id) * scene.emission_pdf(id, position, sample.wi, sample.area_pdf);
    let density = probability * sample.pdf.0;
    let turn = turn(vertex, sample.wi, vertex.at.wo, light_pdf);
    let weight = weights.weight_of_sampled(&turn, emission, density, sample.is_delta);
    light * (weight / density) as f32
}
