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
    /// Lights whose light is known as far as the scattering event that is nearest to the light is by a delta lobe.
    pub specular: Vec<bool>,
}

impl KnownLight {
    /// Whether the light `id` is known that arrives at the end of a path from a point. `events`: scattering events of the path.
    /// `last_is_delta`: whether the last one is by a delta lobe.
    pub(super) fn includes(&self, id: LightId, events: u32, last_is_delta: bool) -> bool {
        let list = match (last_is_delta, events) {
            (true, _) => &self.specular,
            (false, 0) => &self.direct,
            (false, _) => return false,
        };
        list.get(id.0 as usize).copied().unwrap_or(false)
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
}

impl<'a> IrradianceTracer<'a> {
    /// `max_events`: largest number of surfaces that light reaches on its way, the point included, as for [`ParticleTracer`](crate::ParticleTracer).
    #[must_use]
    pub fn new(scene: &'a Scene, max_events: u32) -> Self {
        Self { scene, tracer: PathTracer::with_depth(max_events), counters: Counters::default() }
    }

    /// Appends an estimate of the irradiance, W/m^2, for every start to `irradiance`: a point, seen along the normal of the side that light arrives
    /// at, the numbers of its path, and the light that is left out. A thousand starts are a good number; estimates do not depend on those beside them.
    pub fn trace(
        &mut self,
        starts: impl Iterator<Item = (Interaction, PixelSampler, &'a KnownLight)>,
        irradiance: &mut Vec<Spectrum>,
    ) {
        let options = ContextOptions::new(false);
        let (points, mut contexts): (Vec<Interaction>, Vec<Context<'_>>) = starts
            .map(|(at, sampler, known)| {
                (at, Context::new(self.scene, None, sampler, options).with_known(Some(known)))
            })
            .unzip();
        // The radiance of a white surface is 1 / pi of the irradiance.
        let white = Bsdf::Lambert(Lambert { reflectance: Spectrum::one(&Wavelengths::default()) });
        let (mut paths, mut shadows, mut waiting) = (Vec::new(), Vec::new(), Vec::new());
        for (number, (at, context)) in (0..).zip(points.iter().zip(&mut contexts)) {
            let mut path = PathState::new(context, number, 1);
            let vertex = Vertex::new(at, white.clone());
            path.is_active = self.tracer.scatter_at(context, &mut BsdfDirections, &mut path, &vertex);
            if let Some(light) = &path.pending.light {
                shadows.push(light.shadow);
                waiting.push(number as usize);
            }
            paths.push(path);
        }
        self.complete_starts(&mut paths, &mut contexts, &shadows, &waiting);
        let mut directions: Vec<BsdfDirections> = contexts.iter().map(|_| BsdfDirections).collect();
        self.tracer.continue_paths(self.scene, &mut contexts, &mut directions, &mut paths);
        contexts.iter().for_each(|context| self.counters.merge(context.counters));
        let finite = |light: Spectrum| if light.is_finite() { light } else { Spectrum::BLACK };
        irradiance.extend(paths.iter().map(|path| finite(path.light) * PI));
    }

    /// Adds the light that was sampled at the starts of the paths `waiting`.
    fn complete_starts(
        &self,
        paths: &mut [PathState<()>],
        contexts: &mut [Context<'_>],
        shadows: &[BoundedRay],
        waiting: &[usize],
    ) {
        let mut occluded = Vec::new();
        if !shadows.is_empty() {
            self.scene.occluded_batch(shadows, &mut occluded);
        }
        for (&number, &occluded) in waiting.iter().zip(&occluded) {
            paths[number].add_pending(&mut contexts[number], &mut BsdfDirections, occluded);
        }
    }
}
