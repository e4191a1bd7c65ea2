//! Views without noise, with the library and without.

use std::path::Path;

use serde_json::{Value, json};

use super::server::{ViewServer, scene_file};
use super::soak::visitor::{Visitor, connect, text_of};

#[test]
fn pages_learn_that_the_library_is_missing_and_how_to_get_it() {
    let folder = std::env::temp_dir().join("glanz without a denoiser");
    let served = ViewServer::start_with(&scene_file("plate.pbrt"), &[("OIDN_DIR", &folder)]);
    let mut socket = connect(&served.host).unwrap();
    let scene = text_of(&socket.read().unwrap()).unwrap();
    let reason = scene["denoiser"]["error"].as_str().unwrap_or_else(|| panic!("{scene}"));
    assert!(reason.starts_with("Open Image Denoise was not found: install it"), "{reason}");
    // Folders of the server are not sent.
    assert!(reason.contains("set OIDN_DIR") && !reason.contains("without a denoiser"), "{reason}");
    let mut visitor = Visitor::try_new(&served.host).unwrap();
    let view = view(&visitor, true);
    let id = visitor.request(view).unwrap();
    let failed = visitor.await_text("a failure", |message| message["type"] == "failed").unwrap();
    assert_eq!(failed, json!({ "type": "failed", "id": id, "message": reason }));
}

/// The message that asks for a small view of the scene from its own camera.
fn view(visitor: &Visitor, denoise: bool) -> Value {
    json!({
        "type": "view", "camera": visitor.camera, "size": [96, 64], "hidden": [], "integrator": "path", "denoise": denoise,
    })
}

/// Tests of the nightly run, which need the library, see `glanz_denoise::DIRECTORY_VARIABLE`.
mod heavy {
    use super::*;
    use glanz::formats::image;

    /// Colours of a view as it is saved once it has this number of samples and is denoised or not, and their number of samples.
    fn colors(visitor: &mut Visitor, denoise: bool, samples: u64) -> (Vec<[f32; 3]>, u64) {
        let view = view(visitor, denoise);
        let id = visitor.request(view).unwrap();
        loop {
            let bytes = visitor.save(id).unwrap();
            let saved = image::read(&bytes, Some(Path::new("a.exr")), image::Encoding::Srgb).unwrap();
            let found = saved.attributes["samplesPerPixel"].parse().unwrap();
            if saved.attributes.contains_key("denoised") == denoise && found >= samples {
                return (saved.pixels.to_rgb().unwrap(), found);
            }
        }
    }

    /// Mean square of the relative error.
    fn error(of: &[[f32; 3]], reference: &[[f32; 3]]) -> f32 {
        let pairs = of.as_flattened().iter().zip(reference.as_flattened());
        pairs.map(|(x, y)| (x - y).powi(2) / (y * y + 0.01)).sum::<f32>() / (3 * of.len()) as f32
    }

    #[test]
    fn denoised_picture_is_nearer_to_many_samples_than_a_noisy_one_with_no_fewer() {
        let served = ViewServer::start(&scene_file("demo.pbrt"));
        let mut visitor = Visitor::try_new(&served.host).unwrap();
        let (denoised, few) = colors(&mut visitor, true, 4);
        let (noisy, no_fewer) = colors(&mut visitor, false, few);
        let (reference, many) = colors(&mut visitor, false, 1024);
        let [denoised, noisy] = [denoised, noisy].map(|picture| error(&picture, &reference));
        println!(
            "{few} samples denoised: {denoised}, {no_fewer} samples with noise: {noisy}, against {many}"
        );
        assert!(denoised < 0.5 * noisy, "{denoised} {noisy}");
    }
}
