//! Integrators under infinite lights with pictures, against integrals over the picture.

use std::f64::consts::{PI, TAU};

use crate::common::*;
use glanz_light::Pixels;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::warp;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_scene::light::SphereImage;

#[test]
fn plane_under_a_picture_reflects_its_share_of_the_irradiance() {
    for (mapping, size) in [(SphereMapping::LatitudeLongitude, [16, 8]), (SphereMapping::EqualArea, [12, 12])]
    {
        let scene = one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::ZERO)
            .shape(ShapeDescription::plane(), diffuse(0.7))
            // Paths from lights need a bounded scene.
            .shape(ShapeDescription::sphere(1.0).translated([0.0, 0.0, -1.5]), diffuse(0.7));
        let scene = under_picture(scene, mapping, size);
        // Radiance of the picture times cosine over the directions around z, by the midpoint rule on a fine grid; the light is turned
        // by a quarter about z, which changes nothing.
        let picture =
            SphereImage::try_new(&scene.clone().describe().unwrap().images[0].picture, mapping).unwrap();
        let n = 800;
        let mut irradiance = 0.0;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let wi =
                warp::uniform_hemisphere(DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(n));
            irradiance += f64::from(picture.lookup(wi)[0]) * wi.z * TAU / f64::from(n * n);
        }
        let expected = 0.7 / PI * irradiance;
        for run in Run::all_random(2, 2048).into_iter().filter(|run| run.light_sampling) {
            run.picture(&scene).assert_average([expected; 3], 0.03, &run.name());
        }
        let whitted = Run::new("whitted", 2, 2048);
        whitted.picture(&scene).assert_average([expected; 3], 0.03, "whitted");
    }
}

#[test]
fn picture_is_seen_itself_and_in_mirrors() {
    let sky = |scene| under_picture(scene, SphereMapping::LatitudeLongitude, [16, 8]);
    let picture = sky(SceneBuilder::new()).describe().unwrap().images.remove(0).picture;
    let picture = SphereImage::try_new(&picture, SphereMapping::LatitudeLongitude).unwrap();
    let towards = DVec3::new(1.0, 0.4, 0.3).normalize();
    // The picture is turned by a quarter about z.
    let seen = |wi: DVec3| f64::from(picture.lookup(DVec3::new(wi.y, -wi.x, wi.z))[0]);
    let narrow = |from: DVec3, to: DVec3| looking(from, to, [1, 1], 1e-4);
    let empty = narrow(DVec3::ZERO, towards)
        .shape(ShapeDescription::sphere(1.0).translated([0.0, 0.0, -9.0]), diffuse(0.6));
    let mirror = narrow(DVec3::new(towards.x, towards.y, -towards.z) * -2.0, DVec3::ZERO)
        .shape(ShapeDescription::plane(), MaterialKind::mirror(0.5));
    for run in Run::all_random(5, 16).into_iter().chain([Run::new("whitted", 5, 16)]) {
        run.picture(&sky(empty.clone())).assert_average([seen(towards); 3], 1e-3, &run.name());
        run.picture(&sky(mirror.clone())).assert_average([0.5 * seen(towards); 3], 1e-3, &run.name());
    }
}

#[test]
fn even_picture_is_a_furnace() {
    for mapping in [SphereMapping::LatitudeLongitude, SphereMapping::EqualArea] {
        let pixels = Pixels::try_from_rgb(6, 6, &[[1.5; 3]; 36]).unwrap();
        let light = LightDescription::new(LightKind::ImageInfinite { image: 0, mapping }, [2.0; 3]);
        let image = ImageDescription::try_new("even", &pixels).unwrap();
        let scene = looking(DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO, [6, 6], 0.5)
            .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
            .edit(|scene| scene.images.push(image))
            .light(light);
        for run in Run::all_random(5, 256).into_iter().chain([Run::new("whitted", 5, 256)]) {
            run.picture(&scene).assert_average([1.8; 3], 0.02, &run.name());
        }
    }
}
