//! The scene without the hidden leaves of a page.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_job::ResourceBudget;
use glanz_scene::{Description, Scene};
use tokio::task::spawn_blocking;

use super::request::RenderRequestError;
use crate::model;

/// Builds scenes without hidden leaves and caches the last one: the hidden leaves seldom change between views.
#[derive(Debug, Default)]
pub struct VisibleScene {
    last: Mutex<Option<ResolvedSubset>>,
    /// Held while a scene is built, which cannot be interrupted: one at a time.
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
        let subset =
            last.as_ref().filter(|subset| Arc::ptr_eq(&subset.whole, whole) && subset.hidden == *hidden)?;
        Some(Arc::clone(&subset.scene))
    }

    /// The scene of `description`, which is `whole`, without the leaves `hidden`; building it uses `budget`. Takes as long as building the scene if it is not cached.
    ///
    /// # Errors
    /// [`RenderRequestError::Scene`] if the remaining scene is invalid, or a limit was reached.
    pub(crate) async fn scene(
        self: Arc<Self>,
        whole: Arc<Scene>,
        description: Arc<Description>,
        hidden: BTreeSet<u32>,
        budget: ResourceBudget,
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
            let (scene, _) = Scene::resolve_with(model::without(&description, &hidden), &budget)?;
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
