//! Particles that carry flux from the lights.
//!
//! A particle leaves a light with a part of its power and continues from surface to surface, losing the absorbed part. It
//! carries flux, so that the mean over many particles is the incident flux of any surface.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::PixelSampler;
use glanz_scene::{
    BatchedPath, HitLocation, Interaction, LightId, LightRange, LightRay, ParametricPoint, Scene, SceneHit,
};
use glanz_shading::Bsdf;

use crate::integrator::{Counters, INTERFACE_LIMIT, ScatteredRay, Vertex};

/// Fraction of its initial power below which a particle is subject to Russian roulette. Survivors have this fraction again, so that no time is spent on
/// particles of little power.
const ROULETTE_BELOW: f32 = 0.1;

/// Dimensions of the sampler before the first event: direction and position on the light in one group, the selection of the light in the next.
const EMISSION_DIMENSIONS: u32 = 4;
const SELECTION_DIMENSION: u32 = EMISSION_DIMENSIONS + 4;
const FIRST_EVENT_DIMENSION: u32 = EMISSION_DIMENSIONS + 8;

/// Dimensions per event: direction, lobe, survival.
const DIMENSIONS_PER_EVENT: u32 = 4;

/// Arrival of a particle at a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The location of the hit.
    pub at: HitLocation,
    /// Incident flux, W.
    pub arrived: Spectrum,
    /// Flux of the continuing particle, W: all of it at interfaces; elsewhere its mean over many particles is the scattered flux.
    pub left: Spectrum,
    /// The light that it comes from.
    pub light: LightId,
    /// Its way from there.
    pub route: LightRoute,
    /// Length of its way from there to the surface that scattered it first, or to this one, metres.
    pub distance: f64,
}

/// The way of light from its source, by the scattering event that is nearest to the source. Interfaces do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightRoute {
    /// Not scattered.
    Direct,
    /// Reflected once, by a delta lobe of a surface.
    Mirrored {
        /// Number of the surface.
        surface: u32,
        /// The face.
        face: u32,
    },
    /// First scattered by a delta lobe or by a surface with a finish, but not only [mirrored](LightRoute::Mirrored).
    Specular,
    /// First scattered by another lobe.
    Scattered,
}

impl LightRoute {
    /// The route after another scattering event. `is_delta`: whether its lobe is a delta lobe, or the surface has a finish; `mirror`: the place, if it is a reflection.
    fn after(self, is_delta: bool, mirror: Option<&ParametricPoint>) -> Self {
        match (self, mirror) {
            (Self::Scattered, _) => Self::Scattered,
            (Self::Direct, _) if !is_delta => Self::Scattered,
            (Self::Direct, Some(&ParametricPoint { surface, face, .. })) => Self::Mirrored { surface, face },
            _ => Self::Specular,
        }
    }
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
    /// Number of surfaces that scattered or absorbed it.
    pub events: u32,
}

/// Tracer of particles from lights selected by power.
///
/// The mean of [`ParticlePath::emitted`] over many particles is the power of all lights that can emit particles. In [`Arrival`], `arrived`
/// of one surface is `left` of the one before, so that emitted, absorbed, escaped and abandoned flux balance up to rounding.
pub struct ParticleTracer<'a> {
    scene: &'a Scene,
    wavelengths: Wavelengths,
    /// Largest number of scattering events of a particle.
    max_events: u32,
    // Memory of the particles that were traced last.
    /// Numbers for direction and position on the light of each particle, in [0, 1).
    emission_numbers: Vec<[f64; 4]>,
    particles: Vec<ParticleState>,
}

impl<'a> ParticleTracer<'a> {
    /// A tracer of particles that are scattered up to `max_events` times.
    #[must_use]
    pub fn new(scene: &'a Scene, max_events: u32) -> Self {
        let (emission_numbers, particles) = (Vec::new(), Vec::new());
        Self { scene, wavelengths: Wavelengths::default(), max_events, emission_numbers, particles }
    }

