//! Particles that carry flux from the lights.
//!
//! A particle leaves a light with a part of its power and continues from surface to surface, losing the absorbed part. It
//! carries flux, so that the mean over many particles is the incident flux of any surface.

use glanz_geometry::BoundedRay;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::PixelSampler;
use glanz_scene::{Interaction, LightRange, LightRay, ParametricPoint, Scene, SceneHit};
use glanz_shading::Bsdf;

use crate::integrator::{Counters, INTERFACE_LIMIT, Vertex};

/// Fraction of its initial power below which a particle is subject to Russian roulette. Survivors have this fraction again, so that no time is spent on
/// particles of little power.
const ROULETTE_BELOW: f32 = 0.1;

/// Dimensions of the sampler before the first event: direction and position on the light in one group, the selection of the light in the next.
const EMISSION_DIMENSIONS: u32 = 4;
const FIRST_EVENT_DIMENSION: u32 = EMISSION_DIMENSIONS + 8;

/// Dimensions per event: direction, lobe, survival.
const DIMENSIONS_PER_EVENT: u32 = 4;

/// Arrival of a particle at a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a> {
    /// The hit, with `wo` towards the origin of the particle.
    pub at: &'a Interaction,
    /// The parameters of the hit.
    pub place: ParametricPoint,
    /// Incident flux, W.
    pub arrived: Spectrum,
    /// Flux of the continuing particle, W: all of it at interfaces; elsewhere its mean over many particles is the scattered flux.
    pub left: Spectrum,
}

/// Fate of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParticleFate {
    /// Absorbed by a surface.
    Absorbed,
    /// Left the scene along `ray` with `power`, W.
    Escaped {
        /// Its last ray.
        ray: Ray,
        /// Its power, W.
        power: Spectrum,
    },
    /// Reached the largest number of surfaces with this power, W.
    GivenUp(Spectrum),
}

/// The path of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticlePath {
    /// Initial power, W.
    pub emitted: Spectrum,
    /// Power lost by the [attenuation](glanz_scene::LightRange::attenuation) of its light, W.
    pub faded: Spectrum,
    /// Its fate.
    pub end: ParticleFate,
    /// Number of surfaces hit.
    pub events: u32,
}

/// Tracer of particles from lights selected by power.
///
/// The mean of [`ParticlePath::emitted`] over many particles is the power of all lights that can emit particles. In [`Arrival`], `arrived`
/// of one surface is `left` of the one before, so that emitted, absorbed, escaped and abandoned flux balance up to rounding.
pub struct ParticleTracer<'a> {
    scene: &'a Scene,
    /// Largest number of scattering events of a particle.
    max_events: u32,
    // Memory of the particles that were traced last.
    particles: Vec<Option<ParticleState>>,
    active: Vec<u32>,
    rays: Vec<BoundedRay>,
    hits: Vec<Option<SceneHit>>,
}

impl<'a> ParticleTracer<'a> {
    /// A tracer of particles that are scattered up to `max_events` times.
    #[must_use]
    pub fn new(scene: &'a Scene, max_events: u32) -> Self {
        let (particles, active, rays, hits) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { scene, max_events, particles, active, rays, hits }
    }

    /// Traces one particle for each sampler, and calls `visit` with the index of a particle for every surface that it hits.
    ///
    /// All particles advance from surface to surface together, so that their rays are traced as batches; a thousand are a good number. The
    /// path of a particle does not depend on the others, and its surfaces are visited in their order.
    pub fn trace(
        &mut self,
        samplers: impl Iterator<Item = PixelSampler>,
        counters: &mut Counters,
        mut visit: impl FnMut(usize, &Arrival<'_>),
    ) {
        let Self { scene, max_events, particles, active, rays, hits } = self;
        let wavelengths = Wavelengths::default();
        particles.clear();
        particles.extend(samplers.map(|sampler| ParticleState::emitted(scene, sampler)));
        active.clear();
        active.extend(
            (0..).zip(&*particles).filter(|(_, particle)| particle.is_some()).map(|(index, _)| index),
        );
        while !active.is_empty() {
            counters.closest += active.len() as u64;
            rays.clear();
            let states = active.iter().filter_map(|&index| particles[index as usize].as_ref());
            rays.extend(states.map(|particle| BoundedRay::from(particle.ray)));
            scene.closest_batch(rays, hits);
            let mut hits = hits.iter();
            active.retain(|&index| {
                let index = index as usize;
                let (Some(particle), Some(hit)) = (&mut particles[index], hits.next()) else { return false };
                let mut visit = |arrival: &Arrival<'_>| visit(index, arrival);
                particle.advance(scene, &wavelengths, *max_events, hit.as_ref(), &mut visit)
            });
        }
    }

    /// Paths of the particles that were traced last; `None` where a light is black, so that the particle has no power.
    pub fn paths(&self) -> impl Iterator<Item = Option<&ParticlePath>> {
        self.particles.iter().map(|particle| particle.as_ref().map(|particle| &particle.path))
    }
}

/// State of a particle between its surfaces.
struct ParticleState {
    sampler: PixelSampler,
    ray: Ray,
    /// Its power, W.
    power: Spectrum,
    /// Power below which it is subject to Russian roulette.
    threshold: f32,
    /// The range of its light, and its distance from it until it is scattered first, metres.
    range: LightRange,
    distance: f64,
    /// Interfaces since it was last scattered.
    interfaces: u32,
    path: ParticlePath,
}

impl ParticleState {
    /// A particle that leaves a light; `None` where the light is black.
    fn emitted(scene: &Scene, mut sampler: PixelSampler) -> Option<Self> {
        sampler.skip_to_dimension(EMISSION_DIMENSIONS);
        let [x, y, u, v] = sampler.next_group();
        let (xi_direction, xi_place) = (DVec2::new(x, y), DVec2::new(u, v));
        let (id, probability) = scene.select_emitter(sampler.next_1d()).filter(|&(_, p)| p > 0.0)?;
        let LightRay { ray, power, range, .. } = scene.emit(id, xi_place, xi_direction)?;
        let emitted = power * (1.0 / probability) as f32;
        Some(Self {
            sampler,
            ray,
            power: emitted,
            threshold: ROULETTE_BELOW * emitted.max_component(),
            range,
            distance: 0.0,
            interfaces: 0,
            path: ParticlePath { emitted, faded: Spectrum::BLACK, end: ParticleFate::Absorbed, events: 0 },
        })
    }

