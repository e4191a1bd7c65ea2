//! Errors of inverse design.

use glanz_scene::{LightId, SceneError};

use crate::receiver::ReceiverError;

/// Reason why a scene cannot be optimised.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OptimizeError {
    /// Nothing may change.
    #[error("no number of this scene is free")]
    NoVariable,
    /// Nothing is wanted.
    #[error("no shape of this scene has a target")]
    NoTarget,
    /// Nothing gives light.
    #[error("no light of this scene shines")]
    NoLight,
    /// A light whose rays are not known.
    #[error("light {} is \"{kind}\"", light.0)]
    Light {
        /// The light.
        light: LightId,
        /// Its kind.
        kind: &'static str,
    },
    /// No light meets a mirror, or the one that is to collimate it.
    #[error("no light of the lamps arrives on {0}")]
    NoReflection(&'static str),
    /// A target on a receiver that is not a flat rectangle.
    #[error("the shape of target {} is no flat rectangle", index + 1)]
    NoRectangle {
        /// Index of the target in the description.
        index: usize,
    },
    /// A grid for the target that cannot be built.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// A scene with displacements that cannot be resolved.
    #[error("displaced by {displacements:?} m the scene is invalid: {error}")]
    Scene {
        /// The displacements, metres.
        displacements: Vec<f64>,
        /// The fault.
        error: Box<SceneError>,
    },
}
