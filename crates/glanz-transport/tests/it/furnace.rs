//! Integrators against scenes with known answers. Errors are those that the films state themselves.
//!
//! One file in spite of its length: one contract for all integrators, a function per scene; a new integrator inherits them all.

use std::f64::consts::PI;

use crate::common::*;
use glanz_math::DVec3;
use glanz_sampling::SamplerKind;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_shading::model::{DielectricMaterial, Roughness, RoughnessScale};

/// Radiance in a closed room of albedo `rho` that shines with `e` everywhere, when light is scattered at most `depth` times:
/// e (1 + rho + ... + rho^depth).
fn room(e: f64, rho: f64, depth: u32) -> f64 {
    e * (1.0 - rho.powi(depth as i32 + 1)) / (1.0 - rho)
}

#[test]
fn closed_white_room_shines_with_emission_over_absorption() {
    let (e, rho) = ([0.5_f32, 1.0, 2.0], [0.75_f32, 0.5, 0.25]);
    let inside = looking(DVec3::new(0.3, -0.2, 0.4), DVec3::X, [6, 6], 1.2);
    let walls = MaterialKind::diffuse(rho);
    // Depth 80: what is cut off is below 0.75^81 = 1e-10.
    let expected = std::array::from_fn(|i| room(f64::from(e[i]), f64::from(rho[i]), 80));
    assert!((expected[0] - 2.0).abs() < 1e-9 && (expected[1] - 2.0).abs() < 1e-9);
    let round = inside.clone().shape(ShapeDescription::sphere(2.0).reversed().emitting(e), walls.clone());
    for run in Run::all_random(80, 256) {
        run.picture(&round).assert_average(expected, 0.01, &format!("sphere: {}", run.name()));
    }
    let mut square = inside;
    let (a, b, c) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    let o = DVec3::splat(-1.0);
    // Each face turned inwards.
    for (corner, s, t) in [(o, a, b), (o, b, c), (o, c, a), (o + c, b, a), (o + a, c, b), (o + b, a, c)] {
        square = square.shape(rectangle(corner, s, t).emitting(e), walls.clone());
    }
    for run in Run::all_random(80, 256) {
        run.picture(&square).assert_average(expected, 0.01, &format!("cube: {}", run.name()));
    }
}

#[test]
fn layered_and_transmitting_surfaces_without_absorption_are_unseen_in_a_closed_room() {
    // Radiance 2 everywhere: walls of albedo 1/2 that emit 1. A base of albedo 1 under its coat, a sheet that divides light evenly between its sides
    // and frosted glass, each without absorption, change nothing of it outside of glass.
    let (e, rho) = (1.0, 0.5_f32);
    let frosted = MaterialKind::Dielectric(DielectricMaterial {
        dispersion: None,
        eta: 1.5.into(),
        reflectance: 1.0.into(),
        transmittance: 1.0.into(),
        thin: false,
        roughness: Roughness::isotropic(0.4, RoughnessScale::Alpha),
        multiple_scattering: true,
    });
    let sheet = rectangle(DVec3::new(0.6, -0.4, -0.9), DVec3::Y * 0.8, DVec3::Z * 0.7);
    let scene = looking(DVec3::new(-1.2, 0.0, 0.0), DVec3::X, [8, 8], 1.2)
        .shape(ShapeDescription::sphere(2.0).reversed().emitting([e; 3]), diffuse(rho))
        .shape(
            ShapeDescription::sphere(0.4).translated([0.3, -0.7, 0.3]),
            MaterialKind::coated_diffuse(1.0, 1.5),
        )
        .shape(ShapeDescription::sphere(0.4).translated([0.3, 0.7, 0.3]), frosted)
        .shape(sheet, MaterialKind::diffuse_transmission(0.5, 0.5));
    for integrator in ["path", "light", "sppm", "guided"] {
        let run = Run::new(integrator, 100, 256);
        run.picture(&scene).assert_average([2.0; 3], 0.01, &run.name());
    }
}

