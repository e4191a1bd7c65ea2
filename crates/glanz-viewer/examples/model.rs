//! Writes the model that the page gets of a scene: `model SCENE MODEL`.

use std::error::Error;
use std::path::Path;

use glanz_formats::registry::{Options, load};
use glanz_scene::Scene;
use glanz_viewer::model::Model;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene_file, model_file] = arguments.as_slice() else {
        return Err("usage: model SCENE MODEL".into());
    };
    let loaded = load(Path::new(scene_file), &Options::default()).map_err(|faults| format!("{faults:?}"))?;
    let description = loaded.description;
    let (scene, _) = Scene::resolve(description.clone())?;
    let model = Model::try_new(scene_file, &description, &scene, &description.files)?;
    std::fs::write(model_file, model.to_bytes()?)?;
    Ok(())
}
