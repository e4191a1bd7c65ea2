//! The page's picture agrees with ray intersections of the exact surfaces, in objects and normals.

use std::path::Path;

use glanz::formats::{Options, load};
use glanz::scene::Scene;
use glanz::scene::studio::add_studio;
use glanz::viewer::model::Model;

use super::page::Page;
use super::pixels::SurfacePixels;
use crate::viewer::server::{ViewServer, scene_file};

/// Size of the window in pixels; the bars of the page leave about 400 x 300 for the picture.
const SIZE: [u32; 2] = [400, 390];

/// Largest angle between normals in degrees, and the share of pixels within it.
const NORMALS: (f64, f64) = (1.0, 0.999);

/// Largest distance, in pixels, from a silhouette to a pixel that shows a different object.
const SILHOUETTE: f64 = 1.5;

/// Compares normals and silhouettes of a scene of the repository over the whole picture and prints the differences.
fn compare(name: &str) {
    let file = scene_file(name);
    let served = ViewServer::start(&file);
    compare_drawn(&mut Page::open(&served.address(), SIZE), name, &file);
}

/// Compares what a page draws of a file with rays; of models, with their studio.
pub(super) fn compare_drawn(page: &mut Page, name: &str, file: &Path) {
    let drawn = SurfacePixels::by_page(page);
    let camera = page.evaluate("window.glanz.state().camera");
    let loaded = load(file, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut description = loaded.description;
    if let Some(settings) = &loaded.studio {
        add_studio(&mut description, settings);
    }
    let (scene, _) = Scene::resolve(description.clone()).expect("a scene");
    let model = Model::try_new(name, &description, &scene, &[]).expect("a model");
    let exact = SurfacePixels::by_rays(&scene, &model, &camera, drawn.size);
    let difference = drawn.difference(&exact);
    let angle = |share: f64| {
        difference.angles.get((share * difference.angles.len() as f64) as usize).copied().unwrap_or(0.0)
    };
    let pixels = drawn.size[0] * drawn.size[1];
    let through = drawn.uncovered(&exact);
    println!(
        "{name}, {} x {} pixels, {} of the same object: normals of {} that are curved, {:.3} % within {} degree (half within {:.5}, \
         99.9 % within {:.4} degrees); {} pixels of another object, at most {:.2} pixels from an edge; background through {through}",
        drawn.size[0],
        drawn.size[1],
        difference.same,
        difference.angles.len(),
        100.0 * difference.within(NORMALS.0),
        NORMALS.0,
        angle(0.5),
        angle(0.999),
        difference.other,
        difference.farthest
    );
    assert!(difference.same > pixels / 10, "hardly anything is compared");
    assert!(
        difference.angles.len() < 1000 || difference.within(NORMALS.0) >= NORMALS.1,
        "normals are off, see above"
    );
    assert!(difference.farthest <= SILHOUETTE, "silhouettes are off, see above");
    assert_eq!(through, 0, "background shows through");
    assert_eq!(page.faults(), [""; 0]);
}

#[test]
fn the_teapot_is_drawn_where_rays_meet_it_with_its_normals() {
    compare("teapot.pbrt");
}

/// Tests of the nightly run.
mod heavy {
    use super::*;

    #[test]
    fn the_trimmed_plate_is_drawn_where_rays_meet_it_with_its_normals() {
        compare("plate.pbrt");
    }

    #[test]
    fn quadrics_torus_and_quartic_are_drawn_where_rays_meet_them_with_their_normals() {
        compare("demo.pbrt");
    }
}
