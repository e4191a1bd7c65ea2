//! Paths from lights, combined with paths from the camera.

mod from_camera;
mod from_light;
mod weights;

use glanz_light::Spectrum;
use glanz_math::DVec3;

use self::weights::ScatteringDensities;
use super::path_tracer::BATCH;
use super::vertex::Vertex;
use super::{Context, Integrator, IntegratorSettings, radiance_of_one};

/// Light paths that are connected to the camera, in addition to the paths of [`Path`](super::Path).
///
/// Every sample traces one path from a light; at every scattering, its connection to the camera is splatted to the film. This finds the light
/// that mirrors and glass focus on other surfaces (caustics), which paths from the camera hit by chance only, and never from a point light.
/// Every sample also traces one path from the camera. Light that several techniques find is weighted by the power heuristic (see
/// `weights`). Caustics seen through a mirror or glass are found by chance only, and not at all from point and directional lights.
#[derive(Clone, Copy, Debug)]
pub struct LightPaths {
    max_depth: u32,
}

impl LightPaths {
    /// An integrator with the depth of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self { max_depth: settings.max_depth }
    }
}

impl Integrator for LightPaths {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        BATCH
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        self.send(contexts);
        self.gather(contexts, radiance);
    }

    fn splats(&self) -> bool {
        true
    }
}

/// The scattering event at a vertex with the unit directions to light and camera; `light_pdf`: density with which a path from the camera
/// continues to the light.
fn turn(vertex: &Vertex<'_>, to_light: DVec3, to_camera: DVec3, light_pdf: f64) -> ScatteringDensities {
    let normal = vertex.at.point.normal;
    ScatteringDensities {
        light_cos: normal.dot(to_light).abs(),
        camera_cos: normal.dot(to_camera).abs(),
        light_pdf,
        camera_pdf: vertex.seen_from(to_light).eval(to_camera).1,
    }
}
