//! Which method computes which part of the light.

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::{Light, LightId, Scene};
use glanz_transport::{Arrival, Counters, KnownLight, LightRoute, ParticleTracer};

use rayon::prelude::*;

use crate::integrate::Reflections;
use crate::lux_parts::IntegratedLux;
use crate::receiver::Receivers;

/// Particles that show how far from the lights their light arrives: they are traced by rounds until a few arrive from each light, or there are too many.
const PROBES: u32 = 1 << 16;
const FEW: usize = 256;
const MOST_ROUNDS: u32 = 16;
/// How many of them are traced together.
const BLOCK: u32 = 1 << 10;

/// Seed of these particles, beside those of calculations.
const PROBE_SEED: u64 = 0x6e65_6172;

/// Share of the flux of a light at distances that are far.
const FAR_FLUX: f64 = 0.25;

/// Relative distance beyond the last near surface: particles and paths that are at one distance up to rounding are on one side of the limit.
const BEYOND: f64 = 1e-3;

/// Largest mean square that is left to paths, over that of light which all arrives at a far distance.
const LARGEST_SQUARE: f64 = 30.0;

/// The methods that compute the light of a scene on its receivers, each of which has its part:
///
/// - integration ([`Reflections`]): light that arrives straight, or by one mirror, from lights whose form can be integrated, in cells where it converges;
/// - paths from points ([`IrradianceTracer`](glanz_transport::IrradianceTracer)): other light that arrives straight, and all light whose
///   first scattering event, counted from the light, is not by a delta lobe or a surface with a finish;
/// - particles ([`ParticleTracer`]): what remains, which paths from points find by chance at best: caustics, the light of sets of rays,
///   and the light of points on surfaces close to them, where irradiance has no limit.
#[derive(Debug)]
pub struct LightDivision<'a> {
    reflections: &'a Reflections<'a>,
    known: KnownLight,
    /// Beside what is integrated.
    known_to_particles: KnownLight,
    /// Lights that emit particles, but cannot be sampled from a point.
    only_particles: Vec<bool>,
    /// Whether any light may be left to particles.
    needs_particles: bool,
}

impl<'a> LightDivision<'a> {
    /// The division with what `reflections` integrates. By the threads of the current pool.
    #[must_use]
    pub fn new(scene: &Scene, receivers: &Receivers, reflections: &'a Reflections<'a>) -> Self {
        let ids = || (0..).map(LightId).take(scene.lights().len());
        let only_particles = |id| !scene.is_selectable(id) && scene.emitter_probability(id) > 0.0;
        let known = KnownLight {
            direct: ids().map(|id| reflections.integrates(id)).collect(),
            specular: ids().map(|id| scene.is_selectable(id)).collect(),
            near: near_distances(scene, receivers),
        };
        let known_to_particles = KnownLight { direct: Vec::new(), ..known.clone() };
        let only_particles: Vec<bool> = ids().map(only_particles).collect();
        let focuses =
            scene.materials().iter().any(|material| material.lobes().iter().any(|lobe| lobe.is_delta()));
        let is_near = known.near.iter().any(|near| *near > 0.0);
        let needs_particles = focuses || is_near || only_particles.contains(&true);
        Self { reflections, known, known_to_particles, only_particles, needs_particles }
    }

    /// Whether any light may be left to particles.
    pub(crate) fn needs_particles(&self) -> bool {
        self.needs_particles
    }

    /// What paths from the points of a cell leave out. `is_integrated`: whether the integration converged there.
    pub(crate) fn known(&self, is_integrated: bool) -> &KnownLight {
        if is_integrated { &self.known } else { &self.known_to_particles }
    }

    /// Whether the light of a particle that arrives in a cell has no other method. `is_integrated`: as for [`LightDivision::known`].
    pub(crate) fn is_by_particles(&self, arrival: &Arrival, is_integrated: bool) -> bool {
        if self.only_particles.get(arrival.light.0 as usize).copied().unwrap_or(false) {
            return true;
        }
        let number = arrival.light.0 as usize;
        let known = self.known(is_integrated);
        let is_near = known.near.get(number).is_some_and(|near| arrival.distance < *near);
        match arrival.route {
            LightRoute::Direct => is_near && !known.direct.get(number).copied().unwrap_or(false),
            LightRoute::Scattered => is_near,
            LightRoute::Mirrored { surface, face } => {
                !is_integrated || !self.reflections.integrates_mirrored(arrival.light, surface, face)
            }
            LightRoute::Specular => true,
        }
    }
}

