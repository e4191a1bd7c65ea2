use std::f64::consts::{PI, TAU};

use glanz_scene::description::{FloatParameter, GeometryDescription, ShapeDescription};

use super::*;
use crate::scenes::{parallelogram, scene, walls};

fn elements(scene: &Scene, side: f64) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side }).unwrap()
}

/// Area of the elements of one side of a surface.
fn area(elements: &Elements<'_>, surface: u32, back: bool) -> f64 {
    let of = |element: &&Element| element.patch.surface == surface && element.patch.back == back;
    elements.list.iter().filter(of).map(|element| element.area).sum()
}

/// The solid of points with coordinates of 0 or more whose sum is at most 1.
fn corner_solid() -> ShapeDescription {
    let octant: Vec<_> = [-DVec3::X, -DVec3::Y, -DVec3::Z].map(|normal| (normal, 0.0)).into();
    let half_spaces = [octant, vec![(DVec3::ONE.normalize(), 1.0 / 3.0_f64.sqrt())]].concat();
    ShapeDescription::from(GeometryDescription::Polyhedron { half_spaces })
}

#[test]
fn both_sides_of_every_surface_are_covered() {
    let sphere = ShapeDescription::sphere(0.5);
    let disk = ShapeDescription::from(GeometryDescription::Disk {
        height: 2.0,
        radius: 1.0,
        inner_radius: 0.25,
        phi_max: TAU,
    });
    let scene = scene([sphere, disk, corner_solid()].into_iter().map(|shape| (shape, 0.5, 0.0)).collect());
    let elements = elements(&scene, 0.2);
    let expected = [PI, PI * (1.0 - 0.0625), 1.5 + 0.5 * 3.0_f64.sqrt()];
    for (surface, placed) in (0_u32..).zip(&elements.surfaces) {
        let expected = expected[placed.shape(0) as usize];
        for back in [false, true] {
            let area = area(&elements, surface, back);
            assert!((area - expected).abs() < 1e-4 * expected, "{surface}: {area} {expected}");
        }
    }
    assert_eq!(elements.left_out, 0);
}

#[test]
fn sides_are_no_longer_than_requested() {
    let scene = scene(vec![(parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y), 0.5, 0.0)]);
    // 2 m by 1 m in sides of 0.3 m at most: 7 by 4, on two sides.
    let elements = elements(&scene, 0.3);
    assert_eq!(elements.list.len(), 2 * 28);
    assert!(elements.list.iter().all(|element| (element.area - 2.0 / 28.0).abs() < 1e-12));
}

#[test]
fn elements_reflect_and_emit_by_their_opacity() {
    let square = |opacity: f32| {
        let square =
            parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y).with_alpha(FloatParameter::Value(opacity));
        scene(vec![(square, 0.5, 2.0)])
    };
    let front = |opacity: f32| {
        let list = elements(&square(opacity), 1.0).list;
        let front = list.into_iter().find(|element| !element.patch.back).unwrap();
        (front.reflectance, front.emission)
    };
    let (_, whole) = front(1.0);
    assert!(!whole.is_black());
    // A light of opacity 0 is not seen and emits in full.
    for (opacity, reflected, emitted) in [(1.0, 0.5, 1.0), (0.25, 0.125, 0.25), (0.0, 0.0, 1.0)] {
        assert_eq!(front(opacity), (Spectrum::from_rgb([reflected; 3]), whole * emitted));
    }
}

#[test]
fn flat_polygons_are_distinguished_from_round_and_twisted_surfaces() {
    let twisted = ShapeDescription::from(GeometryDescription::Bilinear {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.3)],
        indices: vec![[0, 1, 2, 3]],
    });
    let disk = ShapeDescription::from(GeometryDescription::Disk {
        height: 2.0,
        radius: 1.0,
        inner_radius: 0.25,
        phi_max: TAU,
    });
    let flat = parallelogram(DVec3::Z, DVec3::X, DVec3::new(0.3, 1.0, 0.0));
    let scene = scene(vec![(twisted, 0.5, 0.0), (disk, 0.5, 0.0), (flat, 0.5, 0.0)]);
    let elements = elements(&scene, 0.5);
    for element in &elements.list {
        let shape = elements.surfaces[element.patch.surface as usize].shape(0);
        assert_eq!(element.polygon.is_some(), shape == 2, "{element:?}");
        if let Some(corners) = &element.polygon {
            let twice = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
            assert!((twice.length() - element.area).abs() < 1e-12);
            assert!(twice.dot(element.center.normal) > 0.0, "corners go round as the side is seen");
        }
    }
}

#[test]
fn reflectance_and_emission_are_those_of_the_side() {
    let scene = scene(vec![(parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 0.25, 3.0)]);
    for element in &elements(&scene, 1.0).list {
        let emission = element.emission.luminance(&Wavelengths::default());
        let expected = if element.patch.back { 0.0 } else { 3.0 * std::f32::consts::PI };
        assert!((emission - expected).abs() < 1e-4, "{emission}");
        assert!((element.reflectance.max_component() - 0.25).abs() < 1e-6);
        let up = element.center.normal.z;
        assert_eq!(up, if element.patch.back { -1.0 } else { 1.0 });
    }
}

#[test]
fn invalid_sides_are_refused() {
    let scene = scene(walls(DVec3::ONE).into_iter().map(|wall| (wall, 0.5, 0.0)).collect());
    let tried = |side| Elements::new(&scene, &ElementSettings { side }).map(|elements| elements.list.len());
    for side in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(tried(side), Err(ElementError::Side(_))), "{side}");
    }
    for side in [1e-5, 1e-12, f64::MIN_POSITIVE] {
        assert!(matches!(tried(side), Err(ElementError::TooMany { .. })), "{side}");
    }
    assert_eq!(tried(1.0), Ok(12));
}

#[test]
fn quarters_of_an_element_fill_it() {
    let triangle = ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y], vec![[0, 1, 2]]);
    let square = parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y);
    for shape in [square, ShapeDescription::sphere(1.0), triangle, corner_solid()] {
        let scene = scene(vec![(shape, 0.5, 0.0)]);
        let elements = elements(&scene, 0.7);
        for whole in &elements.list {
            let quarters = elements.quarters(whole);
            let area: f64 = quarters.iter().map(|quarter| quarter.area).sum();
            assert!(quarters.len() == 4 && (area / whole.area - 1.0).abs() < 1e-2);
            assert!(quarters.iter().all(|quarter| quarter.patch.back == whole.patch.back));
        }
    }
}
