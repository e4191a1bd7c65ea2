//! The process of a scene that a page has opened.
//!
//! The server starts the program of a [`WorkerCommand`] with a folder, whose path is in an environment variable ([`worker_folder`]). The program calls [`run_worker`],
//! which confines the process (`sandbox`), reads the scene among the uploaded files, writes its model to a file of the folder and then
//! serves the page: it gets the page's messages by its standard input and writes those for the page to its standard output, as `frames`. It ends when its
//! input does.

mod frames;
mod sandbox;

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::Message;
use glanz_formats::Options;
use glanz_job::ResourceLimits;
use serde::{Deserialize, Serialize};
use tokio::io::AsyncWriteExt;
use tokio::process::Command;
use tokio::task::spawn_blocking;

use super::message::PageRequest;
use super::page_service::{PageService, ServiceContext, failed};
use super::upload::{FILES_FOLDER, MODEL_FILE, scene_among};
use super::viewer_scene::{ViewerScene, page_text};
use crate::stream::{IntegratorName, ViewDenoiser};

use self::frames::MAX_FRAME;
pub(crate) use self::frames::{FrameKind, WorkerFrame, receive_frames, write_frame};

/// Environment variable with the folder of the scene.
const FOLDER_VARIABLE: &str = "GLANZ_WORKER_FOLDER";

/// Name of the file with the task in the folder.
const TASK: &str = "task.json";

/// Program that reads the files that are dropped on pages, in a process for each: it calls [`run_worker`] when there is a [`worker_folder`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerCommand {
    /// Path of the program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
}

impl WorkerCommand {
    /// The running program with these arguments.
    ///
    /// # Errors
    /// If the system does not know its path.
    pub fn this_program(arguments: Vec<OsString>) -> io::Result<Self> {
        // Where there is this link, it leads to the same program even if a newer one has replaced the file.
        let link = Path::new("/proc/self/exe");
        let program = if link.exists() { link.to_owned() } else { std::env::current_exe()? };
        Ok(Self { program, arguments })
    }

    /// The command for the scene in a folder.
    pub(crate) fn to_command(&self, folder: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).env(FOLDER_VARIABLE, folder);
        // In a group of its own: Ctrl-C in a terminal is for the server, which then ends it.
        #[cfg(unix)]
        command.arg0("glanz-viewer-worker").process_group(0);
        command
    }
}

/// The folder of the scene that this process is to serve; `None` if it is not one that a server has started for that.
#[must_use]
pub fn worker_folder() -> Option<PathBuf> {
    std::env::var_os(FOLDER_VARIABLE).map(PathBuf::from)
}

/// Settings of the process of an opened scene: those of the server.
#[derive(Clone, Debug, Default)]
pub struct WorkerSettings {
    /// Options of reading the scene.
    pub options: Options,
    /// Threads of a render; 0 means as many as the machine has.
    pub threads: usize,
    /// Default integrator of the page.
    pub integrator: IntegratorName,
    /// Denoiser that the page is offered, or the reason why it is missing; `None` if it is offered none.
    pub denoiser: Option<Result<Arc<dyn ViewDenoiser>, String>>,
    /// Folders that the denoiser reads, besides those of the system's libraries.
    pub libraries: Vec<PathBuf>,
}

/// Beginning of the message of [`WorkerError::Start`], by which the server knows it.
pub(crate) const START_FAILURE: &str = "the process of an opened scene cannot begin";

/// Errors of the process of an opened scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkerError {
    /// The folder has no task, or the process cannot be confined.
    #[error("{START_FAILURE}: {0}")]
    Start(#[from] io::Error),
}

/// Task of a process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct WorkerTask {
    /// Relative paths of the uploaded files.
    pub(crate) names: Vec<PathBuf>,
    /// Memory that the process may have, bytes.
    pub(crate) memory: u64,
    /// Time limit of reading the scene.
    pub(crate) reading_time: Duration,
    /// Largest model, bytes.
    pub(crate) model_bytes: u64,
}

impl WorkerTask {
    /// Writes the task to its file in a folder.
    ///
    /// # Errors
    /// The error of the system.
    pub(crate) fn write(&self, folder: &Path) -> io::Result<()> {
        std::fs::write(folder.join(TASK), serde_json::to_vec(self)?)
    }

    fn read(folder: &Path) -> io::Result<Self> {
        Ok(serde_json::from_slice(&std::fs::read(folder.join(TASK))?)?)
    }
}

/// Serves the scene in `folder` until the server ends this.
///
/// # Errors
/// [`WorkerError::Start`]. Errors of the scene go to the server.
pub fn run_worker(folder: &Path, settings: WorkerSettings) -> Result<(), WorkerError> {
    let WorkerSettings { options, threads, integrator, denoiser, libraries } = settings;
    let task = WorkerTask::read(folder)?;
    let model = OpenOptions::new().write(true).open(folder.join(MODEL_FILE))?;
    let files = folder.join(FILES_FOLDER);
    // The sandbox hides the limits of the processors.
    let threads = match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    sandbox::enter(&files, &libraries, &task)?;
    // From here on there are threads, which inherit what was entered.
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let service = PageService::new(ServiceContext::new(integrator, threads, denoiser));
    // An error if the server is gone.
    let _ = runtime.block_on(serve(service, move || read_scene(&files, &task, options, model)));
    // Neither a scene that is being read nor the wait for input is waited for.
    runtime.shutdown_background();
    Ok(())
}

