//! Daylight factors against closed forms.

use std::f64::consts::PI;

use crate::combined::calculated;
use crate::common::*;
use glanz_illumination::GridResolution::Cells;
use glanz_illumination::*;
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// The scene under the sky; its own lamp must not matter.
fn by_day(builder: SceneBuilder) -> Scene {
    let mut description = builder.light(point_light(DVec3::new(0.0, 0.0, 0.1), 1e6)).describe().unwrap();
    under_overcast_sky(&mut description);
    Scene::resolve(description).unwrap().0
}

fn factors(builder: SceneBuilder, asked: &[ReceiverRequest], error: f64) -> Vec<DaylightFactors> {
    calculated(&by_day(builder), asked, error).0.iter().map(DaylightFactors::of).collect()
}

#[test]
fn open_ground_has_all_light_and_walls_two_fifths_of_it() {
    let wall = ShapeDescription::parallelogram([0.0, 50.0, 0.0], DVec3::X, DVec3::Z);
    let lamp = ShapeDescription::sphere(0.1).translated([5.0, 0.0, -5.0]).emitting(candela_per_area(1e6));
    let builder = SceneBuilder::new()
        .shape(rectangle(1.0, 1.0), diffuse(0.0))
        .shape(wall, diffuse(0.0))
        .shape(lamp, diffuse(0.0));
    let found =
        factors(builder, &[request("ground", 0, Cells([1, 1])), request("wall", 1, Cells([1, 1]))], 0.002);
    // 6 (pi / 4 + 2 / 3) / (7 pi) of the sky, and half of the ground's albedo.
    let expected = [1.0, 6.0 * (PI / 4.0 + 2.0 / 3.0) / (7.0 * PI) + 0.5 * 0.2];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found.mean / expected - 1.0).abs() < 0.006, "{found:?} {expected}");
        assert!(
            (found.median / found.mean - 1.0).abs() < 1e-9 && (found.minimum / found.mean - 1.0).abs() < 1e-9
        );
    }
}

#[test]
fn floor_below_an_opening_in_the_roof_sees_a_part_of_the_zenith() {
    // A black room, closed but for a square of a metre in its roof, 3 m above the floor.
    let (x, y, z) = (DVec3::X * 4.0, DVec3::Y * 4.0, DVec3::Z * 3.0);
    let o = DVec3::new(-2.0, -2.0, 0.0);
    let roof = |corner: [f64; 2], size: [f64; 2]| {
        ShapeDescription::parallelogram([corner[0], corner[1], 3.0], DVec3::Y * size[1], DVec3::X * size[0])
    };
    let parallelogram = ShapeDescription::parallelogram;
    let builder = [
        parallelogram(o, x, y),
        parallelogram(o, y, z),
        parallelogram(o + x, z, y),
        parallelogram(o, z, x),
        parallelogram(o + y, x, z),
        roof([-2.0, -2.0], [4.0, 1.5]),
        roof([-2.0, 0.5], [4.0, 1.5]),
        roof([-2.0, -0.5], [1.5, 1.0]),
        roof([0.5, -0.5], [1.5, 1.0]),
    ]
    .into_iter()
    .fold(SceneBuilder::new(), |builder, shape| builder.shape(shape, diffuse(0.0)));
    let (maps, _) = calculated(&by_day(builder), &[request("floor", 0, Cells([4, 4]))], 0.01);
    let lux = |p: DVec2| {
        // 9 / (7 pi) (1 + 2 cos) / 3 of the open ground's light per solid angle, over the opening.
        const PARTS: i32 = 40;
        let share = |i: i32| (f64::from(i) + 0.5) / f64::from(PARTS) - 0.5;
        let parts = (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| DVec2::new(share(i), share(j))));
        let one = |at: DVec2| {
            let squared = (at - p).length_squared() + 9.0;
            let cos = 3.0 / squared.sqrt();
            3.0 / (7.0 * PI) * (1.0 + 2.0 * cos) * cos * cos / squared
        };
        10_000.0 * parts.map(one).sum::<f64>() / f64::from(PARTS * PARTS)
    };
    assert_map_within(&maps[0], &cell_means(&maps[0], lux), 0.03, ERRORS);
}
