//! The way of light from lamps: particles that carry flux.
//!
//! A particle leaves a lamp with a share of its power and goes on from surface to surface, losing what they absorb. What it
//! brings to a place is flux, so that the mean over many particles is the flux there, whatever is counted.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::Ray;
use glanz_sampling::PixelSampler;
use glanz_scene::{Interaction, ParametricPoint, Scene};

use crate::integrator::{Counters, INTERFACE_LIMIT, Vertex};

/// Share of its first power below which a particle may end by chance. Survivors have this share again, so that no particle takes
/// long to bring little.
const ROULETTE_BELOW: f32 = 0.1;

/// Dimensions of the sampler before the first event: direction and place on the lamp in one group, the choice of the lamp in the next.
const EMISSION_DIMENSIONS: u32 = 4;
const FIRST_EVENT_DIMENSION: u32 = EMISSION_DIMENSIONS + 8;

/// Dimensions per event: direction, lobe, survival.
const DIMENSIONS_PER_EVENT: u32 = 4;

/// A particle that meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a> {
    /// The surface, seen from where the particle comes from.
    pub at: &'a Interaction,
    /// The place by parameters.
    pub place: ParametricPoint,
    /// Flux that arrives, W.
    pub arrived: Spectrum,
    /// Flux that goes on, W. All of it at mere borders; on average over many particles what the surface scatters.
    pub left: Spectrum,
}

/// Fate of a particle.
#[derive(Clone, Copy, Debug)]
pub enum ParticleFate {
    /// In a surface.
    Absorbed,
    /// It left the scene along `ray` with `power`, W.
    Escaped {
        /// Its last way.
        ray: Ray,
        /// Its power, W.
        power: Spectrum,
    },
    /// It had met as many surfaces as it may, and still carried this, W.
    GivenUp(Spectrum),
}

/// The whole way of a particle.
#[derive(Clone, Copy, Debug)]
pub struct ParticlePath {
    /// Initial power, W.
    pub emitted: Spectrum,
    /// Power lost on the way from a light that [fades](glanz_scene::LightRay::attenuation), W.
    pub faded: Spectrum,
    /// Its fate.
    pub end: ParticleFate,
    /// Surfaces met.
    pub events: u32,
}

/// Sends one particle from a lamp picked by power, and tells `visit` of every surface it meets.
///
/// The mean of [`ParticlePath::emitted`] over many particles is the power of all lamps that can send particles; a lamp may send
/// nothing where it is black, which counts as a particle without power (`None`). `sampler`: the numbers of this particle.
/// `max_events`: surfaces at most at which it is scattered. In `Arrival`, `arrived` of one surface is `left` of the one before,
/// so what is emitted, absorbed, escaped and given up adds up but for roundings.
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
    let (mut way, mut interfaces) = (0.0, 0);
    loop {
        counters.closest += 1;
        let Some((at, place)) = scene.intersect_parametric(&ray, f64::INFINITY) else {
            flight.end = ParticleFate::Escaped { ray, power };
            return Some(flight);
        };
        if flight.events == 0 {
            way += at.t;
            let left = start.attenuation(way);
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

/// Power that survives Russian roulette: all of `power`, or if that is below `threshold`, either that much of the same colour or nothing.
fn survivor(power: Spectrum, threshold: f32, xi: f64) -> Spectrum {
    let brightest = power.max_component();
    if brightest >= threshold || !power.is_finite() {
        return if power.is_finite() { power } else { Spectrum::BLACK };
    }
    let survival = brightest / threshold;
    if xi < f64::from(survival) { power * (1.0 / survival) } else { Spectrum::BLACK }
}
