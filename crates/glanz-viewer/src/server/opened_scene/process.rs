//! The process of an opened scene, and its supervision.

use std::fmt;
use std::io;
use std::process::{ExitStatus, Stdio};
use std::sync::Arc;
use std::time::Duration;

use glanz_job::ResourceLimits;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::process::{Child, ChildStderr, ChildStdin};
use tokio::sync::{Mutex, Notify, mpsc, oneshot, watch};
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::memory::{SceneMemory, own_memory};
use super::{SceneSlot, UploadPermits};
use crate::server::settings::Limits;
use crate::server::upload::UploadFolder;
use crate::server::viewer_scene::VIEW_REMEDY;
use crate::server::worker::{
    FrameKind, START_FAILURE, WorkerCommand, WorkerFrame, receive_frames, write_frame,
};

/// Interval between measurements of a process. What it can allocate within that is bounded by its own limits, too.
const WATCH_INTERVAL: Duration = Duration::from_millis(50);

/// Time for a process to exit once it has closed its output.
const EXIT_TIME: Duration = Duration::from_secs(5);

/// Largest number of requests that wait for the process.
const MOST_REQUESTS: usize = 256;

/// Number of them that queries leave to requests about views.
const RESERVED_REQUESTS: usize = 32;

/// Largest number of bytes of the error output of a process that are kept.
const MOST_ERRORS: usize = 4096;

/// Reasons for the end of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SceneEnd {
    /// It is no longer wanted.
    Left,
    /// It needs more bytes than a scene may have.
    TooLarge(u64),
    /// All scenes together need more bytes than they may have, and this one the most.
    TooLargeTogether(u64),
    /// It has not read the scene within this time.
    TooSlow(Duration),
    /// It cannot begin.
    Unstarted,
    /// It has ended by itself.
    Stopped,
}

/// The sentence that pages show.
impl fmt::Display for SceneEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gigabytes = |bytes: u64| bytes as f64 / 1e9;
        match *self {
            Self::Left => write!(f, "the page has left its scene"),
            Self::TooLarge(most) => {
                write!(f, "the scene needs more than {:.1} GB of memory; {VIEW_REMEDY}", gigabytes(most))
            }
            Self::TooLargeTogether(most) => write!(
                f,
                "the scenes that pages have opened need more than {:.1} GB of memory together; close other pages, or {VIEW_REMEDY}",
                gigabytes(most)
            ),
            Self::TooSlow(time) => {
                write!(f, "reading the scene took longer than {} s; {VIEW_REMEDY}", time.as_secs_f64())
            }
            Self::Unstarted => {
                write!(f, "the program that reads files cannot be started; start glanz view again")
            }
            Self::Stopped => {
                write!(f, "the program that reads the scene stopped unexpectedly; open the file again")
            }
        }
    }
}

/// A running process, ended when the value is dropped.
#[derive(Debug)]
pub(super) struct SceneProcess {
    requests: mpsc::Sender<WorkerFrame>,
    frames: Mutex<mpsc::Receiver<WorkerFrame>>,
    is_read: Arc<Notify>,
    end: watch::Receiver<Option<SceneEnd>>,
    /// Its drop is the signal to end the process.
    _wanted: oneshot::Sender<()>,
}

impl SceneProcess {
    /// Starts a process for the task in a folder. Folder and slot are kept until it has ended, and `permits` until [`set_read`](Self::set_read), or its end
    /// before that.
    ///
    /// # Errors
    /// The error of the system.
    pub(super) fn start(
        command: &WorkerCommand,
        (folder, slot): (UploadFolder, SceneSlot),
        permits: UploadPermits,
        limits: &Limits,
        memory: Arc<SceneMemory>,
    ) -> io::Result<Self> {
        let mut command = command.to_command(folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).kill_on_drop(true);
        let mut child = command.spawn()?;
        let (Some(input), Some(output), Some(errors)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err(io::Error::other("it has no pipes"));
        };
        let (requests, receiver) = mpsc::channel(MOST_REQUESTS);
        tokio::spawn(write_requests(receiver, input));
        let (frames, reader) = receive_frames(output);
        let (wanted, unwanted) = oneshot::channel();
        let (end, receiver) = watch::channel(None);
        let is_read = Arc::new(Notify::new());
        let supervisor = Supervisor {
            child,
            limits: *limits,
            memory,
            unwanted,
            is_read: Arc::clone(&is_read),
            reader,
            errors: tokio::spawn(last_errors(errors)),
        };
        tokio::spawn(async move {
            let reason = supervisor.run(permits).await;
            // In this order: who learns of the end finds nothing of the process.
            drop((folder, slot));
            end.send_replace(Some(reason));
        });
        Ok(Self { requests, frames: Mutex::new(frames), is_read, end: receiver, _wanted: wanted })
    }

    /// Records that the scene is read: from now on the process may take its time.
    pub(super) fn set_read(&self) {
        self.is_read.notify_one();
    }

