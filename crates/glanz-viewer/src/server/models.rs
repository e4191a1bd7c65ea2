//! The models that can be got.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use axum::body::Bytes;

use super::key::Key;
use super::shown::Shown;

/// A scene under the name that nobody guesses: only who was told it gets the model.
#[derive(Clone, Debug)]
pub(crate) struct Posted {
    pub(crate) key: Key,
    pub(crate) shown: Arc<Shown>,
}

impl Posted {
    /// Where the model is.
    pub(crate) fn path(&self) -> String {
        format!("/model/{}", self.key)
    }
}

/// The models by their names, as long as somebody shows them.
#[derive(Debug, Default)]
pub(crate) struct Models(Mutex<BTreeMap<Key, Weak<Shown>>>);

impl Models {
    /// Makes the model of a scene available.
    ///
    /// # Errors
    /// If the system has no random numbers to give.
    pub(crate) fn post(&self, shown: Arc<Shown>) -> Result<Posted, getrandom::Error> {
        let key = Key::random()?;
        let mut models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.retain(|_, shown| shown.strong_count() > 0);
        models.insert(key, Arc::downgrade(&shown));
        Ok(Posted { key, shown })
    }

    /// The model of that name.
    pub(crate) fn get(&self, key: &Key) -> Option<Bytes> {
        let models = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        models.get(key)?.upgrade().map(|shown| shown.bytes.clone())
    }
}
