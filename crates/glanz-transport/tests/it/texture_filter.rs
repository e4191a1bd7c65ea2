//! Pictures on surfaces, averaged over the footprints of rays.

use std::f64::consts::FRAC_PI_4;

use glanz_math::DVec3;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;

use crate::common::*;

const FILTERS: [ImageFilter; 2] = [ImageFilter::Trilinear, ImageFilter::Anisotropic { most: 8 }];

/// The mean of the pixels 0 and 0.8.
const MEAN: f64 = 0.4;

/// Radiance is reflectance on surfaces that face up.
fn lit(builder: SceneBuilder) -> SceneBuilder {
    builder.light(LightDescription::distant(DVec3::Z, DVec3::ZERO, [std::f32::consts::PI; 3]))
}

/// A floor of 8 m x 8 m from above, of which each of 5 x 5 pixels sees about 1 m x 1 m: the whole picture with its 64 x 64 pixels.
fn floor_from_above(filter: ImageFilter) -> SceneBuilder {
    let angle = 2.0 * (2.5_f64 / 10.0).atan();
    let view = looking(DVec3::Z * 10.0, DVec3::ZERO, [5, 5], angle);
    lit(checkered(view, filter, 64, 8.0))
        .shape(ShapeDescription::rectangle([-4.0, 4.0], [-4.0, 4.0]), "checkered")
}

fn largest_deviation(values: &[f64], mean: f64) -> f64 {
    values.iter().map(|value| (value - mean).abs()).fold(0.0, f64::max)
}

#[test]
fn a_checkerboard_from_afar_is_its_mean_with_one_sample() {
    for filter in FILTERS {
        for run in Run::all_exact(2) {
            let run = Run { samples: 0..1, ..run };
            run.picture(&floor_from_above(filter)).assert_exact(MEAN, &format!("{filter:?} {}", run.name()));
        }
    }
    let run = Run::new("path", 2, 1);
    for filter in [ImageFilter::Point, ImageFilter::Bilinear] {
        let picture = run.picture(&floor_from_above(filter));
        assert!(largest_deviation(&picture.mean[0], MEAN) > 0.2, "{filter:?}");
    }
}

/// As from above, with a mirror at 45 degrees that shows the floor, and a pane in front of it. Both dim the light by factors that a grey floor has, too.
#[test]
fn mirrors_and_glass_show_filtered_pictures() {
    let view = |filter| {
        let view = looking(DVec3::new(-4.0, 0.0, 6.0), DVec3::Z * 6.0, [5, 5], 0.5);
        let mirror = ShapeDescription::rectangle([-3.0, 3.0], [-3.0, 3.0]).rotated(DVec3::Y, FRAC_PI_4);
        let pane = ShapeDescription::cuboid([-2.5, -2.0, 4.0], [-2.3, 2.0, 8.0]);
        // From the side, so that mirror and pane cast no shadow on what they show.
        checkered(view, filter, 64, 8.0)
            .light(LightDescription::distant(DVec3::new(0.0, 2.0, 1.0), DVec3::ZERO, [9.0; 3]))
            .shape(mirror.translated([0.0, 0.0, 6.0]), MaterialKind::mirror(0.9))
            .shape(pane, glass())
    };
    let floor = || ShapeDescription::rectangle([-4.0, 4.0], [-4.0, 4.0]);
    for filter in FILTERS {
        for run in Run::all_exact(6) {
            let run = Run { samples: 0..1, ..run };
            let found = run.picture(&view(filter).shape(floor(), "checkered"));
            let grey = run.picture(&view(filter).shape(floor(), diffuse(MEAN as f32)));
            assert!(grey.mean[0].iter().any(|&value| value > 0.2), "{}", run.name());
            for (a, b) in found.mean[0].iter().zip(&grey.mean[0]) {
                assert!((a - b).abs() < 2e-3, "{filter:?} {}: {a} {b}", run.name());
            }
        }
    }
}

/// A point of the floor at the angle a under the horizon is h / tan(a) away, and a sample with the angle w sees w h / sin^2(a) of it in depth. Where that is
/// more than the picture, there is only its mean.
#[test]
fn a_floor_fades_to_its_mean_at_the_horizon() {
    let (size, angle): (u32, f64) = (32, 0.8);
    // A picture of 4 m x 4 m.
    let view = |filter| {
        let view = looking(DVec3::Z, DVec3::new(1.0, 0.0, 1.0), [size, size], angle).edit(|scene| {
            let camera = CameraDescription::look_at(DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::Z);
            scene.camera = camera.with_field_of_view(0.8);
        });
        let floor = ShapeDescription::rectangle([-4000.0, 4000.0], [-4000.0, 4000.0]);
        lit(checkered(view, filter, 16, 2000.0)).shape(floor, "checkered")
    };
    let run = Run::new("path", 2, 1);
    let row = |picture: &Picture, row: u32| {
        let first = (row * size) as usize;
        picture.mean[0][first..first + size as usize].to_vec()
    };
    let pixel = 2.0 * (0.5 * angle).tan() / f64::from(size);
    // The middles of rows are this far below the horizon; rows 16 and 17 see more than 1 m^2 w / a^2 = 4 m in depth even at their far borders.
    let seen = |row: u32| pixel / (f64::from(row - size / 2 + 1) * pixel).powi(2);
    assert!(seen(size / 2 + 1) > 4.0, "{}", seen(size / 2 + 1));
    let picture = run.picture(&view(ImageFilter::Trilinear));
    for near in [size / 2, size / 2 + 1] {
        assert!(largest_deviation(&row(&picture, near), MEAN) < 1e-6);
    }
    // Three metres in front of the camera, those of the picture (25 cm) are larger than those of the film.
    let deviation = |picture: &Picture, rows: std::ops::Range<u32>| {
        rows.map(|number| largest_deviation(&row(picture, number), MEAN)).fold(0.0, f64::max)
    };
    assert!(deviation(&picture, size - 4..size) > 0.25);
    let bilinear = run.picture(&view(ImageFilter::Bilinear));
    assert!(deviation(&bilinear, size / 2..size / 2 + 2) > 0.25);
}

/// After a rough surface rays have no footprint: a diffuse wall lit by the floor alone is lit the same.
#[test]
fn light_of_filtered_pictures_on_rough_surfaces_is_that_of_others() {
    let view = |filter| {
        let view = looking(DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 1.0), [2, 2], 0.3);
        lit(checkered(view, filter, 8, 8.0))
            .shape(ShapeDescription::rectangle([0.0, 4.0], [-2.0, 2.0]), "checkered")
            .shape(rectangle(DVec3::new(0.0, -2.0, 0.0), DVec3::Y * 4.0, DVec3::Z * 4.0), diffuse(0.5))
    };
    let run = Run::new("path", 3, 400);
    let [filtered, other] = [FILTERS[1], ImageFilter::Bilinear].map(|filter| run.picture(&view(filter)));
    assert_eq!(filtered.mean, other.mean);
    assert!(filtered.mean[0].iter().all(|&value| value > 0.01));
}
