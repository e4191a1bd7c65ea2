//! State shared by all requests.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use glanz_formats::Options;
use glanz_job::CancelFlag;
use tokio::sync::Semaphore;
use tokio::time::sleep;

use super::access::AccessControl;
use super::access_key::AccessKey;
use super::dress::Dress;
use super::message::SceneMessage;
use super::models::{ModelStore, PublishedModel};
use super::session::Sessions;
use super::settings::{Limits, ServerSettings};
use super::{Listener, News, STOP_INTERVAL, Shown};
use crate::stream::{IntegratorName, Processors};

/// State shared by all requests.
pub(crate) struct AppState {
    pub(crate) access: AccessControl,
    pub(crate) limits: Limits,
    pub(crate) options: Options,
    pub(crate) dress: Option<Arc<dyn Dress>>,
    pub(crate) integrator: IntegratorName,
    pub(crate) processors: Arc<Processors>,
    pub(crate) models: ModelStore,
    pub(crate) sessions: Arc<Sessions>,
    pub(crate) uploads: Semaphore,
    published: Mutex<PublishedModel>,
    closing: CancelFlag,
    listener: Listener,
}

impl AppState {
    /// A server of pages that show `shown`.
    ///
    /// # Errors
    /// If the system has no random numbers to give.
    pub(crate) fn new(
        settings: &ServerSettings,
        access: AccessControl,
        shown: Shown,
        listener: Listener,
    ) -> Result<Self, getrandom::Error> {
        let limits = settings.limits;
        let models = ModelStore::default();
        let published = models.post(Arc::new(shown))?;
        Ok(Self {
            access,
            limits,
            options: settings.options.clone(),
            dress: settings.dress.clone(),
            integrator: settings.integrator,
            processors: Arc::new(Processors::new(settings.threads)),
            models,
            sessions: Arc::new(Sessions::new(limits.sessions)),
            uploads: Semaphore::new(limits.uploads),
            published: Mutex::new(published),
            closing: CancelFlag::default(),
            listener,
        })
    }

    /// The model of pages that have not opened a file of their own.
    pub(crate) fn published(&self) -> PublishedModel {
        self.published.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The scene message for the page of that session.
    pub(crate) fn scene_message(&self, session: &AccessKey, published: &PublishedModel) -> SceneMessage {
        SceneMessage {
            model: Some(published.path()),
            name: published.shown.name.clone(),
            session: session.to_string(),
            integrator: self.integrator,
            error: None,
        }
    }

    /// Sends a change of the file `scene` to the pages and the listener.
    pub(crate) fn publish(&self, scene: &Path, news: News) {
        let published = match &news {
            News::Read(shown) => self.models.post(Arc::clone(shown)).ok(),
            News::Refused(_) => None,
        };
        match (&published, &news) {
            (Some(published), _) => {
                *self.published.lock().unwrap_or_else(PoisonError::into_inner) = published.clone();
                self.sessions.tell(Some(published), |session| self.scene_message(session, published));
            }
            (None, News::Refused(diagnostics)) => {
                let name =
                    scene.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                self.sessions.tell(None, |session| SceneMessage {
                    model: None,
                    name: name.clone(),
                    session: session.to_string(),
                    integrator: self.integrator,
                    error: Some(diagnostics.to_string()),
                });
            }
            // Without a name for the model pages keep what they have.
            (None, News::Read(_)) => return,
        }
        (self.listener)(&news);
    }

    /// True if the server is shutting down.
    pub(crate) fn is_closing(&self) -> bool {
        self.closing.is_cancelled()
    }

    /// Sends all pages away, and waits a moment until they are.
    pub(crate) async fn close(&self) {
        self.closing.cancel();
        self.sessions.wake();
        for _ in 0..20 {
            if self.sessions.count() == 0 {
                break;
            }
            sleep(STOP_INTERVAL).await;
        }
    }
}
