//! The denoiser of the viewer's page.

use glanz_denoise::{DenoiseError, Denoiser};
use glanz_job::{CancelFlag, Silent};
use glanz_light::Pixels;
use glanz_viewer::stream::ViewDenoiser;

use crate::render::noisy_picture;

/// Open Image Denoise for views of the page.
#[derive(Debug)]
pub struct LibraryDenoiser(Denoiser);

impl LibraryDenoiser {
    /// Loads the library, as [`Denoiser::load`].
    ///
    /// # Errors
    /// As [`Denoiser::load`].
    pub fn load() -> Result<Self, DenoiseError> {
        Denoiser::load().map(Self)
    }
}

impl ViewDenoiser for LibraryDenoiser {
    fn denoise(
        &self,
        pixels: &Pixels,
        hit_shares: &[f32],
        threads: usize,
        cancel: &CancelFlag,
    ) -> Result<Vec<[f32; 3]>, String> {
        let noisy = noisy_picture(pixels, hit_shares);
        self.0.denoise(noisy, threads, &mut Silent, cancel).map_err(|error| error.to_string())
    }
}
