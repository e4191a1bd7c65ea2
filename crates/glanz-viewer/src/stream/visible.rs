//! The scene without what a page has hidden.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_scene::{Description, Scene};
use tokio::task::spawn_blocking;

use super::order::OrderError;
use crate::model;

/// Makes scenes without some leaves, and keeps the last: a page that turns its camera hides the same all the time.
#[derive(Debug, Default)]
pub struct Visible {
    last: Mutex<Option<Made>>,
    /// Held while a scene is built, which nothing can interrupt: one at a time.
    building: Arc<tokio::sync::Mutex<()>>,
}

#[derive(Debug)]
struct Made {
    whole: Arc<Scene>,
    hidden: BTreeSet<u32>,
    scene: Arc<Scene>,
}

impl Visible {
    fn last(&self) -> MutexGuard<'_, Option<Made>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn known(&self, whole: &Arc<Scene>, hidden: &BTreeSet<u32>) -> Option<Arc<Scene>> {
        let last = self.last();
        let made = last.as_ref().filter(|made| Arc::ptr_eq(&made.whole, whole) && made.hidden == *hidden)?;
        Some(Arc::clone(&made.scene))
    }

    /// The scene of `description`, which is `whole`, without the leaves `hidden`. It may take as long as to build the scene.
    ///
    /// # Errors
    /// [`OrderError::Scene`] if what is left is none.
    pub(crate) async fn scene(
        self: Arc<Self>,
        whole: Arc<Scene>,
        description: Arc<Description>,
        hidden: BTreeSet<u32>,
    ) -> Result<Arc<Scene>, OrderError> {
        if hidden.is_empty() {
            return Ok(whole);
        }
        let guard = Arc::clone(&self.building).lock_owned().await;
        if let Some(scene) = self.known(&whole, &hidden) {
            return Ok(scene);
        }
        let build = move || {
            let _guard = guard;
            let (scene, _) = Scene::resolve(model::without(&description, &hidden))?;
            let scene = Arc::new(scene);
            *self.last() = Some(Made { whole, hidden, scene: Arc::clone(&scene) });
            Ok(scene)
        };
        spawn_blocking(build).await.map_err(|error| OrderError::Scene(error.to_string()))?
    }

    /// Lets go of the scene that is kept.
    pub(crate) fn forget(&self) {
        *self.last() = None;
    }
}
