//! Errors of inverse design.

use glanz_job::{BudgetError, ScratchFileError};
use glanz_scene::{LightId, SceneError, SceneErrorKind};

use crate::receiver::ReceiverError;

/// Reason why a scene cannot be optimised.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OptimizeError {
    /// No variable.
    #[error("no number of this scene is free")]
    NoVariable,
    /// No target.
    #[error("no shape of this scene has a target")]
    NoTarget,
    /// No light with flux.
    #[error("no light of this scene shines")]
    NoLight,
    /// A light of a kind that is not supported.
    #[error("light {} is \"{kind}\"", light.0)]
    Light {
        /// The light.
        light: LightId,
        /// Its kind.
        kind: &'static str,
    },
    /// No light on a mirror, or on the one that is to collimate it.
    #[error("no light of the scene arrives on {0}")]
    NoReflection(&'static str),
    /// A target on a receiver that is not a flat rectangle.
    #[error("the shape of target {} is no flat rectangle", index + 1)]
    NoRectangle {
        /// Index of the target in the description.
        index: usize,
    },
    /// A state of another search.
    #[error("the state to continue from has {found} displacements, the scene has {expected} variables")]
    State {
        /// Number of displacements of the state.
        found: usize,
        /// Number of variables of the scene.
        expected: usize,
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
    /// The temporary file of pictures that cannot be read.
    #[error(transparent)]
    Textures(#[from] ScratchFileError),
}

impl OptimizeError {
    /// The limit that a displaced scene has reached, or the end of its budget for another reason.
    #[must_use]
    pub fn budget(&self) -> Option<&BudgetError> {
        match self {
            Self::Scene { error, .. } => match &error.kind {
                SceneErrorKind::Budget(end) => Some(end),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether it says nothing about the displacements, only about the resources of this run.
    pub(super) fn ends_search(&self) -> bool {
        matches!(self, Self::Textures(_)) || self.budget().is_some()
    }
}
