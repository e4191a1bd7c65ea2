//! Errors of the integration.

use glanz_scene::LightId;

/// Errors of integrating illuminance in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegrateError {
    /// The scene has no light.
    #[error("the scene has no light")]
    NoLight,
    /// A light of a kind that has no image to integrate.
    #[error("light {} is of kind \"{kind}\", which cannot be integrated: supported lights are spheres, disks, flat convex polygons and points", light.0)]
    Kind {
        /// The light.
        light: LightId,
        /// Its name in scene files.
        kind: &'static str,
    },
    /// An emitting surface whose form has no border function.
    #[error("light {} (shape {shape}, \"{kind}\") {fault}, which cannot be integrated: supported lights are spheres, disks, flat convex polygons and points", light.0)]
    EmitterForm {
        /// The light.
        light: LightId,
        /// Number of the shape, in the order of the scene file.
        shape: u32,
        /// Kind of surface, as scene files name it.
        kind: &'static str,
        /// The fault.
        fault: &'static str,
    },
}