/// For each light, the distance, metres, within which surfaces are too bright to be found by paths often enough; 0 without such surfaces.
///
/// By particles: the contributions of paths have a mean square in proportion to the sum of flux over squared distance, without bound for points that
/// touch a surface. By the threads of the current pool.
fn near_distances(scene: &Scene, receivers: &Receivers) -> Vec<f64> {
    let lights = scene.lights();
    let can_touch =
        |light: &Light| !light.can_be_hit() && light.can_be_sampled() && !matches!(light, Light::Distant(_));
    let can_touch: Vec<bool> = lights.iter().map(can_touch).collect();
    if !can_touch.contains(&true) {
        return vec![0.0; lights.len()];
    }
    let wavelengths = Wavelengths::default();
    let arrivals = |block: u32| {
        let mut last = vec![None; BLOCK as usize];
        let mut passed = Vec::new();
        let sampler = PixelSampler::new(SamplerKind::Sobol, 1, PROBE_SEED, [0, 0], block * BLOCK);
        let visit = |particle: usize, arrival: &Arrival| {
            match arrival.route {
                LightRoute::Direct => {
                    let flux = photometric(arrival.arrived, &wavelengths);
                    let entry = (arrival.light.0 as usize, arrival.distance, flux);
                    // Light passes interfaces, which may be receivers.
                    let is_received = receivers.met(&arrival.at).is_some_and(|hit| hit.counts);
                    passed.extend(is_received.then_some(entry));
                    last[particle] = (!is_received && !arrival.left.is_black()).then_some(entry);
                }
                // Paths do not find light that a delta lobe scatters first.
                LightRoute::Mirrored { .. } | LightRoute::Specular => last[particle] = None,
                LightRoute::Scattered => {}
            }
        };
        ParticleTracer::new(scene, 2).trace(sampler, BLOCK, &mut Counters::default(), visit);
        passed.extend(last.into_iter().flatten());
        passed
    };
    let mut by_light = vec![Vec::new(); lights.len()];
    for round in 0..MOST_ROUNDS {
        let blocks = round * (PROBES / BLOCK)..(round + 1) * (PROBES / BLOCK);
        let blocks: Vec<_> = blocks.into_par_iter().map(arrivals).collect();
        for (light, distance, flux) in blocks.into_iter().flatten() {
            if distance > 0.0 && can_touch.get(light) == Some(&true) {
                by_light[light].push((distance, flux));
            }
        }
        let are_known =
            (0..).map(LightId).zip(&by_light).zip(&can_touch).all(|((id, arrived), can_touch)| {
                !can_touch || arrived.len() >= FEW || scene.emitter_probability(id) <= 0.0
            });
        if are_known {
            break;
        }
    }
    by_light.iter_mut().map(|arrived| near_distance(arrived)).collect()
}

/// That of one light, from distances and fluxes of particles: the smallest one beyond which the mean square is not much larger than that of light which
/// all arrives at one distance.
fn near_distance(arrived: &mut [(f64, f64)]) -> f64 {
    arrived.sort_by(|a, b| b.0.total_cmp(&a.0));
    let all: f64 = arrived.iter().map(|(_, flux)| flux).sum();
    let mut farther = 0.0;
    let is_far = |(_, flux): &&(f64, f64)| {
        farther += flux;
        farther < FAR_FLUX * all
    };
    let far = arrived.iter().take_while(is_far).count();
    let Some(&(far, _)) = arrived.get(far) else { return 0.0 };
    let mut square = 0.0;
    let is_near = |(distance, flux): &&(f64, f64)| {
        square += flux / all * (far / distance).powi(2);
        square > LARGEST_SQUARE
    };
    arrived.iter().find(is_near).map_or(0.0, |(distance, _)| (1.0 + BEYOND) * distance)
}

/// A division of the light, and what is integrated in the cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellDivision<'a> {
    pub(crate) division: &'a LightDivision<'a>,
    pub(crate) integrated: &'a [IntegratedLux],
    /// For each cell, whether particles compute all of its light: [`Receiver::has_places`](crate::Receiver::has_places).
    pub(crate) only_particles: &'a [bool],
}

impl<'a> CellDivision<'a> {
    fn is_integrated(&self, cell: usize) -> bool {
        self.integrated.get(cell).is_some_and(|cell| cell.converged)
    }

    /// See [`LightDivision::known`].
    pub(crate) fn known(&self, cell: usize) -> &'a KnownLight {
        self.division.known(self.is_integrated(cell))
    }

    /// See [`LightDivision::is_by_particles`].
    pub(crate) fn is_by_particles(&self, arrival: &Arrival, cell: usize) -> bool {
        self.only_particles.get(cell).is_some_and(|only| *only)
            || self.division.is_by_particles(arrival, self.is_integrated(cell))
    }
}
