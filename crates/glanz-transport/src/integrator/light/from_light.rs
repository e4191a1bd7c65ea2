//! Paths from a light.

use glanz_geometry::BoundedRay;
use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_scene::{BatchedPath, Light, LightId, LightRay, LightSampleContext, SceneHit};

use super::weights::LightPathWeights;
use super::{LightPaths, turn};
use crate::integrator::path_tracer::{DIMENSIONS_PER_EVENT, ROULETTE_FROM};
use crate::integrator::vertex::{Vertex, carried, pass_interface, roulette};
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
        let mut light = scene.emit(id, place, direction)?;
        light.power = context.light_at(id, light.power);
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
        scene.light_probability(self.id, seen) * scene.light_pdf_of_ray(self.id, seen, &self.light).0
    }
}

impl LightPaths {
    /// Traces one path from a light for each sample and splats its connections to the camera.
    pub(super) fn send(&self, contexts: &mut [Context<'_>]) {
        let Some(scene) = contexts.first().map(|context| context.scene) else { return };
        let new = |(sample, context): (usize, &mut _)| LightPath::new(context, sample, self.max_depth);
        let mut paths: Vec<_> = contexts.iter_mut().enumerate().filter_map(new).collect();
        scene.trace_paths(&mut paths, contexts);
    }
}

/// State of a path from a light.
struct LightPath {
    /// Position of its sample in the batch.
    sample: usize,
    max_depth: u32,
    start: LightPathStart,
    /// `None` if it has ended.
    ray: Option<Ray>,
    flux: Spectrum,
    /// Factor on the flux since the light.
    left: Spectrum,
    /// Whether the hero of its wavelengths is left alone.
    is_dispersed: bool,
    /// `None` before the first vertex.
    weights: Option<LightPathWeights>,
    depth: u32,
    interfaces: u32,
    connection: Option<CameraConnection>,
}

/// Connection of a vertex to the camera, whose shadow ray is to be traced.
struct CameraConnection {
    shadow: BoundedRay,
    /// Position on the film, pixels.
    film: DVec2,
    light: Spectrum,
    xi_pixel: f64,
}

impl LightPath {
    /// `None` where there is nothing to trace.
    fn new(context: &mut Context<'_>, sample: usize, max_depth: u32) -> Option<Self> {
        if context.light_paths() <= 0.0 || max_depth == 0 {
            return None;
        }
        let start = LightPathStart::pick(context)?;
        Some(Self {
            sample,
            max_depth,
            ray: Some(start.light.ray),
            flux: start.light.power * (1.0 / start.probability) as f32,
            left: Spectrum::one(&context.wavelengths),
            is_dispersed: false,
            weights: None,
            depth: 0,
            interfaces: 0,
            connection: None,
            start,
        })
    }

    /// The ray that continues from the hit of `ray`; `None` if the path ends.
    fn next_ray(&mut self, context: &mut Context<'_>, ray: &Ray, hit: &SceneHit) -> Option<Ray> {
        let hit = context.scene.interaction(ray, hit);
        let Some(bsdf) = hit.bsdf(context.scene, &context.wavelengths) else {
            return pass_interface(&hit, ray.direction, &mut self.interfaces);
        };
        self.depth += 1;
        self.interfaces = 0;
        let vertex = Vertex::new(&hit, bsdf);
        vertex.disperse(&mut self.flux, &mut self.is_dispersed);
        let weights = match self.weights {
            Some(weights) => weights,
            None => {
                let distance = (hit.point.position - self.start.light.ray.origin).length();
                self.flux *= self.start.light.range.attenuation(distance);
                self.start.weights(context, &vertex)
            }
        };
        let dimension = FIRST_LIGHT_DIMENSION.wrapping_add(DIMENSIONS_PER_EVENT.wrapping_mul(self.depth));
        context.sampler.skip_to_dimension(dimension);
        let [x, y, xi_lobe, xi_roulette] = context.sampler.next_group();
        let xi = DVec2::new(x, y);
        let [x, y, xi_pixel, _] = context.sampler.next_group();
        if !vertex.is_delta() {
            self.connection = self.connect(context, &vertex, &weights, DVec2::new(x, y), xi_pixel);
        }
        let (direction, weight, next) = go_on(context, &vertex, &self.start, &weights, xi, xi_lobe)?;
        self.flux *= weight;
        self.left *= weight;
        self.weights = Some(next);
        if self.depth >= ROULETTE_FROM {
            let factor = roulette(carried(self.left, self.flux), xi_roulette)?;
            self.flux *= factor;
            self.left *= factor;
        }
        (self.depth < self.max_depth).then(|| hit.spawn(direction))
    }

    /// Connects `vertex`, at which the flux arrives, to a point of the lens.
    fn connect(
        &self,
        context: &Context<'_>,
        vertex: &Vertex<'_>,
        weights: &LightPathWeights,
        xi_lens: DVec2,
        xi_pixel: f64,
    ) -> Option<CameraConnection> {
        let (at, to_light) = (vertex.at, vertex.at.wo);
        let seen = context.scene.camera().project(at.point.position, xi_lens)?;
        let to_camera = (seen.origin - at.point.position).try_normalize()?;
        if !context.takes_splats_at(seen.film) {
            return None;
        }
        // The vertex for a viewer at the camera: both kinds of paths use the same BSDF.
        let seen_vertex = vertex.seen_from(to_camera);
        let (value, light_pdf) = seen_vertex.eval(to_light);
        let light = self.flux * value;
        if light.is_black() {
            return None;
        }
        let turn = turn(vertex, to_light, to_camera, light_pdf);
        let reference = seen_vertex.light_sample_context(to_camera);
        let sampled = || self.start.sampled(context, &reference);
        let weight = weights.weight_of_sent(&turn, seen.density, sampled);
        // `value` contains the cosine to the shading normal, as needed for incident radiance; flux already contains the geometric
        // cosine (@veach1997 section 5.3.2).
        let factor = seen.density * turn.camera_cos / turn.light_cos * weight;
        let shadow = BoundedRay::new(at.spawn_to(seen.origin, None), 1.0);
        Some(CameraConnection { shadow, film: seen.film, light: light * factor as f32, xi_pixel })
    }
}

impl<'a> BatchedPath<[Context<'a>]> for LightPath {
    fn ray(&self) -> Option<Ray> {
        self.ray
    }

    fn advance(&mut self, contexts: &mut [Context<'a>], hit: Option<&SceneHit>, _: &mut Vec<Self>) {
        let context = &mut contexts[self.sample];
        context.counters.closest += 1;
        self.ray = self.ray.take().zip(hit).and_then(|(ray, hit)| self.next_ray(context, &ray, hit));
    }

    fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
        rays.extend(self.connection.as_ref().map(|connection| connection.shadow));
    }

    fn complete_vertex(&mut self, contexts: &mut [Context<'a>], occluded: &[bool]) {
        let Some(CameraConnection { film, light, xi_pixel, .. }) = self.connection.take() else { return };
        let context = &mut contexts[self.sample];
        context.counters.shadow += 1;
        if occluded == [false] {
            context.splat(film, light, xi_pixel);
        }
    }
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
    let seen = vertex.seen_from(to_camera);
    let (value, light_pdf) = seen.eval(to_light);
    let turn = turn(vertex, to_light, to_camera, light_pdf);
    let factor = turn.camera_cos / (turn.light_cos * scattered.pdf);
    let reference = seen.light_sample_context(to_camera);
    let next = weights.scattered(&turn, || start.sampled(context, &reference));
    let weight = value * factor as f32;
    (weight.is_finite() && !weight.is_black()).then_some((to_camera, weight, next))
}
