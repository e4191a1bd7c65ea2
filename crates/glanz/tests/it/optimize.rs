//! Inverse designs by the engine.

use std::fs;
use std::path::Path;

use glanz::illumination::optimize::OptimizeSettings;

#[test]
fn scene_file_that_changes_during_the_search_is_written_as_it_was_read() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/design");
    let text = fs::read_to_string(scenes.join("bent_paraboloid.pbrt")).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("optimize-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let [bent, found, same] = ["bent.pbrt", "found.pbrt", "same.pbrt"].map(|name| folder.join(name));
    fs::write(&bent, &text).unwrap();
    let settings = OptimizeSettings { rays: 200, iterations: 3, ..OptimizeSettings::default() };
    let scene = glanz::open(&bent).unwrap();
    let before = scene.clone().optimize().settings(settings).run().unwrap();
    assert!(!before.scene_has_changed());
    before.save(&same).unwrap();
    // No place is where it was.
    fs::write(&bent, format!("# a new line\n{text}")).unwrap();
    let after = scene.optimize().settings(settings).run().unwrap();
    assert!(after.scene_has_changed());
    after.save(&found).unwrap();
    let [found, same] = [found, same].map(|path| fs::read_to_string(path).unwrap());
    assert_eq!(found, same);
    assert!(found != text && found.lines().count() == text.lines().count());
    fs::remove_dir_all(&folder).unwrap();
}
