//! Guided paths: the same picture as `path`, the same bits however the work is divided.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

use crate::common::*;
use glanz_math::DVec3;
use glanz_sampling::SamplerKind;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{
    AovSet, Checkpoint, Film, Guide, MergeError, PictureIdentity, RenderError, RenderOutcome, merge,
};

/// A room of 2 m with a wall across it that ends 0.3 m below the ceiling. The lamp lies on the floor behind the wall, so that almost all
/// light in front comes through the gap; there are a glass and a glossy sphere.
fn gap(resolution: [u32; 2]) -> SceneBuilder {
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    let o = DVec3::splat(-1.0);
    let glossy = MaterialKind::phong(0.0, 0.3, 0.6, 30.0);
    let mut scene = looking(DVec3::new(-0.9, 0.0, 0.0), DVec3::new(0.3, 0.0, -0.1), resolution, 1.4);
    for (corner, s, t) in [(o, x, y), (o + z, y, x), (o + x, z, y), (o, z, x), (o + y, x, z), (o, y, z)] {
        scene = scene.shape(rectangle(corner, s, t), diffuse(0.7));
    }
    scene
        .shape(rectangle(DVec3::new(0.4, -1.0, -1.0), y, DVec3::Z * 1.7), diffuse(0.7))
        .shape(ShapeDescription::sphere(0.25).translated([0.0, 0.4, -0.75]), glass())
        .shape(ShapeDescription::sphere(0.25).translated([0.0, -0.4, -0.75]), glossy)
        .shape(
            ShapeDescription::disk(0.2).translated([0.7, 0.0, -0.98]).emitting([20.0, 18.0, 15.0]),
            diffuse(0.0),
        )
}

/// A floor under a spherical lamp, and a glass sphere.
fn small() -> SceneBuilder {
    looking(DVec3::new(-1.0, 1.5, 0.5), DVec3::ZERO, [21, 17], 0.6)
        .shape(ShapeDescription::disk(50.0), diffuse(0.5))
        .shape(ShapeDescription::sphere(0.2).translated([-0.2, 0.3, 0.2]), glass())
        .shape(
            ShapeDescription::sphere(0.4).translated([0.0, 0.0, 2.0]).emitting([4.0, 5.0, 6.0]),
            diffuse(0.0),
        )
}

/// Without light sampling, which makes much work for a guide.
fn run(samples: u32) -> Run {
    Run {
        sampler: SamplerKind::Sobol,
        light_sampling: false,
        aovs: AovSet::ALL,
        ..Run::new("guided", 6, samples)
    }
}

/// Resumes `film` of the small scene, by a guide that is learnt or that one.
fn resume(
    run: &Run,
    film: Film,
    samples: Range<u32>,
    guide: Option<&Arc<Guide>>,
) -> Result<RenderOutcome, RenderError> {
    run.resume(&small(), film, samples, guide)
}

fn fresh(run: &Run) -> Film {
    Film::try_new(run.format(&small())).unwrap()
}

/// A film for a guide that does not change.
fn plain(run: &Run) -> Film {
    let mut format = run.format(&small());
    format.passes = false;
    Film::try_new(format).unwrap()
}

fn identity(run: &Run, film: &Film, guide: Option<u128>) -> PictureIdentity {
    PictureIdentity {
        scene: 99,
        film: *film.format(),
        filter: described(&small()).filter,
        integrator: run.integrator_settings(),
        sampler: run.sampler,
        seed: run.seed,
        samples_per_pixel: 64,
        guide,
        version: glanz_job::current_version(),
    }
}

fn through_bytes(film: Film, run: &Run, guide: Option<u128>) -> Checkpoint {
    let bytes = Checkpoint { identity: identity(run, &film, guide), film }.to_bytes().unwrap();
    Checkpoint::from_bytes(&bytes).unwrap()
}

#[test]
fn guide_does_not_change_the_expected_picture() {
    let scene = gap([12, 10]);
    let path = Run { seed: 5, ..Run::new("path", 6, 16_000) }.picture(&scene);
    for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
        let run = Run { sampler, ..Run::new("guided", 6, 4_000) };
        let outcome = run.outcome(&scene);
        let size = outcome.film.training().unwrap().guide().size();
        assert!(size.active > 10 && size.cells > 30, "the guide is hardly used: {size:?}");
        let guided = run.picture(&scene);
        let mean = assert_same(&path, &guided, 0.01, sampler.name());
        // Pixel by pixel, 120 pixels whose three bands tell nearly the same: chi-square with 120 degrees of freedom, whose mean is
        // 120 +- 15.5. Sobol points do better than the variances say.
        assert!(mean < 1.0 + 4.0 * 15.5 / 120.0, "{}: {mean}", sampler.name());
    }
}

