//! Jobs whose temporary file of pictures fails: light that was computed with black texels is neither returned nor saved.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use glanz::formats::Options;
use glanz::illumination::optimize::OptimizeSettings;
use glanz::illumination::{GridResolution, TraceGoal};
use glanz::job::{JobProgress, ProgressSink, ScratchFileError};
use glanz::light::Pixels;
use glanz::math::DVec3;
use glanz::scene::description::{ImageDescription, ObserverDescription};
use glanz::shading::texture::{MipMap, TextureCache};
use glanz::transport::FilmError;
use glanz::{Error, IlluminateMethod, IlluminateOptions, JobOptions, LoadedScene};

/// A grey floor below a light, and the cache of a picture in a file.
fn scene() -> (LoadedScene, TextureCache) {
    let text = "Film \"rgb\" WorldBegin LightSource \"point\" \"point3 from\" [0 0 1] Material \"diffuse\"
        Shape \"bilinearmesh\" \"point3 P\" [-.5 -.5 0 .5 -.5 0 -.5 .5 0 .5 .5 0] \"string receiver\" \"floor\"";
    let mut scene = glanz::open_str("floor.pbrt", text, &Options::default()).unwrap();
    let cache = add_picture(&mut scene);
    (scene, cache)
}

/// Adds a picture in a file, which nothing uses; its cache.
fn add_picture(scene: &mut LoadedScene) -> TextureCache {
    let cache = TextureCache::new(0);
    let colours: Vec<[f32; 3]> = (0..64_u16 * 64).map(|i| [f32::from(i); 3]).collect();
    let picture = MipMap::try_new_in(&Pixels::try_from_rgb(64, 64, &colours).unwrap(), &cache).unwrap();
    assert!(picture.cache().is_some());
    scene.description_mut().images.push(ImageDescription { name: "picture".to_owned(), picture });
    cache
}

/// Records a fault of the file, as a failed read does.
fn fail(cache: &TextureCache) {
    let fault = "the disk fails".to_owned();
    cache.fail(ScratchFileError {
        folder: "/var/tmp".into(),
        kind: ErrorKind::Other,
        code: None,
        fault,
        bytes: 1,
    });
}

/// A file that does not exist.
fn new_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("textures-{}-{name}", std::process::id()))
}

fn is_texture_fault<T>(result: &Result<T, Error>) -> bool {
    matches!(result, Err(Error::Film(FilmError::File(_))))
}

#[cfg(feature = "radiosity")]
mod baking {
    use glanz::job::{CancelFlag, JobPart};
    use glanz::radiosity::bake::BakePart;
    use glanz::{BakeBuilder, JobEvent};

    use super::*;

    fn bake<'a>(scene: &LoadedScene, checkpoint: &Path) -> BakeBuilder<'a> {
        scene.clone().bake().density(4.0).rays(8).checkpoint(checkpoint.to_owned())
    }

    #[test]
    fn baked_light_is_not_saved() {
        let (scene, cache) = scene();
        fail(&cache);
        let path = new_file("light");
        assert!(is_texture_fault(&bake(&scene, &path).run()));
        let part = BakePart { part: JobPart::try_new(1, 2).unwrap(), direct_only: false };
        assert!(is_texture_fault(&bake(&scene, &path).run_part(part, None)));
        assert!(!path.exists());
    }

    #[test]
    fn state_of_a_cancelled_bake_is_not_saved() {
        let (scene, cache) = scene();
        fail(&cache);
        let (path, cancel) = (new_file("cancelled"), CancelFlag::default());
        let mut events = |event: JobEvent<'_>| {
            if matches!(event, JobEvent::BakeStarted { .. }) {
                cancel.cancel();
            }
        };
        let baked = bake(&scene, &path).cancel(cancel.clone()).on_event(&mut events).run();
        assert!(is_texture_fault(&baked));
        assert!(!path.exists());
    }
}

#[test]
fn illuminance_is_neither_returned_nor_saved() {
    let (scene, cache) = scene();
    fail(&cache);
    for method in
        [IlluminateMethod::Auto, IlluminateMethod::Trace, IlluminateMethod::Integrate, IlluminateMethod::Both]
    {
        let path = new_file(method.name());
        let goal = TraceGoal { time: Some(Duration::from_millis(20)), ..TraceGoal::default() };
        let resolution = GridResolution::Longer(4);
        let options = IlluminateOptions { method, goal, resolution, ..IlluminateOptions::default() };
        let builder = scene.clone().illuminate().options(options).checkpoint(path.clone());
        assert!(is_texture_fault(&builder.run()), "{}", method.name());
        assert!(!path.exists(), "{}", method.name());
    }
}

#[test]
fn rays_are_not_written() {
    let (scene, cache) = scene();
    let mut outcome = scene.illuminate().particles(1000).ray_file(true).run().unwrap();
    fail(&cache);
    let path = new_file("escaped.tm25ray");
    assert!(is_texture_fault(&outcome.save_ray_file(&path, JobOptions::default())));
    assert!(!path.exists());
}

/// Lets the disk fail while light is rated.
struct FailingRating(TextureCache);

impl ProgressSink for FailingRating {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        if progress.phase == "glare and cylinders" {
            fail(&self.0);
        }
    }
}

#[test]
fn ratings_are_not_returned() {
    let (mut scene, cache) = scene();
    let point = ObserverDescription { position: DVec3::new(0.0, 0.0, 0.5), view: None, location: None };
    scene.description_mut().observers.push(point);
    assert!(scene.clone().illuminate().particles(1000).run().unwrap().report.plan.is_some());
    let mut sink = FailingRating(cache);
    assert!(is_texture_fault(&scene.illuminate().particles(1000).on_progress(&mut sink).run()));
}

#[test]
fn designs_are_not_searched() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/design/bent_paraboloid.pbrt");
    let mut scene = glanz::open(file).unwrap();
    fail(&add_picture(&mut scene));
    let settings = OptimizeSettings { rays: 200, iterations: 3, ..OptimizeSettings::default() };
    let path = new_file("design");
    let searched = scene.optimize().settings(settings).checkpoint(path.clone()).run();
    assert!(is_texture_fault(&searched), "{searched:?}");
    assert!(!path.exists());
}
