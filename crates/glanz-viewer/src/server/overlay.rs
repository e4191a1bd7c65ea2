//! Shapes and maps that are not in the scene file: walls of a room, lux maps, baked light.

use std::fmt;
use std::path::Path;

use glanz_scene::{Description, Scene};

use crate::model::Model;

/// Adds shapes and maps to a scene whenever it is read.
pub trait SceneOverlay: fmt::Debug + Send + Sync {
    /// Adds shapes that are not in the file.
    fn add_shapes(&self, description: &mut Description);

    /// Adds maps to the surfaces of the scene, which was read from files with this [hash](glanz_job::ContentHash).
    ///
    /// # Errors
    /// A message if they do not match the scene.
    fn add_maps(&self, scene: &Scene, content_hash: u128, model: Model) -> Result<Model, String>;

    /// The folder of the maps, which tells two designs of one scene file apart; `None` if they are in none.
    fn folder(&self) -> Option<&Path> {
        None
    }
}
