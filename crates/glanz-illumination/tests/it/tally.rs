//! Tests: sums do not depend on threads, order or interruption.

use crate::common::*;
use glanz_illumination::*;
use glanz_job::{CancelFlag, JobEnd, JobPart, Silent};
use glanz_math::DVec3;
use glanz_scene::description::ShapeDescription;
use glanz_scene::{Scene, SceneBuilder};
use glanz_transport::codec::{Decoder, Encoder};

/// A lamp above a glossless room of two mirrors and two plates.
fn scene() -> Scene {
    SceneBuilder::new()
        .shape(rectangle(4.0, 4.0), diffuse(0.7))
        .shape(
            rectangle(4.0, 4.0).rotated(DVec3::X, std::f64::consts::PI).translated([0.0, 0.0, 3.0]),
            diffuse(0.5),
        )
        .shape(ShapeDescription::sphere(0.3).translated([1.0, 0.0, 1.0]), mirror(0.9))
        .light(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0))
        .resolve()
        .unwrap()
        .0
}

fn receivers(scene: &Scene) -> Receivers {
    let cells = GridResolution::Cells([8, 8]);
    Receivers::try_new(scene, &[request("floor", 0, cells), request("ceiling", 1, cells)]).unwrap()
}

fn sent(scene: &Scene, receivers: &Receivers, tally: Tally, particles: u64, threads: usize) -> Tally {
    sent_part(scene, receivers, tally, particles, None, threads)
}