    /// Traces `count` particles, by the sample of `first` and those after it, and calls `visit` with the number of a particle for every
    /// surface that it hits.
    ///
    /// All particles advance from surface to surface together, so that their rays are traced as batches; a thousand are a good number. The
    /// path of a particle does not depend on the others, and its surfaces are visited in their order. Indices of samples wrap after 2^32 - 1;
    /// the dimension of `first` does not matter. Memory is proportional to `count`.
    pub fn trace(
        &mut self,
        first: PixelSampler,
        count: u32,
        counters: &mut Counters,
        visit: impl FnMut(usize, &Arrival),
    ) {
        let Self { scene, wavelengths, max_events, emission_numbers, particles } = self;
        let (scene, max_events) = (*scene, *max_events);
        let mut traced = TracedParticles { scene, wavelengths, max_events, first, counters, visit };
        let only = scene.only_emitter();
        let select = |particle: u32| match only {
            Some(id) => Some((id, 1.0)),
            None => scene.select_emitter(traced.sampler(particle, SELECTION_DIMENSION).next_1d()),
        };
        traced.sampler(0, EMISSION_DIMENSIONS).groups_of_samples(count, emission_numbers);
        particles.clear();
        particles.extend(
            (0..)
                .zip(&*emission_numbers)
                .map(|(i, &numbers)| ParticleState::emitted(scene, i, select(i), numbers)),
        );
        scene.trace_paths(particles, &mut traced);
    }

    /// Paths of the particles that were traced last; `None` where a light is black, so that the particle has no power.
    pub fn paths(&self) -> impl Iterator<Item = Option<ParticlePath>> {
        self.particles.iter().map(ParticleState::path)
    }
}

/// Data shared by particles that are traced together.
struct TracedParticles<'a, V> {
    scene: &'a Scene,
    wavelengths: &'a Wavelengths,
    max_events: u32,
    /// The sampler of the first particle.
    first: PixelSampler,
    counters: &'a mut Counters,
    visit: V,
}

impl<V> TracedParticles<'_, V> {
    /// The sampler of a particle, continued at `dimension`.
    fn sampler(&self, particle: u32, dimension: u32) -> PixelSampler {
        let mut sampler = self.first.with_index(self.first.sample_index().wrapping_add(particle));
        sampler.skip_to_dimension(dimension);
        sampler
    }
}

/// Whether a particle is under way, or how it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ParticleStatus {
    /// Its light is black.
    NotEmitted,
    Active,
    Absorbed,
    Escaped,
    GivenUp,
}

/// State of a particle between its surfaces.
struct ParticleState {
    /// Its position among the particles that are traced together.
    number: u32,
    /// The last ray.
    ray: Ray,
    /// Initial power, W.
    emitted: Spectrum,
    /// Its power, W.
    power: Spectrum,
    /// Power lost by the attenuation of its light, W.
    faded: Spectrum,
    /// The range of its light, and its distance from it until it is scattered first, metres.
    range: LightRange,
    distance: f64,
    /// Interfaces since it was last scattered.
    interfaces: u32,
    /// Number of surfaces that scattered or absorbed it.
    events: u32,
    light: LightId,
    route: LightRoute,
    status: ParticleStatus,
}

impl ParticleState {
    /// A particle that leaves a light, selected with a probability.
    #[inline]
    fn emitted(scene: &Scene, number: u32, selected: Option<(LightId, f64)>, [x, y, u, v]: [f64; 4]) -> Self {
        let (xi_direction, xi_place) = (DVec2::new(x, y), DVec2::new(u, v));
        let selected = selected.filter(|&(_, p)| p > 0.0);
        let emission = selected.and_then(|(id, p)| Some((scene.emit(id, xi_place, xi_direction)?, p)));
        let mut state = Self {
            number,
            ray: Ray::new(DVec3::ZERO, DVec3::Z),
            emitted: Spectrum::BLACK,
            power: Spectrum::BLACK,
            faded: Spectrum::BLACK,
            range: LightRange::default(),
            distance: 0.0,
            interfaces: 0,
            events: 0,
            light: selected.map_or(LightId(0), |(id, _)| id),
            route: LightRoute::Direct,
            status: ParticleStatus::NotEmitted,
        };
        if let Some((LightRay { ray, power, range, .. }, probability)) = emission {
            let power = power * (1.0 / probability) as f32;
            (state.ray, state.emitted, state.power, state.range) = (ray, power, power, range);
            state.status = ParticleStatus::Active;
        }
        state
    }

    fn path(&self) -> Option<ParticlePath> {
        let Self { ray, emitted, power, faded, events, .. } = *self;
        let end = match self.status {
            ParticleStatus::NotEmitted => return None,
            // None is active after a trace.
            ParticleStatus::Active | ParticleStatus::Absorbed => ParticleFate::Absorbed,
            ParticleStatus::Escaped => ParticleFate::Escaped { ray, power },
            ParticleStatus::GivenUp => ParticleFate::GivenUp(power),
        };
        Some(ParticlePath { emitted, faded, end, events })
    }

