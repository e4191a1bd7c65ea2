//! What a page shows that is in no scene file: the walls of a room, light that was counted or baked before.

use std::fmt;

use glanz_scene::{Description, Scene};

use crate::model::Model;

/// Adds to a scene what is known of it elsewhere, whenever it is read.
pub trait Dress: fmt::Debug + Send + Sync {
    /// Adds shapes that are not in the file.
    fn furnish(&self, description: &mut Description);

    /// Puts values on the surfaces of the scene, which was read from files with this [fingerprint](glanz_formats::ContentHash).
    ///
    /// # Errors
    /// Why they do not go with it, a sentence for people.
    fn dress(&self, scene: &Scene, content_hash: u128, model: Model) -> Result<Model, String>;
}
