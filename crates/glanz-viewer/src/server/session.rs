//! The pages that are connected.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use super::access_key::AccessKey;
use super::message::SceneMessage;
use super::models::PublishedModel;

/// A connected page.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) key: AccessKey,
    state: Mutex<SessionState>,
    /// Signals a pending message or the end of the session.
    pub(crate) news: Notify,
    /// Held while an upload of the page is read: one at a time.
    pub(crate) uploading: tokio::sync::Mutex<()>,
}

#[derive(Debug)]
struct SessionState {
    published: PublishedModel,
    /// True if the page has opened a file of its own.
    is_own: bool,
    /// Message not yet sent.
    untold: Option<SceneMessage>,
}

impl Session {
    fn state(&self) -> MutexGuard<'_, SessionState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The model that the page shows.
    pub(crate) fn published(&self) -> PublishedModel {
        self.state().published.clone()
    }

    /// Switches the page to an uploaded scene, announced by `news`.
    pub(crate) fn show_own(&self, published: PublishedModel, news: SceneMessage) {
        let mut state = self.state();
        (state.published, state.is_own, state.untold) = (published, true, Some(news));
        drop(state);
        self.news.notify_one();
    }

    /// Takes the message not yet sent.
    pub(crate) fn take_news(&self) -> Option<SceneMessage> {
        self.state().untold.take()
    }
}

/// The connected sessions, up to a limit.
#[derive(Debug)]
pub(crate) struct Sessions {
    most: usize,
    open: Mutex<BTreeMap<AccessKey, Arc<Session>>>,
}

/// A page's place among the sessions, which it leaves when this is dropped.
#[derive(Debug)]
pub(crate) struct SessionSlot {
    sessions: Arc<Sessions>,
    pub(crate) session: Arc<Session>,
}

impl Drop for SessionSlot {
    fn drop(&mut self) {
        self.sessions.open().remove(&self.session.key);
    }
}

impl Sessions {
    /// At most so many.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, open: Mutex::default() }
    }

    fn open(&self) -> MutexGuard<'_, BTreeMap<AccessKey, Arc<Session>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for one more page, which shows what is `published`; `None` if there are too many, or no name can be made.
    pub(crate) fn join(self: &Arc<Self>, published: PublishedModel) -> Option<SessionSlot> {
        let key = AccessKey::random().ok()?;
        let state = Mutex::new(SessionState { published, is_own: false, untold: None });
        let session = Arc::new(Session { key, state, news: Notify::new(), uploading: Default::default() });
        let mut open = self.open();
        if open.len() >= self.most {
            return None;
        }
        open.insert(key, Arc::clone(&session));
        Some(SessionSlot { sessions: Arc::clone(self), session })
    }

    /// The session of that name.
    pub(crate) fn get(&self, key: &AccessKey) -> Option<Arc<Session>> {
        self.open().get(key).cloned()
    }

    /// Number of pages.
    pub(crate) fn count(&self) -> usize {
        self.open().len()
    }

    /// Wakes all pages to check for messages.
    pub(crate) fn wake(&self) {
        self.open().values().for_each(|session| session.news.notify_one());
    }

    /// Sends a message to all pages that follow the server's scene. `published`: its new model, if it could be read. `news`: the message by session.
    pub(crate) fn tell(&self, published: Option<&PublishedModel>, news: impl Fn(&AccessKey) -> SceneMessage) {
        for session in self.open().values() {
            let mut state = session.state();
            if state.is_own {
                continue;
            }
            if let Some(published) = published {
                state.published = published.clone();
            }
            state.untold = Some(news(&session.key));
            session.news.notify_one();
        }
    }
}