fn sent_part(
    scene: &Scene,
    receivers: &Receivers,
    tally: Tally,
    particles: u64,
    part: Option<JobPart>,
    threads: usize,
) -> Tally {
    let goal = TraceGoal { particles: Some(particles), ..TraceGoal::default() };
    let settings = TraceSettings { seed: 1, max_events: 100, threads, goal, part };
    trace(scene, receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap().tally
}

#[test]
fn threads_and_interruptions_change_no_bit() {
    let scene = scene();
    let receivers = receivers(&scene);
    let grid = FarFieldGrid::try_new(8, 18);
    let empty = || Tally::new(&receivers, grid.clone());
    let whole = sent(&scene, &receivers, empty(), 50_001, 1);
    assert_eq!(whole.particles().as_slice(), std::slice::from_ref(&(0..50_001)));
    assert!(whole == sent(&scene, &receivers, empty(), 50_001, 3));
    let half = sent(&scene, &receivers, empty(), 20_000, 2);
    assert!(whole == sent(&scene, &receivers, half, 50_001, 2));
}

#[test]
fn parts_in_any_number_and_order_are_the_whole() {
    let scene = scene();
    let receivers = receivers(&scene);
    let grid = FarFieldGrid::try_new(8, 18);
    let empty = || Tally::new(&receivers, grid.clone());
    let whole = sent(&scene, &receivers, empty(), 50_001, 2);
    for (count, threads) in [(1, 2), (3, 1), (7, 3)] {
        let part = |number| {
            let part = JobPart::try_new(number, count);
            sent_part(&scene, &receivers, empty(), 50_001, part, threads)
        };
        let mut joined = empty();
        for number in (1..=count).rev() {
            joined.merge(&part(number)).unwrap();
        }
        assert!(joined == whole, "{count} parts");
        // A part twice: its first particles.
        assert_eq!(joined.merge(&part(count)), Err(50_001 * u64::from(count - 1) / u64::from(count)..50_001));
        assert!(joined == whole);
    }
    // Without the second of three parts: exactly its particles are traced.
    let part = |number| sent_part(&scene, &receivers, empty(), 50_001, JobPart::try_new(number, 3), 2);
    let mut joined = part(3);
    joined.merge(&part(1)).unwrap();
    assert_eq!(joined.particles().to_string(), "0..16667, 33334..50001");
    let goal = TraceGoal { particles: Some(50_001), ..TraceGoal::default() };
    let rest = TraceSettings { seed: 1, max_events: 100, threads: 2, goal, part: None };
    let outcome = trace(&scene, &receivers, &rest, joined, &mut Silent, &CancelFlag::default()).unwrap();
    assert_eq!(outcome.particles, 16_667);
    assert!(outcome.tally == whole);
    // Nothing is left: no particle is traced, but the error is known.
    let again = trace(&scene, &receivers, &rest, whole, &mut Silent, &CancelFlag::default()).unwrap();
    assert_eq!((again.particles, again.end), (0, JobEnd::Complete));
    assert!(again.error == outcome.error && again.error.is_finite());
}

#[test]
fn tallies_are_read_as_they_were_written() {
    let scene = scene();
    let receivers = receivers(&scene);
    for grid in [FarFieldGrid::try_new(8, 18), None] {
        let empty = Tally::new(&receivers, grid.clone());
        let mut tally = sent_part(&scene, &receivers, empty.clone(), 9_000, JobPart::try_new(2, 3), 1);
        tally.merge(&sent(&scene, &receivers, empty, 1_000, 1)).unwrap();
        let mut encoder = Encoder(Vec::new());
        tally.encode(&mut encoder);
        let read = |bytes: &[u8]| Tally::decode(&mut Decoder(bytes));
        assert!(read(&encoder.0).as_ref() == Some(&tally));
        assert!((0..encoder.0.len()).step_by(7).all(|length| read(&encoder.0[..length]).is_none()));
        // Ranges that overlap.
        let mut bytes = encoder.0;
        bytes[16..24].copy_from_slice(&4_000_u64.to_le_bytes());
        assert!(read(&bytes).is_none());
        let is_counted = grid.is_some();
        assert!(tally.fits(&receivers, is_counted) && !tally.fits(&receivers, !is_counted));
        assert!(!tally.fits(&Receivers::default(), is_counted));
        assert!(
            tally.has_shape_of(&tally)
                && !tally.has_shape_of(&Tally::new(&receivers, FarFieldGrid::try_new(8, 17)))
        );
    }
}

#[test]
fn numbers_of_particles_do_not_overflow() {
    let goal = TraceGoal { particles: Some(u64::MAX), ..TraceGoal::default() };
    for part in [None, JobPart::try_new(1 << 20, 1 << 20)] {
        let settings = TraceSettings { seed: 1, max_events: 9, threads: 1, goal, part };
        // Threads add blocks to the numbers before they compare them with the end.
        assert!(settings.range().end <= u64::MAX / 2 + 1 && !settings.range().is_empty());
    }
}

/// Root mean squares over all cells and seeds: stated errors, and true ones against `expected`.
fn stated_and_true(
    scene: &Scene,
    receivers: &Receivers,
    particles: u64,
    expected: impl Fn(&LuxMap) -> Vec<f64>,
) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for seed in 0..8 {
        let goal = TraceGoal { particles: Some(particles), ..TraceGoal::default() };
        let settings = TraceSettings { seed, max_events: 1000, threads: 0, goal, part: None };
        let tally = Tally::new(receivers, None);
        let outcome = trace(scene, receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap();
        for map in outcome.tally.lux_maps(receivers) {
            for ((lux, error), expected) in map.lux.iter().zip(&map.errors).zip(expected(&map)) {
                squares[0] += (error / expected).powi(2);
                squares[1] += (lux / expected - 1.0).powi(2);
            }
        }
    }
    squares.map(f64::sqrt)
}

#[test]
fn stated_errors_are_the_true_ones() {
    // Direct light of a point, which the sequence integrates much better than chance: I h / d^3.
    let (height, candela) = (2.0, 100.0);
    let floor = SceneBuilder::new().shape(rectangle(6.0, 4.0), diffuse(0.0));
    let point = resolved(floor.light(point_light(DVec3::Z * height, candela as f32)));
    let receivers =
        Receivers::try_new(&point, &[request("floor", 0, GridResolution::Cells([12, 8]))]).unwrap();
    let direct = |map: &LuxMap| {
        cell_means(map, |p| candela * height / (height * height + p.length_squared()).powf(1.5))
    };
    // Light that is reflected many times in a sphere: I / (R^2 (1 - rho)) everywhere.
    let sphere = SceneBuilder::new()
        .shape(ShapeDescription::sphere(0.5).reversed(), diffuse(0.9))
        .light(point_light(DVec3::ZERO, 50.0));
    let sphere = resolved(sphere);
    let inside = Receivers::try_new(&sphere, &[request("sphere", 0, GridResolution::Cells([8, 6]))]).unwrap();
    let cases = [
        ("point", stated_and_true(&point, &receivers, 1 << 15, direct)),
        ("sphere", stated_and_true(&sphere, &inside, 1 << 13, |map| vec![2000.0; map.lux.len()])),
    ];
    for (name, [stated, truth]) in cases {
        let ratio = stated / truth;
        println!("{name}: stated {stated:.5}, true {truth:.5}, ratio {ratio:.3}");
        assert!((0.8..1.25).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn uniformity_of_an_even_sphere_is_one() {
    // With so few particles that the darkest cell has less than nine tenths of the mean by chance.
    let sphere = SceneBuilder::new()
        .shape(ShapeDescription::sphere(0.5).reversed(), diffuse(0.9))
        .light(point_light(DVec3::ZERO, 50.0));
    let sphere = resolved(sphere);
    let receivers =
        Receivers::try_new(&sphere, &[request("sphere", 0, GridResolution::Cells([16, 12]))]).unwrap();
    let goal = TraceGoal { particles: Some(1 << 13), ..TraceGoal::default() };
    let map = traced(&sphere, &receivers, goal).tally.lux_maps(&receivers).swap_remove(0);
    let least = map.lux.iter().copied().fold(f64::INFINITY, f64::min);
    let summary = map.summary();
    assert!(least / summary.mean < 0.9, "{least}");
    assert!(summary.u0 > 0.95 && summary.u1 > 0.93, "{} {}", summary.u0, summary.u1);
    assert!(summary.u0_interval[0] < 1.0 && summary.u0_interval[1] == 1.0);
    let [low, high] = summary.mean_interval;
    assert!(low <= 2000.0 && 2000.0 <= high && high - low < 60.0, "{low} {high}");
}

#[test]
fn runs_end_at_the_error_asked_for() {
    let scene = scene();
    let receivers = receivers(&scene);
    let goal = TraceGoal { error: Some(0.02), particles: Some(10_000_000), ..TraceGoal::default() };
    let outcome = traced(&scene, &receivers, goal);
    assert_eq!(outcome.end, JobEnd::Complete);
    for map in outcome.tally.lux_maps(&receivers) {
        let at = |lux: f64| map.lux.iter().position(|cell| *cell == lux).unwrap();
        let [darkest, brightest] =
            [f64::min, f64::max].map(|extreme| at(map.lux.iter().copied().reduce(extreme).unwrap()));
        let mean = map.summary().mean;
        assert!(map.errors[brightest] <= 0.02 * map.lux[brightest]);
        assert!(map.errors[darkest] <= 0.02 * map.lux[darkest].max(0.1 * mean));
    }
    assert!(outcome.particles < 10_000_000);
    let cancelled = CancelFlag::default();
    cancelled.cancel();
    let settings =
        TraceSettings { seed: 1, max_events: 9, threads: 1, goal: TraceGoal::default(), part: None };
    let outcome = trace(&scene, &receivers, &settings, outcome.tally, &mut Silent, &cancelled).unwrap();
    assert_eq!((outcome.end, outcome.particles), (JobEnd::Interrupted, 0));
}

#[test]
fn light_on_the_excluded_side_is_summed_separately() {
    let scene = SceneBuilder::new()
        .shape(rectangle(1.0, 1.0).translated([0.0, 0.0, -1.0]).reversed(), diffuse(0.0))
        .light(point_light(DVec3::ZERO, 1.0))
        .resolve()
        .unwrap()
        .0;
    let receivers = Receivers::try_new(&scene, &[request("floor", 0, GridResolution::Longer(4))]).unwrap();
    let tally = sent(&scene, &receivers, Tally::new(&receivers, None), 4096, 1);
    assert_eq!((tally.received(&receivers, 0).value, tally.received(&receivers, 0).error), (0.0, 0.0));
    // A face of a cube around the point, half as wide as that of the cube of edge 2: its solid angle is
    // 4 asin((1/2)^2 / (1 + (1/2)^2)).
    let expected = 4.0 * (0.2_f64).asin();
    assert!((tally.on_other_side(0) / expected - 1.0).abs() < 0.05);
    assert_eq!(tally.balance().absorbed_by_receivers, tally.on_other_side(0));
}
