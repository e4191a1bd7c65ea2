//! The pages that are connected.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use super::key::Key;
use super::message::SceneNews;
use super::models::Posted;

/// A connected page.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) key: Key,
    state: Mutex<State>,
    /// Told when there is news, or when the page is to go.
    pub(crate) news: Notify,
    /// Held while files of the page are read: one lot at a time.
    pub(crate) uploading: tokio::sync::Mutex<()>,
}

#[derive(Debug)]
struct State {
    posted: Posted,
    /// Whether the page has opened a file of its own.
    is_own: bool,
    /// What it has not been told.
    untold: Option<SceneNews>,
}

impl Session {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the page shows.
    pub(crate) fn posted(&self) -> Posted {
        self.state().posted.clone()
    }

    /// From now on the page shows a file of its own, of which it is told by `news`.
    pub(crate) fn show_own(&self, posted: Posted, news: SceneNews) {
        let mut state = self.state();
        (state.posted, state.is_own, state.untold) = (posted, true, Some(news));
        drop(state);
        self.news.notify_one();
    }

    /// What the page has not been told yet.
    pub(crate) fn take_news(&self) -> Option<SceneNews> {
        self.state().untold.take()
    }
}

/// All of them, not more than a certain number.
#[derive(Debug)]
pub(crate) struct Sessions {
    most: usize,
    open: Mutex<BTreeMap<Key, Arc<Session>>>,
}

/// A page's place among the sessions, which it leaves when this is dropped.
#[derive(Debug)]
pub(crate) struct Seat {
    sessions: Arc<Sessions>,
    pub(crate) session: Arc<Session>,
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.sessions.open().remove(&self.session.key);
    }
}

impl Sessions {
    /// At most so many.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, open: Mutex::default() }
    }

    fn open(&self) -> MutexGuard<'_, BTreeMap<Key, Arc<Session>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for one more page, which shows what is `posted`; `None` if there are too many, or no name can be made.
    pub(crate) fn join(self: &Arc<Self>, posted: Posted) -> Option<Seat> {
        let key = Key::random().ok()?;
        let state = Mutex::new(State { posted, is_own: false, untold: None });
        let session = Arc::new(Session { key, state, news: Notify::new(), uploading: Default::default() });
        let mut open = self.open();
        if open.len() >= self.most {
            return None;
        }
        open.insert(key, Arc::clone(&session));
        Some(Seat { sessions: Arc::clone(self), session })
    }

    /// The session of that name.
    pub(crate) fn get(&self, key: &Key) -> Option<Arc<Session>> {
        self.open().get(key).cloned()
    }

    /// Number of pages.
    pub(crate) fn count(&self) -> usize {
        self.open().len()
    }

    /// Has all pages look whether there is news.
    pub(crate) fn wake(&self) {
        self.open().values().for_each(|session| session.news.notify_one());
    }

    /// Tells all pages that follow the server's scene: `posted`, if it could be read again. `news` makes what a page of that name is told.
    pub(crate) fn tell(&self, posted: Option<&Posted>, news: impl Fn(&Key) -> SceneNews) {
        for session in self.open().values() {
            let mut state = session.state();
            if state.is_own {
                continue;
            }
            if let Some(posted) = posted {
                state.posted = posted.clone();
            }
            state.untold = Some(news(&session.key));
            session.news.notify_one();
        }
    }
}
