use glanz_light::Wavelengths;
use glanz_math::DVec3;
use glanz_scene::Scene;

use super::*;
use crate::elements::ElementSettings;
use crate::scenes::{scene, walls};

fn start(scene: &Scene, side: f64) -> Elements<'_> {
    Elements::new(scene, &ElementSettings { side }).unwrap()
}

fn luminance(light: Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}

#[test]
fn furnace_is_as_bright_as_it_is() {
    for reflectance in [0.3_f32, 0.8] {
        let shapes = walls(DVec3::new(3.0, 2.0, 2.5)).into_iter().map(|wall| (wall, reflectance, 1.0));
        let scene = scene(shapes.collect());
        let settings = Hierarchical { bound: 1e-4, side: 0.05, ..Hierarchical::default() };
        let solved = hierarchical(start(&scene, 10.0), &settings, |_| true).unwrap();
        let expected = std::f64::consts::PI / (1.0 - f64::from(reflectance));
        println!("{:?} {:?} {}", solved.errors, solved.effort, solved.elements.list.len());
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for (element, &radiosity) in solved.elements.list.iter().zip(&solved.radiosity) {
            if !element.patch.back {
                let found = luminance(radiosity) / expected;
                (low, high) = (low.min(found), high.max(found));
            }
        }
        println!("{low} {high}");
    }
}
