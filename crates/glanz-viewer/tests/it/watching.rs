//! A scene that changes while it is shown.

use std::fs;

use glanz_viewer::server::ServerSettings;

use super::client::{BALL, TestServer};

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
