//! Areas of surfaces that shine, and how bright they are for what they give off.

use std::f64::consts::{PI, TAU};

use glanz_light::{SpectralDistribution, Wavelengths, units};
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::*;
use glanz_scene::{Light, Scene, SceneError};

fn shining(
    geometry: GeometryDescription,
    to_parent: DMat4,
    power: Option<EmissionPower>,
) -> ShapeDescription {
    let radiance = SpectralDistribution::Rgb([2.0, 1.0, 0.5]);
    ShapeDescription {
        geometry,
        to_parent,
        reverse_orientation: false,
        material: 0,
        emission: Some(EmissionDescription { radiance, scale: 1.0, power, two_sided: false }),
        trim: None,
        receiver: None,
        location: None,
    }
}

fn resolve(shapes: Vec<ShapeDescription>, copy: Option<DMat4>) -> Result<Scene, SceneError> {
    let mut description = Description::default();
    description.materials.push(MaterialDescription {
        name: String::new(),
        kind: MaterialKind::diffuse(0.5),
        location: None,
    });
    let group = GroupDescription { shapes, ..GroupDescription::default() };
    match copy {
        None => description.world = group,
        Some(to_parent) => {
            description.groups.push(group);
            description.world.instances.push(InstanceDescription { group: 0, to_parent, location: None });
        }
    }
    Scene::resolve(description).map(|(scene, _)| scene)
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

fn area(geometry: GeometryDescription, to_parent: DMat4) -> f64 {
    lights(&resolve(vec![shining(geometry, to_parent, None)], None).unwrap())[0].0
}

fn scale(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_rotation_z(0.7) * DMat4::from_scale(DVec3::new(x, y, z))
}

fn sphere(radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { radius, z: [-radius, radius], phi_max: TAU }
}

fn disk(radius: f64) -> GeometryDescription {
    GeometryDescription::Disk { height: 0.0, radius, inner_radius: 0.0, phi_max: TAU }
}

fn torus() -> GeometryDescription {
    GeometryDescription::Torus { major_radius: 1.0, minor_radius: 0.25, phi_max: TAU }
}

fn patch(corners: [DVec3; 4]) -> GeometryDescription {
    GeometryDescription::Bilinear { positions: corners.to_vec(), indices: vec![[0, 1, 2, 3]] }
}

fn triangle() -> GeometryDescription {
    GeometryDescription::Triangles {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Z],
        indices: vec![[0, 1, 2]],
        normals: None,
        uvs: None,
    }
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
}

#[test]
fn areas_are_those_of_closed_forms() {
    close(area(sphere(0.5), scale(3.0, 3.0, 3.0)), 9.0 * PI, 1e-14);
    close(area(disk(0.5), scale(2.0, 2.0, 2.0)), PI, 1e-14);
    // An ellipse with half axes 1 and 2.
    close(area(disk(1.0), scale(1.0, 2.0, 5.0)), 2.0 * PI, 1e-9);
    let tube = GeometryDescription::Cylinder { radius: 0.25, z: [0.0, 3.0], phi_max: PI };
    close(area(tube.clone(), scale(1.0, 1.0, 1.0)), 0.75 * PI, 1e-14);
    close(area(tube, scale(1.0, 1.0, 4.0)), 3.0 * PI, 1e-9);
    close(area(torus(), scale(1.0, 1.0, 1.0)), PI * PI, 1e-14);
    // Spheroids with half axes a, a, c: 2 pi a^2 (1 + (1 - e^2) / e atanh e) if c < a, e^2 = 1 - c^2 / a^2;
    // 2 pi a^2 (1 + c / (a e) asin e) if c > a, e^2 = 1 - a^2 / c^2.
    let e = 0.75_f64.sqrt();
    close(area(sphere(1.0), scale(2.0, 2.0, 1.0)), 8.0 * PI * (1.0 + 0.25 / e * e.atanh()), 1e-9);
    close(area(sphere(1.0), scale(1.0, 1.0, 2.0)), 2.0 * PI * (1.0 + 2.0 / e * e.asin()), 1e-9);
    // The segment from (1, 0, 0) to (1, 2, 1) turns about the z axis: r^2 = 1 + 4 z^2, area = TAU times the integral of
    // sqrt(r^2 + (r r')^2) = sqrt(1 + 20 z^2) over [0, 1].
    let hyperboloid =
        GeometryDescription::Hyperboloid { p1: DVec3::X, p2: DVec3::new(1.0, 2.0, 1.0), phi_max: TAU };
    let k = 20.0_f64.sqrt();
    close(area(hyperboloid, scale(1.0, 1.0, 1.0)), TAU * 0.5 * (21.0_f64.sqrt() + k.asinh() / k), 1e-9);
    // z = x y over the unit square has the area element sqrt(1 + x^2 + y^2); in polar coordinates half of it is 1/3 of the integral of
    // (1 + sec^2 phi)^(3/2) - 1 over [0, pi / 4], elementary by t = tan phi.
    let saddle = patch([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE]);
    let expected = 3.0_f64.sqrt() / 3.0 + 4.0 / 3.0 * 0.5_f64.sqrt().asinh() - PI / 18.0;
    close(area(saddle, DMat4::from_rotation_x(1.0)), expected, 1e-9);
}

