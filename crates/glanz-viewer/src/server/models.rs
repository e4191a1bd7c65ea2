//! The published models.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use axum::body::Bytes;

use super::access_key::AccessKey;
use super::viewer_scene::ViewerScene;

/// A published scene under an unguessable key.
#[derive(Clone, Debug)]
pub(crate) struct PublishedModel {
    pub(crate) key: AccessKey,
    pub(crate) viewer_scene: Arc<ViewerScene>,
}

impl PublishedModel {
    /// Path of the model.
    pub(crate) fn path(&self) -> String {
        format!("/model/{}", self.key)
    }
}

/// Published models by key, stored as long as a page shows them.
#[derive(Debug, Default)]
pub(crate) struct ModelStore(Mutex<BTreeMap<AccessKey, Weak<ViewerScene>>>);

impl ModelStore {
    /// Publishes the model of a scene.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub(crate) fn publish(&self, viewer_scene: Arc<ViewerScene>) -> Result<PublishedModel, getrandom::Error> {
        let key = AccessKey::random()?;
        let mut models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.retain(|_, viewer_scene| viewer_scene.strong_count() > 0);
        models.insert(key, Arc::downgrade(&viewer_scene));
        Ok(PublishedModel { key, viewer_scene })
    }

    /// The model with this key.
    pub(crate) fn get(&self, key: &AccessKey) -> Option<Bytes> {
        let models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.get(key)?.upgrade().map(|viewer_scene| viewer_scene.bytes.clone())
    }
}
