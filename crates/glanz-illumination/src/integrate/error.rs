//! Errors of the integration.

use glanz_scene::LightId;

/// Errors of integrating illuminance in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegrateError {
    /// Nothing shines.
    #[error("the scene has no lamp")]
    NoLamp,
    /// A light of a kind that has no image to integrate.
    #[error("light {} is of kind \"{kind}\", which cannot be integrated: lamps are spheres, disks, flat convex polygons and points", light.0)]
    Kind {
        /// The light.
        light: LightId,
        /// Its name in scene files.
        kind: &'static str,
    },
    /// A surface that shines, of a form that has no border function.
    #[error("light {} (shape {shape}, \"{kind}\") {fault}, which cannot be integrated: lamps are spheres, disks, flat convex polygons and points", light.0)]
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
