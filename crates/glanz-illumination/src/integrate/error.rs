//! What cannot be integrated.

use glanz_scene::LightId;

/// Why illuminance cannot be integrated in a scene.
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
        /// As scene files name it.
        kind: &'static str,
    },
    /// A surface that shines, of a form that has no border function.
    #[error("light {} (shape {shape}, \"{kind}\") {fault}, which cannot be integrated: lamps are spheres, disks, flat convex polygons and points", light.0)]
    Form {
        /// The light.
        light: LightId,
        /// Number of the shape, in the order of the scene file.
        shape: u32,
        /// Kind of surface, as scene files name it.
        kind: &'static str,
        /// What is wrong with it.
        fault: &'static str,
    },
}
