//! Options that every job takes, and the sink that serves them while it runs.

use std::path::{Path, PathBuf};
use std::time::Duration;

use glanz_job::{CancelFlag, JobProgress, ProgressSink};

use crate::error::Error;
use crate::event::{JobEvent, Warning};
use crate::file;

/// Time between two checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(30);

/// The methods of [`JobOptions`], which all builders have over their field `job`.
macro_rules! job_methods {
    ($lifetime:lifetime $(, $job:ident)?) => {
        /// Runs with `count` threads; 0, the default, uses all processors. The result does not depend on the number.
        pub fn threads(mut self, count: usize) -> Self {
            self$(.$job)?.threads = count;
            self
        }

        /// Saves the state of the job in this file, every 30 seconds and at the end; by default in none.
        pub fn checkpoint(mut self, path: impl Into<Option<std::path::PathBuf>>) -> Self {
            self$(.$job)?.checkpoint = path.into();
            self
        }

        /// Whether to resume from the checkpoint if it exists; otherwise an existing one is an error.
        pub fn resume(mut self, resume: bool) -> Self {
            self$(.$job)?.resume = resume;
            self
        }

        /// Reports the progress to `sink`.
        pub fn on_progress(mut self, sink: &$lifetime mut (dyn glanz_job::ProgressSink + Send)) -> Self {
            self$(.$job)?.sink = Some(sink);
            self
        }

        /// Reports warnings and other events to `events` as they occur.
        pub fn on_event(
            mut self,
            events: &$lifetime mut (dyn FnMut($crate::JobEvent<'_>) + Send),
        ) -> Self {
            self$(.$job)?.events = Some(events);
            self
        }

        /// Ends the job when `flag` is raised.
        pub fn cancel(mut self, flag: glanz_job::CancelFlag) -> Self {
            self$(.$job)?.cancel = flag;
            self
        }
    };
}

pub(crate) use job_methods;

/// Options that every job takes.
#[derive(Default)]
#[must_use = "options have no effect before they are given to a builder"]
pub struct JobOptions<'a> {
    /// 0: all processors of the machine.
    pub(crate) threads: usize,
    pub(crate) checkpoint: Option<PathBuf>,
    pub(crate) resume: bool,
    pub(crate) cancel: CancelFlag,
    pub(crate) sink: Option<&'a mut (dyn ProgressSink + Send)>,
    pub(crate) events: Option<&'a mut (dyn FnMut(JobEvent<'_>) + Send)>,
    pub(crate) warnings: Vec<Warning>,
}

impl<'a> JobOptions<'a> {
    job_methods!('a);
}

impl JobOptions<'_> {
    /// Refuses a checkpoint that cannot be written, or that exists and is not to be resumed.
    pub(crate) fn check_checkpoint(&self) -> Result<(), Error> {
        self.checkpoint.as_deref().map_or(Ok(()), |path| file::check_checkpoint(path, self.resume))
    }

    /// The checkpoint to resume, if it exists.
    pub(crate) fn resumed(&mut self) -> Option<PathBuf> {
        let path = self.checkpoint.clone().filter(|_| self.resume)?;
        if path.exists() {
            return Some(path);
        }
        self.emit(JobEvent::NoCheckpoint(&path));
        None
    }

    pub(crate) fn emit(&mut self, event: JobEvent<'_>) {
        if let Some(events) = &mut self.events {
            events(event);
        }
    }

    pub(crate) fn warn(&mut self, warning: Warning) {
        self.emit(JobEvent::Warning(&warning));
        self.warnings.push(warning);
    }

    /// Runs `work` with the requested number of threads.
    #[cfg(any(feature = "radiosity", feature = "illumination"))]
    pub(crate) fn in_pool<T: Send>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, Error> + Send,
    ) -> Result<T, Error> {
        if self.threads == 0 {
            return work(self);
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build()?;
        pool.install(|| work(self))
    }
}

/// Passes progress on and writes the checkpoints of a running job.
pub(crate) struct JobSink<'a, 'o, W> {
    job: &'a mut JobOptions<'o>,
    /// The checkpoint, if there is one.
    path: Option<PathBuf>,
    /// Writes a state to a file.
    write: W,
    /// Result of writing the last checkpoint.
    pub(crate) written: Result<(), Error>,
    /// The last estimate of the relative standard error.
    pub(crate) error: Option<f64>,
}

impl<'a, 'o, W> JobSink<'a, 'o, W> {
    pub(crate) fn new(job: &'a mut JobOptions<'o>, path: Option<PathBuf>, write: W) -> Self {
        Self { job, path, write, written: Ok(()), error: None }
    }
}

impl<State, W: FnMut(&Path, &State) -> Result<(), Error>> ProgressSink<State> for JobSink<'_, '_, W> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.error = progress.error.or(self.error);
        if let Some(sink) = &mut self.job.sink {
            sink.on_progress(progress);
        }
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        self.path.as_ref().map(|_| CHECKPOINT_INTERVAL)
    }

    fn on_checkpoint(&mut self, state: &State) {
        let Some(path) = &self.path else { return };
        self.written = (self.write)(path, state);
        // A disk that is full now may have room later: the job continues, only the last checkpoint has to succeed.
        if let Err(error) = &self.written
            && !self.job.cancel.is_cancelled()
            && let Some(events) = &mut self.job.events
        {
            events(JobEvent::CheckpointFailed(error));
        }
    }
}
