//! Scenes that pages have opened, in processes of their own.

use std::process::Command;
use std::time::{Duration, Instant};

use glanz_viewer::server::Limits;
use serde_json::json;

use super::client::{BALL, ENDLESS, PATIENCE, ReceivedMessage, TestPage, TestServer, view};
use super::upload::drop_on;

/// Files of a scene that begins in `room.pbrt`, each of which includes the next one twice: 2^`levels` times the last one, whose text is `leaf`.
fn doubling_includes(levels: usize, leaf: &str) -> Vec<(String, String)> {
    let mut files = vec![("room.pbrt".to_owned(), "WorldBegin\nInclude \"0.pbrt\"\n".to_owned())];
    files.extend((0..levels).map(|level| {
        let line = format!("Include \"{}.pbrt\"\n", level + 1);
        (format!("{level}.pbrt"), line.repeat(2))
    }));
    files.push((format!("{levels}.pbrt"), leaf.to_owned()));
    files
}

fn names(files: &[(String, String)]) -> Vec<(&str, &str)> {
    files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect()
}

/// Drops the scene on the page, which then shows it.
fn open(server: &TestServer, page: &mut TestPage, scene: &str) {
    let answer = drop_on(server, page, &[("scene.pbrt", scene)]);
    assert_eq!(answer.status, 200, "{}", answer.text());
    page.scene = page.receive_text("scene");
}

/// Text at the head of a model.
fn head(model: &[u8]) -> &str {
    std::str::from_utf8(&model[16..16 + head_length(model)]).unwrap()
}

/// Bytes of the blocks of a model.
fn blocks(model: &[u8]) -> &[u8] {
    &model[(16 + head_length(model)).next_multiple_of(16)..]
}

fn head_length(model: &[u8]) -> usize {
    u32::from_le_bytes(model[8..12].try_into().unwrap()) as usize
}

/// Until a page that has left is gone for the server, too.
fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "{what} does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn an_opened_scene_answers_like_the_same_scene_of_the_server() {
    let server = TestServer::open(BALL);
    let [mut design, mut opened] = [(); 2].map(|()| server.connect_page());
    open(&server, &mut opened, BALL);
    let pages = [&mut design, &mut opened];
    let pick = json!({ "type": "pick", "id": 2, "origin": [0, -4, 0], "direction": [0, 1, 0] });
    let measure = json!({ "type": "measure", "id": 3, "leaves": [0] });
    let answers = pages.map(|page| {
        let model = server.get(page.scene["model"].as_str().unwrap());
        assert_eq!(model.header("content-length"), Some(model.body.len().to_string().as_str()));
        page.send(&pick);
        let hit = page.receive_text("hit");
        page.send(&measure);
        let measures = page.receive_text("measures");
        // The whole picture, which depends on the seed of the scene alone.
        page.send(view(1, [16, 8], &[]));
        let mut picture = None;
        loop {
            match page.receive() {
                ReceivedMessage::Tile(tile) => picture = Some((tile.size, tile.samples, tile.values)),
                ReceivedMessage::Text(text) if text["done"] == true => break,
                ReceivedMessage::Text(_) => {}
                other => panic!("{other:?}"),
            }
        }
        page.send(json!({ "type": "save", "id": 4 }));
        let ReceivedMessage::File(4, file) = page.receive() else { panic!("a file comes") };
        page.send(json!({ "type": "stop", "id": 1 }));
        page.receive_text("stopped");
        page.send("{\"type\":\"dance\",\"id\":5}");
        let failed = page.receive_text("failed");
        (model.body, hit, measures, picture, file, failed)
    });
    let [design, opened] = answers;
    assert!(design.1["hit"]["distance"].as_f64().is_some_and(|distance| (distance - 3.0).abs() < 1e-9));
    assert!(design.3.as_ref().is_some_and(|(size, samples, _)| (*size, *samples) == ([16, 8], 4096)));
    // Places of a scene of the server are named with its folder.
    let folder = format!("{}/", server.folder.path().display());
    assert_eq!(head(&design.0).replace(&folder, ""), head(&opened.0));
    assert!(blocks(&design.0) == blocks(&opened.0), "the models differ");
    assert_eq!((&design.1, &design.2, &design.5), (&opened.1, &opened.2, &opened.5));
    assert!(design.3 == opened.3, "the pictures differ");
    assert!(design.4 == opened.4, "the saved pictures differ");
}

