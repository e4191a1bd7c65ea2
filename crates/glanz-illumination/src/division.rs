//! Which method computes which part of the light.

use glanz_scene::{LightId, Scene};
use glanz_transport::{Arrival, KnownLight, LightRoute};

use crate::integrate::Reflections;
use crate::lux_parts::IntegratedLux;

/// The methods that compute the light of a scene on its receivers, each of which has its part:
///
/// - integration ([`Reflections`]): light that arrives straight, or by one mirror, from lights whose form can be integrated, in cells where it converges;
/// - paths from points ([`IrradianceTracer`](glanz_transport::IrradianceTracer)): other light that arrives straight, and all light whose
///   first scattering event, counted from the light, is not by a delta lobe;
/// - particles ([`ParticleTracer`](glanz_transport::ParticleTracer)): what remains, which paths from points find by chance at best: caustics, and
///   the light of sets of rays.
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
    /// The division with what `reflections` integrates.
    #[must_use]
    pub fn new(scene: &Scene, reflections: &'a Reflections<'a>) -> Self {
        let ids = || (0..).map(LightId).take(scene.lights().len());
        let only_particles = |id| !scene.is_selectable(id) && scene.emitter_probability(id) > 0.0;
        let known = KnownLight {
            direct: ids().map(|id| reflections.integrates(id)).collect(),
            specular: ids().map(|id| scene.is_selectable(id)).collect(),
        };
        let known_to_particles = KnownLight { direct: Vec::new(), specular: known.specular.clone() };
        let only_particles: Vec<bool> = ids().map(only_particles).collect();
        let focuses =
            scene.materials().iter().any(|material| material.lobes().iter().any(|lobe| lobe.is_delta()));
        let needs_particles = focuses || only_particles.contains(&true);
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
        match arrival.route {
            LightRoute::Direct | LightRoute::Scattered => false,
            LightRoute::Mirrored { surface, face } => {
                !is_integrated || !self.reflections.integrates_mirrored(arrival.light, surface, face)
            }
            LightRoute::Specular => true,
        }
    }
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
