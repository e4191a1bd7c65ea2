//! Light maps and the models that show them.

use std::time::Duration;

use glanz_radiosity::bake::{Atlas, LightMap};
use glanz_scene::description::{CameraDescription, FilmDescription};
use glanz_scene::{Description, Scene};

use crate::event::Warning;

/// The light on the surfaces of a scene.
#[derive(Debug)]
pub struct BakeOutcome {
    pub(super) scene: Scene,
    pub(super) view: ModelView,
    /// Light maps; the two sides of a chart follow one another.
    pub maps: Vec<LightMap>,
    /// The same on square pages.
    pub atlas: Atlas,
    /// Number of elements between which light was exchanged.
    pub elements: usize,
    /// Wall time.
    pub elapsed: Duration,
    /// Warnings, in the order in which they arose.
    pub warnings: Vec<Warning>,
}

impl BakeOutcome {
    /// The scene, to which the maps belong.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
}

/// What a model takes over from the description.
#[derive(Clone, Debug)]
pub(super) struct ModelView {
    pub(super) camera: CameraDescription,
    pub(super) film: FilmDescription,
    /// For each shape, in the order of the scene file: the name of its material, with its number.
    pub(super) names: Vec<String>,
}

impl ModelView {
    pub(super) fn of(description: &Description) -> Self {
        let groups = description.groups.iter().chain([&description.world]);
        let shapes = groups.flat_map(|group| &group.shapes).enumerate();
        let names = shapes.map(|(number, shape)| {
            let material = description.materials.get(shape.material).map_or("", |material| &material.name);
            if material.is_empty() { format!("shape {number}") } else { format!("{material} {number}") }
        });
        let names = names.collect();
        Self { camera: description.camera.clone(), film: description.film.clone(), names }
    }
}