#[test]
fn an_opened_scene_stops_and_changes_its_view_like_one_of_the_server() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    open(&server, &mut page, ENDLESS);
    page.send(view(1, [400, 300], &[]));
    assert!(matches!(page.receive(), ReceivedMessage::Tile(tile) if tile.id == 1));
    page.send(view(2, [400, 300], &[]));
    while !matches!(page.receive(), ReceivedMessage::Tile(tile) if tile.id == 2) {}
    page.send(json!({ "type": "stop", "id": 2 }));
    page.receive_text("stopped");
    // A scene that takes its place answers from then on.
    open(&server, &mut page, BALL);
    page.send(json!({ "type": "pick", "id": 3, "origin": [0, -40, 0], "direction": [0, 1, 0] }));
    assert!(
        page.receive_text("hit")["hit"]["distance"]
            .as_f64()
            .is_some_and(|distance| (distance - 39.0).abs() < 1e-9)
    );
}

#[test]
fn an_opened_scene_answers_a_view_behind_many_saves() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    open(&server, &mut page, BALL);
    page.send(view(1, [256, 256], &[]));
    page.receive_text("progress");
    // More than wait for the process: a part of its queue is left to views.
    let saves = 100..400_u32;
    saves.clone().for_each(|id| page.send(json!({ "type": "save", "id": id })));
    page.send(view(2, [16, 8], &[]));
    let (mut answered, mut is_drawn) = (Vec::new(), false);
    while answered.len() < saves.len() || !is_drawn {
        match page.receive() {
            ReceivedMessage::File(id, _) => answered.push(id),
            ReceivedMessage::Text(text) if text["type"] == "failed" => {
                answered.push(text["id"].as_u64().and_then(|id| u32::try_from(id).ok()).unwrap());
            }
            ReceivedMessage::Tile(tile) => is_drawn |= tile.id == 2,
            ReceivedMessage::Text(_) => {}
            closed => panic!("{closed:?}"),
        }
    }
    answered.sort_unstable();
    assert_eq!(answered, saves.collect::<Vec<_>>());
}

#[test]
fn program_of_opened_scenes_refuses_wrong_arguments_and_a_start_without_a_task() {
    let expected = "it must be a whole number, 0 for as many as the machine has";
    for (arguments, sentence) in [
        (&["many"][..], format!("the number of threads is \"many\"; {expected}")),
        (&["-1"], format!("the number of threads is \"-1\"; {expected}")),
        (&[""], format!("the number of threads is \"\"; {expected}")),
        (&["2", "3"], "the argument \"3\" is one too many".to_owned()),
        (&["2"], "there is no task".to_owned()),
        (&[], "there is no task".to_owned()),
    ] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_glanz-viewer-worker"));
        let output = program.args(arguments).env_remove("GLANZ_WORKER_FOLDER").output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        let begin = "error: the process of an opened scene cannot begin: ";
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(errors.starts_with(&format!("{begin}{sentence}")), "{arguments:?}: {errors}");
    }
}

#[test]
fn reading_ends_in_time() {
    let limits = Limits { reading_time: Duration::from_millis(300), ..Limits::default() };
    let server = TestServer::open_limited(BALL, limits);
    let page = server.connect_page();
    // Gigabytes of comments.
    let endless = doubling_includes(15, &"# nothing\n".repeat(20_000));
    let start = Instant::now();
    let answer = drop_on(&server, &page, &names(&endless));
    assert_eq!(answer.status, 422, "{}", answer.text());
    let expected = "error: reading the scene took longer than 0.3 s; open the file by `glanz view FILE`, which has no such limit\n";
    // The process measures the time, too.
    let is_of_reader = answer.text().contains("the limit of 0.3 s is exceeded")
        && answer.text().contains("help: open the file by `glanz view FILE`, which has no such limit");
    assert!(answer.text() == expected || is_of_reader, "{}", answer.text());
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
    // The page can open others.
    let limits = Limits { reading_time: PATIENCE, ..limits };
    drop(server);
    let server = TestServer::open_limited(BALL, limits);
    let mut page = server.connect_page();
    open(&server, &mut page, BALL);
}