#[test]
fn areas_of_copies_are_those_in_the_world() {
    let copy = |geometry, to_parent| {
        let shape = shining(geometry, DMat4::IDENTITY, None);
        lights(&resolve(vec![shape], Some(to_parent)).unwrap())[0].0
    };
    // The triangle lies in y = 0.
    close(copy(triangle(), scale(2.0, 7.0, 3.0)), 3.0, 1e-12);
    close(copy(sphere(1.0), scale(2.0, 2.0, 2.0)), 16.0 * PI, 1e-14);
}

#[test]
fn lumens_are_the_flux_and_candela_the_intensity_along_the_normal() {
    let luminance = |geometry, power| {
        let scene = resolve(vec![shining(geometry, DMat4::IDENTITY, Some(power))], None).unwrap();
        lights(&scene)[0].1
    };
    // Flux pi L A; intensity L A of what is flat, L pi r^2 of a sphere. A unit disk has the area pi.
    let tolerance = 1e-6;
    close(luminance(disk(1.0), EmissionPower::Lumens(1000.0)), 1000.0 / (PI * PI), tolerance);
    close(luminance(torus(), EmissionPower::Lumens(1000.0)), 1000.0 / (PI * PI * PI), tolerance);
    close(luminance(disk(1.0), EmissionPower::Candela(1000.0)), 1000.0 / PI, tolerance);
    close(luminance(sphere(2.0), EmissionPower::Candela(1000.0)), 1000.0 / (4.0 * PI), tolerance);
    close(luminance(triangle(), EmissionPower::Candela(3.0)), 6.0, tolerance);
    let square = patch([DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Z, 2.0 * (DVec3::X + DVec3::Z)]);
    close(luminance(square, EmissionPower::Candela(3.0)), 0.75, tolerance);
}

#[test]
fn patches_of_a_shape_share_its_lumens() {
    let corners = [0.0, 1.0, 4.0].map(|x| [DVec3::X * x, DVec3::new(x, 1.0, 0.0)]).concat();
    let two = GeometryDescription::Bilinear { positions: corners, indices: vec![[0, 1, 2, 3], [2, 3, 4, 5]] };
    let shape = shining(two.clone(), DMat4::IDENTITY, Some(EmissionPower::Lumens(100.0)));
    let found = lights(&resolve(vec![shape], None).unwrap());
    assert_eq!(found.len(), 2);
    // 4 m^2 in all.
    for ((area, luminance), expected) in found.into_iter().zip([1.0, 3.0]) {
        close(area, expected, 1e-9);
        close(luminance, 25.0 / PI, 1e-6);
    }
    let shape = shining(two, DMat4::IDENTITY, Some(EmissionPower::Candela(100.0)));
    let error = resolve(vec![shape], None).unwrap_err().to_string();
    assert!(error.contains("say lumens for more"), "{error}");
}

#[test]
fn candela_of_other_surfaces_are_refused() {
    let saddle = patch([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE]);
    let half = GeometryDescription::Sphere { radius: 1.0, z: [0.0, 1.0], phi_max: TAU };
    for (geometry, to_parent) in [
        (torus(), DMat4::IDENTITY),
        (saddle, DMat4::IDENTITY),
        (half, DMat4::IDENTITY),
        (sphere(1.0), scale(1.0, 1.0, 2.0)),
    ] {
        let shape = shining(geometry, to_parent, Some(EmissionPower::Candela(1.0)));
        let error = resolve(vec![shape], None).unwrap_err().to_string();
        assert!(error.contains("say lumens"), "{error}");
    }
}
