//! The denoiser of the server.

use std::fmt;
use std::sync::Arc;

use glanz_job::CancelFlag;
use glanz_light::Pixels;
use tokio::sync::{Mutex, OwnedMutexGuard};

/// Removes the noise of rendered views.
pub trait ViewDenoiser: fmt::Debug + Send + Sync {
    /// The colours of `pixels` without noise.
    ///
    /// `pixels`: with the channels R, G, B, and those of albedo and shading normal, means over the hits of a pixel.
    /// `hit_shares`: as [`Film::hit_shares`](glanz_transport::Film::hit_shares). `threads`: their number; 0 for all processors.
    ///
    /// # Errors
    /// A message if it fails, or if `cancel` is raised.
    fn denoise(
        &self,
        pixels: &Pixels,
        hit_shares: &[f32],
        threads: usize,
        cancel: &CancelFlag,
    ) -> Result<Vec<[f32; 3]>, String>;
}

/// The denoiser of all pages, which denoises one image at a time.
#[derive(Debug)]
pub struct SharedDenoiser {
    denoiser: Arc<dyn ViewDenoiser>,
    /// Held while an image is denoised, which takes all processors and much memory.
    turn: Arc<Mutex<()>>,
}

impl SharedDenoiser {
    /// Shares `denoiser`.
    #[must_use]
    pub fn new(denoiser: Arc<dyn ViewDenoiser>) -> Self {
        Self { denoiser, turn: Arc::default() }
    }

    /// Waits until no other image is denoised. The next one begins when the guard is dropped.
    pub(crate) async fn turn(&self) -> OwnedMutexGuard<()> {
        Arc::clone(&self.turn).lock_owned().await
    }

    /// The denoiser itself.
    pub(crate) fn denoiser(&self) -> Arc<dyn ViewDenoiser> {
        Arc::clone(&self.denoiser)
    }
}
