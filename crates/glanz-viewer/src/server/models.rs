//! The published models.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use axum::body::Body;

use super::access_key::AccessKey;
use super::opened_scene::OpenedScene;
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
        model_path(&self.key)
    }
}

/// Path of the model with this key.
pub(crate) fn model_path(key: &AccessKey) -> String {
    format!("/model/{key}")
}

/// A scene with a model.
#[derive(Debug)]
enum StoredModel {
    Design(Weak<ViewerScene>),
    Opened(Weak<OpenedScene>),
}

impl StoredModel {
    fn is_shown(&self) -> bool {
        let count = match self {
            Self::Design(viewer_scene) => viewer_scene.strong_count(),
            Self::Opened(opened) => opened.strong_count(),
        };
        count > 0
    }
}

/// Published models by key, stored as long as a page shows them.
#[derive(Debug, Default)]
pub(crate) struct ModelStore(Mutex<BTreeMap<AccessKey, StoredModel>>);

impl ModelStore {
    /// Publishes the model of a design.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub(crate) fn publish(&self, viewer_scene: Arc<ViewerScene>) -> Result<PublishedModel, getrandom::Error> {
        let key = AccessKey::random()?;
        self.insert(key, StoredModel::Design(Arc::downgrade(&viewer_scene)));
        Ok(PublishedModel { key, viewer_scene })
    }

    /// Publishes the model of a scene that a page has opened.
    pub(crate) fn publish_opened(&self, opened: &Arc<OpenedScene>) {
        self.insert(opened.key, StoredModel::Opened(Arc::downgrade(opened)));
    }

    fn insert(&self, key: AccessKey, model: StoredModel) {
        let mut models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.retain(|_, model| model.is_shown());
        models.insert(key, model);
    }

    /// The model with this key.
    pub(crate) fn get(&self, key: &AccessKey) -> Option<Body> {
        let models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match models.get(key)? {
            StoredModel::Design(viewer_scene) => Some(Body::from(viewer_scene.upgrade()?.bytes.clone())),
            StoredModel::Opened(opened) => Some(opened.upgrade()?.model()),
        }
    }
}