    /// Ends at a hit on a surface that absorbs all light.
    fn end_at<V: FnMut(usize, &Arrival)>(
        &mut self,
        traced: &mut TracedParticles<'_, V>,
        hit: &SceneHit,
    ) -> ParticleStatus {
        if self.events == 0 {
            self.fade(hit.t());
        }
        if self.events >= traced.max_events {
            return ParticleStatus::GivenUp;
        }
        self.events += 1;
        let at = traced.scene.hit_location(&self.ray, hit);
        (traced.visit)(self.number as usize, &self.arrival(at, Spectrum::BLACK));
        ParticleStatus::Absorbed
    }

    /// Its arrival at a location, from which `left` continues.
    fn arrival(&self, at: HitLocation, left: Spectrum) -> Arrival {
        let Self { power: arrived, light, route, distance, .. } = *self;
        Arrival { at, arrived, left, light, route, distance }
    }

    /// Continues from the hit of the ray.
    fn continue_at<V: FnMut(usize, &Arrival)>(
        &mut self,
        traced: &mut TracedParticles<'_, V>,
        hit: &SceneHit,
    ) -> ParticleStatus {
        let (scene, number) = (traced.scene, self.number as usize);
        let at = scene.interaction(&self.ray, hit);
        let location = HitLocation::new(&at, scene.parametric_point(hit, &at));
        if self.events == 0 {
            self.fade(at.t);
        }
        let Some(bsdf) = at.bsdf(scene, traced.wavelengths) else {
            (traced.visit)(number, &self.arrival(location, self.power));
            self.interfaces += 1;
            if self.interfaces > INTERFACE_LIMIT {
                return ParticleStatus::GivenUp;
            }
            self.ray = at.spawn(self.ray.direction);
            return ParticleStatus::Active;
        };
        self.interfaces = 0;
        if self.events >= traced.max_events {
            return ParticleStatus::GivenUp;
        }
        let has_finish = bsdf.has_finish();
        let scattered = self.scatter(traced, &at, bsdf);
        let left = scattered.map_or(Spectrum::BLACK, |(_, left)| left);
        (traced.visit)(number, &self.arrival(location, left));
        let Some((ScatteredRay { direction, is_delta, .. }, left)) = scattered.filter(|_| !left.is_black())
        else {
            return ParticleStatus::Absorbed;
        };
        let reflects = at.point.normal.dot(direction) * at.point.normal.dot(at.wo) > 0.0;
        self.route =
            self.route.after(is_delta || has_finish, (is_delta && reflects).then_some(&location.place));
        self.power = left;
        self.ray = at.spawn(direction);
        ParticleStatus::Active
    }

    /// Applies the attenuation of the light over the distance `t`, metres, of the ray.
    fn fade(&mut self, t: f64) {
        self.distance += t;
        let left = self.range.attenuation(self.distance);
        if left < 1.0 {
            self.power = self.emitted * left;
            self.faded = self.emitted - self.power;
        }
    }

    /// Samples the direction in which the particle continues, and its power after Russian roulette; `None` if it is absorbed.
    fn scatter<V>(
        &mut self,
        traced: &TracedParticles<'_, V>,
        at: &Interaction,
        bsdf: Bsdf<'_>,
    ) -> Option<(ScatteredRay, Spectrum)> {
        let event = self.events;
        self.events += 1;
        if matches!(bsdf, Bsdf::Black) {
            return None;
        }
        let dimension = FIRST_EVENT_DIMENSION.wrapping_add(DIMENSIONS_PER_EVENT.wrapping_mul(event));
        let [x, y, xi_lobe, xi_survival] = traced.sampler(self.number, dimension).next_group();
        let scattered = Vertex::new(at, bsdf).sample_flux(DVec2::new(x, y), xi_lobe)?;
        let threshold = ROULETTE_BELOW * self.emitted.max_component();
        let left = survivor(self.power * scattered.weight, threshold, xi_survival);
        Some((scattered, left))
    }
}

impl<V: FnMut(usize, &Arrival)> BatchedPath<TracedParticles<'_, V>> for ParticleState {
    fn ray(&self) -> Option<Ray> {
        (self.status == ParticleStatus::Active).then_some(self.ray)
    }

    fn advance(&mut self, traced: &mut TracedParticles<'_, V>, hit: Option<&SceneHit>, _: &mut Vec<Self>) {
        traced.counters.closest += 1;
        self.status = match hit {
            None => ParticleStatus::Escaped,
            Some(hit) if traced.scene.hit_material(hit).absorbs_all() => self.end_at(traced, hit),
            Some(hit) => self.continue_at(traced, hit),
        };
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
