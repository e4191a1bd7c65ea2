//! The pages that are connected.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Notify, watch};

use super::access_key::AccessKey;
use super::message::SceneMessage;
use super::models::PublishedModel;
use super::opened_scene::{OpenedScene, SceneSlot};

/// A connected page.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) key: AccessKey,
    /// Number of the design that the page shows.
    pub(crate) design: usize,
    state: Mutex<SessionState>,
    /// Signals a pending message or the end of the session.
    pub(crate) notify: Notify,
    /// Held while an upload of the page is read: one at a time.
    pub(crate) uploading: Arc<tokio::sync::Mutex<()>>,
    is_gone: watch::Sender<bool>,
}

#[derive(Debug)]
struct SessionState {
    published: PublishedModel,
    /// The scene that the page has opened itself.
    opened: Option<Arc<OpenedScene>>,
    /// Message not yet sent.
    pending: Option<SceneMessage>,
}

impl Session {
    fn state(&self) -> MutexGuard<'_, SessionState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The model that the page shows.
    pub(crate) fn published(&self) -> PublishedModel {
        self.state().published.clone()
    }

    /// Switches the page to a scene that it has opened and queues `message`, which announces it.
    pub(crate) fn show_opened(&self, opened: Arc<OpenedScene>, message: SceneMessage) {
        let mut state = self.state();
        (state.opened, state.pending) = (Some(opened), Some(message));
        drop(state);
        self.notify.notify_one();
    }

    /// The slot of the scene that the page has opened, unless its process has ended.
    pub(crate) fn scene_slot(&self) -> Option<SceneSlot> {
        self.state().opened.as_ref().and_then(|opened| opened.slot())
    }

    /// Takes the message not yet sent, and the opened scene that it may be about.
    pub(crate) fn take_message(&self) -> Option<(SceneMessage, Option<Arc<OpenedScene>>)> {
        let mut state = self.state();
        let message = state.pending.take()?;
        Some((message, state.opened.clone()))
    }

    /// Waits until the page has disconnected.
    pub(crate) async fn gone(&self) {
        // An error only without a sender, which this has.
        let _ = self.is_gone.subscribe().wait_for(|is_gone| *is_gone).await;
    }
}

/// The connected sessions, up to a limit.
#[derive(Debug)]
pub(crate) struct Sessions {
    most: usize,
    open: Mutex<BTreeMap<AccessKey, Arc<Session>>>,
}

/// A page's slot among the sessions, released on drop.
#[derive(Debug)]
pub(crate) struct SessionSlot {
    sessions: Arc<Sessions>,
    pub(crate) session: Arc<Session>,
}

impl Drop for SessionSlot {
    fn drop(&mut self) {
        self.sessions.open().remove(&self.session.key);
        self.session.is_gone.send_replace(true);
    }
}

impl Sessions {
    /// An empty set for at most `most` sessions.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, open: Mutex::default() }
    }

    fn open(&self) -> MutexGuard<'_, BTreeMap<AccessKey, Arc<Session>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A slot for one more page, which shows `published`, the model of a design; `None` if all are taken, or the system has no random numbers.
    pub(crate) fn join(self: &Arc<Self>, design: usize, published: PublishedModel) -> Option<SessionSlot> {
        let key = AccessKey::random().ok()?;
        let state = Mutex::new(SessionState { published, opened: None, pending: None });
        let session = Arc::new(Session {
            key,
            design,
            state,
            notify: Notify::new(),
            uploading: Arc::default(),
            is_gone: watch::Sender::new(false),
        });
        let mut open = self.open();
        if open.len() >= self.most {
            return None;
        }
        open.insert(key, Arc::clone(&session));
        Some(SessionSlot { sessions: Arc::clone(self), session })
    }

    /// The session with this key.
    pub(crate) fn get(&self, key: &AccessKey) -> Option<Arc<Session>> {
        self.open().get(key).cloned()
    }

    /// Number of pages.
    pub(crate) fn count(&self) -> usize {
        self.open().len()
    }

    /// Wakes all pages to check for messages.
    pub(crate) fn wake(&self) {
        self.open().values().for_each(|session| session.notify.notify_one());
    }

    /// Sends a message to all pages that show the file of a design. `published`: its new model, if it could be read. `message`: by session.
    pub(crate) fn broadcast(
        &self,
        design: usize,
        published: Option<&PublishedModel>,
        message: impl Fn(&AccessKey) -> SceneMessage,
    ) {
        for session in self.open().values() {
            let mut state = session.state();
            if state.opened.is_some() || session.design != design {
                continue;
            }
            if let Some(published) = published {
                state.published = published.clone();
            }
            state.pending = Some(message(&session.key));
            session.notify.notify_one();
        }
    }
}