#[test]
fn sheet_under_a_constant_sky_shows_what_it_reflects_and_what_it_transmits() {
    let scene = looking(DVec3::new(0.5, 0.3, -2.0), DVec3::ZERO, [4, 4], 0.2)
        .shape(ShapeDescription::disk(1.0), MaterialKind::diffuse_transmission(0.2, 0.5))
        .light(LightDescription::infinite([3.0; 3]));
    for run in Run::all_random(3, 256) {
        run.picture(&scene).assert_average([2.1; 3], 0.02, &run.name());
    }
    Run::new("whitted", 3, 4).picture(&scene).assert_exact(2.1, "whitted");
}

#[test]
fn depth_counts_scattering_events() {
    let scene = looking(DVec3::ZERO, DVec3::X, [4, 4], 1.0)
        .shape(ShapeDescription::sphere(2.0).reversed().emitting([1.0; 3]), diffuse(0.5));
    for depth in [0, 1, 2] {
        for run in Run::all_random(depth, 400) {
            let expected = room(1.0, 0.5, depth);
            run.picture(&scene).assert_average([expected; 3], 0.02, &run.name());
        }
    }
}

#[test]
fn camera_ray_divides_once_at_its_first_rough_surface() {
    // Every pixel sees the sphere, which is convex: each branch has one more ray, which escapes.
    let scene = looking(DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO, [6, 6], 0.5)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .light(LightDescription::infinite([3.0; 3]));
    for branching in [1, 3] {
        let run = Run { branching: Some(branching), light_sampling: false, ..Run::new("path", 5, 16) };
        let outcome = run.outcome(&scene);
        assert_eq!(outcome.counters.closest, 36 * 16 * (1 + u64::from(branching)));
    }
}

#[test]
fn convex_diffuse_sphere_reflects_its_share_of_a_constant_sky() {
    // Every pixel sees the sphere.
    let scene = looking(DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO, [6, 6], 0.5)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .light(LightDescription::infinite([3.0; 3]));
    // The first 64 samples of `guided` happen to be 3.06 standard errors off; 200 other seeds are right, see `guided.rs`.
    for run in Run::all_random(5, 256).into_iter().chain([Run::new("whitted", 5, 64)]) {
        // Cosine sampling is perfect here: rho L0 with every sample, but for the weights of two strategies in `path`.
        run.picture(&scene).assert_average([1.8; 3], 0.01, &run.name());
    }
    Run::new("whitted", 5, 4).picture(&scene).assert_exact(1.8, "whitted");
    let lone = Run { light_sampling: false, ..Run::new("path", 5, 4) };
    lone.picture(&scene).assert_exact(1.8, "path without light sampling");
}

#[test]
fn the_backdrop_is_seen_and_lights_nothing() {
    let backdrop =
        |scene: SceneBuilder| scene.edit(|description| description.backdrop = Some([7.0; 3].into()));
    let empty = looking(DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO, [3, 3], 0.5)
        .shape(ShapeDescription::sphere(1.0).translated([0.0, 9.0, 0.0]), diffuse(0.6))
        .light(LightDescription::infinite([3.0; 3]));
    let full = empty.clone().shape(ShapeDescription::sphere(1.0), diffuse(0.6));
    for run in Run::all_random(5, 256).into_iter().chain([Run::new("whitted", 5, 64)]) {
        run.picture(&backdrop(empty.clone())).assert_exact(7.0, &run.name());
        run.picture(&empty).assert_exact(3.0, &run.name());
        run.picture(&backdrop(full.clone())).assert_average([1.8; 3], 0.02, &run.name());
    }
}

#[test]
fn a_sun_above_the_horizon_lights_a_plane_by_the_cosine_of_its_middle() {
    let (rho, irradiance) = (0.7, 5.0);
    for (zenith, angular_radius) in [(0.0_f64, 0.5), (0.9, 0.3), (0.9, 0.004)] {
        let from = DVec3::new(zenith.sin(), 0.0, zenith.cos());
        let scene = one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::ZERO)
            .shape(ShapeDescription::plane(), diffuse(rho))
            // Paths from lights need a bounded scene.
            .shape(ShapeDescription::sphere(1.0).translated([0.0, 0.0, -1.5]), diffuse(rho))
            .light(LightDescription::new(
                LightKind::Sun { from, to: DVec3::ZERO, angular_radius },
                irradiance,
            ));
        // The integral of a constant radiance times cosine over a cone is pi sin^2 of its half angle times the cosine of its axis.
        let expected = f64::from(rho) / PI * f64::from(irradiance) * zenith.cos();
        for run in Run::all_random(2, 1024).into_iter().filter(|run| run.light_sampling) {
            run.picture(&scene).assert_average([expected; 3], 0.02, &run.name());
        }
    }
}

