//! Particles that carry flux from the lights.
//!
//! A particle leaves a light with a part of its power and continues from surface to surface, losing the absorbed part. It
//! carries flux, so that the mean over many particles is the incident flux of any surface.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::Ray;
use glanz_sampling::PixelSampler;
use glanz_scene::{Interaction, ParametricPoint, Scene};

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
#[derive(Clone, Copy, Debug)]
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
#[derive(Clone, Copy, Debug)]
pub struct ParticlePath {
    /// Initial power, W.
    pub emitted: Spectrum,
    /// Power lost by the [attenuation](glanz_scene::LightRay::attenuation) of its light, W.
    pub faded: Spectrum,
    /// Its fate.
    pub end: ParticleFate,
    /// Number of surfaces hit.
    pub events: u32,
}

/// Traces one particle from a light selected by power, and calls `visit` for every surface that it hits.
///
/// The mean of [`ParticlePath::emitted`] over many particles is the power of all lights that can emit particles; where a light is
/// black, the particle has no power (`None`). `sampler`: the numbers of this particle.
/// `max_events`: largest number of scattering events. In `Arrival`, `arrived` of one surface is `left` of the one before,
/// so that emitted, absorbed, escaped and abandoned flux balance up to rounding.
pub fn send_particle(
    scene: &Scene,
    mut sampler: PixelSampler,
    max_events: u32,
    counters: &mut Counters,
    mut visit: impl FnMut(&Arrival<'_>),
) -> Option<ParticlePath> {
    let wavelengths = Wavelengths::default();
    sampler.skip_to_dimension(EMISSION_DIMENSIONS);
    let (xi_direction, xi_place) = (sampler.next_2d(), sampler.next_2d());
    let (id, probability) = scene.select_emitter(sampler.next_1d()).filter(|&(_, p)| p > 0.0)?;
    let start = scene.emit(id, xi_place, xi_direction)?;
    let emitted = start.power * (1.0 / probability) as f32;
    let threshold = ROULETTE_BELOW * emitted.max_component();
    let mut flight = ParticlePath { emitted, faded: Spectrum::BLACK, end: ParticleFate::Absorbed, events: 0 };
    let (mut ray, mut power) = (start.ray, emitted);
    let (mut distance, mut interfaces) = (0.0, 0);
    loop {
        counters.closest += 1;
        let Some((at, place)) = scene.intersect_parametric(&ray, f64::INFINITY) else {
            flight.end = ParticleFate::Escaped { ray, power };
            return Some(flight);
        };
        if flight.events == 0 {
            distance += at.t;
            let left = start.attenuation(distance);
            if left < 1.0 {
                let arriving = emitted * left;
                flight.faded = emitted - arriving;
                power = arriving;
            }
        }
        let Some(bsdf) = at.bsdf(scene, &wavelengths) else {
            visit(&Arrival { at: &at, place, arrived: power, left: power });
            interfaces += 1;
            if interfaces > INTERFACE_LIMIT {
                flight.end = ParticleFate::GivenUp(power);
                return Some(flight);
            }
            ray = at.spawn(ray.direction);
            continue;
        };
        interfaces = 0;
        if flight.events >= max_events {
            flight.end = ParticleFate::GivenUp(power);
            return Some(flight);
        }
        sampler.skip_to_dimension(
            FIRST_EVENT_DIMENSION.wrapping_add(DIMENSIONS_PER_EVENT.wrapping_mul(flight.events)),
        );
        flight.events += 1;
        let (xi, xi_lobe, xi_survival) = (sampler.next_2d(), sampler.next_1d(), sampler.next_1d());
        let vertex = Vertex::new(&at, bsdf);
        let scattered = vertex.sample_flux(xi, xi_lobe);
        let left = scattered.map_or(Spectrum::BLACK, |s| survivor(power * s.weight, threshold, xi_survival));
        visit(&Arrival { at: &at, place, arrived: power, left });
        let Some(scattered) = scattered.filter(|_| !left.is_black()) else { return Some(flight) };
        power = left;
        ray = at.spawn(scattered.direction);
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
