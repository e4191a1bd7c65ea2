//! Areas and luminances of area lights.

use std::f64::consts::{PI, TAU};

use glanz_light::{Pixels, Wavelengths, units};
use glanz_math::{DMat4, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Light, Scene, SceneBuilder, SceneError};

fn shining(shape: ShapeDescription, power: Option<EmissionPower>) -> ShapeDescription {
    shape.emitting(EmissionDescription { power, ..[2.0, 1.0, 0.5].into() })
}

fn resolve(shape: ShapeDescription, power: Option<EmissionPower>) -> Result<Scene, SceneError> {
    let builder = SceneBuilder::new().shape(shining(shape, power), MaterialKind::diffuse(0.5));
    builder.resolve().map(|(scene, _)| scene)
}

/// Areas of the lights, and their radiance as lumens per m^2 and sr.
fn lights(scene: &Scene) -> Vec<(f64, f64)> {
    let of = |light: &Light| {
        let Light::Area(light) = light else { unreachable!() };
        let area = light.area().unwrap();
        (area, units::photometric(light.power(), &Wavelengths::default()) / (PI * area))
    };
    scene.lights().iter().map(of).collect()
}

fn area(shape: ShapeDescription, matrix: DMat4) -> f64 {
    lights(&resolve(shape.transformed(matrix), None).unwrap())[0].0
}

fn scale(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_rotation_z(0.7) * DMat4::from_scale(DVec3::new(x, y, z))
}

fn torus() -> ShapeDescription {
    ShapeDescription::torus(1.0, 0.25)
}

fn patch(corners: [DVec3; 4]) -> ShapeDescription {
    GeometryDescription::Bilinear { positions: corners.to_vec(), indices: vec![[0, 1, 2, 3]] }.into()
}

fn triangle() -> ShapeDescription {
    ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Z], vec![[0, 1, 2]])
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
}

/// A square of side 2 around the origin that faces z, with a picture whose quarters are, row by row, black, red, green and blue.
fn pictured(emission: EmissionDescription) -> Scene {
    square_with(emission, crate::image_light::quarters())
}

/// That square with another picture.
fn square_with(emission: EmissionDescription, pixels: Pixels) -> Scene {
    let square = ShapeDescription::parallelogram([-1.0, -1.0, 0.0], DVec3::X * 2.0, DVec3::Y * 2.0);
    let emission = EmissionDescription { image: Some(0), ..emission };
    let builder = SceneBuilder::new().shape(square.emitting(emission), MaterialKind::diffuse(0.5));
    crate::image_light::with_picture(builder, pixels)
}

#[test]
fn picture_of_a_light_is_placed_by_texture_coordinates() {
    let scene = pictured([2.0, 3.0, 4.0].into());
    for (x, y, expected) in [
        (-0.5, 0.5, [0.0; 3]),
        (0.5, 0.5, [2.0, 0.0, 0.0]),
        (-0.5, -0.5, [0.0, 3.0, 0.0]),
        (0.5, -0.5, [0.0, 0.0, 4.0]),
        // Half way between two pixels.
        (0.5, 0.0, [1.0, 0.0, 2.0]),
    ] {
        let hit = scene.intersect(&Ray::new(DVec3::new(x, y, 1.0), -DVec3::Z), f64::INFINITY).unwrap();
        let front = scene.emitted(&hit, DVec3::Z).to_rgb(&Wavelengths::default());
        for (found, expected) in front.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{x} {y}: {front:?}");
        }
        assert!(scene.emitted(&hit, -DVec3::Z).is_black());
    }
}

