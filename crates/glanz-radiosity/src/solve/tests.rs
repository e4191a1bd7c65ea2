use glanz_job::CancelFlag;
use glanz_light::Wavelengths;
use glanz_math::DVec3;
use glanz_scene::Scene;

use super::*;
use crate::elements::{ElementSettings, Elements};
use crate::form_factor::FormFactors;
use crate::scenes::{parallelogram, scene, walls};

fn elements(scene: &Scene, side: f64) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side }).unwrap()
}

fn luminance(light: glanz_light::Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}

#[test]
fn furnace_has_the_radiosity_of_its_closed_form() {
    for reflectance in [0.3_f32, 0.8] {
        let shapes = walls(DVec3::new(3.0, 2.0, 2.5)).into_iter().map(|wall| (wall, reflectance, 1.0));
        let scene = scene(shapes.collect());
        let elements = elements(&scene, 0.8);
        let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
        let solved =
            gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &CancelFlag::default())
                .unwrap();
        let expected = std::f64::consts::PI / (1.0 - f64::from(reflectance));
        for (element, &radiosity) in elements.list.iter().zip(&solved.radiosity) {
            if !element.patch.back {
                let found = luminance(radiosity);
                assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
            }
        }
        assert!(solved.change <= 1e-6 && solved.sweeps > 3);
    }
}

#[test]
fn no_light_leaks_through_a_wall() {
    // A wall of 1 cm divides the room, with a lamp on one side. Elements end at the wall.
    let mut shapes: Vec<_> = walls(DVec3::new(4.0, 2.0, 2.0)).into_iter().map(|w| (w, 0.7, 0.0)).collect();
    let wall = |x: f64, turned: bool| {
        let (u, v) = (DVec3::Y * 2.0, DVec3::Z * 2.0);
        let corner = DVec3::X * x;
        if turned { parallelogram(corner, v, u) } else { parallelogram(corner, u, v) }
    };
    shapes.push((wall(2.0, true), 0.7, 0.0));
    shapes.push((wall(2.01, false), 0.7, 0.0));
    let lamp = parallelogram(DVec3::new(0.5, 0.5, 1.9), DVec3::Y, DVec3::X);
    shapes.push((lamp, 0.0, 1.0));
    let scene = scene(shapes);
    let elements = elements(&scene, 0.5);
    let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
    let solved =
        gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &CancelFlag::default())
            .unwrap();
    let (mut lit, mut dark) = (0, 0);
    for (element, &radiosity) in elements.list.iter().zip(&solved.radiosity) {
        let at = element.center;
        let inside = at.position + at.normal * 1e-3;
        let is_in = inside.min_element() > 0.0 && inside.y < 2.0 && inside.z < 2.0;
        if is_in && (inside.x > 2.01 && inside.x < 4.0) {
            assert_eq!(luminance(radiosity), 0.0, "{:?}", at.position);
            dark += 1;
        } else if is_in && inside.x < 2.0 {
            lit += usize::from(luminance(radiosity) > 0.0);
        }
    }
    assert!(lit > 50 && dark > 50, "{lit} {dark}");
}