#[test]
fn guide_does_no_harm_where_light_is_easily_found() {
    // With light sampling the ceiling behind the wall is a large lamp: hardly anything is to be gained.
    let scene = gap([12, 10]);
    let variance = |integrator| {
        let run = Run { sampler: SamplerKind::Sobol, ..Run::new(integrator, 6, 1024) };
        run.picture(&scene).variance[1].iter().sum::<f64>()
    };
    let (guided, path) = (variance("guided"), variance("path"));
    println!("variance of guided {guided}, of path {path}");
    assert!(guided < 1.1 * path, "{guided} {path}");
}

#[test]
fn glossy_and_smooth_surfaces_keep_their_own_sampling() {
    // The highlights of Phong's model with exponent 2000 are far smaller than what a cell resolves. The lamp reflects nothing: on a diffuse
    // lamp a guide towards the sphere has a gain, and active cells would not show a fault of the sphere.
    let glossy = MaterialKind::phong(0.0, 0.0, 0.8, 2000.0);
    let scene = looking(DVec3::new(-3.0, 0.0, 1.0), DVec3::ZERO, [16, 16], 0.5)
        .shape(ShapeDescription::sphere(1.0), glossy)
        .shape(
            rectangle(DVec3::new(-4.0, -2.0, 3.0), DVec3::Y * 4.0, DVec3::X * 4.0).emitting([2.0; 3]),
            diffuse(0.0),
        );
    let outcome = Run::new("guided", 4, 512).outcome(&scene);
    let size = outcome.film.training().unwrap().guide().size();
    assert!(size.active * 10 <= size.cells, "{size:?}");
}

#[test]
fn number_of_threads_does_not_change_a_bit() {
    let two = run(80).outcome(&small()).film;
    assert!(two.training().unwrap().guide().size().active > 0);
    for threads in [1, 5] {
        let other = Run { threads, ..run(80) }.outcome(&small()).film;
        assert_eq!(other, two);
        assert_eq!(other.to_pixels(), two.to_pixels());
    }
}

#[test]
fn resumed_anywhere_is_one_run() {
    let run = run(80);
    let whole = resume(&run, fresh(&run), 0..80, None).unwrap().film;
    let mut film = fresh(&run);
    for end in [1, 3, 9, 16, 17, 70, 80] {
        film = resume(&run, film, 0..end, None).unwrap().film;
        film = through_bytes(film, &run, None).film;
    }
    assert_eq!(film, whole);
    assert_eq!(film.to_pixels(), whole.to_pixels());
}

#[test]
fn samples_out_of_turn_are_refused() {
    let run = run(80);
    let begun = resume(&run, fresh(&run), 0..6, None).unwrap().film;
    assert!(matches!(resume(&run, begun.clone(), 7..9, None), Err(RenderError::Order { next: 6 })));
    assert!(matches!(resume(&run, fresh(&run), 1..9, None), Err(RenderError::Order { next: 0 })));
    assert!(resume(&run, begun, 6..9, None).is_ok());
    assert!(matches!(resume(&run, plain(&run), 0..9, None), Err(RenderError::Passes)));
}

#[test]
fn parts_with_one_guide_are_the_whole_and_parts_that_learn_are_refused() {
    let run = run(80);
    let learning = resume(&run, fresh(&run), 0..64, None).unwrap().film;
    let guide = learning.training().unwrap().guide().clone();
    let guide = Arc::new(Guide::from_bytes(&guide.to_bytes()).unwrap());
    assert_eq!(&*guide, learning.training().unwrap().guide());
    assert!(guide.size().active > 0);

    let part = |range| resume(&run, plain(&run), range, Some(&guide)).unwrap().film;
    let parts = [5..16, 0..5].map(|range| through_bytes(part(range), &run, Some(7)));
    let merged = merge(parts.clone()).unwrap();
    assert_eq!(merged.film, part(0..16));

    let mut foreign = parts[1].clone();
    foreign.identity.guide = Some(8);
    assert!(matches!(merge([parts[0].clone(), foreign]), Err(MergeError::Picture { part: 1, .. })));
    let learnt = through_bytes(learning, &run, None);
    assert_eq!(merge([parts[0].clone(), learnt.clone()]), Err(MergeError::Ordered { part: 1 }));
    assert_eq!(merge([learnt.clone(), parts[0].clone()]), Err(MergeError::Ordered { part: 0 }));
    assert_eq!(merge([learnt.clone()]), Ok(learnt));
}

