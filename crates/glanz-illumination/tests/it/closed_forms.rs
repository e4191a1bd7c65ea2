//! Lux against closed forms: every cell within four of its own standard errors, none of which exceeds one per cent.

use std::f64::consts::PI;

use crate::common::*;
use glanz_illumination::GridResolution::Cells;
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::SceneBuilder;
use glanz_scene::description::ShapeDescription;

/// Particles of the tests; cells get 10^4 and more.
const PARTICLES: u64 = 1 << 20;

#[test]
fn point_and_small_plate_follow_the_third_and_the_fourth_power_of_the_cosine() {
    let (height, candela) = (2.0, 100.0);
    let over = DVec3::new(0.5, -0.2, height);
    let floor = SceneBuilder::new().shape(rectangle(6.0, 4.0), diffuse(0.0));
    let cosine = |p: DVec2| height / (height * height + (p - over.truncate()).length_squared()).sqrt();
    let asked = [request("floor", 0, Cells([3, 2]))];
    // I cos / d^2 with d = h / cos.
    let (point, balance) =
        maps(&resolved(floor.clone().light(point_light(over, candela as f32))), &asked, PARTICLES);
    let lux = |p: DVec2| candela / (height * height) * cosine(p).powi(3);
    assert_map(&point[0], &cell_means(&point[0], lux), 0.01);
    assert!((balance.emitted / (4.0 * PI * candela) - 1.0).abs() < 1e-6 && balance.closes_to() < 1e-6);
    // A plate of radius r that faces the floor sends I cos; what it is not a point for is (r / h)^2 = 2.5e-5.
    let radius = 0.01;
    let luminance = candela / (PI * radius * radius);
    let down = DMat4::from_translation(over) * DMat4::from_rotation_x(PI);
    let plate = floor.shape(
        ShapeDescription::disk(radius).transformed(down).emitting(candela_per_area(luminance as f32)),
        diffuse(0.0),
    );
    let (plate, balance) = maps(&resolved(plate), &asked, PARTICLES / 2);
    let lux = |p: DVec2| candela / (height * height) * cosine(p).powi(4);
    assert_map(&plate[0], &cell_means(&plate[0], lux), 0.01);
    assert!((balance.emitted / (PI * candela) - 1.0).abs() < 1e-5 && balance.closes_to() < 1e-6);
}

#[test]
fn lambert_disk_lights_a_parallel_plane_as_its_view_factor_says() {
    let (height, radius, luminance) = (1.5, 0.8, 1000.0);
    let down = DMat4::from_translation(DVec3::Z * height) * DMat4::from_rotation_x(PI);
    let scene = SceneBuilder::new()
        .shape(rectangle(3.0, 3.0), diffuse(0.0))
        .shape(
            ShapeDescription::disk(radius).transformed(down).emitting(candela_per_area(luminance as f32)),
            diffuse(0.0),
        )
        .resolve()
        .unwrap()
        .0;
    let (maps, balance) = maps(&scene, &[request("floor", 0, Cells([3, 3]))], PARTICLES);
    // @howell2011: a small plane element and a parallel disk.
    let lux = |p: DVec2| {
        let (h2, r2, d2) = (height * height, radius * radius, p.length_squared());
        let root = ((h2 + d2 + r2).powi(2) - 4.0 * r2 * d2).sqrt();
        0.5 * PI * luminance * (1.0 - (h2 + d2 - r2) / root)
    };
    assert_map(&maps[0], &cell_means(&maps[0], lux), 0.01);
    // Power of a Lambert disk: pi L A.
    assert!((balance.emitted / (PI * luminance * PI * radius * radius) - 1.0).abs() < 1e-5);
}