#[test]
fn power_of_a_light_with_a_picture_is_that_of_its_mean() {
    let power = |scene: &Scene| {
        let Some(Light::Area(light)) = scene.lights().first() else { unreachable!() };
        assert!(light.has_picture());
        light.power().to_rgb(&Wavelengths::default())
    };
    // A quarter of 4 m^2 in each colour.
    let found = power(&pictured(EmissionDescription { two_sided: true, ..[2.0, 3.0, 4.0].into() }));
    for (found, expected) in found.into_iter().zip([2.0, 3.0, 4.0].map(|x| 2.0 * PI * x)) {
        close(f64::from(found), expected, 1e-4);
    }
    let watts = EmissionDescription { power: Some(EmissionPower::Watts(70.0)), ..[1.0; 3].into() };
    let scene = pictured(watts);
    let Some(Light::Area(light)) = scene.lights().first() else { unreachable!() };
    close(f64::from(light.power().luminance(&Wavelengths::default())), 70.0, 1e-5);
}

#[test]
fn power_counts_every_pixel_of_a_large_picture() {
    // One bright pixel, the mean of the picture is 1.
    for ([width, height], [column, row]) in
        [([600, 300], [101, 37]), ([300, 600], [299, 0]), ([1000, 1], [501, 0])]
    {
        let (count, bright) = (width * height, row * width + column);
        let rgb: Vec<[f32; 3]> =
            (0..count).map(|i| [if i == bright { count as f32 } else { 0.0 }; 3]).collect();
        let scene = square_with(1.0.into(), Pixels::try_from_rgb(width, height, &rgb).unwrap());
        let Some(Light::Area(light)) = scene.lights().first() else { unreachable!() };
        // pi times the 4 m^2 of the square.
        close(f64::from(light.power().luminance(&Wavelengths::default())), 4.0 * PI, 1e-4);
    }
}

#[test]
fn areas_are_those_of_closed_forms() {
    close(area(ShapeDescription::sphere(0.5), scale(3.0, 3.0, 3.0)), 9.0 * PI, 1e-14);
    close(area(ShapeDescription::disk(0.5), scale(2.0, 2.0, 2.0)), PI, 1e-14);
    // An ellipse with half axes 1 and 2.
    close(area(ShapeDescription::disk(1.0), scale(1.0, 2.0, 5.0)), 2.0 * PI, 1e-9);
    let tube = GeometryDescription::Cylinder { radius: 0.25, z: [0.0, 3.0], phi_max: PI };
    let tube = ShapeDescription::from(tube);
    close(area(tube.clone(), scale(1.0, 1.0, 1.0)), 0.75 * PI, 1e-14);
    close(area(tube, scale(1.0, 1.0, 4.0)), 3.0 * PI, 1e-9);
    close(area(torus(), scale(1.0, 1.0, 1.0)), PI * PI, 1e-14);
    // Spheroids with half axes a, a, c: 2 pi a^2 (1 + (1 - e^2) / e atanh e) if c < a, e^2 = 1 - c^2 / a^2;
    // 2 pi a^2 (1 + c / (a e) asin e) if c > a, e^2 = 1 - a^2 / c^2.
    let e = 0.75_f64.sqrt();
    close(
        area(ShapeDescription::sphere(1.0), scale(2.0, 2.0, 1.0)),
        8.0 * PI * (1.0 + 0.25 / e * e.atanh()),
        1e-9,
    );
    close(
        area(ShapeDescription::sphere(1.0), scale(1.0, 1.0, 2.0)),
        2.0 * PI * (1.0 + 2.0 / e * e.asin()),
        1e-9,
    );
    // The segment from (1, 0, 0) to (1, 2, 1) turns about the z axis: r^2 = 1 + 4 z^2, area = TAU times the integral of
    // sqrt(r^2 + (r r')^2) = sqrt(1 + 20 z^2) over [0, 1].
    let hyperboloid =
        GeometryDescription::Hyperboloid { p1: DVec3::X, p2: DVec3::new(1.0, 2.0, 1.0), phi_max: TAU };
    let k = 20.0_f64.sqrt();
    close(
        area(hyperboloid.into(), scale(1.0, 1.0, 1.0)),
        TAU * 0.5 * (21.0_f64.sqrt() + k.asinh() / k),
        1e-9,
    );
    // z = x y over the unit square has the area element sqrt(1 + x^2 + y^2); in polar coordinates half of it is 1/3 of the integral of
    // (1 + sec^2 phi)^(3/2) - 1 over [0, pi / 4], elementary by t = tan phi.
    let saddle = patch([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE]);
    let expected = 3.0_f64.sqrt() / 3.0 + 4.0 / 3.0 * 0.5_f64.sqrt().asinh() - PI / 18.0;
    close(area(saddle, DMat4::from_rotation_x(1.0)), expected, 1e-9);
}