    /// Continues from the hit of the ray. Returns whether the particle has another ray.
    fn advance(
        &mut self,
        scene: &Scene,
        wavelengths: &Wavelengths,
        max_events: u32,
        hit: Option<&SceneHit>,
        visit: &mut impl FnMut(&Arrival<'_>),
    ) -> bool {
        let Some(hit) = hit else {
            self.path.end = ParticleFate::Escaped { ray: self.ray, power: self.power };
            return false;
        };
        let at = scene.interaction(&self.ray, hit);
        let place = scene.parametric_point(hit, &at);
        if self.path.events == 0 {
            self.fade(at.t);
        }
        let arrived = self.power;
        let Some(bsdf) = at.bsdf(scene, wavelengths) else {
            visit(&Arrival { at: &at, place, arrived, left: arrived });
            self.interfaces += 1;
            if self.interfaces > INTERFACE_LIMIT {
                self.path.end = ParticleFate::GivenUp(arrived);
                return false;
            }
            self.ray = at.spawn(self.ray.direction);
            return true;
        };
        self.interfaces = 0;
        if self.path.events >= max_events {
            self.path.end = ParticleFate::GivenUp(arrived);
            return false;
        }
        let scattered = self.scatter(&at, bsdf);
        let left = scattered.map_or(Spectrum::BLACK, |(_, left)| left);
        visit(&Arrival { at: &at, place, arrived, left });
        let Some((direction, left)) = scattered.filter(|_| !left.is_black()) else { return false };
        self.power = left;
        self.ray = at.spawn(direction);
        true
    }

    /// Applies the attenuation of the light over the distance `t`, metres, of the ray.
    fn fade(&mut self, t: f64) {
        self.distance += t;
        let left = self.range.attenuation(self.distance);
        if left < 1.0 {
            self.power = self.path.emitted * left;
            self.path.faded = self.path.emitted - self.power;
        }
    }

    /// Samples the direction in which the particle continues, and its power after Russian roulette; `None` if it is absorbed.
    fn scatter(&mut self, at: &Interaction, bsdf: Bsdf) -> Option<(DVec3, Spectrum)> {
        let event = self.path.events;
        self.path.events += 1;
        if matches!(bsdf, Bsdf::Black) {
            return None;
        }
        self.sampler
            .skip_to_dimension(FIRST_EVENT_DIMENSION.wrapping_add(DIMENSIONS_PER_EVENT.wrapping_mul(event)));
        let [x, y, xi_lobe, xi_survival] = self.sampler.next_group();
        let scattered = Vertex::new(at, bsdf).sample_flux(DVec2::new(x, y), xi_lobe)?;
        Some((scattered.direction, survivor(self.power * scattered.weight, self.threshold, xi_survival)))
    }
}

/// Power after Russian roulette: `power` itself, or if it is below `threshold`, either that amount with the same colour or nothing.
fn survivor(power: Spectrum, threshold: f32, xi: f64) -> Spectrum {
    let brightest = power.max_component();
    if brightest >= threshold || !power.is_finite() {
        return if power.is_finite() { power } else { Spectrum::BLACK };
    }
    let survival = brightest / threshold;
    if xi < f64::from(survival) { power * (1.0 / survival) } else { Spectrum::BLACK }
}
