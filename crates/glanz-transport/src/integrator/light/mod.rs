//! Paths from lamps and from the camera together.

mod from_camera;
mod from_light;
mod weights;

use glanz_light::Spectrum;
use glanz_math::DVec3;

use self::weights::ScatteringDensities;
use super::vertex::Vertex;
use super::{Context, Integrator, IntegratorSettings};

/// Paths that begin at the lamps and are connected to the camera, beside those of [`Path`](super::Path).
///
/// With every sample one path leaves a lamp; wherever it is scattered, what the camera sees of it is splatted to the film. That finds the light
/// that mirrors and glass throw on other surfaces (caustics), which paths from the camera meet by chance, and never if the lamp is a point.
/// One path from the camera goes with it. Light that several ways find is shared by weights of the power heuristic (see `weights`). What is behind
/// a mirror or glass itself and lit through them is found by chance alone, and not at all from lamps that are points or directions.
#[derive(Clone, Copy, Debug)]
pub struct LightPaths {
    max_depth: u32,
}

impl LightPaths {
    /// With the depth of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self { max_depth: settings.max_depth }
    }
}

impl Integrator for LightPaths {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        self.send(context);
        self.gather(context)
    }

    fn splats(&self) -> bool {
        true
    }
}

/// The vertex of a path with the unit directions to light and camera; `light_pdf`: density with which a walk from the camera goes on
/// to the light.
fn turn(vertex: &Vertex<'_>, to_light: DVec3, to_camera: DVec3, light_pdf: f64) -> ScatteringDensities {
    let normal = vertex.at.point.normal;
    ScatteringDensities {
        light_cos: normal.dot(to_light).abs(),
        camera_cos: normal.dot(to_camera).abs(),
        light_pdf,
        camera_pdf: vertex.seen_from(to_light).eval(to_camera).1,
    }
}
