//! Particles from lights compared with closed forms, and their balance.

use crate::common::*;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec3;
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::Scene;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{Counters, ParticleFate, ParticlePath, ParticleTracer};

fn watts(spectrum: Spectrum) -> f64 {
    f64::from(spectrum.luminance(&Wavelengths::default()))
}

fn sampler(index: u32) -> PixelSampler {
    PixelSampler::new(SamplerKind::Sobol, 1, 5, [0, 0], index)
}

/// Sums over particles, W of luminance.
#[derive(Default)]
struct Books {
    emitted: f64,
    arrived: f64,
    absorbed: f64,
    escaped: f64,
    given_up: f64,
    particles: f64,
}

impl Books {
    fn of(scene: &Scene, particles: u32, max_events: u32) -> Self {
        let mut books = Self { particles: f64::from(particles), ..Self::default() };
        let (mut tracer, mut counters) = (ParticleTracer::new(scene, max_events), Counters::default());
        tracer.trace(sampler(0), particles, &mut counters, |_, arrival| {
            books.arrived += watts(arrival.arrived);
            books.absorbed += watts(arrival.arrived) - watts(arrival.left);
        });
        for path in tracer.paths().flatten() {
            books.emitted += watts(path.emitted);
            books.absorbed += watts(path.faded);
            match path.end {
                ParticleFate::Absorbed => {}
                ParticleFate::Escaped { power, .. } => books.escaped += watts(power),
                ParticleFate::GivenUp(power) => books.given_up += watts(power),
            }
        }
        books
    }

    fn assert_balance(&self) {
        let ends = self.absorbed + self.escaped + self.given_up;
        assert!((ends / self.emitted - 1.0).abs() < 1e-6, "{} of {}", ends, self.emitted);
    }
}

#[test]
fn integrating_sphere_is_lit_by_power_over_absorption() {
    // Every bounce brings the share rho again: arrived = P (1 + rho + rho^2 + ...) = P / (1 - rho), P = 4 pi I.
    for rho in [0.3_f32, 0.9, 0.98] {
        let scene = SceneBuilder::new()
            .shape(ShapeDescription::sphere(2.0), diffuse(rho))
            .light(LightDescription::point(DVec3::new(0.7, 0.2, -0.3), [1.0; 3]));
        let books = Books::of(&resolved(&scene), 4096, 10_000);
        books.assert_balance();
        let power = 4.0 * std::f64::consts::PI;
        assert!((books.emitted / books.particles / power - 1.0).abs() < 1e-6);
        let ratio = books.arrived / books.emitted * f64::from(1.0 - rho);
        // Roulette begins at a tenth: the number of bounces after that is geometric, its deviation about its mean, of
        // at most a tenth of what arrives. 4096 particles: 0.1 / 64.
        assert!((ratio - 1.0).abs() < 4.0 * 0.1 / 64.0, "{rho}: {ratio}");
        assert_eq!(books.escaped, 0.0);
    }
}

/// A room without walls: glass and a highlight under a lamp.
fn room() -> SceneBuilder {
    let phong = MaterialKind::phong(0.0, [0.5, 0.2, 0.1], 0.3, 20.0);
    looking(DVec3::ZERO, DVec3::X, [1, 1], 1.0)
        .shape(ShapeDescription::sphere(0.5).translated([0.5, 0.0, -0.4]), glass())
        .shape(ShapeDescription::sphere(0.4).translated([-0.6, 0.0, -0.4]), phong)
        .shape(
            ShapeDescription::disk(0.3).translated([0.0, 0.0, 0.9]).reversed().emitting([3.0, 2.0, 1.0]),
            diffuse(0.5),
        )
}

#[test]
fn particles_do_not_depend_on_those_traced_with_them() {
    let scene = resolved(&room().shape(cuboid(1.0), diffuse(0.7)));
    let trace = |first: u32, count: u32| {
        let (mut arrivals, mut counters) = (vec![Vec::new(); count as usize], Counters::default());
        let mut tracer = ParticleTracer::new(&scene, 12);
        tracer.trace(sampler(first), count, &mut counters, |particle, arrival| {
            arrivals[particle].push((arrival.at, arrival.arrived, arrival.left));
        });
        let paths: Vec<Option<ParticlePath>> = tracer.paths().collect();
        (paths, arrivals, counters.closest)
    };
    let (paths, arrivals, rays) = trace(0, 600);
    let alone: Vec<_> = (0..600).map(|particle| trace(particle, 1)).collect();
    assert_eq!(rays, alone.iter().map(|(_, _, rays)| rays).sum::<u64>());
    for (number, (path, arrivals_alone, _)) in alone.iter().enumerate() {
        assert_eq!((paths[number], &arrivals[number]), (path[0], &arrivals_alone[0]), "{number}");
    }
}

#[test]
fn particles_end_alike_on_black_surfaces_of_any_material() {
    // Black constants of diffuse surfaces have a way of their own, black mirrors have not.
    let trace = |black: MaterialKind, max_events| {
        let fading = LightKind::Point { from: DVec3::new(0.1, 0.2, 0.3), range: Some(1.2) };
        let scene = SceneBuilder::new()
            .shape(cuboid(1.0), black)
            .shape(ShapeDescription::sphere(0.2).translated([0.5, 0.0, 0.0]), diffuse(0.6))
            .shape(ShapeDescription::sphere(0.3).translated([-0.4, 0.0, 0.0]), MaterialKind::Interface)
            .light(LightDescription::new(fading, 3.0));
        let scene = resolved(&scene);
        let (mut arrivals, mut counters) = (Vec::new(), Counters::default());
        let mut tracer = ParticleTracer::new(&scene, max_events);
        tracer.trace(sampler(0), 2000, &mut counters, |particle, arrival| {
            arrivals.push((particle, arrival.at, arrival.arrived, arrival.left));
        });
        (tracer.paths().collect::<Vec<_>>(), arrivals, counters.closest)
    };
    for max_events in [0, 1, 12] {
        let (diffuse, mirror) =
            (trace(diffuse(0.0), max_events), trace(MaterialKind::mirror(0.0), max_events));
        assert_eq!(diffuse, mirror, "{max_events} events");
        assert!(max_events == 0 || diffuse.1.len() >= 2000);
    }
}

#[test]
fn books_balance_whatever_stands_in_the_room() {
    let room = room();
    let open = Books::of(&resolved(&room), 4096, 100);
    open.assert_balance();
    assert!(open.escaped > 0.1 * open.emitted);
    let closed = Books::of(&resolved(&room.shape(cuboid(1.0), diffuse(0.9))), 4096, 6);
    closed.assert_balance();
    assert!(closed.escaped == 0.0 && closed.given_up > 0.1 * closed.emitted);
}
