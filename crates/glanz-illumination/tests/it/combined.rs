//! Light by integration, paths and particles together.

use std::f64::consts::PI;
use std::time::Instant;

use crate::common::*;
use glanz_illumination::GridResolution::Cells;
use glanz_illumination::integrate::{CellTolerance, Reflections, Tolerance};
use glanz_illumination::*;
use glanz_job::{CancelFlag, JobEnd, ProgressSink, Silent};
use glanz_light::units::photometric;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

fn settings(goal: TraceGoal, seed: u64, threads: usize) -> TraceSettings {
    TraceSettings { seed, max_events: 1000, threads, goal, part: None }
}

fn until(error: f64) -> TraceGoal {
    TraceGoal { error: Some(error), ..TraceGoal::default() }
}

/// What is integrated.
fn integrable<'a>(scene: &'a Scene, receivers: &Receivers) -> Reflections<'a> {
    let tolerance = Tolerance { relative: 0.01, absolute: 0.0 };
    Reflections::of_integrable(scene).0.without_costly(receivers, tolerance)
}

fn begun(scene: &Scene, receivers: &Receivers) -> CombinedLight {
    begun_within(scene, receivers, 0.01)
}

/// Integrated for an error of the whole.
fn begun_within(scene: &Scene, receivers: &Receivers, error: f64) -> CombinedLight {
    let reflections = integrable(scene, receivers);
    let cells = reflections
        .cells::<()>(
            receivers,
            CellTolerance { relative: 0.5 * error, dark: 0.1, points: 60, until: None },
            &mut Silent,
            &CancelFlag::default(),
        )
        .unwrap();
    CombinedLight::new(receivers, cells)
}

fn continued(
    scene: &Scene,
    receivers: &Receivers,
    light: CombinedLight,
    settings: &TraceSettings,
) -> CombinedOutcome {
    let reflections = integrable(scene, receivers);
    let division = LightDivision::new(scene, receivers, &reflections);
    combine(scene, receivers, &division, settings, light, &mut Silent, &CancelFlag::default()).unwrap()
}

/// Maps of all light with this error, and the outcome.
pub(crate) fn calculated(
    scene: &Scene,
    asked: &[ReceiverRequest],
    error: f64,
) -> (Vec<LuxMap>, CombinedOutcome) {
    let receivers = Receivers::try_new(scene, asked).unwrap();
    let begun = begun_within(scene, &receivers, error);
    let outcome = continued(scene, &receivers, begun, &settings(until(error), 1, 0));
    (outcome.light.lux_maps(&receivers), outcome)
}

/// Six walls of a room of 3 x 2 x 2.5 m, the last of which, x = 3, has a window of a metre above its sill.
fn room(reflectance: f32) -> SceneBuilder {
    let (x, y, z) = (DVec3::X * 3.0, DVec3::Y * 2.0, DVec3::Z * 2.5);
    let wall = ShapeDescription::parallelogram;
    [
        wall(DVec3::ZERO, x, y),
        wall(z, y, x),
        wall(DVec3::ZERO, y, z),
        wall(DVec3::ZERO, z, x),
        wall(y, x, z),
        wall(x, DVec3::Z, y),
        wall(x + DVec3::Z * 2.0, DVec3::Z * 0.5, y),
    ]
    .into_iter()
    .fold(SceneBuilder::new(), |builder, wall| builder.shape(wall, diffuse(reflectance)))
}

