//! Participating media against closed forms and quadrature.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use glanz_math::{DMat4, DVec3};
use glanz_sampling::SamplerKind;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{Aov, AovSet};

fn with_medium(scene: SceneBuilder, medium: MediumDescription) -> SceneBuilder {
    scene.edit(|description| description.media.push(medium))
}

/// A box of medium 0 that light enters unhindered.
fn fog_box(scene: SceneBuilder, min: impl Into<DVec3>, max: impl Into<DVec3>) -> SceneBuilder {
    scene.shape(ShapeDescription::cuboid(min, max).enclosing(0, None), MaterialKind::Interface)
}

/// The scene in medium 0, which has no end.
fn in_fog(scene: SceneBuilder) -> SceneBuilder {
    scene.edit(|description| description.camera_medium = Some(0))
}

/// The medium with densities by a function of the place in [0, 1]^3 of a box between two corners.
fn gridded(
    medium: MediumDescription,
    resolution: [u32; 3],
    corners: [DVec3; 2],
    density: impl Fn(DVec3) -> f64,
) -> MediumDescription {
    let [nx, ny, nz] = resolution;
    let at = |i: u32| {
        let cell = DVec3::new(f64::from(i % nx), f64::from(i / nx % ny), f64::from(i / (nx * ny)));
        density((cell + 0.5) / DVec3::new(f64::from(nx), f64::from(ny), f64::from(nz))) as f32
    };
    let values: Arc<[f32]> = (0..nx * ny * nz).map(at).collect();
    let density = DensityDescription { resolution, values, corners, to_world: DMat4::IDENTITY };
    MediumDescription { density: Some(density), ..medium }
}

/// The camera at the origin, which sees along x.
fn along_x() -> SceneBuilder {
    one_pixel(DVec3::ZERO, DVec3::X)
}

/// A wall across the x axis, wherever it shines.
fn wall(x: f64, radiance: impl Into<EmissionDescription>) -> ShapeDescription {
    rectangle(DVec3::new(x, -9.0, -9.0), DVec3::Z * 18.0, DVec3::Y * 18.0).emitting(radiance)
}

/// `path` and `guided`, each with and without light sampling.
fn runs(depth: u32, samples: u32) -> Vec<Run> {
    let run =
        |name| [true, false].map(|light_sampling| Run { light_sampling, ..Run::new(name, depth, samples) });
    ["path", "guided"].into_iter().flat_map(run).collect()
}

/// Radiance that is left of (4, 2, 1) after `extinction` 1/m over `distance` m.
fn attenuated(extinction: [f32; 3], distance: f64) -> [f64; 3] {
    let left = |i: usize| [4.0, 2.0, 1.0][i] * (-f64::from(extinction[i]) * distance).exp();
    std::array::from_fn(left)
}

const LIGHT: [f32; 3] = [4.0, 2.0, 1.0];
const EXTINCTION: [f32; 3] = [0.2, 0.9, 2.5];

fn assert_exact(picture: &Picture, expected: [f64; 3], name: &str) {
    for (band, expected) in picture.mean.iter().zip(expected) {
        assert!((band[0] - expected).abs() < 2e-6 * expected, "{name}: {}, not {expected}", band[0]);
    }
}

