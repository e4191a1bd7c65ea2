//! Paths from the camera.

use glanz_geometry::BoundedRay;
use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Ray};
use glanz_scene::{
    BatchedPath, Interaction, LightId, LightSampleContext, RayDifferential, SceneHit, SelectedLight,
};

use super::weights::CameraPathWeights;
use super::{LightPaths, turn};
use crate::integrator::path_tracer::{DIMENSIONS_PER_EVENT, ROULETTE_FROM};
use crate::integrator::vertex::{ScatteredRay, Vertex, pass_interface, roulette};
use crate::integrator::{Context, FIRST_DIMENSION};

/// Sampling state of the current ray.
struct CameraPathRay {
    /// Position of the vertex.
    from: LightSampleContext,
    /// Density per solid angle of its direction; infinite after a mirror.
    pdf: f64,
    weights: CameraPathWeights,
}

impl LightPaths {
    /// Radiance estimates of one path from the camera for each sample, with the same random decisions as
    /// [`Path`](crate::integrator::Path).
    pub(super) fn gather(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        radiance.clear();
        let Some(scene) = contexts.first().map(|context| context.scene) else { return };
        let new = |(sample, context): (usize, &Context<'_>)| CameraPath::new(context, sample, self.max_depth);
        let mut paths: Vec<_> = contexts.iter().enumerate().map(new).collect();
        scene.trace_paths(&mut paths, contexts);
        radiance.extend(paths.iter().map(|path| path.light));
    }
}

/// State of a path from the camera.
struct CameraPath {
    /// Position of its sample in the batch.
    sample: usize,
    max_depth: u32,
    /// `None` if it has ended.
    ray: Option<Ray>,
    /// Of the ray, up to the first rough vertex in scenes with filtered textures.
    differential: Option<RayDifferential>,
    light: Spectrum,
    throughput: Spectrum,
    eta_scale: f32,
    /// Whether the hero of its wavelengths is left alone.
    is_dispersed: bool,
    /// `None` before the first scattering: no other technique finds directly visible light.
    origin: Option<CameraPathRay>,
    depth: u32,
    interfaces: u32,
    sampled: Option<SampledLight>,
}

/// Light of a sampled point, whose shadow ray is to be traced.
struct SampledLight {
    shadow: BoundedRay,
    light: Spectrum,
}

impl CameraPath {
    fn new(context: &Context<'_>, sample: usize, max_depth: u32) -> Self {
        Self {
            sample,
            max_depth,
            ray: context.start(),
            differential: context.start_differential(),
            light: Spectrum::BLACK,
            throughput: Spectrum::ONE,
            eta_scale: 1.0,
            is_dispersed: false,
            origin: None,
            depth: 0,
            interfaces: 0,
            sampled: None,
        }
    }

    /// The ray that continues from the hit of `ray`; `None` if the path ends.
    fn next_ray(&mut self, context: &mut Context<'_>, ray: &Ray, hit: Option<&SceneHit>) -> Option<Ray> {
        let Some(hit) = hit else {
            self.light += match self.depth {
                0 => self.throughput * context.backdrop_radiance(ray),
                _ => self.throughput * escaped(context, ray, self.origin.as_ref()),
            };
            return None;
        };
        let hit = context.scene.interaction_differential(ray, hit, self.differential.as_ref());
        self.light += self.throughput * emitted(context, &hit, self.origin.as_ref());
        let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
            self.differential = hit.differential.map(|differential| differential.passed());
            return pass_interface(&hit, ray.direction, &mut self.interfaces);
        };
        let vertex = Vertex::new(&hit, bsdf);
        context.note_first_hit(&vertex);
        if self.depth >= self.max_depth {
            return None;
        }
        vertex.disperse(&mut self.throughput, &mut self.is_dispersed);
        context.sampler.skip_to_dimension(FIRST_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(self.depth));
        self.depth += 1;
        self.interfaces = 0;
        let [x, y, xi_lobe, xi_roulette] = context.sampler.next_group();
        let xi = DVec2::new(x, y);
        let weights =
            self.origin.as_ref().map_or_else(|| first(context, &hit, ray.direction), |origin| origin.weights);
        if !vertex.is_delta() {
            let [x, y, xi_light, _] = context.sampler.next_group();
            let sampled = sampled(context, &vertex, &weights, xi_light, DVec2::new(x, y));
            let throughput = self.throughput;
            self.sampled =
                sampled.map(|sampled| SampledLight { light: throughput * sampled.light, ..sampled });
        }
        let scattered = vertex.sample(xi, xi_lobe)?;
        self.throughput *= scattered.weight;
        self.eta_scale *= scattered.eta_scale;
        if self.depth >= ROULETTE_FROM {
            self.throughput *= roulette(self.throughput * self.eta_scale, xi_roulette)?;
        }
        self.differential = vertex.differential(&scattered);
        let weights = passed(&weights, &vertex, &scattered);
        let from = vertex.light_sample_context(vertex.at.wo);
        self.origin = Some(CameraPathRay { from, pdf: scattered.pdf, weights });
        Some(hit.spawn(scattered.direction))
    }
}

