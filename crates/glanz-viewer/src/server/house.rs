//! What all requests share.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use glanz_formats::Options;
use glanz_job::CancelFlag;
use tokio::sync::Semaphore;
use tokio::time::sleep;

use super::dress::Dress;
use super::guard::Guard;
use super::key::Key;
use super::message::SceneNews;
use super::models::{Models, Posted};
use super::session::Sessions;
use super::settings::{Limits, ServerSettings};
use super::{Listener, News, STOP_INTERVAL, Shown};
use crate::stream::{IntegratorName, Processors};

/// What all requests share.
pub(crate) struct House {
    pub(crate) guard: Guard,
    pub(crate) limits: Limits,
    pub(crate) options: Options,
    pub(crate) dress: Option<Arc<dyn Dress>>,
    pub(crate) integrator: IntegratorName,
    pub(crate) processors: Arc<Processors>,
    pub(crate) models: Models,
    pub(crate) sessions: Arc<Sessions>,
    pub(crate) uploads: Semaphore,
    posted: Mutex<Posted>,
    closing: CancelFlag,
    listener: Listener,
}

impl House {
    /// A server of pages that show `shown`.
    ///
    /// # Errors
    /// If the system has no random numbers to give.
    pub(crate) fn new(
        settings: &ServerSettings,
        guard: Guard,
        shown: Shown,
        listener: Listener,
    ) -> Result<Self, getrandom::Error> {
        let limits = settings.limits;
        let models = Models::default();
        let posted = models.post(Arc::new(shown))?;
        Ok(Self {
            guard,
            limits,
            options: settings.options.clone(),
            dress: settings.dress.clone(),
            integrator: settings.integrator,
            processors: Arc::new(Processors::new(settings.threads)),
            models,
            sessions: Arc::new(Sessions::new(limits.sessions)),
            uploads: Semaphore::new(limits.uploads),
            posted: Mutex::new(posted),
            closing: CancelFlag::default(),
            listener,
        })
    }

    /// What pages show that have opened no file of their own.
    pub(crate) fn posted(&self) -> Posted {
        self.posted.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What a page of that name is told of a scene.
    pub(crate) fn news(&self, session: &Key, posted: &Posted) -> SceneNews {
        SceneNews {
            model: Some(posted.path()),
            name: posted.shown.name.clone(),
            session: session.to_string(),
            integrator: self.integrator,
            error: None,
        }
    }

    /// Tells pages and listener what became of the file `scene`.
    pub(crate) fn publish(&self, scene: &Path, news: News) {
        let posted = match &news {
            News::Read(shown) => self.models.post(Arc::clone(shown)).ok(),
            News::Refused(_) => None,
        };
        match (&posted, &news) {
            (Some(posted), _) => {
                *self.posted.lock().unwrap_or_else(PoisonError::into_inner) = posted.clone();
                self.sessions.tell(Some(posted), |session| self.news(session, posted));
            }
            (None, News::Refused(diagnostics)) => {
                let name =
                    scene.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                self.sessions.tell(None, |session| SceneNews {
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

    /// Whether the server ends.
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