#[cfg(target_os = "linux")]
#[test]
fn a_scene_that_needs_too_much_memory_is_given_up() {
    let spheres = doubling_includes(14, &"Shape \"sphere\"\n".repeat(1000));
    let together = Limits { opened_memory: 100_000_000, ..Limits::default() };
    let alone = Limits { scene_memory: 100_000_000, ..Limits::default() };
    for (limits, said) in [
        (alone, "error: the scene needs more than 0.1 GB of memory; open the file by `glanz view FILE`"),
        (
            together,
            "error: the scenes that pages have opened need more than 0.1 GB of memory together; close",
        ),
    ] {
        let server = TestServer::open_limited(BALL, limits);
        let mut page = server.connect_page();
        let answer = drop_on(&server, &page, &names(&spheres));
        assert_eq!(answer.status, 422, "{}", answer.text());
        // The reader may notice it before.
        let is_of_reader = answer.text().contains("of memory is exceeded")
            && answer.text().contains("help: open the file by `glanz view FILE`, which has no such limit");
        let is_alone = limits.scene_memory == 100_000_000;
        assert!(answer.text().starts_with(said) || is_alone && is_of_reader, "{}", answer.text());
        open(&server, &mut page, BALL);
    }
}

#[test]
fn a_model_that_is_too_large_for_the_page_is_refused() {
    let server = TestServer::open_limited(BALL, Limits { model_bytes: 100, ..Limits::default() });
    let page = server.connect_page();
    let answer = drop_on(&server, &page, &[("a.pbrt", BALL)]);
    assert_eq!(answer.status, 422);
    assert!(answer.text().contains("more than the 0 MB that a page takes"), "{}", answer.text());
}

#[test]
fn pages_with_opened_scenes_are_limited_and_make_room_when_they_leave() {
    let server = TestServer::open_limited(BALL, Limits { opened_scenes: 1, ..Limits::default() });
    let (mut first, second) = (server.connect_page(), server.connect_page());
    open(&server, &mut first, BALL);
    let answer = drop_on(&server, &second, &[("a.pbrt", BALL)]);
    assert_eq!(answer.status, 503);
    assert!(
        answer.text().starts_with("too many pages show files that they have opened"),
        "{}",
        answer.text()
    );
    // It takes the place of its own scene, again and again.
    for _ in 0..3 {
        open(&server, &mut first, BALL);
    }
    drop(first);
    until("a slot", || drop_on(&server, &second, &[("a.pbrt", BALL)]).status == 200);
}

#[cfg(target_os = "linux")]
#[test]
fn a_lost_scene_makes_room_for_that_of_another_page() {
    let limits = Limits { opened_scenes: 1, scene_memory: 150_000_000, ..Limits::default() };
    let server = TestServer::open_limited(BALL, limits);
    let [mut first, mut second] = [(); 2].map(|()| server.connect_page());
    open(&server, &mut first, BALL);
    // At 120 bytes or more for each pixel, its film needs 270 MB.
    first.send(view(1, [1500, 1500], &[]));
    let lost = first.receive_text("scene");
    assert!(lost["error"].as_str().is_some_and(|text| text.contains("needs more than")), "{lost}");
    open(&server, &mut second, BALL);
    // The page that has lost its scene is still answered.
    first.send(json!({ "type": "pick", "id": 2, "origin": [0, -4, 0], "direction": [0, 1, 0] }));
    assert!(
        first.receive_text("failed")["message"].as_str().is_some_and(|text| text.contains("needs more than"))
    );
}

#[cfg(unix)]
#[test]
fn a_program_that_cannot_begin_is_reported_as_one_that_cannot_be_started() {
    use glanz_viewer::server::{ServerSettings, WorkerCommand};

    let script = "echo 'the process of an opened scene cannot begin: it has no task' >&2; exit 1";
    let arguments = vec!["-c".into(), script.into()];
    let worker = Some(WorkerCommand { program: "/bin/sh".into(), arguments });
    let settings = ServerSettings { worker, ..ServerSettings::default() };
    let server = TestServer::open_with_listener(BALL, settings, Box::new(|_, _| {}));
    let page = server.connect_page();
    let answer = drop_on(&server, &page, &[("a.pbrt", BALL)]);
    let expected = "error: the program that reads files cannot be started; start glanz view again\n";
    assert_eq!((answer.status, answer.text().as_str()), (422, expected));
}

#[test]
fn a_server_without_a_program_for_it_opens_no_files() {
    let server = TestServer::open_alone(BALL);
    let page = server.connect_page();
    let answer = drop_on(&server, &page, &[("a.pbrt", BALL)]);
    assert_eq!((answer.status, answer.text().as_str()), (503, "this server opens no files"));
}
