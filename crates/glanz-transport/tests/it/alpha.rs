//! Integrators in scenes with surfaces that rays pass in part.

use glanz_math::DVec3;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;

use crate::common::*;

/// A ball of albedo 0.6 seen from within a black shell of an opacity.
fn ball_in_shell(opacity: f32, shell: ShapeDescription) -> SceneBuilder {
    looking(DVec3::new(0.0, 0.0, -1.5), DVec3::ZERO, [6, 6], 0.5)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .shape(shell.with_alpha(FloatParameter::Value(opacity)), diffuse(0.0))
}

#[test]
fn a_shell_of_opacity_one_quarter_lets_three_quarters_of_the_sky_through() {
    let scene =
        ball_in_shell(0.25, ShapeDescription::sphere(2.0)).light(LightDescription::infinite([2.0; 3]));
    for run in Run::all_random(4, 300) {
        run.picture(&scene).assert_average([0.6 * 2.0 * 0.75; 3], 0.02, &run.name());
    }
}

#[test]
fn a_camera_sees_through_the_front_by_its_transparency() {
    let outside = looking(DVec3::new(0.0, 0.0, -3.0), DVec3::ZERO, [6, 6], 0.3);
    let scene = outside
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .shape(ShapeDescription::sphere(2.0).with_alpha(FloatParameter::Value(0.25)), diffuse(0.0))
        .light(LightDescription::infinite([2.0; 3]));
    for run in Run::all_random(4, 300) {
        run.picture(&scene).assert_average([0.6 * 2.0 * 0.75 * 0.75; 3], 0.03, &run.name());
    }
}

#[test]
fn lights_shine_by_their_opacity_with_any_weights_and_unseen_ones_in_full() {
    let shell = || ShapeDescription::sphere(2.0).reversed().emitting([3.0; 3]);
    for (opacity, share) in [(0.25, 0.25), (0.0, 1.0)] {
        let scene = ball_in_shell(opacity, shell());
        // What no ray hits is only found by light sampling.
        for run in Run::all_random(4, 300).into_iter().filter(|run| opacity > 0.0 || run.light_sampling) {
            let name = format!("opacity {opacity}: {}", run.name());
            run.picture(&scene).assert_average([0.6 * 3.0 * share; 3], 0.04, &name);
        }
    }
}

/// A plane below a spherical lamp, seen from the side, so that rays to the lamp come from outside of it.
fn below_lamp(lamp: ShapeDescription, opacity: f32) -> SceneBuilder {
    let lamp = lamp.translated([0.0, 0.0, 2.0]).with_alpha(FloatParameter::Value(opacity));
    looking(DVec3::new(3.0, 0.0, 0.5), DVec3::ZERO, [2, 2], 0.002)
        .shape(ShapeDescription::rectangle([-0.5, 0.5], [-0.5, 0.5]), diffuse(0.5))
        .shape(lamp, diffuse(0.0))
}

#[test]
fn the_inside_of_a_spherical_lamp_shines_through_its_front() {
    let ball = || ShapeDescription::sphere(1.0);
    let two_sided = EmissionDescription { two_sided: true, ..[3.0; 3].into() };
    let half = 0.5_f64;
    for (name, lamp, opacity, radiance) in [
        ("outward", ball().emitting([3.0; 3]), 0.5, 3.0 * half),
        ("inward", ball().reversed().emitting([3.0; 3]), 0.5, 3.0 * half * half),
        ("two-sided", ball().emitting(two_sided.clone()), 0.5, 3.0 * (half + half * half)),
        ("inward, not seen", ball().reversed().emitting([3.0; 3]), 0.0, 3.0),
    ] {
        // The irradiance of a sphere of radius r at the distance d in front of a plane: pi L (r / d)^2.
        let expected = 0.5 * radiance * 0.25;
        for run in Run::all_random(1, 4000).into_iter().filter(|run| opacity > 0.0 || run.light_sampling) {
            let name = format!("{name}: {}", run.name());
            run.picture(&below_lamp(lamp.clone(), opacity)).assert_average([expected; 3], 0.04, &name);
        }
    }
}
