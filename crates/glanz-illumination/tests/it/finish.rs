//! Light of mirrors with a surface finish.

use crate::combined::calculated;
use crate::common::*;
use glanz_illumination::GridResolution::Cells;
use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{DMat4, DVec3};
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};
use glanz_shading::model::{FinishModel, MirrorMaterial, SurfaceFinish};
use glanz_transport::{Counters, ParticleFate, ParticleTracer};

fn finished(model: FinishModel) -> MaterialKind {
    let finish = SurfaceFinish::try_new(model).unwrap();
    MaterialKind::Mirror(MirrorMaterial { reflectance: 0.8.into(), finish: Some(finish) })
}

/// A beam of half an arc second from 1 m above the mirror z = 0, straight down.
fn beam(model: FinishModel) -> Scene {
    let light = LightDescription::spot(DVec3::Z, DVec3::NEG_Z, [2.4e-6; 2], CANDELA);
    resolved(SceneBuilder::new().light(light).shape(rectangle(1.0, 1.0), finished(model)))
}

/// Light reflected by the mirror of [`beam`]: over the light of the beam, all of it and that of more than 1e-4 from the normal, with the mean of
/// the squared direction cosine along x of the latter.
fn reflected(scene: &Scene) -> [f64; 3] {
    let count = 1 << 16;
    let mut tracer = ParticleTracer::new(scene, 10);
    let sampler = PixelSampler::new(SamplerKind::Sobol, 1, 1, [0, 0], 0);
    tracer.trace(sampler, count, &mut Counters::default(), |_, _| {});
    let (mut emitted, mut all, mut scattered, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for path in tracer.paths().flatten() {
        emitted += photometric(path.emitted, &Wavelengths::default());
        let ParticleFate::Escaped { ray, power } = path.end else { continue };
        let lumens = photometric(power, &Wavelengths::default());
        all += lumens;
        let cosines = ray.direction.truncate();
        if cosines.length() > 1e-4 {
            scattered += lumens;
            squares += lumens * cosines.x.powi(2);
        }
    }
    [all / emitted, scattered / emitted, squares / scattered]
}

#[test]
fn gaussian_finish_widens_a_collimated_beam_by_its_sigma() {
    for sigma in [0.01, 0.05] {
        let [all, scattered, variance] = reflected(&beam(FinishModel::Gaussian { sigma, fraction: 1.0 }));
        assert!((all / 0.8 - 1.0).abs() < 1e-3 && (scattered / 0.8 - 1.0).abs() < 2e-3, "{all} {scattered}");
        assert!((variance.sqrt() / sigma - 1.0).abs() < 0.01, "{} of {sigma}", variance.sqrt());
    }
}

#[test]
fn abg_finish_takes_its_total_scatter_from_the_beam() {
    let (a, b) = (0.01_f64, 1e-4_f64);
    // The integrals of 2 pi r A / (B + r^2), and of half of r^2 times that, over the unit disk.
    let total = std::f64::consts::PI * a * (1.0 / b).ln_1p();
    let second = 0.5 * std::f64::consts::PI * a * (1.0 - b * (1.0 / b).ln_1p());
    let [all, scattered, variance] = reflected(&beam(FinishModel::Abg { a, b, g: 2.0 }));
    assert!((all / 0.8 - 1.0).abs() < 1e-3, "{all}");
    assert!((scattered / 0.8 / total - 1.0).abs() < 0.01, "{scattered} {total}");
    assert!((variance / (second / total) - 1.0).abs() < 0.03, "{variance}");
}

#[test]
fn light_of_finished_mirrors_is_the_same_by_all_methods() {
    // A lamp beside a mirror that is bent towards a floor, lit by scattered and by mirrored light.
    let lamp = ShapeDescription::sphere(0.05).translated([0.0, 0.0, 0.8]).emitting(candela_per_area(1e5));
    let tilted = DMat4::from_translation(DVec3::new(-0.5, 0.0, 0.8)) * DMat4::from_rotation_y(1.2);
    for model in
        [FinishModel::Abg { a: 0.02, b: 1e-3, g: 2.0 }, FinishModel::Gaussian { sigma: 0.05, fraction: 0.7 }]
    {
        let scene = resolved(
            SceneBuilder::new()
                .shape(rectangle(2.0, 2.0), diffuse(0.3))
                .shape(rectangle(0.6, 0.6).transformed(tilted), finished(model))
                .shape(lamp.clone(), diffuse(0.0)),
        );
        let asked = [request("floor", 0, Cells([4, 4]))];
        let (combined, _) = calculated(&scene, &asked, 0.01);
        let (traced, _) = maps(&scene, &asked, 1 << 19);
        for cell in 0..16 {
            let (a, b) = (&combined[0], &traced[0]);
            let apart = (a.lux[cell] - b.lux[cell]).abs();
            let error = a.errors[cell].hypot(b.errors[cell]);
            assert!(apart <= ERRORS * error, "{model:?} {cell}: {} and {}", a.lux[cell], b.lux[cell]);
            assert!(error < 0.05 * b.lux[cell], "{cell}: {error}");
        }
    }
}

#[test]
fn narrow_scatter_of_the_light_of_a_point_is_not_left_to_chance() {
    // Paths from the floor would meet the lobe of a milliradian once in millions.
    let tilted = DMat4::from_translation(DVec3::new(-0.5, 0.0, 0.8)) * DMat4::from_rotation_y(1.2);
    let finish = FinishModel::Gaussian { sigma: 1e-3, fraction: 1.0 };
    let scene = resolved(
        SceneBuilder::new()
            .shape(rectangle(2.0, 2.0), diffuse(0.3))
            .shape(rectangle(0.6, 0.6).transformed(tilted), finished(finish))
            .light(point_light(DVec3::new(0.0, 0.0, 0.8), 100.0)),
    );
    let asked = [request("floor", 0, Cells([4, 4]))];
    let (combined, _) = calculated(&scene, &asked, 0.02);
    let (traced, _) = maps(&scene, &asked, 1 << 19);
    for cell in 0..16 {
        let (a, b) = (&combined[0], &traced[0]);
        let error = a.errors[cell].hypot(b.errors[cell]);
        assert!(
            (a.lux[cell] - b.lux[cell]).abs() <= ERRORS * error,
            "{cell}: {} and {}",
            a.lux[cell],
            b.lux[cell]
        );
        assert!(error < 0.1 * b.lux[cell], "{cell}: {error}");
    }
}
