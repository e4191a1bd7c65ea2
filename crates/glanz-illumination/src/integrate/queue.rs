//! Order of the parts of an integral in a binary heap.

use std::cmp::Ordering;

/// A part of an integral in a heap whose top has the largest error.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueueEntry<T> {
    pub(super) error: f64,
    pub(super) part: T,
}

impl<T> PartialEq for QueueEntry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for QueueEntry<T> {}

impl<T> PartialOrd for QueueEntry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for QueueEntry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}
