//! Light maps and the models that show them.

use std::time::Duration;

use glanz_radiosity::bake::{Atlas, LightMap};
use glanz_scene::Scene;

use crate::event::Warning;

/// The light on the surfaces of a scene.
#[derive(Debug)]
pub struct BakeOutcome {
    pub(super) scene: Scene,
    #[cfg(feature = "formats")]
    pub(super) view: super::model_files::ModelView,
    /// Light maps, in the order of [`BakedLight::maps`](glanz_radiosity::bake::BakedLight::maps).
    pub maps: Vec<LightMap>,
    /// Their layout on square pages.
    pub atlas: Atlas,
    /// Number of elements that exchanged light.
    pub elements: usize,
    /// Wall time.
    pub elapsed: Duration,
    /// Warnings, in order of occurrence.
    pub warnings: Vec<Warning>,
}

impl BakeOutcome {
    /// The scene of the maps.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
}