/// Lights of all kinds of which the methods share the light, a mirror, smooth metal, a glass ball, a coated box and a pane.
fn showroom() -> Scene {
    let down = DMat4::from_translation(DVec3::new(1.0, 1.0, 2.4)) * DMat4::from_rotation_x(PI);
    let glass = || MaterialKind::dielectric(1.5, 1.0, 1.0);
    let builder = room(0.5)
        .shape(rectangle(0.6, 0.3).transformed(down).emitting(candela_per_area(2000.0)), diffuse(0.0))
        .shape(
            ShapeDescription::sphere(0.1).translated([2.0, 0.6, 2.0]).emitting(candela_per_area(4000.0)),
            diffuse(0.0),
        )
        // Neither sphere, disk nor polygon: sampled.
        .shape(
            ShapeDescription::cylinder(0.03, [-0.4, 0.4])
                .translated([0.2, 1.8, 1.2])
                .emitting(candela_per_area(3000.0)),
            diffuse(0.0),
        )
        .shape(ShapeDescription::parallelogram([0.01, 0.3, 0.3], DVec3::Y, DVec3::Z * 1.5), mirror(0.9))
        .shape(ShapeDescription::sphere(0.3).translated([1.6, 1.2, 0.9]), glass())
        .shape(
            ShapeDescription::parallelogram([0.5, 0.2, 0.8], DVec3::X * 0.6, DVec3::Y * 0.6),
            MaterialKind::thin_dielectric(1.5, 1.0, 1.0),
        )
        .shape(
            ShapeDescription::cuboid([2.2, 1.2, 0.0], [2.7, 1.7, 0.6]),
            MaterialKind::coated_diffuse(0.6, 1.5),
        );
    resolved(
        builder
            .light(point_light(DVec3::new(2.2, 1.0, 1.6), 60.0))
            .light(LightDescription::infinite(3.0 * CANDELA)),
    )
}

/// A lamp over a floor between a mirror that stands upright and a grey wall.
fn mirror_and_wall() -> Scene {
    let down = DMat4::from_translation(DVec3::new(1.0, 1.0, 2.0)) * DMat4::from_rotation_x(PI);
    let builder = SceneBuilder::new()
        .shape(ShapeDescription::parallelogram(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 2.0), diffuse(0.4))
        .shape(ShapeDescription::parallelogram([0.0, 0.0, 0.5], DVec3::Y * 2.0, DVec3::Z), mirror(0.9))
        .shape(ShapeDescription::parallelogram([3.0, 0.0, 0.0], DVec3::Z * 2.0, DVec3::Y * 2.0), diffuse(0.7))
        .shape(
            ShapeDescription::disk(0.2).transformed(down).emitting(candela_per_area(2000.0)),
            diffuse(0.0),
        );
    resolved(builder)
}

#[test]
fn methods_share_the_light_without_gaps_and_overlaps() {
    let floor = request("floor", 0, Cells([6, 4]));
    // What the mirror shows is integrated.
    let scene = mirror_and_wall();
    let receivers = Receivers::try_new(&scene, std::slice::from_ref(&floor)).unwrap();
    assert!(integrable(&scene, &receivers).has_mirrors());
    assert_shared(&scene, std::slice::from_ref(&floor), 24.0);
    // Here the glass ball has too many images for that.
    let scene = showroom();
    let asked = [floor, request("wall", 2, Cells([4, 5]))];
    let receivers = Receivers::try_new(&scene, &asked).unwrap();
    assert!(!integrable(&scene, &receivers).has_mirrors());
    assert_shared(&scene, &asked, 44.0);
}

/// Compares the methods together with particles alone.
fn assert_shared(scene: &Scene, asked: &[ReceiverRequest], count: f64) {
    let receivers = Receivers::try_new(scene, asked).unwrap();
    let combined = continued(scene, &receivers, begun(scene, &receivers), &settings(until(0.01), 5, 0));
    assert_eq!(combined.end, JobEnd::Complete);
    let particles = TraceGoal { particles: Some(1 << 20), ..TraceGoal::default() };
    let traced = traced(scene, &receivers, particles).tally;
    let (mut squares, mut cells) = (0.0, 0.0);
    for (a, b) in combined.light.lux_maps(&receivers).iter().zip(&traced.lux_maps(&receivers)) {
        for cell in 0..a.lux.len() {
            cells += 1.0;
            // Dark behind the mirror.
            if a.lux[cell] == b.lux[cell] {
                continue;
            }
            let apart = (a.lux[cell] - b.lux[cell]) / a.errors[cell].hypot(b.errors[cell]);
            assert!(apart.abs() < ERRORS, "{} {cell}: {} and {}", a.name, a.lux[cell], b.lux[cell]);
            squares += apart * apart;
        }
        let [one, other] = [a, b].map(LuxMap::summary);
        assert!((one.mean / other.mean - 1.0).abs() < 0.005, "{}: {} {}", a.name, one.mean, other.mean);
    }
    // Bounds make the errors larger than they are.
    assert!(cells == count && squares / cells < 1.5, "{cells} {}", squares / cells);
}

