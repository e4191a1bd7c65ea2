//! Settings of the server.

use std::sync::Arc;
use std::time::Duration;

use glanz_formats::Options;

use super::dress::Dress;
use crate::stream::IntegratorName;

/// Settings of the server.
#[derive(Clone, Debug, Default)]
pub struct ServerSettings {
    /// The name or number of this machine under which others reach the server, who then need the token of its address; without one only this
    /// machine reaches it.
    pub host: Option<String>,
    /// The port: 0 takes any that is free, `None` [`DEFAULT_PORT`] or, if that is not free, any.
    pub port: Option<u16>,
    /// Threads of a render; 0 means as many as the machine has.
    pub threads: usize,
    /// What renders unless a page chooses.
    pub integrator: IntegratorName,
    /// Options of reading scenes, uploaded ones included.
    pub options: Options,
    /// Overlay applied to the scene whenever it is read; not to uploaded scenes.
    pub dress: Option<Arc<dyn Dress>>,
    /// Reads the scene again when one of its files changes.
    pub watch: bool,
    /// Resource limits of clients.
    pub limits: Limits,
}

/// The port that is tried first: one that no service has registered.
pub const DEFAULT_PORT: u16 = 7870;

/// Resource limits of clients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Pages at a time.
    pub sessions: usize,
    /// Connections at a time besides; further ones wait.
    pub connections: usize,
    /// Time for a request to arrive, all its headers included, and between two requests of a connection.
    pub header_time: Duration,
    /// Time for a connection in all, but for those of pages, which stay open.
    pub connection_time: Duration,
    /// Bytes of a message from a page.
    pub message_bytes: usize,
    /// Messages from a page that are malformed, until it is sent away.
    pub malformed_messages: usize,
    /// Time between two questions whether a page is still there.
    pub ping_interval: Duration,
    /// Time without any sign of a page, or to take what is sent to it, until it counts as gone.
    pub silence: Duration,
    /// Bytes of all files that are dropped on a page at once.
    pub upload_bytes: usize,
    /// Number of these files.
    pub upload_files: usize,
    /// Uploads at a time, of all pages.
    pub uploads: usize,
    /// Time for them to arrive.
    pub upload_time: Duration,
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
        }
    }
}
