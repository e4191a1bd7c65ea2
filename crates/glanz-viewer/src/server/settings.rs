//! Settings of the server.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use glanz_formats::Options;

use super::overlay::SceneOverlay;
use super::viewer_scene::ViewerScene;
use super::worker::WorkerCommand;
use crate::stream::{IntegratorName, ViewDenoiser};

/// Settings of the server.
#[derive(Clone, Debug, Default)]
pub struct ServerSettings {
    /// Host name or IP address under which other machines reach the server, with the token of its address; `None` if only this machine may
    /// connect.
    pub host: Option<String>,
    /// The port: 0 selects any free port, `None` [`DEFAULT_PORT`] or, if that is taken, any free port.
    pub port: Option<u16>,
    /// Threads of a render of the scenes of the server; 0 means as many as the machine has. The program that reads uploaded ones has its own:
    /// [`WorkerSettings::threads`](super::WorkerSettings::threads).
    pub threads: usize,
    /// Default integrator of pages. The program that reads uploaded scenes has its own, which should be the same: [`WorkerSettings::integrator`](super::WorkerSettings::integrator).
    pub integrator: IntegratorName,
    /// Options of reading the scenes of the server. The program that reads uploaded ones has its own: [`WorkerSettings::options`](super::WorkerSettings::options).
    pub options: Options,
    /// Overlay applied to the scene whenever it is read; not to uploaded scenes.
    pub overlay: Option<Arc<dyn SceneOverlay>>,
    /// A second design, which pages show beside the first one.
    pub compared: Option<ComparedDesign>,
    /// Denoiser that pages offer, or the reason why it is missing, which they show; `None` if they offer none.
    pub denoiser: Option<Result<Arc<dyn ViewDenoiser>, String>>,
    /// Program that reads the files that are dropped on pages, in a process for each; `None` if pages cannot open files.
    pub worker: Option<WorkerCommand>,
    /// Reads the scene again when one of its files changes.
    pub watch: bool,
    /// Resource limits of clients.
    pub limits: Limits,
}

/// The second of two designs.
#[derive(Clone, Debug)]
pub struct ComparedDesign {
    /// Its scene file.
    pub path: PathBuf,
    /// Its scene.
    pub viewer_scene: Arc<ViewerScene>,
    /// Overlay applied to its scene whenever it is read.
    pub overlay: Option<Arc<dyn SceneOverlay>>,
}

/// The port that is tried first: one that no service has registered.
pub const DEFAULT_PORT: u16 = 7870;

/// Resource limits of clients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest number of connected pages; one that shows two designs is one page.
    pub sessions: usize,
    /// Largest number of other connections; further ones wait.
    pub connections: usize,
    /// Time for a request to arrive, all its headers included, and between two requests of a connection.
    pub header_time: Duration,
    /// Time limit of a connection, except for those of pages, which stay open.
    pub connection_time: Duration,
    /// Largest message of a page, bytes.
    pub message_bytes: usize,
    /// Largest number of malformed messages from a page before its connection is closed.
    pub malformed_messages: usize,
    /// Interval between two pings of a page.
    pub ping_interval: Duration,
    /// Time without any message from a page, or for a page to receive one, after which it counts as disconnected.
    pub silence: Duration,
    /// Largest total size of the files of an upload, bytes.
    pub upload_bytes: usize,
    /// Largest number of files of an upload.
    pub upload_files: usize,
    /// Largest number of concurrent uploads of all pages.
    pub uploads: usize,
    /// Time limit of an upload.
    pub upload_time: Duration,
    /// Time limit of reading the scene of an upload.
    pub reading_time: Duration,
    /// Largest number of pages that show scenes that they have opened.
    pub opened_scenes: usize,
    /// Largest memory of an opened scene, its views included, bytes.
    pub scene_memory: u64,
    /// Largest memory of all opened scenes together, bytes; at most half of what was available is used.
    pub opened_memory: u64,
    /// Largest model of an opened scene, bytes; pages take no larger one.
    pub model_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sessions: 256,
            connections: 512,
            header_time: Duration::from_secs(10),
            connection_time: Duration::from_secs(600),
            message_bytes: 1 << 16,
            malformed_messages: 16,
            ping_interval: Duration::from_secs(15),
            silence: Duration::from_secs(45),
            upload_bytes: 64 << 20,
            upload_files: 64,
            uploads: 4,
            upload_time: Duration::from_secs(60),
            reading_time: Duration::from_secs(60),
            opened_scenes: 16,
            scene_memory: 4 << 30,
            opened_memory: 8 << 30,
            model_bytes: 1 << 30,
        }
    }
}
