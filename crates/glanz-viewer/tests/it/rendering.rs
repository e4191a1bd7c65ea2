//! Pictures of what pages look at.

use std::time::Duration;

use serde_json::json;
use tungstenite::Message;

use super::client::{BALL, ENDLESS, PATIENCE, ReceivedMessage, TestPage, TestServer, view};

/// The first whole picture of a view: samples of its pixels, and green half floats, `None` where nothing came.
fn picture(page: &mut TestPage, id: u32, size: [u16; 2]) -> (u32, Vec<Option<u16>>) {
    let [width, height] = size.map(usize::from);
    let mut pixels = vec![None; width * height];
    let mut samples = 0;
    loop {
        match page.receive() {
            ReceivedMessage::Tile(tile) => {
                assert_eq!(tile.id, id);
                let [x, y, columns, rows] =
                    [tile.min[0], tile.min[1], tile.size[0], tile.size[1]].map(usize::from);
                assert_eq!(tile.values.len(), 3 * rows * columns);
                for (i, rgb) in tile.values.chunks_exact(3).enumerate() {
                    pixels[(y + i / columns) * width + x + i % columns] = Some(rgb[1]);
                }
                samples = tile.samples;
            }
            ReceivedMessage::Text(text) if text["type"] == "progress" => {
                assert_eq!(text["id"], id);
                return (samples, pixels);
            }
            heard => panic!("{heard:?}"),
        }
    }
}

/// 1 as a half float.
const ONE: u16 = 0x3c00;

#[test]
fn tiles_cover_the_picture_and_progress_follows() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    page.send(view(5, [50, 30], &[]));
    let (samples, pixels) = picture(&mut page, 5, [50, 30]);
    assert!(samples >= 1 && pixels.iter().all(Option::is_some));
    // The sky is 1 in the corner; the ball in the middle reflects half of it.
    assert_eq!(pixels[0], Some(ONE));
    assert!(pixels[15 * 50 + 25].is_some_and(|value| value < ONE));
    let mut last = json!(0);
    for _ in 0..3 {
        let progress = page.receive_text("progress");
        assert_eq!(progress["id"], 5);
        assert!(progress["samples"].as_u64() > last.as_u64());
        // Known from two samples on.
        assert!(progress["noise"].as_f64().is_some_and(|noise| noise > 0.0), "{progress}");
        last = progress["samples"].clone();
        if progress["done"] == true {
            break;
        }
    }
}

#[test]
fn a_view_ends_with_all_samples_and_is_saved_as_it_is() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    page.send(view(1, [6, 4], &[]));
    while page.receive_text("progress")["done"] != true {}
    page.send(json!({ "type": "save", "id": 2 }));
    let file = loop {
        match page.receive() {
            ReceivedMessage::File(2, bytes) => break bytes,
            ReceivedMessage::Tile(_) => {}
            heard => panic!("{heard:?}"),
        }
    };
    let read = glanz_formats::image::read(&file, None, glanz_formats::image::Encoding::Linear).unwrap();
    assert_eq!((read.pixels.width(), read.pixels.height()), (6, 4));
    assert_eq!(read.pixels.channel("R").unwrap()[0], 1.0);
}

#[test]
fn hidden_shapes_are_not_rendered() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    for (id, hidden, is_sky) in [(1, &[][..], false), (2, &[0], true), (3, &[1], false), (4, &[0, 1], true)] {
        page.send(view(id, [9, 9], hidden));
        let (_, pixels) = loop {
            // Messages of the view before may still arrive.
            match page.receive() {
                ReceivedMessage::Tile(tile) if tile.id == id => {
                    break ((), tile.values.chunks_exact(3).map(|rgb| rgb[1]).collect::<Vec<_>>());
                }
                _ => {}
            }
        };
        assert_eq!(pixels[4 * 9 + 4] == ONE, is_sky, "{hidden:?}");
    }
}

#[test]
fn guided_pictures_are_sent_as_a_whole() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    let mut order = view(1, [40, 20], &[]);
    order["integrator"] = json!("guided");
    page.send(&order);
    // 40 x 20 pixels fit in one tile of a whole picture, and are three of those that a pass fills.
    let ReceivedMessage::Tile(tile) = page.receive() else { panic!("a tile comes first") };
    assert_eq!((tile.min, tile.size), ([0, 0], [40, 20]));
}