#[test]
fn light_in_a_white_sphere_is_that_of_the_closed_form() {
    // A sphere of reflectance r around a lamp of flux F: r / (1 - r) F over its area everywhere, beside the direct light.
    let (radius, reflectance, candela) = (2.0, 0.8, 100.0);
    let scene = SceneBuilder::new()
        .shape(ShapeDescription::sphere(radius).reversed(), diffuse(reflectance as f32))
        .light(point_light(DVec3::ZERO, candela as f32));
    let scene = resolved(scene);
    let receivers = Receivers::try_new(&scene, &[request("sphere", 0, Cells([6, 4]))]).unwrap();
    let light = continued(&scene, &receivers, begun(&scene, &receivers), &settings(until(0.004), 1, 0)).light;
    let maps = light.lux_maps(&receivers);
    let expected = candela / (radius * radius) / (1.0 - reflectance);
    assert_map_within(&maps[0], &[expected; 24], 0.008, ERRORS);
    let summary = maps[0].summary();
    assert!(summary.u0 > 0.99 && summary.u0_interval[1] >= 1.0, "{summary:?}");
}

/// Saves the first checkpoint, and raises the flag after it.
struct Interrupting<'a> {
    cancel: &'a CancelFlag,
    saved: Option<CombinedLight>,
}

impl ProgressSink<CombinedLight> for Interrupting<'_> {
    fn checkpoint_interval(&self) -> Option<std::time::Duration> {
        Some(std::time::Duration::ZERO)
    }

    fn on_checkpoint(&mut self, state: &CombinedLight) {
        if state.paths() > 0 {
            self.cancel.cancel();
            self.saved.get_or_insert_with(|| state.clone());
        }
    }
}

#[test]
fn interrupted_light_continues_from_its_bytes() {
    let scene = showroom();
    let receivers = Receivers::try_new(&scene, &[request("floor", 0, Cells([3, 2]))]).unwrap();
    let reflections = integrable(&scene, &receivers);
    let division = LightDivision::new(&scene, &receivers, &reflections);
    let cancel = CancelFlag::default();
    let mut sink = Interrupting { cancel: &cancel, saved: None };
    let goal = settings(until(1e-9), 2, 1);
    let first = combine(&scene, &receivers, &division, &goal, begun(&scene, &receivers), &mut sink, &cancel);
    let first = first.unwrap();
    assert_eq!((first.end, sink.saved.as_ref()), (JobEnd::Interrupted, Some(&first.light)));
    let mut encoder = glanz_transport::codec::Encoder::default();
    first.light.encode(&mut encoder);
    let read = |bytes: &[u8]| CombinedLight::decode(&mut glanz_transport::codec::Decoder(bytes));
    assert_eq!(read(&encoder.0).as_ref(), Some(&first.light));
    for length in (0..encoder.0.len()).step_by(97) {
        assert_eq!(read(&encoder.0[..length]), None, "{length}");
    }
    assert!(first.light.fits(&receivers));
    let later = continued(&scene, &receivers, read(&encoder.0).unwrap(), &settings(until(0.02), 2, 0));
    assert!(later.error <= 0.02 && later.light.paths() >= first.light.paths(), "{}", later.error);
}