impl<'a> BatchedPath<[Context<'a>]> for CameraPath {
    fn ray(&self) -> Option<Ray> {
        self.ray
    }

    fn advance(&mut self, contexts: &mut [Context<'a>], hit: Option<&SceneHit>, _: &mut Vec<Self>) {
        let context = &mut contexts[self.sample];
        context.counters.closest += 1;
        self.ray = self.ray.take().and_then(|ray| self.next_ray(context, &ray, hit));
    }

    fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
        rays.extend(self.sampled.as_ref().map(|sampled| sampled.shadow));
    }

    fn complete_vertex(&mut self, contexts: &mut [Context<'a>], occluded: &[bool]) {
        let Some(SampledLight { light, .. }) = self.sampled.take() else { return };
        contexts[self.sample].counters.shadow += 1;
        if occluded == [false] {
            self.light += light;
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
fn escaped(context: &Context<'_>, ray: &Ray, origin: Option<&CameraPathRay>) -> Spectrum {
    let scene = context.scene;
    let lights = scene.infinite_lights().iter();
    lights
        .map(|&id| {
            let sampled =
                |origin: &CameraPathRay| scene.compensated_infinite_pdf(id, &origin.from, ray.direction).0;
            context.infinite_radiance(id, ray)
                * weight_of_hit(context, id, origin, ray.direction, None, sampled) as f32
        })
        .sum()
}

/// Light emitted by the surface at `hit`.
fn emitted(context: &Context<'_>, hit: &Interaction, origin: Option<&CameraPathRay>) -> Spectrum {
    let Some(id) = hit.light() else { return Spectrum::BLACK };
    let emitted = context.emitted(hit);
    if emitted.is_black() {
        return emitted;
    }
    let sampled = |origin: &CameraPathRay| context.scene.light_pdf(id, &origin.from, hit).0;
    emitted * weight_of_hit(context, id, origin, -hit.wo, hit.area_pdf(), sampled) as f32
}

/// Weight of hitting the light `id` in the unit direction `wi`. `area_pdf`: area density of the hit point; `sampled`: density of light sampling.
fn weight_of_hit(
    context: &Context<'_>,
    id: LightId,
    origin: Option<&CameraPathRay>,
    wi: DVec3,
    area_pdf: Option<AreaPdf>,
    sampled: impl FnOnce(&CameraPathRay) -> f64,
) -> f64 {
    let Some(origin) = origin else { return 1.0 };
    let probability = context.scene.light_probability(id, &origin.from);
    let emission = context.scene.emitter_probability(id)
        * context.scene.emission_pdf(id, origin.from.position, wi, area_pdf);
    origin.weights.weight_of_hit(emission, probability * sampled(origin), origin.pdf)
}

/// Direct light of one randomly selected light.
fn sampled(
    context: &Context<'_>,
    vertex: &Vertex<'_>,
    weights: &CameraPathWeights,
    xi_light: f64,
    xi: DVec2,
) -> Option<SampledLight> {
    let scene = context.scene;
    let from = vertex.light_sample_context(vertex.at.wo);
    let SelectedLight { id, probability, .. } = scene.select_light(&from, xi_light)?;
    let sample = scene.sample_light_compensated(id, vertex.at, xi)?;
    let (value, light_pdf) = vertex.eval(sample.wi);
    let light = value * context.light_at(id, sample.radiance);
    if light.is_black() {
        return None;
    }
    let position = vertex.at.point.position;
    let emission =
        scene.emitter_probability(id) * scene.emission_pdf(id, position, sample.wi, sample.area_pdf);
    let density = probability * sample.pdf.0;
    let turn = turn(vertex, sample.wi, vertex.at.wo, light_pdf);
    let weight = weights.weight_of_sampled(&turn, emission, density, sample.is_delta);
    let shadow = BoundedRay::new(sample.shadow, sample.t_max);
    Some(SampledLight { shadow, light: light * (weight / density) as f32 })
}