#[test]
fn areas_of_copies_are_those_in_the_world() {
    let copy = |shape, to_parent| {
        let contents = |group: SceneBuilder| group.shape(shining(shape, None), MaterialKind::diffuse(0.5));
        let builder = SceneBuilder::new().group("light", contents).instance("light", to_parent);
        lights(&builder.resolve().unwrap().0)[0].0
    };
    // The triangle lies in y = 0.
    close(copy(triangle(), scale(2.0, 7.0, 3.0)), 3.0, 1e-12);
    close(copy(ShapeDescription::sphere(1.0), scale(2.0, 2.0, 2.0)), 16.0 * PI, 1e-14);
}

#[test]
fn lumens_are_the_flux_and_candela_the_intensity_along_the_normal() {
    let luminance = |shape, power| lights(&resolve(shape, Some(power)).unwrap())[0].1;
    // Flux pi L A; intensity L A of what is flat, L pi r^2 of a sphere. A unit disk has the area pi.
    let tolerance = 1e-6;
    close(
        luminance(ShapeDescription::disk(1.0), EmissionPower::Lumens(1000.0)),
        1000.0 / (PI * PI),
        tolerance,
    );
    close(luminance(torus(), EmissionPower::Lumens(1000.0)), 1000.0 / (PI * PI * PI), tolerance);
    close(luminance(ShapeDescription::disk(1.0), EmissionPower::Candela(1000.0)), 1000.0 / PI, tolerance);
    close(
        luminance(ShapeDescription::sphere(2.0), EmissionPower::Candela(1000.0)),
        1000.0 / (4.0 * PI),
        tolerance,
    );
    close(luminance(triangle(), EmissionPower::Candela(3.0)), 6.0, tolerance);
    let square = patch([DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Z, 2.0 * (DVec3::X + DVec3::Z)]);
    close(luminance(square, EmissionPower::Candela(3.0)), 0.75, tolerance);
}

#[test]
fn patches_of_a_shape_share_its_lumens() {
    let corners = [0.0, 1.0, 4.0].map(|x| [DVec3::X * x, DVec3::new(x, 1.0, 0.0)]).concat();
    let two = GeometryDescription::Bilinear { positions: corners, indices: vec![[0, 1, 2, 3], [2, 3, 4, 5]] };
    let two = ShapeDescription::from(two);
    let found = lights(&resolve(two.clone(), Some(EmissionPower::Lumens(100.0))).unwrap());
    assert_eq!(found.len(), 2);
    // 4 m^2 in all.
    for ((area, luminance), expected) in found.into_iter().zip([1.0, 3.0]) {
        close(area, expected, 1e-9);
        close(luminance, 25.0 / PI, 1e-6);
    }
    let error = resolve(two, Some(EmissionPower::Candela(100.0))).unwrap_err().to_string();
    assert!(error.contains("use lumens for more"), "{error}");
}

#[test]
fn candela_of_other_surfaces_are_refused() {
    let saddle = patch([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE]);
    let half = GeometryDescription::Sphere { radius: 1.0, z: [0.0, 1.0], phi_max: TAU };
    let stretched = ShapeDescription::sphere(1.0).transformed(scale(1.0, 1.0, 2.0));
    for shape in [torus(), saddle, half.into(), stretched] {
        let error = resolve(shape, Some(EmissionPower::Candela(1.0))).unwrap_err().to_string();
        assert!(error.contains("use lumens"), "{error}");
    }
}
