//! State shared by all requests.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glanz_formats::Options;
use glanz_job::CancelFlag;
use tokio::sync::Semaphore;
use tokio::time::sleep;

use super::access::AccessControl;
use super::access_key::AccessKey;
use super::label::{design_labels, file_name};
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
    /// One design, or two that are compared.
    pub(crate) designs: Vec<ServedDesign>,
    pub(crate) integrator: IntegratorName,
    pub(crate) processors: Arc<Processors>,
    /// As in the settings.
    pub(crate) denoiser: Option<Result<Arc<SharedDenoiser>, String>>,
    pub(crate) models: ModelStore,
    pub(crate) sessions: Arc<Sessions>,
    pub(crate) uploads: Semaphore,
    closing: CancelFlag,
    listener: UpdateListener,
}

/// A scene file that pages show.
pub(crate) struct ServedDesign {
    pub(crate) path: PathBuf,
    pub(crate) overlay: Option<Arc<dyn SceneOverlay>>,
    /// What tells it from the other design on the page.
    label: String,
    published: Mutex<PublishedModel>,
}

impl ServedDesign {
    /// The model of pages that have not opened a file of their own.
    pub(crate) fn published(&self) -> PublishedModel {
        self.published.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl AppState {
    /// The state of a server whose pages show `viewer_scene`, the scene of a file, and the compared design.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub(crate) fn new(
        settings: &ServerSettings,
        access: AccessControl,
        (scene, viewer_scene): (&Path, ViewerScene),
        listener: UpdateListener,
    ) -> Result<Self, getrandom::Error> {
        let limits = settings.limits;
        let models = ModelStore::default();
        let first = (scene, Arc::new(viewer_scene), &settings.overlay);
        let second = settings
            .compared
            .as_ref()
            .map(|design| (design.path.as_path(), Arc::clone(&design.viewer_scene), &design.overlay));
        let folders = [first.2.as_ref(), second.as_ref().and_then(|(_, _, overlay)| overlay.as_ref())];
        let folders = folders.map(|overlay| overlay.and_then(|overlay| overlay.folder()));
        let second_path = second.as_ref().map_or(scene, |(path, ..)| path);
        let labels = design_labels([scene, second_path], folders);
        let designs = std::iter::once(first).chain(second).zip(labels);
        let designs = designs.map(|((path, viewer_scene, overlay), label)| {
            let published = Mutex::new(models.publish(viewer_scene)?);
            Ok(ServedDesign { path: path.to_owned(), overlay: overlay.clone(), label, published })
        });
        let designs = designs.collect::<Result<Vec<ServedDesign>, getrandom::Error>>()?;
        // A page has a session for each design.
        let sessions = limits.sessions.saturating_mul(designs.len());
        Ok(Self {
            access,
            limits,
            options: settings.options.clone(),
            designs,
            integrator: settings.integrator,
            processors: Arc::new(Processors::new(settings.threads)),
            denoiser: settings
                .denoiser
                .clone()
                .map(|denoiser| denoiser.map(|denoiser| Arc::new(SharedDenoiser::new(denoiser)))),
            models,
            sessions: Arc::new(Sessions::new(sessions)),
            uploads: Semaphore::new(limits.uploads),
            closing: CancelFlag::default(),
            listener,
        })
    }

    /// The model of pages of a design that have not opened a file of their own; `None` if there is no such design.
    pub(crate) fn published(&self, design: usize) -> Option<PublishedModel> {
        self.designs.get(design).map(ServedDesign::published)
    }

    /// The scene message for the page of that session. `design`: the number of the one that it shows; `None` if it has opened a file itself.
    pub(crate) fn scene_message(
        &self,
        session: &AccessKey,
        published: &PublishedModel,
        design: Option<usize>,
    ) -> SceneMessage {
        let name = published.viewer_scene.name.clone();
        let label = design.and_then(|number| self.designs.get(number)).map(|design| design.label.clone());
        SceneMessage {
            model: Some(published.path()),
            label: label.unwrap_or_else(|| name.clone()),
            name,
            session: session.to_string(),
            integrator: self.integrator,
            denoiser: self.denoiser_message(),
            compared: design.is_some() && self.designs.len() > 1,
            error: None,
        }
    }

    fn denoiser_message(&self) -> Option<DenoiserMessage> {
        let denoiser = self.denoiser.as_ref()?;
        Some(DenoiserMessage { error: denoiser.as_ref().err().cloned() })
    }

    /// Sends a change of the file of a design to its pages and the listener.
    pub(crate) fn publish(&self, number: usize, update: SceneUpdate) {
        let Some(design) = self.designs.get(number) else { return };
        let published = match &update {
            SceneUpdate::Reloaded(viewer_scene) => self.models.publish(Arc::clone(viewer_scene)).ok(),
            SceneUpdate::Refused(_) => None,
        };
        match (&published, &update) {
            (Some(published), _) => {
                *design.published.lock().unwrap_or_else(PoisonError::into_inner) = published.clone();
                self.sessions.broadcast(number, Some(published), |session| {
                    self.scene_message(session, published, Some(number))
                });
            }
            (None, SceneUpdate::Refused(diagnostics)) => {
                let name = file_name(&design.path);
                self.sessions.broadcast(number, None, |session| SceneMessage {
                    model: None,
                    name: name.clone(),
                    label: design.label.clone(),
                    session: session.to_string(),
                    integrator: self.integrator,
                    denoiser: self.denoiser_message(),
                    compared: self.designs.len() > 1,
                    error: Some(diagnostics.to_string()),
                });
            }
            // Without a key for the new model, pages keep the old one.
            (None, SceneUpdate::Reloaded(_)) => return,
        }
        (self.listener)(&design.path, &update);
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
