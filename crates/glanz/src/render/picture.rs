//! Pictures: a film with its identity, and its checkpoint.

use std::path::Path;
use std::time::Duration;

use glanz_job::JobEnd;
use glanz_light::Pixels;
use glanz_transport::{Checkpoint, Counters, Film, PictureIdentity};

use super::guide_file;
use crate::error::Error;
use crate::event::Warning;
use crate::file;

/// A picture with all or a part of its samples.
#[derive(Clone, Debug)]
pub struct Picture {
    identity: PictureIdentity,
    film: Film,
    statistics: RenderStatistics,
    pub(super) warnings: Vec<Warning>,
    /// Its colours without noise, row by row; `None` if noise was not removed.
    pub(super) denoised: Option<Vec<[f32; 3]>>,
}

/// Statistics of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderStatistics {
    /// Reason for its end.
    pub end: JobEnd,
    /// Wall time of the render loop.
    pub elapsed: Duration,
    /// Number of rays.
    pub counters: Counters,
    /// Number of samples over all pixels.
    pub samples: u64,
    /// Number of searches for hits on freeform surfaces that ended without a decision.
    pub undecided: u64,
    /// Number of threads.
    pub threads: usize,
}

impl Default for RenderStatistics {
    /// Statistics without a render.
    fn default() -> Self {
        let (elapsed, counters) = Default::default();
        Self { end: JobEnd::Complete, elapsed, counters, samples: 0, undecided: 0, threads: 0 }
    }
}

impl Picture {
    pub(crate) fn new(
        identity: PictureIdentity,
        film: Film,
        statistics: RenderStatistics,
        warnings: Vec<Warning>,
    ) -> Self {
        Self { identity, film, statistics, warnings, denoised: None }
    }

    /// The identity of the picture: everything that it depends on.
    #[must_use]
    pub fn identity(&self) -> &PictureIdentity {
        &self.identity
    }

    /// The film: sums and sample numbers.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Statistics of the render of this picture; zero for a merged picture.
    #[must_use]
    pub fn statistics(&self) -> &RenderStatistics {
        &self.statistics
    }

    /// Warnings of the render, in order of occurrence.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Whether its sums are in a temporary file and not in memory.
    #[cfg(feature = "formats")]
    pub(super) fn is_in_file(&self) -> bool {
        self.film.is_in_file() && self.denoised.is_none()
    }

    /// Whether the noise of its colours was removed.
    #[must_use]
    pub fn is_denoised(&self) -> bool {
        self.denoised.is_some()
    }

    /// The planes of the picture, linear light; the colours without noise, if it was removed (variances stay those of the noisy colours).
    ///
    /// # Errors
    /// [`Error::Pixels`] if two channels have the same name, [`Error::Film`] if the temporary file of a large picture failed.
    pub fn pixels(&self) -> Result<Pixels, Error> {
        let mut pixels = self.film.to_pixels()?;
        if let Some(colors) = &self.denoised {
            pixels.set_rgb(colors)?;
        }
        Ok(pixels)
    }

    /// Writes film and identity to a file, to be resumed by a [`RenderBuilder`](super::RenderBuilder) or [merged](crate::merge).
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_checkpoint(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        file::write_with(path.as_ref(), |out| Checkpoint::write(&self.identity, &self.film, out))
    }

    /// Writes the guide learnt in the last complete pass, for [`RenderOptions::guide_input`](super::RenderOptions::guide_input).
    ///
    /// # Errors
    /// [`Error::NoGuide`] if none was learnt, [`Error::File`].
    pub fn save_guide(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let integrator = self.identity.integrator.name();
        let training = self.film.training().ok_or(Error::NoGuide { integrator })?;
        guide_file::write(path.as_ref(), training.guide())
    }
}
