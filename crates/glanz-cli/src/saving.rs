//! Progress of jobs that save their state now and then.

use std::time::Duration;

use glanz_job::{CancelFlag, JobProgress, ProgressSink};
use glanz_transport::{Film, RenderSink};

use crate::messages::{Failure, Messages};
use crate::progress::Progress;

/// Time between two checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(30);

/// Shows how far a job is, and saves its state now and then.
pub(crate) struct SavingProgress<'a, State: ?Sized> {
    progress: Progress,
    save: Option<SaveState<'a, State>>,
    /// Whether the last state was saved.
    saved: Result<(), Failure>,
    cancel: CancelFlag,
    messages: Messages,
}

/// Writes a state to its file.
pub(crate) type SaveState<'a, State> = Box<dyn Fn(&State) -> Result<(), Failure> + 'a>;

impl<'a, State: ?Sized> SavingProgress<'a, State> {
    /// Shows nothing yet; saves nothing without `save`.
    pub(crate) fn start(save: Option<SaveState<'a, State>>, cancel: &CancelFlag, messages: Messages) -> Self {
        let progress = Progress::start(messages);
        Self { progress, save, saved: Ok(()), cancel: cancel.clone(), messages }
    }

    /// Takes the bar away; whether the last state was saved.
    ///
    /// # Errors
    /// Why it was not.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        self.progress.finish();
        self.saved
    }
}

impl<State: ?Sized> ProgressSink<State> for SavingProgress<'_, State> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.progress.show(progress);
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        self.save.as_ref().map(|_| CHECKPOINT_INTERVAL)
    }

    fn on_checkpoint(&mut self, state: &State) {
        let Some(save) = &self.save else { return };
        self.saved = save(state);
        // A disk that is full now may have room later: only the last time has to succeed.
        if let (Err(failure), false) = (&self.saved, self.cancel.is_cancelled()) {
            self.messages.warning(&failure.message);
        }
    }
}

impl RenderSink for SavingProgress<'_, Film> {}
