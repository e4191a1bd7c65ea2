//! Adaptive numbers of samples.
//!
//! Seeds are fixed. The mean may be three standard errors from that of the reference (one fair comparison in 370 fails). The true error of a tile may be 1.4 of the level: in a tile of
//! 256 pixels its root mean square varies by 1 / sqrt(512), 4.4 %, and more where samples are skewed.

use glanz_math::DVec3;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{Aov, AovSet, Film, FilmError, FilmFormat, NoiseLevel, RenderError};

use crate::common::*;

const SIDE: u32 = 48;

/// A wall, the left part of which a lamp close to it lights unevenly; the rest is dark.
fn wall() -> SceneBuilder {
    let lamp = ShapeDescription::sphere(0.1).translated([-0.9, 0.0, 0.4]).emitting([20.0; 3]);
    let floor = rectangle(DVec3::new(-2.0, -2.0, 0.0), 4.0 * DVec3::X, 4.0 * DVec3::Y);
    looking(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, [SIDE, SIDE], 0.9)
        .shape(floor, diffuse(0.5))
        .shape(lamp, diffuse(0.0))
}

fn run(seed: u64) -> Run {
    Run { seed, samples: 0..4096, ..Run::new("path", 3, 4096) }
}

fn format(level: f64) -> FilmFormat {
    FilmFormat { noise: NoiseLevel::try_new(level), ..run(1).format(&wall()) }
}

fn adaptive(run: &Run, level: f64, samples: u32) -> Film {
    let film = Film::try_new(format(level)).unwrap();
    run.resume(&wall(), film, 0..samples, None).unwrap().film
}

#[test]
fn tiles_take_samples_until_their_noise_is_at_the_level() {
    let outcome = run(3).resume(&wall(), Film::try_new(format(0.03)).unwrap(), 0..4096, None).unwrap();
    let (film, pixels) = (&outcome.film, u64::from(SIDE * SIDE));
    let deepest = film.samples().total();
    assert!(deepest < 4096, "the level is never reached");
    assert!(outcome.samples < deepest * pixels * 3 / 4, "{} of {}", outcome.samples, deepest * pixels);
    // The true error is at most the claimed one, against many more samples.
    let reference = Run { samples: 0..8000, ..run(1000) }.picture(&wall());
    let found = run(3).picture_of(&outcome);
    let picture = reference.mean[1].iter().sum::<f64>() / pixels as f64;
    for tile in film.format().crop.tiles() {
        let of = |plane: &[f64]| -> Vec<f64> {
            tile.pixels().map(|[x, y]| plane[(y * SIDE + x) as usize]).collect()
        };
        let (mean, truth) = (of(&found.mean[1]), of(&reference.mean[1]));
        let square: f64 = mean.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        let count = mean.len() as f64;
        let reference = (truth.iter().sum::<f64>() / count).max(0.1 * picture);
        let error = (square / count).sqrt() / reference;
        assert!(error < 0.03 * 1.4, "tile at {:?}: {error}", tile.min);
    }
}

#[test]
fn ends_of_tiles_hardly_change_the_mean() {
    let reference = Run { samples: 0..4000, ..run(500) }.picture(&wall());
    let (expected, its_error) = reference.average(1);
    let means: Vec<f64> = (0..24)
        .map(|seed| {
            let film = adaptive(&run(seed), 0.1, 4096);
            let green = film.to_pixels().unwrap();
            let green = green.channel("G").unwrap();
            green.iter().map(|&g| f64::from(g)).sum::<f64>() / green.len() as f64
        })
        .collect();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count * (count - 1.0));
    let error = (variance + its_error * its_error).sqrt();
    assert!(error < 2e-3 * expected, "{error}");
    assert!((mean - expected).abs() < 3.0 * error, "{mean} +- {error}, not {expected}");
}

#[test]
fn picture_depends_neither_on_threads_nor_on_interruptions() {
    let once = adaptive(&run(7), 0.06, 2000);
    assert!(once.samples().total() < 2000, "no tile ends");
    assert_eq!(once, adaptive(&Run { threads: 1, ..run(7) }, 0.06, 2000));
    let mut film = adaptive(&run(7), 0.06, 20);
    for samples in [33, 50, 120, 2000] {
        film = run(7).resume(&wall(), film, 0..samples, None).unwrap().film;
    }
    assert_eq!(film, once);
}

#[test]
fn samples_are_taken_in_order_and_films_cannot_be_joined() {
    let film = Film::try_new(format(0.06)).unwrap();
    assert!(matches!(run(7).resume(&wall(), film, 5..20, None), Err(RenderError::Order { next: 0 })));
    let (mut one, other) = (adaptive(&run(7), 0.06, 8), Film::try_new(format(0.06)).unwrap());
    assert_eq!(one.merge(&other), Err(FilmError::Ordered));
}

#[test]
fn films_without_variance_or_with_passes_have_no_noise_level() {
    let fine = format(0.1);
    assert!(Film::try_new(fine).is_ok());
    let without = FilmFormat { aovs: AovSet::NONE.with(Aov::Albedo), ..fine };
    for format in [without, FilmFormat { passes: true, ..fine }, FilmFormat { splats: true, ..fine }] {
        assert_eq!(Film::try_new(format), Err(FilmError::Noise));
    }
}
