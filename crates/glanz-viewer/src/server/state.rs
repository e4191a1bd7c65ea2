//! State shared by all requests.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use glanz_formats::Options;
use glanz_job::CancelFlag;
use tokio::sync::Semaphore;
use tokio::time::sleep;

use super::access::AccessControl;
use super::access_key::AccessKey;
use super::message::{DenoiserMessage, SceneMessage};
use super::models::{ModelStore, PublishedModel};
use super::overlay::SceneOverlay;
use super::session::Sessions;
use super::settings::{Limits, ServerSettings};
use super::{STOP_INTERVAL, SceneUpdate, UpdateListener, ViewerScene};
use crate::stream::{IntegratorName, Processors, SharedDenoiser};

/// State shared by all requests.
pub(crate) struct AppState {
    pub(crate) access: AccessControl,
    pub(crate) limits: Limits,
    pub(crate) options: Options,
    pub(crate) overlay: Option<Arc<dyn SceneOverlay>>,
    pub(crate) integrator: IntegratorName,
    pub(crate) processors: Arc<Processors>,
    /// As in the settings.
    pub(crate) denoiser: Option<Result<Arc<SharedDenoiser>, String>>,
    pub(crate) models: ModelStore,
    pub(crate) sessions: Arc<Sessions>,
    pub(crate) uploads: Semaphore,
    published: Mutex<PublishedModel>,
    closing: CancelFlag,
    listener: UpdateListener,
}

impl AppState {
    /// The state of a server whose pages show `viewer_scene`.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub(crate) fn new(
        settings: &ServerSettings,
        access: AccessControl,
        viewer_scene: ViewerScene,
        listener: UpdateListener,
    ) -> Result<Self, getrandom::Error> {
        let limits = settings.limits;
        let models = ModelStore::default();
        let published = models.publish(Arc::new(viewer_scene))?;
        Ok(Self {
            access,
            limits,
            options: settings.options.clone(),
            overlay: settings.overlay.clone(),
            integrator: settings.integrator,
            processors: Arc::new(Processors::new(settings.threads)),
            denoiser: settings
                .denoiser
                .clone()
                .map(|denoiser| denoiser.map(|denoiser| Arc::new(SharedDenoiser::new(denoiser)))),
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
            name: published.viewer_scene.name.clone(),
            session: session.to_string(),
            integrator: self.integrator,
            denoiser: self.denoiser_message(),
            error: None,
        }
    }

    fn denoiser_message(&self) -> Option<DenoiserMessage> {
        let denoiser = self.denoiser.as_ref()?;
        Some(DenoiserMessage { error: denoiser.as_ref().err().cloned() })
    }

    /// Sends a change of the file `scene` to the pages and the listener.
    pub(crate) fn publish(&self, scene: &Path, update: SceneUpdate) {
        let published = match &update {
            SceneUpdate::Reloaded(viewer_scene) => self.models.publish(Arc::clone(viewer_scene)).ok(),
            SceneUpdate::Refused(_) => None,
        };
        match (&published, &update) {
            (Some(published), _) => {
                *self.published.lock().unwrap_or_else(PoisonError::into_inner) = published.clone();
                self.sessions.broadcast(Some(published), |session| self.scene_message(session, published));
            }
            (None, SceneUpdate::Refused(diagnostics)) => {
                let name =
                    scene.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                self.sessions.broadcast(None, |session| SceneMessage {
                    model: None,
                    name: name.clone(),
                    session: session.to_string(),
                    integrator: self.integrator,
                    denoiser: self.denoiser_message(),
                    error: Some(diagnostics.to_string()),
                });
            }
            // Without a key for the new model, pages keep the old one.
            (None, SceneUpdate::Reloaded(_)) => return,
        }
        (self.listener)(&update);
    }

    /// True if the server is shutting down.
    pub(crate) fn is_closing(&self) -> bool {
        self.closing.is_cancelled()
    }

    /// Closes the connections of all pages, and waits up to a second for that.
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
