//! A scene that changes while it is shown.

use std::fs;

use glanz_viewer::server::ServerSettings;

use super::house::{BALL, House};

#[test]
fn pages_are_told_when_the_scene_changes_and_when_it_cannot_be_read() {
    let house = House::open_with(BALL, ServerSettings { watch: true, ..ServerSettings::default() });
    let mut page = house.visit();
    // One shape less: another length, so that the change shows however coarse the times of files are.
    fs::write(house.scene(), BALL.replace("Translate 0 0 3\nShape \"sphere\"\n", "")).unwrap();
    let told = page.hear_text("scene");
    assert!(told["error"].is_null());
    assert_ne!(told["model"], page.scene["model"]);
    assert_eq!(house.get(told["model"].as_str().unwrap()).status, 200);
    fs::write(house.scene(), "WorldBegin\nShape\n").unwrap();
    let broken = page.hear_text("scene");
    assert!(broken["model"].is_null());
    assert!(
        broken["error"].as_str().unwrap().contains("scene.pbrt:2:1: Shape needs a name in quotes"),
        "{broken}"
    );
    // The old one stays, for this page and for those to come.
    page.say(r#"{"type":"pick","id":1,"origin":[0,-4,0],"direction":[0,1,0]}"#);
    assert_eq!(page.hear_text("hit")["hit"]["distance"], 3.0);
    assert_eq!(house.visit().scene["model"], told["model"]);
    fs::write(house.scene(), BALL).unwrap();
    assert!(page.hear_text("scene")["error"].is_null());
}
