//! Scenes that pages have opened, each in a process of its own.
//!
//! A hostile scene can demand any time and any memory, when it is read as well as when it is resolved, rendered or picked, and threads cannot be
//! ended from outside. So all of that happens in a process (see `worker`), which the server watches and ends: when the page
//! leaves or abandons its upload, when reading takes too long, or when the scene needs too much memory. The server itself sees no more of
//! the scene than bytes, which it passes between the page and the process.

mod memory;
mod model_file;
mod process;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use axum::body::Body;
use axum::extract::ws::Message;
use tokio::sync::{OwnedMutexGuard, OwnedSemaphorePermit};

use super::access_key::AccessKey;
use super::state::AppState;
use super::upload::UploadFolder;
use super::worker::{FrameKind, WorkerCommand, WorkerTask};

use self::model_file::ModelFile;
use self::process::{SceneEnd, SceneProcess};

pub(crate) use self::memory::SceneMemory;

/// A page's share of the scenes that may be open, kept until their processes have ended.
pub(crate) type SceneSlot = Arc<OwnedSemaphorePermit>;

/// Permits of an upload, held until its scene is read or the process that reads it has ended.
#[derive(Debug)]
pub(crate) struct UploadPermits {
    pub(crate) _page: OwnedMutexGuard<()>,
    pub(crate) _upload: OwnedSemaphorePermit,
}

/// A scene that a page has opened. Its process is ended when the value is dropped.
#[derive(Debug)]
pub(crate) struct OpenedScene {
    /// Key of its model.
    pub(crate) key: AccessKey,
    pub(crate) name: String,
    model: ModelFile,
    /// Empty once the process has ended.
    slot: Mutex<Option<SceneSlot>>,
    process: SceneProcess,
}

/// Frees the space of the model, which a page that still receives it would hold.
impl Drop for OpenedScene {
    fn drop(&mut self) {
        self.model.clear();
    }
}

impl OpenedScene {
    /// Lets a process read the scene among the files `names` of a folder, and waits until it has. If that is abandoned, the process is ended.
    ///
    /// # Errors
    /// A message for the page. Everything that the upload has held is free again by then.
    pub(crate) async fn open(
        app: &AppState,
        command: &WorkerCommand,
        (folder, names): (UploadFolder, Vec<PathBuf>),
        permits: UploadPermits,
        slot: SceneSlot,
    ) -> Result<Self, String> {
        let unstarted = |error: std::io::Error| {
            format!(
                "error: the program that reads files cannot be started: {error}; start glanz view again\n"
            )
        };
        let key = AccessKey::random().map_err(|error| unstarted(std::io::Error::other(error.to_string())))?;
        let model = ModelFile::create(&folder.model()).map_err(unstarted)?;
        let limits = &app.limits;
        let task = WorkerTask {
            names,
            memory: limits.scene_memory,
            reading_time: limits.reading_time,
            model_bytes: limits.model_bytes,
        };
        task.write(folder.path()).map_err(unstarted)?;
        let held = (folder, Arc::clone(&slot));
        let process = SceneProcess::start(command, held, permits, limits, Arc::clone(&app.scene_memory))
            .map_err(unstarted)?;
        let text = match process.next().await {
            Ok(frame) if frame.kind == FrameKind::Opened => {
                process.set_read();
                let name = frame.into_text();
                let slot = Mutex::new(Some(slot));
                return Ok(Self { key, name, model, slot, process });
            }
            Ok(frame) if frame.kind == FrameKind::Refused => frame.into_text(),
            Ok(_) => format!("error: {}\n", SceneEnd::Stopped),
            Err(end) => format!("error: {end}\n"),
        };
        process.end().await;
        Err(text)
    }

    /// The slot of its page, unless its process has ended.
    pub(crate) fn slot(&self) -> Option<SceneSlot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Gives the slot to other pages, once the process has ended.
    pub(crate) fn release_slot(&self) {
        *self.slot.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// The model, as it is sent.
    pub(crate) fn model(&self) -> Body {
        self.model.body()
    }

    /// Passes a request of the page on, which may be a [query](super::message::PageRequest::is_query). Returns false if too many wait.
    pub(crate) fn forward(&self, message: Message, is_query: bool) -> bool {
        match message {
            Message::Text(text) => self.process.send(text.as_str(), is_query),
            _ => true,
        }
    }

    /// Waits for the next message for the page.
    ///
    /// # Errors
    /// The reason why the process has ended.
    pub(crate) async fn next(&self) -> Result<Message, String> {
        loop {
            let frame = self.process.next().await.map_err(|end| end.to_string())?;
            match frame.kind {
                FrameKind::Text => return Ok(Message::text(frame.into_text())),
                FrameKind::Binary => return Ok(Message::binary(frame.bytes)),
                FrameKind::Opened | FrameKind::Refused => {}
            }
        }
    }
}