#[test]
fn first_rounds_have_the_same_bits_by_any_number_of_threads() {
    let scene = showroom();
    let receivers = Receivers::try_new(&scene, &[request("floor", 0, Cells([3, 2]))]).unwrap();
    // The first round of particles and that of paths.
    let goal = TraceGoal { particles: Some((1 << 16) + 1), ..TraceGoal::default() };
    let of =
        |threads| continued(&scene, &receivers, begun(&scene, &receivers), &settings(goal, 7, threads)).light;
    let (one, three) = (of(1), of(3));
    assert!(one.paths() > 0 && one == three);
}

#[test]
fn cells_that_are_not_integrated_in_time_have_their_light_by_paths() {
    // E = I cos^3 / h^2 under a lamp.
    let scene = resolved(
        SceneBuilder::new()
            .shape(rectangle(2.0, 2.0), diffuse(0.0))
            .light(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0)),
    );
    let receivers = Receivers::try_new(&scene, &[request("floor", 0, Cells([20, 20]))]).unwrap();
    let accuracy = CellTolerance { relative: 0.01, dark: 0.1, points: 60, until: Some(Instant::now()) };
    let cells = integrable(&scene, &receivers)
        .cells::<()>(&receivers, accuracy, &mut Silent, &CancelFlag::default())
        .unwrap();
    assert!(cells.len() == 400 && cells.iter().all(|cell| !cell.converged));
    let light = CombinedLight::new(&receivers, cells);
    let outcome = continued(&scene, &receivers, light, &settings(until(0.01), 1, 0));
    let map = &outcome.light.lux_maps(&receivers)[0];
    for (position, lux) in map.positions.iter().zip(&map.lux) {
        let cosine = 2.0 / position.distance(DVec3::Z * 2.0);
        let expected = 100.0 / 4.0 * cosine.powi(3);
        // The cell's curvature is .1 %.
        assert!((lux / expected - 1.0).abs() < 0.03, "{position}: {lux}, {expected}");
    }
}

#[test]
fn light_of_lamps_close_to_a_cell_is_integrated() {
    // Millimetres below the middle of a ceiling of 3 x 2 m: nearly all flux that goes upwards arrives, of a point I times the solid angle of the ceiling.
    let ceiling = || ShapeDescription::parallelogram(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 2.0).reversed();
    let below = |depth: f64| DMat4::from_translation(DVec3::new(1.37, 0.91, -depth));
    let luminance = candela_per_area(1000.0);
    let emitting = |shape: ShapeDescription, depth: f64| {
        SceneBuilder::new().shape(shape.transformed(below(depth)).emitting(luminance.clone()), diffuse(0.0))
    };
    let disk = emitting(ShapeDescription::disk(0.005), 0.002);
    let strip = emitting(rectangle(0.6, 0.005), 0.004);
    let point = SceneBuilder::new().light(point_light(DVec3::new(1.37, 0.91, -0.001), 100.0));
    let lamps = [
        (point, 2.0 * PI * 100.0),
        (disk, PI * 1000.0 * PI * 0.005 * 0.005),
        (strip, PI * 1000.0 * 0.6 * 0.005),
    ];
    for (number, (lamp, flux)) in lamps.into_iter().enumerate() {
        let scene = resolved(lamp.shape(ceiling(), diffuse(0.0)));
        let shape = u32::from(number > 0);
        let receivers = Receivers::try_new(&scene, &[request("ceiling", shape, Cells([6, 4]))]).unwrap();
        let accuracy = CellTolerance { relative: 0.005, dark: 0.1, points: 60, until: None };
        let cells = integrable(&scene, &receivers)
            .cells::<()>(&receivers, accuracy, &mut Silent, &CancelFlag::default())
            .unwrap();
        let areas = receivers.as_slice()[0].areas();
        let found: f64 = cells.iter().zip(areas).map(|(cell, area)| cell.lux * area).sum();
        assert!((found / flux - 1.0).abs() < 0.01, "{number}: {found}, {flux}");
        assert!(cells.iter().all(|cell| cell.converged), "{number}: {cells:?}");
    }
}

