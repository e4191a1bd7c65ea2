//! Views without noise. The denoisers of these tests compute nothing, so that it is known what is shown and when.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use glanz_formats::image;
use glanz_job::CancelFlag;
use glanz_light::Pixels;
use glanz_viewer::server::ServerSettings;
use glanz_viewer::stream::ViewDenoiser;
use serde_json::{Value, json};

use super::client::{BALL, ENDLESS, ReceivedMessage, ReceivedTile, TestPage, TestServer, view};

/// 2 as a half float; nothing in the scenes has this radiance.
const TWO: u16 = 0x4000;

fn open(scene: &str, denoiser: Arc<dyn ViewDenoiser>) -> TestServer {
    TestServer::open_with(scene, ServerSettings { denoiser: Some(Ok(denoiser)), ..ServerSettings::default() })
}

fn denoised_view(id: u32, size: [u32; 2]) -> Value {
    let mut view = view(id, size, &[]);
    view["denoise"] = json!(true);
    view
}

/// The next denoised tile; the other messages before it.
fn denoised_tile(page: &mut TestPage) -> (ReceivedTile, Vec<ReceivedMessage>) {
    let mut before = Vec::new();
    loop {
        match page.receive() {
            ReceivedMessage::Tile(tile) if tile.is_denoised => return (tile, before),
            ReceivedMessage::Closed(code) => panic!("closed with {code:?}"),
            ReceivedMessage::Text(text) if text["type"] == "failed" => panic!("{text}"),
            other => before.push(other),
        }
    }
}

/// Gives every pixel the radiance 2, if it gets what a denoiser needs.
#[derive(Debug)]
struct Painter;

impl ViewDenoiser for Painter {
    fn denoise(
        &self,
        pixels: &Pixels,
        hit_shares: &[f32],
        threads: usize,
        _: &CancelFlag,
    ) -> Result<Vec<[f32; 3]>, String> {
        assert_eq!(threads, 2);
        let value = |name: &str, at: usize| pixels.channel(name).unwrap()[at];
        let (corner, middle) = (0, pixels.len() / 2 + pixels.width() as usize / 2);
        assert_eq!((hit_shares.len(), hit_shares[corner], hit_shares[middle]), (pixels.len(), 0.0, 1.0));
        // The ball has pbrt's albedo of 0.5, and faces the camera, which looks along y.
        assert!((value("Albedo.G", middle) - 0.5).abs() < 1e-3, "{}", value("Albedo.G", middle));
        assert!(value("Ns.Y", middle) < -0.9, "{}", value("Ns.Y", middle));
        Ok(vec![[2.0; 3]; pixels.len()])
    }
}

#[test]
fn pages_learn_why_nothing_is_denoised() {
    let reason = "Open Image Denoise was not found".to_owned();
    let missing = ServerSettings { denoiser: Some(Err(reason.clone())), ..ServerSettings::default() };
    for (settings, state, said) in [
        (missing, Some(json!({ "error": reason })), reason.as_str()),
        (ServerSettings::default(), None, "this server does not remove noise"),
    ] {
        let server = TestServer::open_with(BALL, settings);
        let mut page = server.connect_page();
        assert_eq!(page.scene.get("denoiser"), state.as_ref());
        page.send(denoised_view(3, [8, 8]));
        let failed = page.receive_text("failed");
        assert_eq!((&failed["id"], failed["message"].as_str()), (&json!(3), Some(said)));
        // Without it the view is rendered as ever.
        page.send(view(4, [8, 8], &[]));
        assert!(matches!(page.receive(), ReceivedMessage::Tile(tile) if tile.id == 4 && !tile.is_denoised));
    }
}

#[test]
fn denoised_picture_replaces_the_noisy_one_for_good_and_is_the_one_that_is_saved() {
    let server = open(BALL, Arc::new(Painter));
    let mut page = server.connect_page();
    assert_eq!(page.scene["denoiser"], json!({ "error": null }));
    page.send(denoised_view(1, [24, 16]));
    let (mut last, mut is_done) = (0, false);
    while !(is_done && last == 4096) {
        match page.receive() {
            ReceivedMessage::Tile(tile) if tile.is_denoised => {
                assert!(tile.values.iter().all(|value| *value == TWO));
                assert_eq!((tile.id, tile.min, tile.size), (1, [0, 0], [24, 16]));
                // At doublings, and at the end.
                assert!(tile.samples >= 2 * last || tile.samples == 4096, "{} after {last}", tile.samples);
                last = tile.samples;
            }
            ReceivedMessage::Tile(tile) => assert_eq!(last, 0, "noise at {} samples", tile.samples),
            ReceivedMessage::Text(text) => {
                assert_eq!(text["type"], "progress", "{text}");
                is_done |= text["done"] == true;
            }
            other => panic!("{other:?}"),
        }
    }
    page.send(json!({ "type": "save", "id": 9 }));
    let ReceivedMessage::File(9, bytes) = page.receive() else { panic!("a file is sent") };
    let saved = image::read(&bytes, Some(Path::new("a.exr")), image::Encoding::Srgb).unwrap();
    assert!(saved.pixels.to_rgb().unwrap().iter().all(|rgb| *rgb == [2.0; 3]));
    assert_eq!(saved.attributes.get("denoised").map(String::as_str), Some("true"));
    assert_eq!(saved.attributes.get("samplesPerPixel").map(String::as_str), Some("4096"));
    // The next view begins with noise, and one that is not to be denoised keeps it.
    page.send(view(2, [24, 16], &[]));
    while page.receive_text("progress")["done"] != true {}
    page.send(json!({ "type": "save", "id": 10 }));
    let ReceivedMessage::File(10, bytes) = page.receive() else { panic!("a file is sent") };
    let saved = image::read(&bytes, Some(Path::new("a.exr")), image::Encoding::Srgb).unwrap();
    assert!(!saved.attributes.contains_key("denoised"));
    assert!(saved.pixels.channel("Albedo.R").is_none());
}