#[test]
fn flat_mirror_adds_an_image_of_the_source() {
    let (reflectance, candela) = (0.75, 100.0);
    let lamp = DVec3::new(0.3, 0.1, 1.0);
    // The mirror stands at x = -1, larger than what the floor can see in it.
    let mirror_at = DMat4::from_translation(-DVec3::X) * DMat4::from_rotation_y(0.5 * PI);
    let scene = SceneBuilder::new()
        .shape(rectangle(2.0, 2.0), diffuse(0.0))
        .shape(rectangle(20.0, 20.0).transformed(mirror_at), mirror(reflectance as f32))
        .light(point_light(lamp, candela as f32))
        .resolve()
        .unwrap()
        .0;
    let (maps, balance) = maps(&scene, &[request("floor", 0, Cells([3, 3]))], PARTICLES);
    let of = |source: DVec3, p: DVec2| {
        let way = source - p.extend(0.0);
        candela * source.z / way.length().powi(3)
    };
    let image = DVec3::new(-2.0 - lamp.x, lamp.y, lamp.z);
    let lux = |p: DVec2| of(lamp, p) + reflectance * of(image, p);
    assert_map(&maps[0], &cell_means(&maps[0], lux), 0.01);
    assert!(balance.closes_to() < 1e-6);
}

#[test]
fn integrating_sphere_is_lit_evenly() {
    // All over: E = P / (4 pi R^2 (1 - rho)) by what was reflected at least once, and what comes straight from the lamp in its
    // middle: P / (4 pi R^2). Together P / (4 pi R^2) / (1 - rho).
    let (radius, reflectance, candela) = (0.5, 0.9, 50.0);
    let scene = SceneBuilder::new()
        .shape(ShapeDescription::sphere(radius).reversed(), diffuse(reflectance as f32))
        .light(point_light(DVec3::ZERO, candela as f32))
        .resolve()
        .unwrap()
        .0;
    let (maps, balance) = maps(&scene, &[request("sphere", 0, Cells([8, 6]))], PARTICLES / 8);
    let expected = candela / (radius * radius) / (1.0 - reflectance);
    assert_map(&maps[0], &[expected; 48], 0.01);
    assert!((maps[0].areas.iter().sum::<f64>() / (4.0 * PI * radius * radius) - 1.0).abs() < 1e-6);
    assert!(balance.closes_to() < 1e-6 && balance.escaped == 0.0);
}

#[test]
fn lamp_off_the_middle_of_an_integrating_sphere_adds_its_direct_light_alone() {
    // Light that a sphere reflects comes to all of it alike: E = direct + P rho / (1 - rho) / (4 pi R^2).
    let (radius, reflectance, candela) = (1.0, 0.6, 50.0);
    let lamp = DVec3::new(0.0, 0.0, 0.5);
    let scene = SceneBuilder::new()
        .shape(ShapeDescription::sphere(radius).reversed(), diffuse(reflectance as f32))
        .light(point_light(lamp, candela as f32))
        .resolve()
        .unwrap()
        .0;
    let (maps, _) = maps(&scene, &[request("sphere", 0, Cells([4, 6]))], PARTICLES / 2);
    let indirect = candela * reflectance / (1.0 - reflectance);
    // Flux of the lamp through the cap of a polar angle t seen from the middle: the cosine of its angle at the lamp is
    // (cos t - a) / sqrt(1 + a^2 - 2 a cos t), a = 1/2.
    let cap = |t: f64| {
        let (c, a) = (t.cos(), lamp.z);
        2.0 * PI * candela * (1.0 - (c - a) / (1.0 + a * a - 2.0 * a * c).sqrt())
    };
    for (cell, (&lux, &error)) in maps[0].lux.iter().zip(&maps[0].errors).enumerate() {
        // Rows are equal in polar angle, from the pole that their position tells.
        let row = (cell / 4) as f64;
        let from_top = maps[0].positions[0].z > 0.0;
        let row = if from_top { row } else { 5.0 - row };
        let (t0, t1) = (row * PI / 6.0, (row + 1.0) * PI / 6.0);
        let area = 2.0 * PI * (t0.cos() - t1.cos());
        let expected = (cap(t1) - cap(t0)) / area + indirect;
        assert!(
            (lux - expected).abs() <= 4.0 * error && error <= 0.01 * expected,
            "{cell}: {lux} {error} {expected}"
        );
    }
}
