//! The last picture of a stream.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_light::Pixels;

/// The newest whole picture of what a page renders, to be saved.
#[derive(Debug, Default)]
pub struct LatestImage(Mutex<Option<ImageSnapshot>>);

/// A picture, and the samples of each of its pixels.
#[derive(Clone, Debug)]
pub(crate) struct ImageSnapshot {
    pub(crate) pixels: Arc<Pixels>,
    pub(crate) samples: u64,
}

impl LatestImage {
    fn shot(&self) -> MutexGuard<'_, Option<ImageSnapshot>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn set(&self, pixels: Pixels, samples: u64) {
        *self.shot() = Some(ImageSnapshot { pixels: Arc::new(pixels), samples });
    }

    /// The picture, if there is one already.
    pub(crate) fn get(&self) -> Option<ImageSnapshot> {
        self.shot().clone()
    }

    pub(crate) fn clear(&self) {
        *self.shot() = None;
    }
}
