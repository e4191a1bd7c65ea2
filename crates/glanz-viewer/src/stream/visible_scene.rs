//! The scene without what a page has hidden.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_scene::{Description, Scene};
use tokio::task::spawn_blocking;

use super::request::RenderRequestError;
use crate::model;

/// Builds scenes without hidden leaves and caches the last one: the hidden leaves seldom change between views.
#[derive(Debug, Default)]
pub struct VisibleScene {
    last: Mutex<Option<ResolvedSubset>>,
    /// Held while a scene is built, which nothing can interrupt: one at a time.
    building: Arc<tokio::sync::Mutex<()>>,
}

#[derive(Debug)]
struct ResolvedSubset {
    whole: Arc<Scene>,
    hidden: BTreeSet<u32>,
    scene: Arc<Scene>,
}

impl VisibleScene {
    fn last(&self) -> MutexGuard<'_, Option<ResolvedSubset>> {
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
    /// [`RenderRequestError::Scene`] if what is left is none.
    pub(crate) async fn scene(
        self: Arc<Self>,
        whole: Arc<Scene>,
        description: Arc<Description>,
        hidden: BTreeSet<u32>,
    ) -> Result<Arc<Scene>, RenderRequestError> {
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
            *self.last() = Some(ResolvedSubset { whole, hidden, scene: Arc::clone(&scene) });
            Ok(scene)
        };
        spawn_blocking(build).await.map_err(|error| RenderRequestError::Scene(error.to_string()))?
    }

    /// Drops the cached scene.
    pub(crate) fn forget(&self) {
        *self.last() = None;
    }
}