#[test]
fn point_light_over_a_plane_gives_the_third_power_of_the_cosine() {
    let (rho, intensity, h) = (0.7, 5.0, 1.5);
    for x in [0.0, 0.8, 3.0] {
        let scene = one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::new(x, 0.0, 0.0))
            .shape(ShapeDescription::plane(), diffuse(rho))
            .light(LightDescription::point(DVec3::new(0.0, 0.0, h), [intensity; 3]));
        // I cos / d^2 on the floor with d = h / cos. (The fourth power is for a lamp with Lambert's law itself.)
        let cos = h / (h * h + x * x).sqrt();
        let expected = f64::from(intensity) * cos.powi(3) / (h * h) * f64::from(rho) / PI;
        for run in Run::all_exact(4) {
            run.picture(&scene).assert_exact(expected, &run.name());
        }
    }
}

#[test]
fn light_behind_an_obstacle_or_below_the_floor_does_not_arrive() {
    let floor =
        one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::ZERO).shape(ShapeDescription::plane(), diffuse(0.7));
    let hidden = floor
        .clone()
        .shape(ShapeDescription::disk(0.1).translated([0.0, 0.0, 0.7]), diffuse(0.7))
        .light(LightDescription::point(DVec3::new(0.0, 0.0, 1.5), [5.0; 3]));
    let below = floor.light(LightDescription::point(DVec3::new(0.0, 0.0, -1.5), [5.0; 3]));
    for scene in [hidden, below] {
        for run in Run::all_exact(1) {
            run.picture(&scene).assert_exact(0.0, &run.name());
        }
    }
}

#[test]
fn distant_light_and_spot_follow_their_definitions() {
    let floor =
        one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::ZERO).shape(ShapeDescription::plane(), diffuse(0.5));
    let from = DVec3::new(0.0, 3.0, 4.0);
    let distant =
        floor.clone().light(LightDescription::new(LightKind::Distant { from, to: DVec3::ZERO }, [2.0; 3]));
    let spot = floor.light(LightDescription::new(
        LightKind::Spot {
            from,
            to: DVec3::ZERO,
            cone_angle: 0.4,
            inner_angle: 0.3,
            falloff: SpotFalloff::Smoothstep,
        },
        [2.0; 3],
    ));
    for run in Run::all_exact(3) {
        // cos theta = 4 / 5; the spot is 5 m away.
        run.picture(&distant).assert_exact(0.5 / PI * 2.0 * 0.8, &run.name());
        run.picture(&spot).assert_exact(0.5 / PI * 2.0 * 0.8 / 25.0, &run.name());
    }
}

#[test]
fn shining_disk_over_a_floor_gives_the_closed_form() {
    let (l, rho, h, r) = (4.0_f32, 0.5_f32, 1.0, 0.6);
    for a in [0.0, 0.7] {
        let scene = one_pixel(DVec3::new(-1.0, 1.5, 0.5), DVec3::new(a, 0.0, 0.0))
            .shape(ShapeDescription::disk(50.0), diffuse(rho))
            .shape(
                ShapeDescription::disk(r).rotated(DVec3::X, PI).translated([0.0, 0.0, h]).emitting([l; 3]),
                diffuse(0.0),
            );
        // Configuration factor of a parallel disk seen from a point beside its axis (@howell2011, element to parallel disk):
        // (1 - (h^2 + a^2 - r^2) / sqrt((h^2 + a^2 + r^2)^2 - 4 a^2 r^2)) / 2.
        let (h2, a2, r2) = (h * h, a * a, r * r);
        let root = ((h2 + a2 + r2) * (h2 + a2 + r2) - 4.0 * a2 * r2).sqrt();
        let factor = 0.5 * (1.0 - (h2 + a2 - r2) / root);
        let expected = f64::from(l) * f64::from(rho) * factor;
        let whitted = Run::new("whitted", 1, 20_000);
        for run in Run::all_random(1, 20_000).into_iter().chain([whitted]) {
            run.picture(&scene).assert_average([expected; 3], 0.02, &run.name());
        }
    }
}

