//! The last picture of a stream.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glanz_light::Pixels;

/// The newest whole picture of a view, to be saved.
#[derive(Debug, Default)]
pub struct LatestImage(Mutex<Option<ImageSnapshot>>);

/// A picture, and the samples of each of its pixels.
#[derive(Clone, Debug)]
pub(crate) struct ImageSnapshot {
    pub(crate) pixels: Arc<Pixels>,
    pub(crate) samples: u64,
    /// Whether its noise was removed.
    pub(crate) is_denoised: bool,
}

impl LatestImage {
    fn shot(&self) -> MutexGuard<'_, Option<ImageSnapshot>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the picture, unless that is a denoised one, which the page goes on showing.
    pub(crate) fn set(&self, pixels: Arc<Pixels>, samples: u64) {
        let mut shot = self.shot();
        if shot.as_ref().is_none_or(|shot| !shot.is_denoised) {
            *shot = Some(ImageSnapshot { pixels, samples, is_denoised: false });
        }
    }

    /// Replaces the picture by one without noise.
    pub(crate) fn set_denoised(&self, pixels: Pixels, samples: u64) {
        *self.shot() = Some(ImageSnapshot { pixels: Arc::new(pixels), samples, is_denoised: true });
    }

    /// The picture, if there is one already.
    pub(crate) fn get(&self) -> Option<ImageSnapshot> {
        self.shot().clone()
    }
}
