//! The wish that a stream ends.

use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::Notify;

/// Raised once, seen by the threads that render and by the one task that waits.
#[derive(Debug, Default)]
pub(crate) struct Cancel {
    raised: AtomicBool,
    news: Notify,
}

impl Cancel {
    /// From now on the stream is to end.
    pub(crate) fn raise(&self) {
        self.raised.store(true, Ordering::Relaxed);
        // Kept for the task if it does not wait right now.
        self.news.notify_one();
    }

    /// Whether it is to end.
    pub(crate) fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// Waits until it is to end.
    pub(crate) async fn raised(&self) {
        while !self.is_raised() {
            self.news.notified().await;
        }
    }
}