    /// Sends a request. Returns false if too many wait.
    pub(super) fn send(&self, text: &str, is_query: bool) -> bool {
        if is_query && !self.requests.is_closed() && self.requests.capacity() <= RESERVED_REQUESTS {
            return false;
        }
        let frame = WorkerFrame { kind: FrameKind::Text, bytes: text.as_bytes().to_vec() };
        // A process that has ended takes no more, which `next` reports.
        !matches!(self.requests.try_send(frame), Err(mpsc::error::TrySendError::Full(_)))
    }

    /// Waits for the next frame.
    ///
    /// # Errors
    /// The reason why the process has ended.
    pub(super) async fn next(&self) -> Result<WorkerFrame, SceneEnd> {
        match self.frames.lock().await.recv().await {
            Some(frame) => Ok(frame),
            None => Err(reason(self.end.clone()).await),
        }
    }

    /// Ends the process and waits until nothing is left of it.
    pub(super) async fn end(self) {
        let end = self.end.clone();
        drop(self);
        reason(end).await;
    }
}

/// The reason for the end of a process, once it has ended.
async fn reason(mut end: watch::Receiver<Option<SceneEnd>>) -> SceneEnd {
    // An error if the server shuts down.
    end.wait_for(Option::is_some).await.ok().and_then(|end| *end).unwrap_or(SceneEnd::Stopped)
}

/// Task that ends a process when it is time to.
struct Supervisor {
    child: Child,
    limits: Limits,
    memory: Arc<SceneMemory>,
    /// Resolved when nobody wants the process any more.
    unwanted: oneshot::Receiver<()>,
    is_read: Arc<Notify>,
    /// Task that receives the frames of the process.
    reader: JoinHandle<()>,
    errors: JoinHandle<String>,
}

impl Supervisor {
    /// Waits until the process has ended, or ends it. Nothing of it runs when this returns.
    async fn run(mut self, permits: UploadPermits) -> SceneEnd {
        let id = self.child.id();
        let mut permits = Some(permits);
        let reason = self.watch(&mut permits).await;
        // It may have ended by itself.
        let _ = self.child.kill().await;
        drop(permits);
        if let Some(id) = id {
            self.memory.remove(id);
        }
        match reason {
            Ok(reason) => reason,
            Err(_) => match timeout(EXIT_TIME, self.errors).await {
                // The text of Rust's allocator, after which the process aborts.
                Ok(Ok(text)) if text.contains("memory allocation of") => {
                    SceneEnd::TooLarge(self.limits.scene_memory)
                }
                Ok(Ok(text)) if text.contains(START_FAILURE) => SceneEnd::Unstarted,
                _ => SceneEnd::Stopped,
            },
        }
    }

    /// Waits for a reason to end the process. The error is how it has ended by itself.
    /// `permits` are released when the scene is read.
    async fn watch(
        &mut self,
        permits: &mut Option<UploadPermits>,
    ) -> Result<SceneEnd, io::Result<ExitStatus>> {
        let Self { child, limits, memory, unwanted, is_read, reader, .. } = self;
        let process = child.id().unwrap_or(0);
        // The default is three quarters of what is available: here it is half.
        let available = ResourceLimits::default().memory / 3 * 2;
        let opened_memory = available.min(limits.opened_memory);
        let mut late = std::pin::pin!(sleep(limits.reading_time));
        let mut lingering = std::pin::pin!(async {
            let _ = reader.await;
            sleep(EXIT_TIME).await;
        });
        let mut ticks = interval(WATCH_INTERVAL);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                status = child.wait() => {
                    return Err(status);
                }
                _ = &mut *unwanted => return Ok(SceneEnd::Left),
                () = is_read.notified() => drop(permits.take()),
                () = &mut late, if permits.is_some() => return Ok(SceneEnd::TooSlow(limits.reading_time)),
                () = &mut lingering => return Ok(SceneEnd::Stopped),
                _ = ticks.tick() => {
                    let bytes = own_memory(process);
                    if bytes > limits.scene_memory {
                        return Ok(SceneEnd::TooLarge(limits.scene_memory));
                    }
                    if memory.record(process, bytes, opened_memory) {
                        return Ok(SceneEnd::TooLargeTogether(opened_memory));
                    }
                }
            }
        }
    }
}

/// Writes requests to the process until either ends.
async fn write_requests(mut requests: mpsc::Receiver<WorkerFrame>, mut input: ChildStdin) {
    while let Some(frame) = requests.recv().await {
        if write_frame(&mut input, &frame).await.is_err() || input.flush().await.is_err() {
            return;
        }
    }
}

/// The last part of the error output of a process.
async fn last_errors(mut errors: ChildStderr) -> String {
    let (mut last, mut piece) = (Vec::new(), vec![0; MOST_ERRORS]);
    while let Ok(count @ 1..) = errors.read(&mut piece).await {
        last.extend_from_slice(piece.get(..count).unwrap_or_default());
        last.drain(..last.len().saturating_sub(MOST_ERRORS));
    }
    String::from_utf8_lossy(&last).into_owned()
}
