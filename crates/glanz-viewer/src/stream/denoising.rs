//! Removal of noise from a view while it is rendered.

use std::sync::Arc;

use glanz_light::Pixels;
use glanz_transport::Film;
use tokio::sync::{OwnedMutexGuard, watch};
use tokio::task::spawn_blocking;

use super::cancel::StreamCancel;
use super::denoiser::SharedDenoiser;
use super::latest_image::LatestImage;
use super::outbox::Outbox;
use super::request::MAX_SAMPLES;
use super::tile::{Tile, tiles};

/// An image with noise.
#[derive(Debug)]
struct NoisyImage {
    pixels: Arc<Pixels>,
    /// As [`Film::hit_shares`].
    hit_shares: Vec<f32>,
    /// Per pixel.
    samples: u64,
}

/// Sender of the images to be denoised: one for each doubling of the number of samples, and the last one.
#[derive(Debug)]
pub(crate) struct NoisyImages(watch::Sender<Option<Arc<NoisyImage>>>);

impl NoisyImages {
    /// Sends the image of a film after a pass, `pixels`, if it is to be denoised. An image that is not denoised yet is replaced.
    pub(crate) fn send_if_due(&self, film: &Film, pixels: &Arc<Pixels>) {
        let samples = film.samples().total();
        let last = self.0.borrow().as_ref().map(|image| image.samples);
        // Films of pages are in memory, so that they can be read.
        if is_due(samples, last)
            && let Ok(hit_shares) = film.hit_shares()
        {
            let pixels = Arc::clone(pixels);
            self.0.send_replace(Some(Arc::new(NoisyImage { pixels, hit_shares, samples })));
        }
    }
}

/// Whether an image with this number of samples per pixel is denoised. `last`: samples of the last one.
fn is_due(samples: u64, last: Option<u64>) -> bool {
    last.is_none_or(|last| samples >= 2 * last) || samples >= u64::from(MAX_SAMPLES)
}

/// Denoising of one view, beside its rendering.
pub(crate) struct ViewDenoising {
    id: u32,
    threads: usize,
    denoiser: Arc<SharedDenoiser>,
    cancel: Arc<StreamCancel>,
    outbox: Arc<Outbox>,
    picture: Arc<LatestImage>,
    images: watch::Receiver<Option<Arc<NoisyImage>>>,
}

impl ViewDenoising {
    /// Denoising of the view `id`, and the sender of its images. `threads`: of the denoiser; 0 for all processors.
    pub(crate) fn new(
        id: u32,
        threads: usize,
        denoiser: Arc<SharedDenoiser>,
        cancel: Arc<StreamCancel>,
        outbox: Arc<Outbox>,
        picture: Arc<LatestImage>,
    ) -> (Self, NoisyImages) {
        let (sender, images) = watch::channel(None);
        (Self { id, threads, denoiser, cancel, outbox, picture, images }, NoisyImages(sender))
    }

    /// Denoises the latest image, time after time, until the sender is dropped or the stream cancelled. If this future is dropped, the denoiser
    /// ends when it finds the stream cancelled, and its result is discarded.
    ///
    /// # Errors
    /// The message of the denoiser.
    pub(crate) async fn run(mut self) -> Result<(), String> {
        while self.images.changed().await.is_ok() {
            let turn = self.denoiser.turn().await;
            // Later images may have come while another view had its turn.
            let Some(image) = self.images.borrow_and_update().clone() else { continue };
            let samples = image.samples;
            match self.denoise(image, turn).await {
                Ok((tiles, pixels)) => {
                    self.outbox.put_denoised(tiles);
                    self.picture.set_denoised(pixels, samples);
                }
                Err(_) if self.cancel.is_cancelled() => break,
                Err(message) => return Err(message),
            }
        }
        Ok(())
    }

    /// Denoises an image in a thread of its own: its tiles, and the channels with colours without noise.
    async fn denoise(
        &self,
        image: Arc<NoisyImage>,
        turn: OwnedMutexGuard<()>,
    ) -> Result<(Vec<Tile>, Pixels), String> {
        let (id, threads) = (self.id, self.threads);
        let (denoiser, cancel) = (self.denoiser.denoiser(), Arc::clone(&self.cancel));
        let denoise = move || {
            let _turn = turn;
            let colors = denoiser.denoise(&image.pixels, &image.hit_shares, threads, cancel.flag())?;
            let mut pixels = Pixels::clone(&image.pixels);
            pixels.set_rgb(&colors).map_err(|error| error.to_string())?;
            let tiles = tiles(id, &pixels, image.samples).into_iter().map(Tile::denoised).collect();
            Ok((tiles, pixels))
        };
        spawn_blocking(denoise).await.map_err(|error| error.to_string())?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_denoised_at_doublings_and_at_the_end() {
        let (mut last, mut denoised) = (None, Vec::new());
        for samples in [1, 2, 3, 5, 9, 10, 300, 599, 3000, 4000, 4096] {
            if is_due(samples, last) {
                last = Some(samples);
                denoised.push(samples);
            }
        }
        assert_eq!(denoised, [1, 2, 5, 10, 300, 3000, 4096]);
    }
}