#[test]
fn fixed_guide_gives_the_expected_picture_too() {
    let run = Run { sampler: SamplerKind::Sobol, ..Run::new("guided", 6, 64) };
    let learning = resume(&run, fresh(&run), 0..64, None).unwrap().film;
    let guide = Arc::new(learning.training().unwrap().guide().clone());
    let film = resume(&run, plain(&run), 0..512, Some(&guide)).unwrap().film;
    let pixels = film.to_pixels().unwrap();
    let path = Run { seed: 9, ..Run::new("path", 6, 4096) }.picture(&small());
    let mean = |name: &str| {
        let values = pixels.channel(name).unwrap();
        values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
    };
    let error = {
        let values = pixels.channel("Variance.G").unwrap();
        values.iter().map(|&v| f64::from(v)).sum::<f64>().sqrt() / values.len() as f64
    };
    let (expected, path_error) = path.average(1);
    assert!((mean("G") - expected).abs() < 3.0 * error.hypot(path_error), "{} {expected} {error}", mean("G"));
}

#[test]
fn lamp_found_by_chance_alone_is_found_by_the_guide() {
    // Without light sampling a lamp of 0.03 sr is found by one direction in a hundred; a guide learns where it is. Expected as
    // in `furnace`: (r / d)^2 cos theta, with the floor's albedo of 0.5.
    let (r, d) = (0.2, 2.0);
    let scene = looking(DVec3::new(-1.0, 1.5, 0.5), DVec3::ZERO, [8, 8], 1e-3)
        .shape(ShapeDescription::disk(50.0), diffuse(0.5))
        .shape(ShapeDescription::sphere(r).translated([0.0, 0.0, d]).emitting([4.0; 3]), diffuse(0.0));
    let run = Run { light_sampling: false, ..Run::new("guided", 1, 1024) };
    let guided = run.picture(&scene);
    guided.assert_average([4.0 * 0.5 * (r / d) * (r / d); 3], 0.03, "guided");
    let path = Run { integrator: "path", ..run }.picture(&scene);
    let (guided, path) = (guided.average(0).1, path.average(0).1);
    assert!(guided < 0.6 * path, "standard errors {guided}, {path}");
    assert!((4.0 * PI * (r / d).powi(2) / 4.0 - 0.0314).abs() < 1e-4);
}

#[test]
fn sphere_in_a_constant_sky_is_as_bright_as_it_is_in_short_runs_too() {
    // As in `furnace`: 200 pictures of 64 samples, in which the guide has just begun.
    let scene = looking(DVec3::new(0.0, 0.0, -2.0), DVec3::ZERO, [6, 6], 0.5)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .light(LightDescription::infinite([3.0; 3]));
    let runs = (100..300).map(|seed| Run { seed, ..Run::new("guided", 5, 64) }.picture(&scene).average(1));
    let (sum, variance) = runs.fold((0.0, 0.0), |(s, v), (mean, error)| (s + mean, v + error * error));
    let (mean, error) = (sum / 200.0, variance.sqrt() / 200.0);
    println!("{mean} +- {error}");
    assert!(error < 0.001 && (mean - 1.8).abs() < 3.0 * error, "{mean} +- {error}, not 1.8");
}

#[test]
fn lamps_of_which_few_are_seen_are_weighed_right() {
    // Forty lamps about as near, all but one behind a wall: groups of lamps, and most of what is picked is picked in vain.
    let mut scene = looking(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, [8, 6], 0.6)
        .shape(rectangle(DVec3::new(-4.0, -4.0, 0.0), 8.0 * DVec3::X, 8.0 * DVec3::Y), diffuse(0.7))
        .shape(rectangle(DVec3::new(1.0, -4.0, 0.0), 8.0 * DVec3::Y, 3.0 * DVec3::Z), diffuse(0.5));
    let hidden =
        (0..39).map(|i| DVec3::new(1.1 + 0.3 * f64::from(i % 4), -1.5 + 0.3 * f64::from(i / 4), 1.5));
    for corner in hidden.chain([DVec3::new(0.5, 0.5, 1.5)]) {
        let lamp = rectangle(corner, 0.2 * DVec3::Y, 0.2 * DVec3::X);
        scene = scene.shape(lamp.emitting([10.0; 3]), diffuse(0.0));
    }
    let path = Run { seed: 5, ..Run::new("path", 4, 8_000) }.picture(&scene);
    let guided = Run::new("guided", 4, 4_000).picture(&scene);
    assert_same(&path, &guided, 0.02, "lamps");
    // Even with half the samples it is more exact by far.
    let ((_, by_path), (_, by_guide)) = (path.average(1), guided.average(1));
    assert!(by_guide < 0.5 * by_path, "{by_guide} {by_path}");
}
