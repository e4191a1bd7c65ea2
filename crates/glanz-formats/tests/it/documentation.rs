//! What the documentation shows.

use std::fs;

use glanz_formats::{Options, load, load_str, rib};

const PAGE: &str = include_str!("../../../../docs/scene-format.md");

/// The fenced blocks of a language.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("```{language}\n");
    PAGE.split(&fence).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn every_scene_of_the_documentation_is_read_without_a_warning() {
    let scenes = blocks("pbrt");
    assert!(scenes.len() >= 3);
    let folder = std::env::temp_dir().join(format!("glanz-documentation-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("lamp.ies"), blocks("ies")[0]).unwrap();
    fs::write(folder.join("lamp.step"), crate::step_shape::lamp()).unwrap();
    for scene in scenes {
        let whole =
            if scene.contains("WorldBegin") { scene.to_owned() } else { format!("WorldBegin\n{scene}") };
        fs::write(folder.join("scene.pbrt"), whole).unwrap();
        let loaded = load(&folder.join("scene.pbrt"), &Options::default()).unwrap_or_else(|d| panic!("{d}"));
        assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn every_rib_file_of_the_documentation_has_surfaces_and_nothing_else() {
    let files = blocks("rib");
    assert!(!files.is_empty());
    for text in files {
        let file = rib::read(text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        assert!(!file.patches.is_empty() && file.skipped.is_empty());
    }
}

#[test]
fn documented_message_is_reported() {
    let scene = format!("WorldBegin{}Shape \"sphere\" \"float raduis\" 2\n", "\n".repeat(13));
    let loaded = load_str("room.pbrt", &scene, &Options::default()).unwrap();
    assert_eq!(loaded.diagnostics.to_string(), blocks("text")[0]);
}