#[test]
fn a_stop_ends_a_pass_before_it_is_over() {
    let server = TestServer::open(ENDLESS);
    let mut page = server.connect_page();
    page.send(view(1, [400, 300], &[]));
    assert!(matches!(page.receive(), ReceivedMessage::Tile(_)));
    page.send(json!({ "type": "stop", "id": 1 }));
    loop {
        match page.receive() {
            ReceivedMessage::Tile(tile) => assert_eq!(tile.id, 1),
            // Progress comes after a pass only, and this one would take minutes.
            ReceivedMessage::Text(text) => {
                assert_eq!(text, json!({ "type": "stopped", "id": 1 }));
                break;
            }
            heard => panic!("{heard:?}"),
        }
    }
    // Nothing comes after it, until something is asked for.
    page.send(json!({ "type": "stop", "id": 2 }));
    assert!(matches!(page.receive(), ReceivedMessage::Text(text) if text["id"] == 2));
}

#[test]
fn a_new_view_takes_the_place_of_the_last() {
    let server = TestServer::open(ENDLESS);
    let mut page = server.connect_page();
    page.send(view(1, [400, 300], &[]));
    assert!(matches!(page.receive(), ReceivedMessage::Tile(_)));
    page.send(view(2, [400, 300], &[]));
    let mut changed = false;
    for _ in 0..20 {
        let ReceivedMessage::Tile(tile) = page.receive() else { panic!("only tiles come") };
        assert!(tile.id == 2 || !changed, "a tile of the first view after one of the second");
        changed |= tile.id == 2;
    }
    assert!(changed);
    // A stop that comes late is about a view that has ended already: the other goes on.
    page.send(json!({ "type": "stop", "id": 1 }));
    page.receive_text("stopped");
    assert!(matches!(page.receive(), ReceivedMessage::Tile(tile) if tile.id == 2));
}

#[test]
fn a_page_that_leaves_frees_the_processors_for_others() {
    let server = TestServer::open(ENDLESS);
    let mut pages: Vec<TestPage> = (0..4).map(|_| server.connect_page()).collect();
    for page in &mut pages {
        page.send(view(1, [400, 300], &[]));
        assert!(matches!(page.receive(), ReceivedMessage::Tile(_)));
    }
    // Four render at a time, for minutes.
    let mut last = server.connect_page();
    last.send(view(9, [16, 16], &[]));
    assert_eq!(last.receive_text("waiting")["id"], 9);
    drop(pages.pop());
    assert!(matches!(last.receive(), ReceivedMessage::Tile(tile) if tile.id == 9));
}

#[test]
fn a_page_that_waits_can_stop() {
    let server = TestServer::open(ENDLESS);
    let mut pages: Vec<TestPage> = (0..5).map(|_| server.connect_page()).collect();
    for page in &mut pages[..4] {
        page.send(view(1, [400, 300], &[]));
        assert!(matches!(page.receive(), ReceivedMessage::Tile(_)));
    }
    pages[4].send(view(1, [16, 16], &[]));
    pages[4].receive_text("waiting");
    pages[4].send(json!({ "type": "stop", "id": 1 }));
    assert!(matches!(pages[4].receive(), ReceivedMessage::Text(text) if text["type"] == "stopped"));
}

/// The samples of the last progress that arrives until nothing does for half a second.
fn last_progress(page: &mut TestPage) -> Option<u64> {
    page.socket.get_ref().set_read_timeout(Some(Duration::from_millis(500))).unwrap();
    let mut samples = None;
    while let Ok(message) = page.socket.read() {
        let Message::Text(text) = message else { continue };
        let text: serde_json::Value = serde_json::from_str(text.as_str()).unwrap();
        assert_eq!(text["type"], "progress", "{text}");
        samples = text["samples"].as_u64();
    }
    page.socket.get_ref().set_read_timeout(Some(PATIENCE)).unwrap();
    samples
}

#[test]
fn a_paused_view_renders_nothing_until_it_goes_on() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    page.send(view(1, [400, 300], &[]));
    page.receive_text("progress");
    // That of another view changes nothing.
    page.send(json!({ "type": "pause", "id": 2 }));
    let before = page.receive_text("progress")["samples"].as_u64();
    page.send(json!({ "type": "pause", "id": 1 }));
    // The pass that was being rendered, and then none. On a busy machine it may take longer than the silence before the next one.
    let mut paused = last_progress(&mut page).or(before);
    for _ in 0..20 {
        match last_progress(&mut page) {
            Some(samples) => paused = Some(samples),
            None => break,
        }
    }
    assert_eq!((last_progress(&mut page), paused >= before), (None, true));
    page.send(json!({ "type": "resume", "id": 1 }));
    assert!(page.receive_text("progress")["samples"].as_u64() > paused);
    page.send(json!({ "type": "pause", "id": 1 }));
    page.send(json!({ "type": "stop", "id": 1 }));
    page.receive_text("stopped");
}
