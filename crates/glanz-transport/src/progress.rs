//! What a render tells while it runs.

use std::ops::Range;
use std::time::Duration;

use crate::film::Film;
use crate::pixel::{PixelLayout, PixelSums};
use crate::pixel_rect::PixelRect;
use crate::settled::Blend;

/// How far a render is, after a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgressReport {
    /// Samples per pixel that the film has of those wanted, also from earlier runs.
    pub samples_done: u64,
    /// Samples per pixel wanted.
    pub samples_wanted: u64,
    /// Rays of this run so far.
    pub rays: u64,
    /// Since the render began.
    pub elapsed: Duration,
    /// Until it ends, by samples or by the time limit, whichever comes first.
    pub remaining: Duration,
}

impl ProgressReport {
    /// Share of the render's time that has passed, [0, 1].
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let (elapsed, remaining) = (self.elapsed.as_secs_f64(), self.remaining.as_secs_f64());
        if remaining == 0.0 { 1.0 } else { elapsed / (elapsed + remaining) }
    }
}

/// A tile to which a pass has added its samples.
#[derive(Clone, Debug)]
pub struct FinishedTile<'a> {
    /// Its pixels.
    pub rect: PixelRect,
    /// The samples of the pass.
    pub pass: Range<u32>,
    /// Samples that each of its pixels has now.
    pub samples: u64,
    pub(crate) layout: PixelLayout,
    pub(crate) words: &'a [u64],
}

impl FinishedTile<'_> {
    /// Linear Rec. 709 radiance, row by row from the top left: the mean of the pixels' own samples.
    ///
    /// That is what the film will have if no filter, integrator or pass weighs samples otherwise: light that is splatted is missing, and
    /// of a film with [passes](crate::FilmFormat::passes) this is the pass under way alone.
    #[must_use]
    pub fn radiance(&self) -> Vec<[f32; 3]> {
        let blend = Blend::plain(self.samples);
        let pixels = self.words.chunks_exact(self.layout.words());
        pixels
            .map(|words| PixelSums::read(&self.layout, words).blended(&blend).map(|v| v.mean as f32))
            .collect()
    }
}

/// Someone who wants to know. Called between passes, by the thread that called [`crate::render()`].
pub trait Progress {
    /// A pass has ended.
    fn report(&mut self, report: &ProgressReport);

    /// The interval between checkpoints is over: `film` has everything so far. Not called after the last pass, whose
    /// film [`crate::render()`] returns.
    fn checkpoint(&mut self, film: &Film) {
        let _ = film;
    }

    /// A pass has ended, after which there is this film. Called before [`Progress::report`].
    fn exposed(&mut self, film: &Film) {
        let _ = film;
    }

    /// Who wants to know more, and at once.
    fn watch(&self) -> &dyn Watch {
        &Silent
    }
}

/// Someone who looks on in the midst of a pass. Called by the threads that render, which wait for the answer.
pub trait Watch: Sync {
    /// A tile has got the samples of the pass.
    fn tile(&self, tile: &FinishedTile<'_>) {
        let _ = tile;
    }

    /// Whether the film is of no use any more: asked before every sample. The render ends with
    /// [`RenderError::Cancelled`](crate::RenderError::Cancelled) then.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody wants to know.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&mut self, _: &ProgressReport) {}
}

impl Watch for Silent {}