#[test]
fn guided_views_are_denoised_too() {
    let server = open(BALL, Arc::new(Painter));
    let mut page = server.connect_page();
    let mut order = denoised_view(1, [24, 16]);
    order["integrator"] = json!("guided");
    page.send(order);
    for _ in 0..2 {
        assert_eq!(denoised_tile(&mut page).0.values[0], TWO);
    }
}

/// Returns once the gate is open, whether cancelled or not, as a library that looks at the flag too seldom.
#[derive(Debug, Default)]
struct Gated {
    is_open: Mutex<bool>,
    opened: Condvar,
    is_running: AtomicBool,
}

impl Gated {
    fn open(&self) {
        *self.is_open.lock().unwrap() = true;
        self.opened.notify_all();
    }
}

impl ViewDenoiser for Gated {
    fn denoise(
        &self,
        pixels: &Pixels,
        _: &[f32],
        _: usize,
        cancel: &CancelFlag,
    ) -> Result<Vec<[f32; 3]>, String> {
        assert!(!self.is_running.swap(true, Ordering::SeqCst), "two pictures at a time");
        drop(self.opened.wait_while(self.is_open.lock().unwrap(), |is_open| !*is_open));
        self.is_running.store(false, Ordering::SeqCst);
        cancel.check().map_err(|_| "interrupted".to_owned())?;
        Ok(vec![[2.0; 3]; pixels.len()])
    }
}

#[test]
fn neither_rendering_nor_a_new_view_waits_for_the_denoiser() {
    let denoiser = Arc::new(Gated::default());
    let server = open(BALL, Arc::clone(&denoiser) as _);
    let (mut page, mut other) = (server.connect_page(), server.connect_page());
    page.send(denoised_view(1, [24, 16]));
    // Samples come while the first picture is held up.
    let mut samples = 0;
    while samples < 64 {
        samples = page.receive_text("progress")["samples"].as_u64().unwrap();
    }
    assert!(denoiser.is_running.load(Ordering::SeqCst));
    // The view is left, although the denoiser does not end.
    page.send(json!({ "type": "stop", "id": 1 }));
    page.receive_text("stopped");
    page.send(denoised_view(2, [24, 16]));
    while page.receive_text("progress")["samples"].as_u64() < Some(8) {}
    other.send(denoised_view(3, [24, 16]));
    while other.receive_text("progress")["samples"].as_u64() < Some(8) {}
    assert!(denoiser.is_running.load(Ordering::SeqCst));
    denoiser.open();
    // What was left is not shown; the pictures that waited are.
    for (page, id) in [(&mut page, 2), (&mut other, 3)] {
        let (tile, before) = denoised_tile(page);
        assert_eq!((tile.id, tile.values[0]), (id, TWO));
        assert!(
            before
                .iter()
                .all(|m| !matches!(m, ReceivedMessage::Tile(tile) if tile.id != id || tile.is_denoised))
        );
    }
}

/// Fails.
#[derive(Debug)]
struct Broken;

impl ViewDenoiser for Broken {
    fn denoise(&self, _: &Pixels, _: &[f32], _: usize, _: &CancelFlag) -> Result<Vec<[f32; 3]>, String> {
        Err("out of memory".to_owned())
    }
}

#[test]
fn failure_of_the_denoiser_is_that_of_the_view() {
    let server = open(ENDLESS, Arc::new(Broken));
    let mut page = server.connect_page();
    page.send(denoised_view(7, [16, 16]));
    let failed = page.receive_text("failed");
    assert_eq!((&failed["id"], &failed["message"]), (&json!(7), &json!("out of memory")));
    page.send(json!({ "type": "stop", "id": 7 }));
    assert!(matches!(page.receive(), ReceivedMessage::Text(text) if text["type"] == "stopped"));
}