#[test]
fn light_close_to_a_round_cell_is_integrated() {
    // A disk as one cell, whose corners are off it or coincide: nearly all flux that goes upwards arrives.
    let below = point_light(DVec3::new(0.3, 0.1, -0.001), 100.0);
    let ceiling = ShapeDescription::disk(1.0).reversed();
    let scene = resolved(SceneBuilder::new().light(below).shape(ceiling, diffuse(0.0)));
    let receivers = Receivers::try_new(&scene, &[request("ceiling", 0, Cells([1, 1]))]).unwrap();
    let accuracy = CellTolerance { relative: 0.005, dark: 0.1, points: 60, until: None };
    let cells = integrable(&scene, &receivers)
        .cells::<()>(&receivers, accuracy, &mut Silent, &CancelFlag::default())
        .unwrap();
    let flux = cells[0].lux * receivers.as_slice()[0].areas()[0];
    // The points of the rule in squares that the rim cuts know its area to 1 % only.
    assert!((flux / (2.0 * PI * 100.0) - 1.0).abs() < 0.02, "{flux}");
}

#[test]
fn light_at_one_distance_from_a_lamp_is_counted_once() {
    // A half sphere about the lamp, in a black sphere. Half of the light that it scatters leaves it at once: I 2 pi (1 + rho / 2 / (1 - rho / 2)).
    let bowl = GeometryDescription::Sphere { radius: 0.1, z: [0.0, 0.1], phi_max: 2.0 * PI };
    let scene = resolved(
        SceneBuilder::new()
            .shape(ShapeDescription::sphere(3.0).reversed(), diffuse(0.0))
            .shape(bowl, diffuse(0.6))
            .light(point_light(DVec3::ZERO, 100.0)),
    );
    let (maps, _) = calculated(&scene, &[request("sphere", 0, Cells([6, 4]))], 0.02);
    let expected = 2.0 * PI * 100.0 * (1.0 + 0.3 / (1.0 - 0.3));
    let flux = maps[0].summary().flux;
    assert!((flux / expected - 1.0).abs() < 0.03, "{flux}, {expected}");
}

#[test]
fn lamp_that_touches_a_ceiling_has_finite_errors() {
    // A closed room of reflectance rho absorbs all flux: the sum of the fluxes on its walls is that of the lamp over 1 - rho.
    let window = ShapeDescription::parallelogram([3.0, 0.0, 1.0], DVec3::Z, DVec3::Y * 2.0);
    let lamp = point_light(DVec3::new(1.2, 0.9, 2.499), 100.0);
    let scene = resolved(room(0.5).shape(window, diffuse(0.5)).light(lamp));
    let walls: Vec<_> = (0..8).map(|wall| request(&wall.to_string(), wall, Cells([5, 4]))).collect();
    let receivers = Receivers::try_new(&scene, &walls).unwrap();
    let goal = TraceGoal { particles: Some(6_000_000), ..until(0.03) };
    let outcome =
        continued(&scene, &receivers, begun_within(&scene, &receivers, 0.03), &settings(goal, 3, 0));
    assert!(
        outcome.error <= 0.03,
        "{}, {} paths, {} particles",
        outcome.error,
        outcome.light.paths(),
        outcome.light.particles()
    );
    let maps = outcome.light.lux_maps(&receivers);
    let flux: f64 = maps.iter().map(|map| map.summary().flux).sum();
    let expected = 4.0 * PI * 100.0 / (1.0 - 0.5);
    assert!((flux / expected - 1.0).abs() < 0.01, "{flux}, {expected}");
}

