//! The published models.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use axum::body::Bytes;

use super::access_key::AccessKey;
use super::shown::Shown;

/// A published scene under an unguessable key.
#[derive(Clone, Debug)]
pub(crate) struct PublishedModel {
    pub(crate) key: AccessKey,
    pub(crate) shown: Arc<Shown>,
}

impl PublishedModel {
    /// Path of the model.
    pub(crate) fn path(&self) -> String {
        format!("/model/{}", self.key)
    }
}

/// Published models by key, kept as long as a page shows them.
#[derive(Debug, Default)]
pub(crate) struct ModelStore(Mutex<BTreeMap<AccessKey, Weak<Shown>>>);

impl ModelStore {
    /// Publishes the model of a scene.
    ///
    /// # Errors
    /// If the system has no random numbers to give.
    pub(crate) fn post(&self, shown: Arc<Shown>) -> Result<PublishedModel, getrandom::Error> {
        let key = AccessKey::random()?;
        let mut models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.retain(|_, shown| shown.strong_count() > 0);
        models.insert(key, Arc::downgrade(&shown));
        Ok(PublishedModel { key, shown })
    }

    /// The model with this key.
    pub(crate) fn get(&self, key: &AccessKey) -> Option<Bytes> {
        let models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.get(key)?.upgrade().map(|shown| shown.bytes.clone())
    }
}
