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
use super::models::{ModelStore, PublishedModel, model_path};
use super::opened_scene::{OpenedScene, SceneMemory};
use super::overlay::SceneOverlay;
use super::page_service::ServiceContext;
use super::session::Sessions;
use super::settings::{Limits, ServerSettings};
use super::upload::UploadFolder;
use super::viewer_scene::page_text;
use super::worker::WorkerCommand;
use super::{STOP_INTERVAL, SceneUpdate, UpdateListener, ViewerScene};

/// State shared by all requests.
pub(crate) struct AppState {
    pub(crate) access: AccessControl,
    pub(crate) limits: Limits,
    pub(crate) options: Options,
    /// One design, or two that are compared.
    pub(crate) designs: Vec<ServedDesign>,
    pub(crate) service: ServiceContext,
    /// As in the settings.
    pub(crate) worker: Option<WorkerCommand>,
    pub(crate) models: ModelStore,
    pub(crate) sessions: Arc<Sessions>,
    pub(crate) uploads: Arc<Semaphore>,
    /// Slots of pages that have opened a scene.
    pub(crate) opened_scenes: Arc<Semaphore>,
    pub(crate) scene_memory: Arc<SceneMemory>,
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
        UploadFolder::remove_abandoned();
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
            service: ServiceContext::new(settings.integrator, settings.threads, settings.denoiser.clone()),
            worker: settings.worker.clone(),
            models,
            sessions: Arc::new(Sessions::new(sessions)),
            uploads: Arc::new(Semaphore::new(limits.uploads)),
            opened_scenes: Arc::new(Semaphore::new(limits.opened_scenes)),
            scene_memory: Arc::default(),
            closing: CancelFlag::default(),
            listener,
        })
    }

    /// The model of pages of a design that have not opened a file of their own; `None` if there is no such design.
    pub(crate) fn published(&self, design: usize) -> Option<PublishedModel> {
        self.designs.get(design).map(ServedDesign::published)
    }

    /// The message about the scene of a design, for the page of that session.
    pub(crate) fn scene_message(
        &self,
        session: &AccessKey,
        published: &PublishedModel,
        design: usize,
    ) -> SceneMessage {
        let label = self.designs.get(design).map(|design| design.label.clone());
        let name = &published.viewer_scene.name;
        SceneMessage {
            label: label.unwrap_or_else(|| name.clone()),
            compared: self.designs.len() > 1,
            ..self.message(session, published.path(), name)
        }
    }

    /// The message about a scene that the page of that session has opened.
    pub(crate) fn opened_message(&self, session: &AccessKey, opened: &OpenedScene) -> SceneMessage {
        self.message(session, model_path(&opened.key), &opened.name)
    }

    /// A message about a scene that is not compared.
    fn message(&self, session: &AccessKey, model: String, name: &str) -> SceneMessage {
        SceneMessage {
            model: Some(model),
            label: name.to_owned(),
            name: name.to_owned(),
            session: session.to_string(),
            integrator: self.service.integrator,
            denoiser: self.denoiser_message(),
            compared: false,
            error: None,
            lost: false,
        }
    }

    fn denoiser_message(&self) -> Option<DenoiserMessage> {
        let denoiser = self.service.denoiser.as_ref()?;
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
                    self.scene_message(session, published, number)
                });
            }
            (None, SceneUpdate::Refused(diagnostics)) => {
                let name = file_name(&design.path);
                self.sessions.broadcast(number, None, |session| SceneMessage {
                    model: None,
                    name: name.clone(),
                    label: design.label.clone(),
                    session: session.to_string(),
                    integrator: self.service.integrator,
                    denoiser: self.denoiser_message(),
                    compared: self.designs.len() > 1,
                    error: Some(page_text(diagnostics, &self.options.limits)),
                    lost: false,
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

    /// Closes the connections of all pages, which ends the processes of their scenes, and waits up to a second for that.
    pub(crate) async fn close(&self) {
        self.closing.cancel();
        self.sessions.wake();
        for _ in 0..20 {
            let are_scenes_closed = self.opened_scenes.available_permits() == self.limits.opened_scenes;
            if self.sessions.count() == 0 && are_scenes_closed {
                break;
            }
            sleep(STOP_INTERVAL).await;
        }
    }
}
