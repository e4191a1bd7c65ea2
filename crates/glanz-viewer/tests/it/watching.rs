//! A scene that changes while it is shown.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use glanz_formats::Options;
use glanz_viewer::server::{ComparedDesign, Limits, SceneUpdate, ServerSettings, ViewerScene};

use super::client::{BALL, ReceivedMessage, TestPage, TestServer};

#[test]
fn pages_receive_changed_scenes_and_their_errors() {
    let server = TestServer::open_with(BALL, ServerSettings { watch: true, ..ServerSettings::default() });
    let mut page = server.connect_page();
    // One shape less: another length, so that the change shows however coarse the times of files are.
    fs::write(server.scene(), BALL.replace("Translate 0 0 3\nShape \"sphere\"\n", "")).unwrap();
    let told = page.receive_text("scene");
    assert!(told["error"].is_null());
    assert_ne!(told["model"], page.scene["model"]);
    assert_eq!(server.get(told["model"].as_str().unwrap()).status, 200);
    fs::write(server.scene(), "WorldBegin\nShape\n").unwrap();
    let broken = page.receive_text("scene");
    assert!(broken["model"].is_null());
    assert!(
        broken["error"].as_str().unwrap().contains("scene.pbrt:2:1: Shape needs a name in quotes"),
        "{broken}"
    );
    // The old one stays, for this page and for those to come.
    page.send(r#"{"type":"pick","id":1,"origin":[0,-4,0],"direction":[0,1,0]}"#);
    assert_eq!(page.receive_text("hit")["hit"]["distance"], 3.0);
    assert_eq!(server.connect_page().scene["model"], told["model"]);
    fs::write(server.scene(), BALL).unwrap();
    assert!(page.receive_text("scene")["error"].is_null());
}

#[test]
fn each_of_two_designs_has_its_own_pages() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("second.pbrt");
    fs::write(&path, BALL.replace("Shape \"sphere\"\n", "Shape \"sphere\" \"float radius\" 2\n")).unwrap();
    let viewer_scene = ViewerScene::read(&path, &Options::default(), None).unwrap();
    let compared = ComparedDesign { path: path.clone(), viewer_scene: viewer_scene.into(), overlay: None };
    // Pages of both designs count as one.
    let limits = Limits { sessions: 2, ..Limits::default() };
    let settings =
        ServerSettings { watch: true, compared: Some(compared), limits, ..ServerSettings::default() };
    let changed = Arc::new(Mutex::new(Vec::new()));
    let list = Arc::clone(&changed);
    let listener = Box::new(move |path: &Path, _: &SceneUpdate| list.lock().unwrap().push(path.to_owned()));
    let server = TestServer::open_with_listener(BALL, settings, listener);
    let [mut first, mut second] = ["ws", "ws?design=b"].map(|path| server.try_connect_page_to(path).unwrap());
    let named = |page: &TestPage| {
        let [name, label, compared] = ["name", "label", "compared"].map(|field| page.scene[field].clone());
        (name, label, compared)
    };
    assert_eq!(named(&first), ("scene.pbrt".into(), "scene.pbrt".into(), true.into()));
    assert_eq!(named(&second), ("second.pbrt".into(), "second.pbrt".into(), true.into()));
    let third = server.try_connect_page_to("ws?design=a").unwrap();
    assert_eq!(named(&third), named(&first));
    assert!(server.try_connect_page_to("ws?design=c").is_none());
    let pick = r#"{"type":"pick","id":1,"origin":[0,-4,0],"direction":[0,1,0]}"#;
    for (page, distance) in [(&mut first, 3.0), (&mut second, 2.0)] {
        page.send(pick);
        assert_eq!(page.receive_text("hit")["hit"]["distance"], distance);
    }
    // A change of one design is no matter of the other.
    fs::write(&path, BALL.replace("Shape \"sphere\"\n", "Shape \"sphere\" \"float radius\" 3.5\n")).unwrap();
    assert_eq!(second.receive_text("scene")["name"], "second.pbrt");
    for (page, distance) in [(&mut first, 3.0), (&mut second, 0.5)] {
        page.send(pick);
        let message = page.receive();
        let ReceivedMessage::Text(message) = message else { panic!("{message:?}") };
        assert_eq!(message["hit"]["distance"], distance, "{message}");
    }
    // The listener comes after the pages.
    while changed.lock().unwrap().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert_eq!(*changed.lock().unwrap(), [path]);
}

#[test]
fn a_second_design_that_is_not_there_is_refused() {
    let server = TestServer::open(BALL);
    assert!(server.try_connect_page_to("ws?design=b").is_none());
    assert_eq!(server.connect_page().scene["compared"], false);
}