#[test]
fn shining_sphere_over_a_floor_gives_the_closed_form() {
    let (l, rho, r) = (4.0_f32, 0.5_f32, 0.6);
    let center = DVec3::new(0.9, 0.0, 1.2);
    let scene = one_pixel(DVec3::new(-1.0, 1.5, 0.5), DVec3::ZERO)
        .shape(ShapeDescription::disk(50.0), diffuse(rho))
        .shape(ShapeDescription::sphere(r).translated(center).emitting([l; 3]), diffuse(0.0));
    // A sphere wholly above the horizon: factor (r / d)^2 cos theta (@howell2011).
    let d = center.length();
    let expected = f64::from(l) * f64::from(rho) * (r / d) * (r / d) * (center.z / d);
    for run in Run::all_random(1, 20_000) {
        run.picture(&scene).assert_average([expected; 3], 0.02, &run.name());
    }
}

/// The camera looks down on a mirror on the floor and sees the wall x = 2 in it.
fn mirror_scene(kind: MaterialKind) -> SceneBuilder {
    one_pixel(DVec3::new(-1.0, 0.0, 1.0), DVec3::ZERO)
        .shape(ShapeDescription::disk(0.2), kind)
        .shape(rectangle(DVec3::new(2.0, -9.0, -9.0), DVec3::Z * 18.0, DVec3::Y * 18.0), diffuse(0.5))
        .light(LightDescription::point(DVec3::new(0.5, 0.0, 2.0), [7.0; 3]))
}

#[test]
fn mirror_shows_what_is_there() {
    // The reflected ray meets the wall at (2, 0, 2), 1.5 m in front of the light and head on.
    let wall = 7.0 / (1.5 * 1.5) * 0.5 / PI;
    let mirror = mirror_scene(MaterialKind::mirror(0.8));
    for run in Run::all_exact(2) {
        run.picture(&mirror).assert_exact(0.8 * wall, &run.name());
    }
    for run in Run::all_exact(1) {
        // One event is the mirror's; the wall does not scatter any more.
        run.picture(&mirror).assert_exact(0.0, &run.name());
    }
    // Metal of eta = 0.2, k = 3.9 under 45 degrees: reflectance from the complex Fresnel equations. With
    // n = eta + i k, c' = sqrt(1 - (sin / n)^2): rs = (c - n c') / (c + n c'), rp = (n c - c') / (n c + c').
    let metal = mirror_scene(MaterialKind::conductor(0.2, 3.9));
    let reflectance = conductor_at_45_degrees(0.2_f32.into(), 3.9_f32.into());
    for run in Run::all_exact(2) {
        run.picture(&metal).assert_exact(reflectance * wall, &run.name());
    }
}

/// (|rs|^2 + |rp|^2) / 2 with complex numbers as pairs.
fn conductor_at_45_degrees(eta: f64, k: f64) -> f64 {
    type C = (f64, f64);
    let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let div = |a: C, b: C| {
        let n = b.0 * b.0 + b.1 * b.1;
        ((a.0 * b.0 + a.1 * b.1) / n, (a.1 * b.0 - a.0 * b.1) / n)
    };
    let root = |a: C| {
        let r = a.0.hypot(a.1);
        let re = (0.5 * (r + a.0)).sqrt();
        (re, a.1 / (2.0 * re))
    };
    let norm = |a: C| a.0 * a.0 + a.1 * a.1;
    let c = 0.5_f64.sqrt();
    let n = (eta, k);
    let s2 = div((0.5, 0.0), mul(n, n));
    let ct = root((1.0 - s2.0, -s2.1));
    let nct = mul(n, ct);
    let rs = div((c - nct.0, -nct.1), (c + nct.0, nct.1));
    let nc = (eta * c, k * c);
    let rp = div((nc.0 - ct.0, nc.1 - ct.1), (nc.0 + ct.0, nc.1 + ct.1));
    0.5 * (norm(rs) + norm(rp))
}

