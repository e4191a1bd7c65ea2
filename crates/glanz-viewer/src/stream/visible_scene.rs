//! The scene without the hidden leaves of a page.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_job::{CancelFlag, ResourceBudget};
use glanz_scene::{Description, Scene};
use tokio::task::spawn_blocking;

use super::request::RenderRequestError;
use crate::model;

/// Builds scenes without hidden leaves and caches the last one: the hidden leaves seldom change between views.
#[derive(Debug, Default)]
pub struct VisibleScene {
    last: Mutex<Option<ResolvedSubset>>,
    /// Held while a scene is built: one at a time.
    building: Arc<tokio::sync::Mutex<()>>,
    /// Raised when the page has left, which ends a build.
    abandoned: CancelFlag,
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

    /// The scene of `description`, which is `whole`, without the leaves `hidden`; building it uses `budget`, without its flag. Takes as long as building the scene if it is not cached.
    ///
    /// # Errors
    /// [`RenderRequestError::Scene`] if the remaining scene is invalid, a limit was reached, or this was [abandoned](Self::abandon).
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
        let budget = budget.with_cancel(self.abandoned.clone());
        let build = move || {
            let _guard = guard;
            let (scene, _) = Scene::resolve_with(model::without(&description, &hidden), &budget)?;
            let scene = Arc::new(scene);
            *self.last() = Some(ResolvedSubset { whole, hidden, scene: Arc::clone(&scene) });
            Ok(scene)
        };
        spawn_blocking(build).await.map_err(|error| RenderRequestError::Scene(error.to_string()))?
    }

    /// Ends the build of a scene, and all later ones.
    pub(crate) fn abandon(&self) {
        self.abandoned.cancel();
    }

    /// Drops the cached scene.
    pub(crate) fn forget(&self) {
        *self.last() = None;
    }
}

#[cfg(test)]
mod tests {
    use glanz_formats::{Options, load_str};

    use super::*;

    #[test]
    fn abandoned_scenes_are_not_built() {
        let text = "WorldBegin\nShape \"sphere\"\nShape \"sphere\"\n";
        let description = Arc::new(load_str("a.pbrt", text, &Options::default()).unwrap().description);
        let whole = Arc::new(Scene::resolve(Description::clone(&description)).unwrap().0);
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let visible = Arc::new(VisibleScene::default());
        let build = |leaf| {
            let (whole, description) = (Arc::clone(&whole), Arc::clone(&description));
            let hidden = BTreeSet::from([leaf]);
            let budget = ResourceBudget::default();
            runtime.block_on(Arc::clone(&visible).scene(whole, description, hidden, budget))
        };
        assert!(build(0).is_ok());
        visible.abandon();
        assert!(matches!(build(1), Err(RenderRequestError::Scene(_))));
    }
}