#[test]
fn light_behind_what_absorbs_is_left_by_beers_law_in_each_band() {
    let absorbing =
        MediumDescription { scale: 0.5, ..MediumDescription::new(EXTINCTION.map(|x| 2.0 * x), 0.0) };
    let scene = with_medium(along_x().shape(wall(4.0, LIGHT), diffuse(0.0)), absorbing);
    let slab = fog_box(scene.clone(), [1.0, -2.0, -2.0], [2.5, 2.0, 2.0]);
    // The same in a hollow of 1.5 m, whichever way its surface is turned.
    let hollow = |shape: ShapeDescription, media| {
        in_fog(scene.clone()).shape(ShapeDescription { media, ..shape }, MaterialKind::Interface)
    };
    let ball = ShapeDescription::sphere(0.75).translated([2.0, 0.0, 0.0]);
    let inside_empty = SurfaceMedia { inside: None, outside: Some(0) };
    let outside_empty = SurfaceMedia { inside: Some(0), outside: None };
    for run in Run::all_exact(3).into_iter().filter(|run| ["path", "guided"].contains(&run.integrator)) {
        assert_exact(&run.picture(&slab), attenuated(EXTINCTION, 1.5), "slab");
        let everywhere = run.picture(&in_fog(scene.clone()));
        assert_exact(&everywhere, attenuated(EXTINCTION, 4.0), "everywhere");
        let outwards = hollow(ball.clone(), inside_empty);
        assert_exact(&run.picture(&outwards), attenuated(EXTINCTION, 2.5), "hollow");
        let inwards = hollow(ball.clone().reversed(), outside_empty);
        assert_exact(&run.picture(&inwards), attenuated(EXTINCTION, 2.5), "hollow, turned");
        // A surface with the same on both sides is no boundary, whatever is around it.
        let none = hollow(ball.clone(), SurfaceMedia { inside: None, outside: None });
        assert_exact(&run.picture(&none), attenuated(EXTINCTION, 4.0), "no hollow");
    }
}

#[test]
fn grey_media_leave_the_same_light_at_sampled_wavelengths() {
    let scene =
        with_medium(along_x().shape(wall(4.0, LIGHT), diffuse(0.0)), MediumDescription::new(0.9, 0.0));
    let slab = fog_box(scene, [1.0, -2.0, -2.0], [2.5, 2.0, 2.0]);
    let run = Run { spectral: true, ..Run::new("path", 3, 8192) };
    run.picture(&slab).assert_average(attenuated([0.9; 3], 1.5), 0.05, &run.name());
}

#[test]
fn light_that_is_not_scattered_is_left_by_beers_law_in_each_band() {
    let scattering = MediumDescription::new([0.1, 0.0, 1.5], [0.1, 0.9, 1.0]);
    let scene = with_medium(along_x().shape(wall(4.0, LIGHT), diffuse(0.0)), scattering);
    let slab = fog_box(scene, [1.0, -2.0, -2.0], [2.5, 2.0, 2.0]);
    for run in runs(0, 20_000) {
        run.picture(&slab).assert_average(attenuated(EXTINCTION, 1.5), 0.05, &run.name());
    }
}

#[test]
fn a_medium_shines_with_what_it_absorbs() {
    let shining = |absorption: [f32; 3], scattering: [f32; 3]| MediumDescription {
        emission: LIGHT.into(),
        emission_scale: 3.0,
        ..MediumDescription::new(absorption, scattering)
    };
    let half = EXTINCTION.map(|x| 0.5 * x);
    // Without scattered light emission is exact also in what scatters, and as large a part of it as absorption of extinction.
    for (medium, depth, share) in [(shining(EXTINCTION, [0.0; 3]), 3, 1.0), (shining(half, half), 0, 0.5)] {
        let slab = fog_box(with_medium(along_x(), medium), [1.0, -2.0, -2.0], [2.5, 2.0, 2.0]);
        let left = attenuated(EXTINCTION, 1.5);
        let expected = std::array::from_fn(|i| 3.0 * share * (f64::from(LIGHT[i]) - left[i]));
        let run = Run { sampler: SamplerKind::Center, ..Run::new("path", depth, 2) };
        assert_exact(&run.picture(&slab), expected, "slab");
    }
}

#[test]
fn a_medium_that_also_scatters_shines_with_the_part_that_it_absorbs() {
    let scattering = [0.3, 0.1, 1.5_f32];
    let medium =
        MediumDescription { emission: LIGHT.into(), ..MediumDescription::new(EXTINCTION, scattering) };
    let slab = fog_box(with_medium(along_x(), medium), [1.0, -2.0, -2.0], [2.5, 2.0, 2.0]);
    // Absorption times emission times the integral of the transmittance; without scattering events nothing else is seen.
    let expected = std::array::from_fn(|i| {
        let (absorbed, lost) = (f64::from(EXTINCTION[i]), f64::from(EXTINCTION[i] + scattering[i]));
        f64::from(LIGHT[i]) * absorbed / lost * (1.0 - (-lost * 1.5).exp())
    });
    let run = Run { sampler: SamplerKind::Center, ..Run::new("path", 0, 2) };
    assert_exact(&run.picture(&slab), expected, "slab");
}