#[test]
fn glass_slab_transmits_as_fresnel_says() {
    // A shining disk behind a slab, seen head on: R = ((1.5 - 1) / (1.5 + 1))^2 = 0.04.
    let scene = one_pixel(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO).shape(cuboid(0.5), glass()).shape(
        ShapeDescription::disk(1.0).rotated(DVec3::X, PI).translated([0.0, 0.0, 2.0]).emitting([2.0; 3]),
        diffuse(0.0),
    );
    let r: f64 = 0.04;
    let whitted = |depth| Run { sampler: SamplerKind::Center, ..Run::new("whitted", depth, 1) };
    whitted(2).picture(&scene).assert_exact(2.0 * (1.0 - r) * (1.0 - r), "straight through");
    // One more pair of inner reflections adds the factor 1 + R^2.
    whitted(4).picture(&scene).assert_exact(2.0 * (1.0 - r) * (1.0 - r) * (1.0 + r * r), "one echo");
    for run in Run::all_random(20, 20_000) {
        // All interreflections: (1 - R)^2 / (1 - R^2).
        run.picture(&scene).assert_average([2.0 * (1.0 - r) / (1.0 + r); 3], 0.01, &run.name());
    }
}

#[test]
fn thin_pane_transmits_the_mean_of_both_polarisations() {
    // A shining disk behind a pane under 80 degrees, beside the mirrored ray: (1 - r) / (1 + r) with r of each polarisation, by Fresnel's
    // equations.
    let (n, angle) = (1.5_f64, f64::to_radians(80.0));
    let inner = (angle.sin() / n).asin();
    let through = |r: f64| (1.0 - r) / (1.0 + r);
    let perpendicular = through(((angle - inner).sin() / (angle + inner).sin()).powi(2));
    let parallel = through(((angle - inner).tan() / (angle + inner).tan()).powi(2));
    let expected = 2.0 * 0.5 * (perpendicular + parallel);
    let across = DVec3::new(0.0, angle.cos(), angle.sin());
    let scene = one_pixel(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO)
        .shape(
            rectangle(-DVec3::X - 0.8 * across, DVec3::X * 2.0, across * 2.0),
            MaterialKind::thin_dielectric(1.5, 1.0, 1.0),
        )
        .shape(
            ShapeDescription::disk(0.5).rotated(DVec3::X, PI).translated([0.0, 0.0, 2.0]).emitting([2.0; 3]),
            diffuse(0.0),
        );
    let whitted = Run { sampler: SamplerKind::Center, ..Run::new("whitted", 2, 1) };
    whitted.picture(&scene).assert_exact(expected, "whitted");
    for run in Run::all_random(3, 16_384) {
        run.picture(&scene).assert_average([expected; 3], 0.02, &run.name());
    }
    let spectral = Run { spectral: true, ..Run::new("path", 3, 16_384) };
    spectral.picture(&scene).assert_average([expected; 3], 0.02, "spectral");
}

#[test]
fn glass_cannot_be_seen_in_a_constant_sky() {
    let scene = looking(DVec3::new(0.0, 0.0, -3.0), DVec3::ZERO, [8, 8], 0.9)
        .shape(ShapeDescription::sphere(1.0), glass())
        .light(LightDescription::infinite([1.0; 3]));
    for run in Run::all_random(60, 64) {
        run.picture(&scene).assert_average([1.0; 3], 0.01, &run.name());
    }
    // Rays below 1/4096 are left out.
    for &value in &Run::new("whitted", 60, 4).picture(&scene).mean[0] {
        assert!(value <= 1.0 + 1e-5 && value > 1.0 - 8.0 / 4096.0, "{value}");
    }
}

#[test]
fn radiance_inside_glass_grows_by_the_squared_index() {
    let scene = one_pixel(DVec3::ZERO, DVec3::new(0.3, 0.2, 1.0))
        .shape(ShapeDescription::sphere(1.0), glass())
        .light(LightDescription::infinite([1.0; 3]));
    for run in Run::all_random(60, 4000) {
        run.picture(&scene).assert_average([2.25; 3], 0.01, &run.name());
    }
}

