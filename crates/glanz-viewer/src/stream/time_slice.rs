//! Time slices of a render.

use std::sync::Arc;
use std::time::Instant;

use glanz_job::{CancelFlag, JobProgress, ProgressSink};
use glanz_scene::Scene;
use glanz_transport::{Film, FinishedTile, Integrator, RenderError, RenderSink, TileSink, render};
use tokio::sync::watch;

use super::cancel::StreamCancel;
use super::denoising::NoisyImages;
use super::latest_image::LatestImage;
use super::noise::noise;
use super::outbox::{Outbox, StreamStatus};
use super::processors::{Processors, TIME_SLICE};
use super::request::{MAX_SAMPLES, StreamPlan};
use super::tile::{Tile, tiles};

/// State shared by the time slices of one view.
pub(crate) struct StreamView {
    /// Its number.
    pub(crate) id: u32,
    /// With the camera of the view.
    pub(crate) scene: Scene,
    pub(crate) plan: StreamPlan,
    pub(crate) integrator: Box<dyn Integrator>,
    pub(crate) cancel: Arc<StreamCancel>,
    /// Whether the page does not want more samples for now.
    pub(crate) paused: watch::Receiver<bool>,
    pub(crate) outbox: Arc<Outbox>,
    pub(crate) picture: Arc<LatestImage>,
    pub(crate) processors: Arc<Processors>,
    /// Receiver of images to be denoised, if they are.
    pub(crate) noisy: Option<NoisyImages>,
}

/// State after a time slice.
pub(crate) struct TimeSlice {
    pub(crate) film: Film,
    /// Time spent rendering so far.
    pub(crate) seconds: f64,
}

impl StreamView {
    /// Continues from an earlier time slice until the view has all samples, is paused, or another render waits.
    ///
    /// # Errors
    /// [`RenderError`]; [`RenderError::Interrupted`] if the stream was cancelled.
    pub(crate) fn run_time_slice(&self, before: TimeSlice) -> Result<TimeSlice, RenderError> {
        let over = CancelFlag::default();
        let samples = before.film.samples().total();
        let mut sink = StreamSink {
            view: self,
            over: &over,
            begun: Instant::now(),
            before: before.seconds,
            samples,
            noise: None,
        };
        let settings = &self.plan.settings;
        let outcome = render(&self.scene, self.integrator.as_ref(), settings, before.film, &mut sink, &over)?;
        Ok(TimeSlice { film: outcome.film, seconds: before.seconds + outcome.elapsed.as_secs_f64() })
    }
}

/// True if a view with this film is finished.
pub(crate) fn is_done(film: &Film) -> bool {
    film.samples().total() >= u64::from(MAX_SAMPLES)
}

/// Progress sink that writes tiles and status to the outbox.
struct StreamSink<'a> {
    view: &'a StreamView,
    /// Raised at the end of the time slice.
    over: &'a CancelFlag,
    begun: Instant,
    /// Seconds of earlier time slices.
    before: f64,
    /// Samples that every pixel had after the last pass.
    samples: u64,
    noise: Option<f64>,
}

impl StreamSink<'_> {
    /// True if a pass of `length` samples is sent tile by tile: passes of one sample may take long, longer ones take about half a second.
    fn is_tiled(&self, length: u64) -> bool {
        // Passes of an integrator that learns must be weighted first.
        length == 1 && !self.view.plan.format.passes
    }
}

impl RenderSink for StreamSink<'_> {
    fn on_pass(&mut self, film: &Film) {
        let samples = film.samples().total();
        let length = samples - self.samples;
        self.samples = samples;
        if self.is_abandoned() {
            return;
        }
        // Fails only for the size, which is that of the film.
        let Ok(pixels) = film.to_pixels() else { return };
        self.noise = noise(&pixels);
        if !self.is_tiled(length) {
            self.view.outbox.put_picture(tiles(self.view.id, &pixels, samples));
        }
        let pixels = Arc::new(pixels);
        if let Some(noisy) = &self.view.noisy {
            noisy.send_if_due(film, &pixels);
        }
        self.view.picture.set(pixels, samples);
    }

    fn tiles(&self) -> &dyn TileSink {
        self
    }
}

impl ProgressSink<Film> for StreamSink<'_> {
    fn on_progress(&mut self, _: &JobProgress<'_>) {
        let elapsed = self.begun.elapsed();
        let status = StreamStatus::Progress {
            samples: self.samples,
            noise: self.noise,
            seconds: self.before + elapsed.as_secs_f64(),
            done: self.samples >= u64::from(MAX_SAMPLES),
        };
        self.view.outbox.put_status(self.view.id, status);
        let is_long = elapsed >= TIME_SLICE && self.view.processors.are_wanted();
        if is_long || *self.view.paused.borrow() {
            self.over.cancel();
        }
    }
}

impl TileSink for StreamSink<'_> {
    fn on_tile(&self, tile: &FinishedTile<'_>) {
        if self.is_tiled(tile.pass.len() as u64) && !self.is_abandoned() {
            let radiance = tile.radiance().into_iter();
            let tile = Tile::new(self.view.id, tile.rect.min, tile.rect.size, tile.samples, radiance);
            self.view.outbox.put_tile(tile);
        }
    }

    fn is_abandoned(&self) -> bool {
        self.view.cancel.is_cancelled()
    }
}
