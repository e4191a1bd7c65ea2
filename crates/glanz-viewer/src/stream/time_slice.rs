//! Time slices of a render.

use std::sync::Arc;
use std::time::Instant;

use glanz_job::{CancelFlag, JobProgress, ProgressSink};
use glanz_light::Pixels;
use glanz_scene::Scene;
use glanz_transport::{Film, FinishedTile, Integrator, RenderError, RenderSink, TileSink, render};

use super::cancel::StreamCancel;
use super::latest_image::LatestImage;
use super::noise::noise;
use super::outbox::{Outbox, StreamStatus};
use super::processors::{Processors, TIME_SLICE};
use super::request::{MAX_SAMPLES, StreamPlan};
use super::tile::Tile;

/// Side of the tiles of a whole picture, pixels: few messages, none of them long.
const SIDE: u32 = 128;

/// State shared by the time slices of one view.
pub(crate) struct StreamView {
    /// Its number.
    pub(crate) id: u32,
    /// With the camera of the view.
    pub(crate) scene: Scene,
    pub(crate) plan: StreamPlan,
    pub(crate) integrator: Box<dyn Integrator>,
    pub(crate) cancel: Arc<StreamCancel>,
    pub(crate) outbox: Arc<Outbox>,
    pub(crate) picture: Arc<LatestImage>,
    pub(crate) processors: Arc<Processors>,
}

/// State after a time slice.
pub(crate) struct TimeSlice {
    pub(crate) film: Film,
    /// Time spent rendering so far.
    pub(crate) seconds: f64,
}

impl StreamView {
    /// Continues from an earlier time slice until the view has all samples or another render waits.
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
        if elapsed >= TIME_SLICE && self.view.processors.are_wanted() {
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

/// An image cut into tiles.
fn tiles(id: u32, pixels: &Pixels, samples: u64) -> Vec<Tile> {
    let [width, height] = [pixels.width(), pixels.height()];
    let bands = ["R", "G", "B"].map(|name| pixels.channel(name).unwrap_or_default());
    let at = |x: u32, y: u32| {
        let index = y as usize * width as usize + x as usize;
        bands.map(|band| band.get(index).copied().unwrap_or_default())
    };
    let starts = |length: u32| (0..length).step_by(SIDE as usize);
    let places = starts(height).flat_map(|y| starts(width).map(move |x| [x, y]));
    let tile = |[x, y]: [u32; 2]| {
        let size = [(width - x).min(SIDE), (height - y).min(SIDE)];
        let radiance = (y..y + size[1]).flat_map(|row| (x..x + size[0]).map(move |column| at(column, row)));
        Tile::new(id, [x, y], size, samples, radiance)
    };
    places.map(tile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_of_a_picture_cover_it_once_in_rows() {
        let (width, height) = (300, 130);
        let rgb: Vec<[f32; 3]> =
            (0..width * height).map(|i| [(i % 300) as f32, (i / 300) as f32, 1.0]).collect();
        let pixels = Pixels::try_from_rgb(width, height, &rgb).unwrap();
        let tiles = tiles(9, &pixels, 5);
        let places: Vec<_> = tiles.iter().map(|tile| tile.min).collect();
        assert_eq!(places, [[0, 0], [128, 0], [256, 0], [0, 128], [128, 128], [256, 128]]);
        // 20 bytes before the pixels, 6 each: 44 x 2 pixels in the last corner.
        assert_eq!(tiles[5].bytes.len(), 20 + 6 * 44 * 2);
        // Its second row begins at (256, 129). 256 and 129 as half floats: 2^8 is 0x5c00, 129 = 2^7 (1 + 8/1024) is 0x5808.
        let second = 20 + 6 * 44;
        assert_eq!(tiles[5].bytes[second..second + 4], [0x00, 0x5c, 0x08, 0x58]);
    }
}