#[test]
fn light_beyond_the_critical_angle_stays_inside() {
    // Along the diagonal of a cube each wall is met under 54.7 degrees; the critical angle is 41.8.
    let scene = one_pixel(DVec3::new(0.1, 0.0, -0.05), DVec3::new(1.1, 1.0, 0.95))
        .shape(cuboid(1.0), glass())
        .light(LightDescription::infinite([1.0; 3]));
    for run in Run::all_exact(50) {
        run.picture(&scene).assert_exact(0.0, &run.name());
    }
}

#[test]
fn phong_in_whitted_is_that_of_document_001() {
    let phong = MaterialKind::phong(0.1, 0.5, 0.4, 5.0);
    // The light is 5 m away under cos = 0.8, the viewer straight above: r.v = 0.8.
    let scene = one_pixel(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO)
        .shape(ShapeDescription::plane(), phong)
        .light(LightDescription::point(DVec3::new(3.0, 0.0, 4.0), [50.0; 3]));
    // L = 50 / 25 / pi.
    let l = 2.0 / PI;
    let lit = l * (0.5 * 0.8 + 0.4 * 0.8_f64.powi(5));
    let whitted = Run { sampler: SamplerKind::Center, ..Run::new("whitted", 3, 1) };
    whitted.picture(&scene).assert_exact(lit, "lit");
    let ambient = scene.clone().light(LightDescription::infinite([2.0; 3]));
    whitted.picture(&ambient).assert_exact(lit + 0.1 * 2.0, "with ambient light");
    let shadowed = scene
        .shape(ShapeDescription::sphere(0.2).translated([1.5, 0.0, 2.0]), diffuse(0.5))
        .light(LightDescription::infinite([2.0; 3]));
    whitted.picture(&shadowed).assert_exact(0.2, "in shadow");
}

#[test]
fn interfaces_are_not_there() {
    let bare = one_pixel(DVec3::new(-1.0, 0.5, 2.0), DVec3::new(0.8, 0.0, 0.0))
        .shape(ShapeDescription::plane(), diffuse(0.7))
        .light(LightDescription::point(DVec3::new(0.0, 0.0, 1.5), [5.0; 3]));
    let wrapped = bare
        .clone()
        .shape(ShapeDescription::sphere(0.5).translated([0.0, 0.0, 1.5]), MaterialKind::Interface)
        .shape(ShapeDescription::sphere(1.0).translated([-1.0, 0.5, 2.0]), MaterialKind::Interface);
    for run in Run::all_exact(1) {
        let expected = run.picture(&bare).mean[0][0];
        assert!(expected > 0.0);
        run.picture(&wrapped).assert_exact(expected, &run.name());
    }
}

#[test]
fn smooth_shading_normals_let_no_light_through() {
    // An octahedron with the normals of a sphere, closed, in a bright sky; the camera is inside.
    let positions = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut indices = Vec::new();
    for x in [0, 1] {
        for y in [2, 3] {
            for z in [4, 5] {
                indices.push(if (x + y + z) % 2 == 0 { [x, y, z] } else { [y, x, z] });
            }
        }
    }
    let octahedron =
        GeometryDescription::Triangles { normals: Some(positions.clone()), positions, indices, uvs: None };
    let scene = looking(DVec3::new(0.1, 0.2, 0.0), DVec3::new(1.0, 0.9, 0.8), [8, 8], 2.0)
        .shape(octahedron, diffuse(0.9))
        .light(LightDescription::infinite([1.0; 3]));
    for run in Run::all_random(8, 64).into_iter().chain([Run::new("whitted", 8, 64)]) {
        run.picture(&scene).assert_exact(0.0, &run.name());
    }
}

