//! Reports of a running render beyond those of every job.

use std::ops::Range;

use glanz_job::{ProgressSink, Silent};

use crate::film::Film;
use crate::pixel::{PixelLayout, PixelSums};
use crate::pixel_rect::PixelRect;
use crate::weighted_sums::PassWeights;

/// A tile to which a pass has added its samples.
#[derive(Clone, Debug)]
pub struct FinishedTile<'a> {
    /// Its pixels.
    pub rect: PixelRect,
    /// The samples of the pass.
    pub pass: Range<u32>,
    /// Number of samples of each of its pixels.
    pub samples: u64,
    pub(crate) layout: PixelLayout,
    pub(crate) words: &'a [u64],
}

impl FinishedTile<'_> {
    /// Linear Rec. 709 radiance, row by row from the top left: the mean of the pixels' own samples.
    ///
    /// This is the film's picture unless a filter, integrator or pass weights samples differently: splatted light is missing, and
    /// for a film with [passes](crate::FilmFormat::passes) this is the current pass alone.
    #[must_use]
    pub fn radiance(&self) -> Vec<[f32; 3]> {
        let blend = PassWeights::plain(self.samples);
        let pixels = self.words.chunks_exact(self.layout.words());
        pixels
            .map(|words| PixelSums::read(&self.layout, words).blended(&blend).map(|v| v.mean as f32))
            .collect()
    }
}

/// Receiver of a render's progress and films. Called between passes, by the thread that called [`crate::render()`].
///
/// The film of a checkpoint has all samples so far; the last one is returned by [`crate::render()`] instead.
pub trait RenderSink: ProgressSink<Film> {
    /// Receives the film after each pass, before [`ProgressSink::on_progress`].
    fn on_pass(&mut self, film: &Film) {
        let _ = film;
    }

    /// Receiver of the tiles of a pass.
    fn tiles(&self) -> &dyn TileSink {
        &Silent
    }
}

/// Receiver of finished tiles during a pass. Called by the rendering threads, which wait for it to return.
pub trait TileSink: Sync {
    /// Receives a tile that has the samples of the pass.
    fn on_tile(&self, tile: &FinishedTile<'_>) {
        let _ = tile;
    }

    /// Whether the film is no longer needed; called before every batch of samples or photons, about a thousand at most. If so, the render ends at once with
    /// [`RenderError::Interrupted`](crate::RenderError::Interrupted).
    fn is_abandoned(&self) -> bool {
        false
    }
}

impl RenderSink for Silent {}

impl TileSink for Silent {}