/// Reads the scene and serves the page, until the input ends.
async fn serve(
    mut service: PageService,
    read: impl FnOnce() -> Result<ViewerScene, String> + Send + 'static,
) -> io::Result<()> {
    let (mut requests, _) = receive_frames(tokio::io::stdin());
    let mut output = tokio::io::stdout();
    let viewer_scene = tokio::select! {
        _ = requests.recv() => return Ok(()),
        viewer_scene = spawn_blocking(read) => {
            viewer_scene.unwrap_or_else(|error| Err(format!("error: the scene cannot be read: {error}\n")))
        }
    };
    let viewer_scene = match viewer_scene {
        Ok(viewer_scene) => Arc::new(viewer_scene),
        Err(text) => return send(&mut output, FrameKind::Refused, text.into()).await,
    };
    send(&mut output, FrameKind::Opened, viewer_scene.name.clone().into()).await?;
    loop {
        let message = tokio::select! {
            biased;
            request = requests.recv() => {
                let Some(request) = request else { return Ok(()) };
                // The server has understood it, too.
                let Ok(request) = PageRequest::parse(&request.into_text()) else { continue };
                match service.serve(request, &viewer_scene).await {
                    Some(message) => message,
                    None => continue,
                }
            }
            message = service.next() => message,
        };
        match sendable(message, MAX_FRAME as usize) {
            Message::Text(text) => send(&mut output, FrameKind::Text, text.as_str().into()).await?,
            Message::Binary(bytes) => send(&mut output, FrameKind::Binary, bytes.into()).await?,
            _ => {}
        }
    }
}

/// The message, or instead of a binary one of more than `most` bytes the reply that it is too large.
fn sendable(message: Message, most: usize) -> Message {
    let reply = match &message {
        Message::Binary(bytes) if bytes.len() > most => {
            let id =
                bytes.get(4..8).and_then(|id| <[u8; 4]>::try_from(id).ok()).map_or(0, u32::from_le_bytes);
            Some(failed(id, "the picture is too large to be sent; render a smaller one".to_owned()))
        }
        _ => None,
    };
    reply.unwrap_or(message)
}

async fn send(output: &mut tokio::io::Stdout, kind: FrameKind, bytes: Vec<u8>) -> io::Result<()> {
    write_frame(output, &WorkerFrame { kind, bytes }).await?;
    output.flush().await
}

/// Reads the scene among the files and writes its model; the error is a readable message.
fn read_scene(
    files: &Path,
    task: &WorkerTask,
    options: Options,
    mut model: File,
) -> Result<ViewerScene, String> {
    let sentence = |message: String| format!("error: {message}\n");
    let scene = scene_among(files, &task.names).map_err(sentence)?;
    // The server enforces its own, too, but the message of the reader names the place.
    let own = options.limits.clone();
    let limits =
        ResourceLimits { memory: own.memory.min(task.memory), time: own.time.min(task.reading_time), ..own };
    let options = Options { folder: Some(files.to_owned()), confined: true, limits, ..options };
    let mut viewer_scene = ViewerScene::read(&files.join(scene), &options, None)
        .map_err(|diagnostics| page_text(&diagnostics, &own))?;
    // Nobody else needs them.
    let bytes = std::mem::take(&mut viewer_scene.bytes);
    if bytes.len() as u64 > task.model_bytes {
        return Err(sentence(format!(
            "the model for the page has {} MB, more than the {} MB that a page takes",
            bytes.len() / 1_000_000,
            task.model_bytes / 1_000_000
        )));
    }
    model.write_all(&bytes).map_err(|error| sentence(format!("the model cannot be stored: {error}")))?;
    Ok(viewer_scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_that_are_too_large_are_answered_under_their_number() {
        let file = Message::binary(vec![2, 0, 0, 0, 7, 1, 0, 0, 9]);
        assert_eq!(sendable(file.clone(), 9), file);
        let Message::Text(text) = sendable(file, 8) else { panic!("a text comes") };
        let reply: serde_json::Value = serde_json::from_str(text.as_str()).unwrap();
        assert_eq!(reply["type"], "failed");
        assert_eq!(reply["id"], 263);
        assert!(reply["message"].as_str().is_some_and(|message| message.contains("render a smaller one")));
        let short = Message::binary(vec![2; 6]);
        assert!(matches!(sendable(short, 5), Message::Text(_)));
    }

    #[test]
    fn saved_pictures_of_the_largest_size_can_be_sent() {
        let pixels = u64::from(crate::stream::MAX_SIDE).pow(2);
        assert!(u64::from(MAX_FRAME) > 48 * pixels);
    }
}
