//! Cancellation of a stream.

use glanz_job::CancelFlag;
use tokio::sync::Notify;

/// Flag for the threads that render, which also wakes the one task that waits.
#[derive(Debug, Default)]
pub(crate) struct StreamCancel {
    flag: CancelFlag,
    raised: Notify,
}

impl StreamCancel {
    /// Requests the end of the stream.
    pub(crate) fn cancel(&self) {
        self.flag.cancel();
        // Kept for the task if it does not wait right now.
        self.raised.notify_one();
    }

    /// True if the end was requested.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.flag.is_cancelled()
    }

    /// The flag for jobs that end when it is raised.
    pub(crate) fn flag(&self) -> &CancelFlag {
        &self.flag
    }

    /// Waits until the end is requested.
    pub(crate) async fn cancelled(&self) {
        while !self.is_cancelled() {
            self.raised.notified().await;
        }
    }
}