#[test]
fn what_fog_sends_elsewhere_is_not_what_the_camera_sees() {
    // A wall 1 m in front of the camera; all others of the room are at other distances.
    let room = ShapeDescription::cuboid([-3.0, -2.0, -2.5], [1.0, 2.2, 1.7]).reversed();
    let fog = MediumDescription::new(0.0, 1.0);
    let scene = in_fog(with_medium(along_x().shape(room, diffuse(0.5)), fog));
    for name in ["path", "guided"] {
        let run =
            Run { aovs: AovSet::NONE.with(Aov::Variance).with(Aov::Distance), ..Run::new(name, 50, 256) };
        let picture = run.outcome(&scene).film.to_pixels().unwrap();
        let distance = picture.channel("Z").unwrap()[0];
        assert!((distance - 1.0).abs() < 1e-4, "{name}: {distance}");
    }
}

/// The density of Henyey and Greenstein per solid angle for the cosine of the angle by which light is turned.
fn phase(g: f64, cos: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
}

/// Light of a point at `light` of intensity (4, 2, 1) that is scattered once on the x axis between `from` and `to`, by the midpoint rule.
/// `way`: the distance in the medium from a point of the axis to the light.
fn scattered_once(
    [absorption, scattering]: [[f32; 3]; 2],
    g: f64,
    [from, to]: [f64; 2],
    light: DVec3,
    way: impl Fn(f64, f64) -> f64,
) -> [f64; 3] {
    let steps = 20_000;
    std::array::from_fn(|band| {
        let extinction = f64::from(absorption[band] + scattering[band]);
        let at = |i: u32| {
            let x = from + (f64::from(i) + 0.5) / f64::from(steps) * (to - from);
            let offset = light - DVec3::new(x, 0.0, 0.0);
            let distance = offset.length();
            // Light goes along -offset, and on along -x to the camera.
            let value = phase(g, offset.x / distance) * f64::from(LIGHT[band]) / distance.powi(2);
            value * (-extinction * (x - from + way(x, distance))).exp()
        };
        (0..steps).map(at).sum::<f64>() * (to - from) / f64::from(steps) * f64::from(scattering[band])
    })
}

#[test]
fn light_of_a_point_that_is_scattered_once_is_its_integral_along_the_ray() {
    let coefficients @ [absorption, scattering] = [[0.1, 0.0, 0.4], [0.1, 0.5, 0.3]];
    for g in [0.0, 0.6, -0.4] {
        let fog = MediumDescription { g, ..MediumDescription::new(absorption, scattering) };
        let light = DVec3::new(2.0, 1.5, 0.0);
        let lit =
            along_x().light(LightDescription::point(light, LIGHT)).shape(wall(4.0, [0.0; 3]), diffuse(0.0));
        let everywhere = in_fog(with_medium(lit.clone(), fog.clone()));
        let expected = scattered_once(coefficients, g, [0.0, 4.0], light, |_, distance| distance);
        let (min, max) = (DVec3::new(1.0, -0.5, -0.5), DVec3::new(3.0, 0.5, 0.5));
        // The light is three times as high as the box: a third of the way is in it.
        let in_box = scattered_once(coefficients, g, [1.0, 3.0], light, |_, distance| distance / 3.0);
        let even =
            gridded(fog.clone(), [5, 4, 3], [DVec3::new(0.0, -1.0, -1.0), DVec3::new(5.0, 2.0, 1.0)], |_| {
                1.0
            });
        let boxes = [fog, even].map(|medium| fog_box(with_medium(lit.clone(), medium), min, max));
        for name in ["path", "guided"] {
            let run = Run::new(name, 1, 20_000);
            run.picture(&everywhere).assert_average(expected, 0.02, &format!("{name} {g}"));
            for (scene, kind) in boxes.iter().zip(["homogeneous", "grid"]) {
                run.picture(scene).assert_average(in_box, 0.02, &format!("{name} {g} {kind}"));
            }
        }
    }
}