#[test]
fn a_dark_scene_ends() {
    let scene = resolved(room(0.5).light(point_light(DVec3::new(1.0, 1.0, -1.0), 100.0)));
    let receivers = Receivers::try_new(&scene, &[request("floor", 0, Cells([3, 2]))]).unwrap();
    let outcome = continued(&scene, &receivers, begun(&scene, &receivers), &settings(until(0.01), 0, 0));
    assert_eq!((outcome.end, outcome.error), (JobEnd::Complete, f64::INFINITY));
    let balance = outcome.light.balance();
    assert!(outcome.light.particles() >= 1 << 22);
    let emitted = 4.0 * PI * 100.0 * photometric(Spectrum::splat(CANDELA), &Wavelengths::default());
    assert!((balance.emitted / emitted - 1.0).abs() < 1e-3, "{balance:?}");
}

#[test]
fn cells_at_the_rim_and_behind_posts_have_their_light() {
    // The rim of a disk crosses cells, hardly in some; a post of 5 cm shades a strip between the nodes of the rules.
    let post = ShapeDescription::cuboid([0.2, 0.28, 0.3], [0.25, 0.33, 0.9]);
    let builder = SceneBuilder::new()
        .shape(ShapeDescription::disk(1.0), diffuse(0.0))
        .shape(post, diffuse(0.0))
        .light(point_light(DVec3::new(0.3, 0.4, 1.2), 100.0));
    let scene = resolved(builder);
    let asked = [request("disk", 0, Cells([18, 18]))];
    let receivers = Receivers::try_new(&scene, &asked).unwrap();
    let light = continued(&scene, &receivers, begun(&scene, &receivers), &settings(until(0.02), 3, 0)).light;
    let map = &light.lux_maps(&receivers)[0];
    let particles = TraceGoal { particles: Some(1 << 20), ..TraceGoal::default() };
    let expected = &traced(&scene, &receivers, particles).tally.lux_maps(&receivers)[0];
    let mut count = 0;
    for cell in (0..map.lux.len()).filter(|&cell| map.areas[cell] > 0.0) {
        let (lux, other) = (map.lux[cell], expected.lux[cell]);
        let error = map.errors[cell].hypot(expected.errors[cell]);
        assert!((lux - other).abs() <= ERRORS * error, "{cell}: {lux} {other} {error} {}", map.areas[cell]);
        count += 1;
    }
    assert!(count > 250, "{count}");
}

#[test]
fn receivers_of_several_patches_are_measured_by_particles() {
    let patch = |x: f64| {
        let corner = |i: u32, j: u32| {
            DVec3::new(x + f64::from(i) / 3.0, f64::from(j) / 3.0, 0.05 * f64::from(i * j % 2))
        };
        let points = (0..4).flat_map(|j| (0..4).map(move |i| (i, j))).map(|(i, j)| corner(i, j).extend(1.0));
        glanz_geometry::bezier::TensorPatch::try_new(3, 3, points.collect()).unwrap()
    };
    let builder = SceneBuilder::new()
        .shape(ShapeDescription::bezier_patches(&[patch(0.0), patch(1.0)]), diffuse(0.3))
        .light(point_light(DVec3::new(1.0, 0.5, -2.0), 100.0));
    let scene = resolved(builder);
    let (maps, _) = calculated(&scene, &[request("patches", 0, Cells([2, 2]))], 0.02);
    let receivers = Receivers::try_new(&scene, &[request("patches", 0, Cells([2, 2]))]).unwrap();
    let particles = TraceGoal { particles: Some(1 << 18), ..TraceGoal::default() };
    let expected = traced(&scene, &receivers, particles).tally.lux_maps(&receivers)[0].summary();
    let found = maps[0].summary();
    // Straight below the middle of the patches it is 25 lx.
    assert!(found.mean > 15.0);
    assert!((found.mean / expected.mean - 1.0).abs() < 0.03, "{found:?} {expected:?}");
}