#[test]
fn surface_seen_from_behind_its_shading_normal_reflects_a_constant_sky() {
    // The viewer is 10 degrees above the triangle, whose shading normal leans away by 70 degrees.
    let at = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let positions = vec![DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::Y];
    let normals = Some(vec![at(70.0); 3]);
    let triangle = GeometryDescription::Triangles { positions, indices: vec![[0, 1, 2]], normals, uvs: None };
    let scene = one_pixel(2.0 * at(-80.0), DVec3::ZERO)
        .shape(triangle, diffuse(0.6))
        .light(LightDescription::infinite([3.0; 3]));
    for run in Run::all_random(2, 1024) {
        run.picture(&scene).assert_average([1.8; 3], 0.02, &run.name());
    }
    Run::new("whitted", 2, 4).picture(&scene).assert_exact(1.8, "whitted");
}

/// A room with a lamp under the ceiling, a glass sphere and a glossy one.
fn cornell_box(resolution: [u32; 2]) -> SceneBuilder {
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    let o = DVec3::splat(-1.0);
    let wall = |c: [f32; 3]| MaterialKind::diffuse(c);
    let white = [0.73; 3];
    let glossy = MaterialKind::phong(0.0, 0.3, 0.6, 30.0);
    looking(DVec3::new(-3.4, 0.0, 0.0), DVec3::ZERO, resolution, 0.7)
        .shape(rectangle(o, x, y), wall(white))
        .shape(rectangle(o + z, y, x), wall(white))
        .shape(rectangle(o + x, z, y), wall(white))
        .shape(rectangle(o, z, x), wall([0.65, 0.05, 0.05]))
        .shape(rectangle(o + y, x, z), wall([0.12, 0.45, 0.15]))
        .shape(ShapeDescription::sphere(0.35).translated([0.3, -0.45, -0.65]), glass())
        .shape(ShapeDescription::sphere(0.35).translated([0.5, 0.45, -0.65]), glossy)
        .shape(
            ShapeDescription::disk(0.3)
                .rotated(DVec3::X, PI)
                .translated([0.0, 0.0, 0.98])
                .emitting([12.0, 11.0, 9.0]),
            diffuse(0.0),
        )
}

#[test]
fn ways_of_sampling_agree_in_a_room() {
    let scene = cornell_box([12, 12]);
    let mut runs = Run::all_random(6, 1000);
    let reference = runs[0].picture(&scene);
    for integrator in ["path", "distributed"] {
        for sampler in [SamplerKind::Sobol, SamplerKind::Stratified] {
            // Stated errors are those of independent samples, more than enough here.
            runs.push(Run { sampler, ..Run::new(integrator, 6, 1000) });
        }
    }
    for run in &runs[1..] {
        let picture = Run { seed: 3, ..run.clone() }.picture(&scene);
        for band in 0..3 {
            let ((a, sa), (b, sb)) = (reference.average(band), picture.average(band));
            let error = sa.hypot(sb);
            assert!(error < 0.03 * a, "{}: standard error {error} of {a}", run.name());
            let name = format!("{} {}", run.name(), run.sampler.name());
            assert!((a - b).abs() < 3.0 * error, "{name}: {b} +- {sb}, not {a} +- {sa}");
        }
    }
}

#[test]
fn well_spread_samples_have_less_noise() {
    // Direct light of a disk, 64 samples a pixel: Sobol points leave less than half the error of independent ones.
    let scene = looking(DVec3::new(-1.0, 1.5, 0.5), DVec3::ZERO, [12, 12], 0.2)
        .shape(ShapeDescription::disk(50.0), diffuse(0.5))
        .shape(
            ShapeDescription::disk(0.6).rotated(DVec3::X, PI).translated([0.0, 0.0, 1.0]).emitting([4.0; 3]),
            diffuse(0.0),
        );
    let sobol = |samples| Run { sampler: SamplerKind::Sobol, ..Run::new("path", 1, samples) };
    let reference = sobol(8192).picture(&scene);
    let error = |run: Run| {
        let picture = run.picture(&scene);
        let squares = picture.mean[0].iter().zip(&reference.mean[0]).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f64>().sqrt()
    };
    let (spread, independent) = (error(sobol(64)), error(Run::new("path", 1, 64)));
    println!("error of Sobol points {spread}, of independent ones {independent}");
    assert!(spread < 0.5 * independent, "{spread}, {independent}");
}