#[test]
fn what_only_scatters_is_unseen_under_a_white_sky() {
    let camera = || looking(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO, [4, 4], 0.4);
    let ball = ShapeDescription::sphere(1.0).enclosing(0, None);
    for g in [-0.7, 0.0, 0.8] {
        let fog = MediumDescription { g, ..MediumDescription::new(0.0, [0.5, 1.0, 3.0]) };
        let ramp = gridded(fog.clone(), [6, 6, 6], [DVec3::NEG_ONE, DVec3::ONE], |p| 2.0 * p.x + p.z);
        for medium in [fog, ramp] {
            let scene = with_medium(camera(), medium)
                .shape(ball.clone(), MaterialKind::Interface)
                .shape(ShapeDescription::sphere(0.3).translated([0.2, 0.1, 0.0]), diffuse(1.0))
                .light(LightDescription::infinite([1.0; 3]));
            // Of three bands with a sum that does not grow, one may have it all.
            for run in runs(200, 256) {
                run.picture(&scene).assert_average([1.0; 3], 0.03, &format!("{g} {}", run.name()));
            }
        }
    }
}

#[test]
fn thin_fog_before_a_constant_sky_has_hardly_any_noise() {
    // Of the paths, 1 - exp(-0.02) are scattered. Uniform directions by either technique find the sky, unless the path is scattered again and lost: one in 50 or fewer, 4e-4 of all. Samples
    // by a cosine would have a variance of 0.161 for each scattered path.
    let fog = with_medium(one_pixel(DVec3::NEG_X * 4.0, DVec3::ZERO), MediumDescription::new(0.0, 0.01));
    let scene = fog
        .shape(ShapeDescription::sphere(1.0).enclosing(0, None), MaterialKind::Interface)
        .light(LightDescription::infinite([1.0; 3]));
    let samples = 1 << 14;
    for name in ["path", "guided"] {
        let picture = Run::new(name, 1, samples).picture(&scene);
        let (mean, error) = picture.average(1);
        let variance = error.powi(2) * f64::from(samples) / 0.02;
        assert!((mean - 1.0).abs() < 5e-4 && variance < 0.03, "{name}: {mean}, {variance}");
    }
}

#[test]
fn densities_that_grow_linearly_leave_the_exponential_of_their_integral() {
    // Density 2 x over [0, 1]; of the box from x = 1/4 to 3/4 the integral is 1/2. Along y and z there is one cell, with its middle on the ray.
    let corners = [DVec3::new(0.0, -0.5, -0.5), DVec3::new(1.0, 0.5, 0.5)];
    for (absorption, scattering) in [(EXTINCTION, [0.0; 3]), ([0.1, 0.0, 1.5], [0.1, 0.9, 1.0])] {
        let medium = MediumDescription { scale: 3.0, ..MediumDescription::new(absorption, scattering) };
        let medium = gridded(medium, [8, 1, 1], corners, |p| 2.0 * p.x);
        let scene = with_medium(along_x().shape(wall(4.0, LIGHT), diffuse(0.0)), medium);
        let slab = fog_box(scene, [0.25, -0.4, -0.4], [0.75, 0.4, 0.4]);
        let run = Run::new("path", 0, 20_000);
        run.picture(&slab).assert_average(attenuated(EXTINCTION, 1.5), 0.05, &format!("{scattering:?}"));
    }
}

