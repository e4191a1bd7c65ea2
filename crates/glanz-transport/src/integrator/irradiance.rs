//! Irradiance of points, by paths that start there.

use std::f32::consts::PI;

use glanz_geometry::BoundedRay;
use glanz_light::{Spectrum, Wavelengths};
use glanz_sampling::PixelSampler;
use glanz_scene::{Interaction, LightId, Scene};
use glanz_shading::Bsdf;
use glanz_shading::model::Lambert;

use super::path::BsdfDirections;
use super::path_state::PathState;
use super::path_tracer::PathTracer;
use super::vertex::Vertex;
use super::{Context, ContextOptions, Counters};

/// Light that an [`IrradianceTracer`] leaves out because it is computed in another way.
#[derive(Clone, Debug, Default)]
pub struct KnownLight {
    /// Lights whose direct light is known, in order of their numbers.
    pub direct: Vec<bool>,
    /// Lights whose light is known as far as the scattering event that is nearest to the light is by a delta lobe, or by a surface with a finish, which scatters it
    /// so closely around the mirrored direction that paths find it by chance only.
    pub specular: Vec<bool>,
    /// For each light, the distance, metres, up to which its light on the surface that scatters it first is known; counted from the points of lights
    /// that rays cannot hit.
    pub near: Vec<f64>,
}

impl KnownLight {
    /// Whether the light `id` is known that arrives at the end of a path from a point. `events`: scattering events of the path.
    /// `last_is_delta`: whether the last one is by a delta lobe or a surface with a finish.
    pub(super) fn includes(&self, id: LightId, events: u32, last_is_delta: bool) -> bool {
        let list = match (last_is_delta, events) {
            (true, _) => &self.specular,
            (false, 0) => &self.direct,
            (false, _) => return false,
        };
        list.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// Whether the light of `id` is known on a surface at this distance, metres, that scatters it.
    pub(super) fn includes_near(&self, id: LightId, distance: f64) -> bool {
        self.near.get(id.0 as usize).is_some_and(|near| distance < *near)
    }
}

/// Estimates irradiance at points by paths that start there, with directions in proportion to their cosines.
///
/// At the point itself and at every surface one light is sampled, as by the integrator `path`. Media are left out.
pub struct IrradianceTracer<'a> {
    scene: &'a Scene,
    tracer: PathTracer,
    /// Rays so far.
    pub counters: Counters,
    // Memory of the last paths, for the next ones.
    contexts: Vec<Context<'a>>,
    paths: Vec<PathState<()>>,
    shadows: Vec<BoundedRay>,
    waiting: Vec<usize>,
    occluded: Vec<bool>,
    irradiance: Vec<Spectrum>,
}

impl<'a> IrradianceTracer<'a> {
    /// `max_events`: largest number of surfaces that light reaches on its way, the point included, as for [`ParticleTracer`](crate::ParticleTracer).
    #[must_use]
    pub fn new(scene: &'a Scene, max_events: u32) -> Self {
        Self {
            scene,
            tracer: PathTracer::with_depth(max_events),
            counters: Counters::default(),
            contexts: Vec::new(),
            paths: Vec::new(),
            shadows: Vec::new(),
            waiting: Vec::new(),
            occluded: Vec::new(),
            irradiance: Vec::new(),
        }
    }

    /// Estimates of the irradiance, W/m^2, one for every start: a point, seen along the normal of the side that light arrives at, the numbers of its
    /// path, and the light that is left out. A thousand starts are a good number; estimates do not depend on those beside them.
    pub fn trace(
        &mut self,
        starts: impl Iterator<Item = (Interaction, PixelSampler, &'a KnownLight)>,
    ) -> &[Spectrum] {
        self.contexts.clear();
        self.paths.clear();
        self.shadows.clear();
        self.waiting.clear();
        let options = ContextOptions::new(false);
        // The radiance of a white surface is 1 / pi of the irradiance.
        let white = Bsdf::Lambert(Lambert { reflectance: Spectrum::one(&Wavelengths::default()) });
        for (number, (at, sampler, known)) in (0..).zip(starts) {
            let mut context = Context::new(self.scene, None, sampler, options).with_known(Some(known));
            let mut path = PathState::new(&context, number, 1);
            let vertex = Vertex::new(&at, white.clone());
            path.is_active = self.tracer.scatter_at(&mut context, &mut BsdfDirections, &mut path, &vertex);
            if let Some(light) = &path.pending.light {
                self.shadows.push(light.shadow);
                self.waiting.push(number as usize);
            }
            self.paths.push(path);
            self.contexts.push(context);
        }
        self.complete_starts();
        let mut directions: Vec<BsdfDirections> = self.contexts.iter().map(|_| BsdfDirections).collect();
        self.tracer.continue_paths(self.scene, &mut self.contexts, &mut directions, &mut self.paths);
        self.contexts.iter().for_each(|context| self.counters.merge(context.counters));
        let finite = |light: Spectrum| if light.is_finite() { light } else { Spectrum::BLACK };
        self.irradiance.clear();
        self.irradiance.extend(self.paths.iter().map(|path| finite(path.light) * PI));
        &self.irradiance
    }

    /// Adds the light that was sampled at the starts of the paths `waiting`.
    fn complete_starts(&mut self) {
        self.occluded.clear();
        if !self.shadows.is_empty() {
            self.scene.occluded_batch(&self.shadows, &mut self.occluded);
        }
        for (&number, &occluded) in self.waiting.iter().zip(&self.occluded) {
            self.paths[number].add_pending(&mut self.contexts[number], &mut BsdfDirections, occluded);
        }
    }
}
