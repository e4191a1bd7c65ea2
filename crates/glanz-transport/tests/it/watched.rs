//! Tests of reports and cancelling within a pass.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::*;
use glanz_job::{CancelFlag, JobEnd, JobProgress, ProgressSink};
use glanz_math::DVec3;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{Film, FinishedTile, PixelRect, RenderError, RenderSink, TileSink, render};

/// 37 x 23 pixels: six tiles, those at the right and lower border smaller than the others.
const SIZE: [u32; 2] = [37, 23];

fn scene() -> SceneBuilder {
    // Its lobes are negative: some samples count against the mean.
    let filter =
        FilterDescription { kind: FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, radius: [2.0, 2.0] };
    looking(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO, SIZE, 0.9)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .light(LightDescription::infinite([0.7; 3]))
        .edit(|scene| scene.filter = filter)
}

fn expose(run: &Run, sink: &mut dyn RenderSink) -> Result<Film, RenderError> {
    let builder = scene();
    let film = Film::try_new(run.format(&builder)).unwrap();
    let (settings, integrator) = (run.settings(&builder), run.integrator_settings().build());
    let scene = resolved(&builder);
    render(&scene, integrator.as_ref(), &settings, film, sink, &CancelFlag::default())
        .map(|outcome| outcome.film)
}

/// Abandons the film after `patience` queries.
#[derive(Default)]
struct Impatient {
    patience: u64,
    asked: AtomicU64,
    tiles: AtomicU64,
    passes: u64,
}

impl ProgressSink<Film> for Impatient {
    fn on_progress(&mut self, _: &JobProgress<'_>) {
        self.passes += 1;
    }
}

impl RenderSink for Impatient {
    fn tiles(&self) -> &dyn TileSink {
        self
    }
}

impl TileSink for Impatient {
    fn on_tile(&self, _: &FinishedTile<'_>) {
        self.tiles.fetch_add(1, Ordering::Relaxed);
    }

    fn is_abandoned(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.patience
    }
}

/// Queries of the first pass, which has one sample per pixel: one per tile if samples are taken in batches, else one per sample, and of `sppm` one per
/// 1024 photons, of which two rounds of 8192 are traced before the first pass and 4096 before each pass.
fn queries(integrator: &str) -> u64 {
    match integrator {
        "whitted" => u64::from(SIZE[0] * SIZE[1]),
        "sppm" => 2 * 8 + 4 + 6,
        _ => 6,
    }
}

#[test]
fn an_abandoned_render_takes_no_further_batch() {
    for integrator in ["path", "guided", "light", "sppm", "distributed", "whitted"] {
        let first = queries(integrator);
        for (patience, passes) in [(0, 0), (1, 0), (first / 2, 0), (first - 1, 0), (first + 3, 1)] {
            let mut watch = Impatient { patience, ..Impatient::default() };
            let outcome = expose(&Run::new(integrator, 5, 64), &mut watch);
            assert!(matches!(outcome, Err(RenderError::Interrupted(_))), "{integrator} {patience}");
            // Once refused, it asks at most once more per tile.
            let asked = watch.asked.into_inner();
            assert!(asked > patience && asked <= patience + 6, "{integrator}: {asked} after {patience}");
            assert_eq!(watch.passes, passes, "{integrator} {patience}");
        }
    }
}

#[test]
fn a_render_queries_before_every_batch() {
    for integrator in ["path", "light", "sppm", "distributed", "whitted"] {
        let mut watch = Impatient { patience: u64::MAX, ..Impatient::default() };
        expose(&Run::new(integrator, 5, 8), &mut watch).unwrap();
        let (asked, samples) = (watch.asked.into_inner(), 8 * u64::from(SIZE[0] * SIZE[1]));
        if integrator == "whitted" {
            assert_eq!(asked, samples);
        } else {
            let least = if integrator == "sppm" { 2 * 8 + (4 + 6) * watch.passes } else { 6 * watch.passes };
            assert!(asked >= least && asked < samples / 50, "{integrator}: {asked}");
        }
        assert_eq!(watch.tiles.into_inner(), 6 * watch.passes);
    }
}

/// Raises a flag while the photons of the second pass are traced.
struct CancelledInPhotons {
    cancel: CancelFlag,
    passes: u64,
    asked: AtomicU64,
}

impl ProgressSink<Film> for CancelledInPhotons {
    fn on_progress(&mut self, _: &JobProgress<'_>) {
        self.passes += 1;
    }
}

impl RenderSink for CancelledInPhotons {
    fn tiles(&self) -> &dyn TileSink {
        self
    }
}

impl TileSink for CancelledInPhotons {
    fn is_abandoned(&self) -> bool {
        // The first pass has `queries("sppm")`: this is the second of the four batches of photons of the second one.
        if self.asked.fetch_add(1, Ordering::Relaxed) + 1 == queries("sppm") + 2 {
            self.cancel.cancel();
        }
        false
    }
}

#[test]
fn a_render_cancelled_while_photons_are_traced_returns_the_passes_before() {
    let (builder, run) = (scene(), Run { threads: 1, ..Run::new("sppm", 5, 64) });
    let film = Film::try_new(run.format(&builder)).unwrap();
    let cancel = CancelFlag::default();
    let mut sink = CancelledInPhotons { cancel: cancel.clone(), passes: 0, asked: AtomicU64::default() };
    let integrator = run.integrator_settings().build();
    let outcome =
        render(&resolved(&builder), integrator.as_ref(), &run.settings(&builder), film, &mut sink, &cancel)
            .unwrap();
    assert_eq!((outcome.end, sink.passes), (JobEnd::Interrupted, 1));
    // Not a single batch follows.
    assert_eq!(sink.asked.into_inner(), queries("sppm") + 2);
    let once = Run { samples: 0..1, ..run };
    assert_eq!(outcome.film, once.outcome(&builder).film);
}

/// Pixels, samples of each, radiance.
type Tile = (PixelRect, u64, Vec<[f32; 3]>);

/// Assembles a picture from tiles and compares it with the film after each pass.
#[derive(Default)]
struct Mosaic {
    tiles: Mutex<Vec<Tile>>,
    compared: u64,
}

impl ProgressSink<Film> for Mosaic {}

impl RenderSink for Mosaic {
    fn on_pass(&mut self, film: &Film) {
        let pixels = film.to_pixels().unwrap();
        let [red, green, blue] = ["R", "G", "B"].map(|name| pixels.channel(name).unwrap());
        let tiles = std::mem::take(self.tiles.get_mut().unwrap());
        assert_eq!(tiles.len(), 6);
        let mut seen = 0;
        for (rect, samples, values) in tiles {
            assert_eq!(samples, film.samples().total());
            for ([x, y], value) in rect.pixels().zip(&values) {
                let at = (y * SIZE[0] + x) as usize;
                assert_eq!(*value, [red[at], green[at], blue[at]], "{x} {y}");
                seen += 1;
            }
            assert_eq!(values.len() as u64, rect.len());
        }
        assert_eq!(seen, SIZE[0] * SIZE[1]);
        self.compared += 1;
    }

    fn tiles(&self) -> &dyn TileSink {
        self
    }
}

impl TileSink for Mosaic {
    fn on_tile(&self, tile: &FinishedTile<'_>) {
        self.tiles.lock().unwrap().push((tile.rect, tile.samples, tile.radiance()));
    }
}

#[test]
fn tiles_of_a_pass_are_the_film_after_it() {
    let mut mosaic = Mosaic::default();
    expose(&Run::new("path", 5, 16), &mut mosaic).unwrap();
    // The first pass takes one sample, so that there are two at least.
    assert!(mosaic.compared >= 2);
}
