//! A running job, and the sink that serves its options.

use std::path::{Path, PathBuf};
use std::time::Duration;

use glanz_job::{CheckpointLock, JobProgress, ProgressSink};

use crate::error::Error;
use crate::event::{JobEvent, Warning};
use crate::file;
use crate::job_options::JobOptions;

/// Longest time between two checkpoints, if writing one takes little of it.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(30);

/// A running job: its options and its warnings so far.
pub(crate) struct RunningJob<'a> {
    pub(crate) options: JobOptions<'a>,
    pub(crate) warnings: Vec<Warning>,
    /// Keeps other processes from writing the checkpoint.
    pub(crate) lock: Option<CheckpointLock>,
}

impl RunningJob<'_> {
    /// Claims the checkpoint; refuses one that cannot be written, that another process writes, or that exists and is not to be resumed.
    pub(crate) fn claim_checkpoint(&mut self) -> Result<(), Error> {
        let Some(path) = self.options.checkpoint.as_deref() else { return Ok(()) };
        file::check_writable(path)?;
        self.lock = file::claim_checkpoint(path)?;
        // After the claim, before which another process may have written it.
        file::check_resumable(path, self.options.resume)
    }

    /// The checkpoint to resume, if it exists.
    pub(crate) fn resumed(&mut self) -> Option<PathBuf> {
        let path = self.options.checkpoint.clone().filter(|_| self.options.resume)?;
        if path.exists() {
            return Some(path);
        }
        self.emit(JobEvent::NoCheckpoint(&path));
        None
    }

    pub(crate) fn emit(&mut self, event: JobEvent<'_>) {
        if let Some(events) = &mut self.options.events {
            events(event);
        }
    }

    pub(crate) fn warn(&mut self, warning: Warning) {
        self.emit(JobEvent::Warning(&warning));
        self.warnings.push(warning);
    }

    /// The number of threads.
    pub(crate) fn threads(&self) -> usize {
        match self.options.threads {
            0 => rayon::current_num_threads(),
            threads => threads,
        }
    }

    /// Runs `work` with the requested number of threads.
    pub(crate) fn in_pool<T: Send>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, Error> + Send,
    ) -> Result<T, Error> {
        if self.options.threads == 0 {
            return work(self);
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.options.threads).build()?;
        pool.install(|| work(self))
    }
}

/// Passes progress on and writes the checkpoints of a running job.
pub(crate) struct JobSink<'a, 'o, W> {
    job: &'a mut RunningJob<'o>,
    /// The checkpoint, if there is one.
    path: Option<PathBuf>,
    /// Writes a state to a file.
    write: W,
    /// Result of writing the last checkpoint.
    pub(crate) written: Result<(), Error>,
}

impl<'a, 'o, W> JobSink<'a, 'o, W> {
    pub(crate) fn new(job: &'a mut RunningJob<'o>, path: Option<PathBuf>, write: W) -> Self {
        Self { job, path, write, written: Ok(()) }
    }
}

impl<State, W: FnMut(&Path, &State) -> Result<(), Error>> ProgressSink<State> for JobSink<'_, '_, W> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        if let Some(sink) = &mut self.job.options.sink {
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
            && !self.job.options.cancel.is_cancelled()
            && let Some(events) = &mut self.job.options.events
        {
            events(JobEvent::CheckpointFailed(error));
        }
    }
}