#[test]
fn a_ball_of_coloured_glass_absorbs_along_the_refracted_ray() {
    // A ray at 0.5 m from the middle of a ball of radius 1 m goes 2 sqrt(1 - (0.5 / 1.5)^2) m from side to side. Of a white sky it sees R, and
    // (1 - R)^2 a (1 + R a + ...) of light that was in the ball.
    let (eta, b) = (1.5_f64, 0.5_f64);
    let (cos_o, cos_i) = ((1.0 - b * b).sqrt(), (1.0 - (b / eta).powi(2)).sqrt());
    let parallel = (eta * cos_o - cos_i) / (eta * cos_o + cos_i);
    let across = (cos_o - eta * cos_i) / (cos_o + eta * cos_i);
    let r = 0.5 * (parallel * parallel + across * across);
    let expected = EXTINCTION.map(|sigma| {
        let a = (-f64::from(sigma) * 2.0 * cos_i).exp();
        r + (1.0 - r).powi(2) * a / (1.0 - r * a)
    });
    let scene = one_pixel(DVec3::new(-5.0, b, 0.0), DVec3::new(0.0, b, 0.0))
        .shape(ShapeDescription::sphere(1.0).enclosing(0, None), glass())
        .light(LightDescription::infinite([1.0; 3]));
    let scene = with_medium(scene, MediumDescription::new(EXTINCTION, 0.0));
    for run in runs(60, 30_000) {
        run.picture(&scene).assert_average(expected, 0.04, &run.name());
    }
}

/// Smoke on a grid beside a lamp, over a floor, in thin fog.
fn smoke() -> SceneBuilder {
    let fog = MediumDescription { g: 0.3, ..MediumDescription::new([0.01; 3], [0.05, 0.06, 0.08]) };
    let smoke = MediumDescription { g: -0.2, ..MediumDescription::new([1.0, 0.5, 0.2], [2.0; 3]) };
    let smoke = gridded(smoke, [5, 6, 7], [DVec3::NEG_ONE, DVec3::ONE], |p| (9.0 * p.x).sin().abs() + p.y);
    let scene = looking(DVec3::new(0.0, -5.0, 1.0), DVec3::ZERO, [6, 6], 0.6);
    in_fog(with_medium(with_medium(scene, fog), smoke))
        .shape(ShapeDescription::cuboid([-1.0; 3], [1.0; 3]).enclosing(1, Some(0)), MaterialKind::Interface)
        .shape(
            ShapeDescription::rectangle([-4.0, 4.0], [-4.0, 4.0]).translated([0.0, 0.0, -1.0]),
            diffuse(0.6),
        )
        .shape(
            ShapeDescription::sphere(0.6).translated([1.8, 0.0, 2.2]).emitting([8.0, 6.0, 5.0]),
            diffuse(0.0),
        )
}

#[test]
fn guided_paths_and_divided_paths_see_the_same_smoke() {
    let scene = smoke();
    let path = Run::new("path", 8, 512).picture(&scene);
    let others = [
        Run::new("guided", 8, 512),
        Run { branching: Some(3), ..Run::new("path", 8, 256) },
        Run { light_sampling: false, ..Run::new("path", 8, 2048) },
    ];
    for run in others {
        assert_same(&path, &run.picture(&scene), 0.06, &run.name());
    }
}

#[test]
fn photons_leave_smoke_to_paths() {
    // A caustic on the floor, if there were photons.
    let scene = smoke().shape(ShapeDescription::sphere(0.35).translated([1.4, -0.5, 0.2]), glass());
    let [path, sppm] = ["path", "sppm"].map(|name| Run::new(name, 8, 16).picture(&scene).mean);
    assert_eq!(path, sppm);
}

#[test]
fn bits_of_smoke_do_not_depend_on_threads_and_passes() {
    let scene = smoke();
    for name in ["path", "guided"] {
        let run = Run::new(name, 6, 16);
        let expected = run.picture(&scene).mean;
        for threads in [1, 3] {
            assert_eq!(Run { threads, ..run.clone() }.picture(&scene).mean, expected, "{name} {threads}");
        }
    }
    // Sample by sample, not in batches.
    let run = Run { samples: 0..1, ..Run::new("path", 6, 1) };
    let begun = run.outcome(&scene).film;
    let whole = run.resume(&scene, begun, 0..16, None).unwrap();
    assert_eq!(run.picture_of(&whole).mean, Run::new("path", 6, 16).picture(&scene).mean);
}
