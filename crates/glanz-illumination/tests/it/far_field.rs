//! Tests: far fields against closed forms.

use std::f64::consts::{PI, TAU};

use crate::common::*;
use glanz_illumination::*;
use glanz_job::{CancelFlag, JobEnd, JobPart, JobProgress, ProgressSink, Silent};
use glanz_light::intensity::AngularSystem;
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{
    GeometryDescription, LightDescription, LightKind, ShapeDescription, SourceRay,
};
use glanz_scene::{Scene, SceneBuilder};

fn settings(particles: u64, threads: usize) -> TraceSettings {
    let goal = TraceGoal { particles: Some(particles), ..TraceGoal::default() };
    TraceSettings { seed: 1, max_events: 100, threads, goal, part: None }
}

fn adapted(scene: &Scene, settings: &TraceSettings) -> FarFieldGrid {
    adapted_grid(scene, settings, &CancelFlag::default()).unwrap().unwrap()
}

/// Standard errors from 16 replicates within which a thousand values lie with a probability of 98 %.
const ERRORS: f64 = 6.0;

/// The far field of so many particles, on this grid or on an adapted one; its flux is that of the balance.
fn far_field(scene: &Scene, particles: u64, grid: Option<FarFieldGrid>) -> FarField {
    let (receivers, settings) = (Receivers::default(), settings(particles, 2));
    let tally = Tally::new(&receivers, Some(grid.unwrap_or_else(|| adapted(scene, &settings))));
    let outcome = trace(scene, &receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap();
    let far = outcome.tally.far_field().unwrap();
    let escaped = outcome.tally.balance().escaped;
    for flux in [far.flux(), far.distribution().unwrap().flux()] {
        assert!((flux / escaped - 1.0).abs() < 1e-6, "{flux} lm, not {escaped}");
    }
    far
}

fn spot(axis: DVec3, half_angle: f64, candela: f32) -> Scene {
    let light = LightDescription::spot(DVec3::ZERO, axis, [half_angle.to_radians(); 2], CANDELA);
    resolved(SceneBuilder::new().light(LightDescription { scale: candela, ..light }))
}

fn direction(c: f64, gamma: f64) -> DVec3 {
    AngularSystem::C.direction(c, gamma)
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected} +- {tolerance}");
}

/// The paraboloid z = -r^2 / 4 f, cut at `rim`, with its focus below the vertex, and a round emitter in the focus that faces the vertex; metres.
struct Reflector {
    focal_length: f64,
    rim: f64,
    emitter: f64,
    luminance: f64,
}

const REFLECTOR: Reflector = Reflector { focal_length: 0.01, rim: 0.02, emitter: 0.001, luminance: 1e6 };

impl Reflector {
    fn scene(&self) -> Scene {
        let &Self { focal_length, rim, emitter, luminance } = self;
        let z = [0.0, rim * rim / (4.0 * focal_length)];
        let shape = ShapeDescription::from(GeometryDescription::Paraboloid { radius: rim, z, phi_max: TAU });
        let mirrored = shape.transformed(DMat4::from_rotation_x(PI));
        let disk = ShapeDescription::disk(emitter).translated([0.0, 0.0, -focal_length]);
        resolved(
            SceneBuilder::new()
                .shape(mirrored, mirror(1.0))
                .shape(disk.emitting(candela_per_area(luminance as f32)), diffuse(0.0)),
        )
    }

    /// Intensity at gamma in degrees: the luminance times the area, seen from there, of the mirror in which the emitter is seen.
    fn intensity(&self, gamma: f64) -> f64 {
        const CELLS: i32 = 500;
        let &Self { focal_length: f, rim, emitter, luminance } = self;
        let d = direction(0.0, gamma);
        // Whether a ray from below the emitter, in whose plane z = -f it starts or ends, meets it.
        let meets = |point: DVec3, along: DVec3| {
            let at = point + along * ((-f - point.z) / along.z);
            at.truncate().length() <= emitter
        };
        let step = 2.0 * rim / f64::from(CELLS);
        let mut area = 0.0;
        for (i, k) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |k| (i, k))) {
            let [x, y] = [i, k].map(|n| (f64::from(n) + 0.5) * step - rim);
            let r2 = x * x + y * y;
            if r2 > rim * rim {
                continue;
            }
            let point = DVec3::new(x, y, -r2 / (4.0 * f));
            let slope = DVec3::new(x / (2.0 * f), y / (2.0 * f), 1.0);
            let normal = slope.normalize();
            // Seen against the light, and reflected; the emitter itself hides a part of the mirror.
            let reflected = -d + normal * (2.0 * d.dot(normal));
            if reflected.z < 0.0 && meets(point, reflected) && !meets(point, d) {
                area += slope.dot(d).abs() * step * step;
            }
        }
        luminance * area
    }

    /// Angle at which the intensity is half of that on the axis, degrees.
    fn half_angle(&self) -> f64 {
        let half = 0.5 * self.intensity(0.0);
        let (mut low, mut high) = (0.0, 10.0);
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if self.intensity(middle) > half { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[test]
fn paraboloid_has_its_peak_and_width() {
    // On the axis the whole mirror shows the emitter, but for the part that the emitter hides.
    let on_axis = REFLECTOR.luminance * PI * (REFLECTOR.rim.powi(2) - REFLECTOR.emitter.powi(2));
    near(REFLECTOR.intensity(0.0), on_axis, 2e-3 * on_axis, "numerical intensity on the axis");
    let scene = REFLECTOR.scene();
    let far = far_field(&scene, 1_000_000, None);
    let summary = far.summary().unwrap();
    assert!(summary.peak_shortfall < 0.06 * on_axis, "{summary:?}");
    near(summary.peak, on_axis, 4.0 * summary.peak_error + summary.peak_shortfall, "peak");
    // Other directions: the mean over all planes, between which the intensity does not change.
    let distribution = far.distribution().unwrap();
    for gamma in [0.5, 1.0, 2.0, 3.0, 4.0, 5.0] {
        let mean = (0..24).map(|i| distribution.at(15.0 * f64::from(i), gamma)).sum::<f64>() / 24.0;
        near(mean, REFLECTOR.intensity(gamma), 0.02 * on_axis, "intensity");
    }
    let width = 2.0 * REFLECTOR.half_angle();
    for angle in summary.beam_angles {
        // What the kink loses of the peak widens the beam.
        near(REFLECTOR.intensity(0.5 * angle), 0.5 * summary.peak, 0.03 * on_axis, "half of the peak");
        near(angle, width, 0.1 * width, "beam angle");
    }
    assert_eq!((summary.middle, summary.coarse()), ([0.0; 2], None));
    // With the angles that were fixed before, the beam is flattened, which is reported.
    let coarse = far_field(&scene, 1_000_000, FarFieldGrid::try_new(24, 36)).summary().unwrap();
    assert!(coarse.peak < 0.7 * on_axis && coarse.coarse().is_some(), "{coarse:?}");
}

#[test]
fn cones_have_their_intensity_angle_and_axis() {
    for (half_angle, [c, gamma]) in
        [(1.0, [0.0, 0.0]), (0.05, [0.0, 0.0]), (1.0, [50.0, 37.0]), (5.0, [260.0, 120.0])]
    {
        let far = far_field(&spot(direction(c, gamma), half_angle, 1000.0), 1_000_000, None);
        let flux = 1000.0 * TAU * 2.0 * (0.5_f64 * half_angle.to_radians()).sin().powi(2);
        near(far.flux(), flux, 1e-3 * flux, "flux");
        let summary = far.summary().unwrap();
        near(summary.peak, 1000.0, ERRORS * summary.peak_error, "peak");
        let distribution = far.distribution().unwrap();
        near(distribution.at(c, gamma), 1000.0, 0.1 * 1000.0, "axis");
        let off =
            distribution.direction(summary.middle[0], summary.middle[1]).angle_between(direction(c, gamma));
        near(off.to_degrees(), 0.0, 0.03 * half_angle, "middle");
        let width = 2.0 * half_angle;
        summary.beam_angles.iter().for_each(|angle| near(*angle, width, 0.04 * width, "beam angle"));
        summary.field_angles.iter().for_each(|angle| near(*angle, width, 0.12 * width, "field angle"));
        assert_eq!(summary.coarse(), None, "{summary:?}");
        assert!(far.grid.bins() <= 1 << 16, "{} bins", far.grid.bins());
    }
}

#[test]
fn steps_given_for_a_beam_that_is_narrower_are_reported() {
    let step = |degrees| AngleStep::try_new(degrees).unwrap();
    let scene = spot(direction(50.0, 37.0), 2.0, 1000.0);
    for ([gamma, plane], coarse) in [([5.0, 5.0], true), ([0.5, 15.0], true), ([0.5, 1.0], false)] {
        let far = far_field(&scene, 100_000, FarFieldGrid::with_steps(step(gamma), step(plane)));
        assert_eq!(far.summary().unwrap().coarse().is_some(), coarse, "{gamma} {plane}");
    }
}

#[test]
fn even_light_has_even_values_and_large_steps() {
    let scene = resolved(SceneBuilder::new().light(point_light(DVec3::ZERO, 100.0)));
    let far = far_field(&scene, 1_000_000, None);
    assert_eq!((far.grid.planes().len(), far.grid.gammas().len()), (24, 37));
    near(far.flux(), 400.0 * PI, 1e-3, "flux");
    for (candela, error) in far.candela.iter().zip(&far.errors) {
        near(*candela, 100.0, ERRORS * error, "intensity");
    }
    assert!(!far.summary().unwrap().is_noisy());
    assert!(far_field(&scene, 10_000, None).summary().unwrap().is_noisy());
}

fn lambert_disk() -> Scene {
    let down = DMat4::from_rotation_x(PI);
    let disk = ShapeDescription::disk(0.1).transformed(down).emitting(candela_per_area(1000.0));
    resolved(SceneBuilder::new().shape(disk, diffuse(0.0)))
}

#[test]
fn far_field_of_a_lambert_disk_is_a_cosine() {
    let peak = 1000.0 * PI * 0.01;
    let cosine = |gamma: f64| peak * gamma.to_radians().cos().max(0.0);
    for grid in [FarFieldGrid::try_new(1, 18), None] {
        let far = far_field(&lambert_disk(), 400_000, grid);
        near(far.flux(), PI * peak, 1e-5 * PI * peak, "flux");
        let gammas = far.grid.gammas();
        // Values differ by a twelfth of the second derivative times the square of the step, three times as much next to the pole, and at the end of
        // the light by a sixth of the step.
        let step = gammas[1].to_radians();
        for (j, &gamma) in gammas.iter().enumerate() {
            let is_end = (79.0..=101.0).contains(&gamma);
            let tolerance = peak * if is_end { step / 5.0 } else { step * step / 4.0 };
            for plane in 0..far.grid.planes().len() {
                let bin = far.grid.bin_of(plane, j);
                let what = format!("C {plane} gamma {gamma}");
                near(far.candela[bin], cosine(gamma), ERRORS * far.errors[bin] + tolerance, &what);
            }
        }
    }
}

#[test]
fn smooth_beams_have_their_peak_within_a_percent() {
    // 1000 cd times the smoothstep of the cosine between 0 and 20 degrees.
    let light =
        LightDescription::spot(DVec3::ZERO, direction(200.0, 60.0), [20.0_f64.to_radians(), 0.0], CANDELA);
    let scene = resolved(SceneBuilder::new().light(LightDescription { scale: 1000.0, ..light }));
    let far = far_field(&scene, 4_000_000, None);
    let distribution = far.distribution().unwrap();
    let axis = direction(200.0, 60.0);
    let end = 20.0_f64.to_radians().cos();
    let smoothstep = |cos: f64| {
        let t = ((cos - end) / (1.0 - end)).clamp(0.0, 1.0);
        1000.0 * t * t * (3.0 - 2.0 * t)
    };
    let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0);
    for (i, &c) in far.grid.planes().iter().enumerate() {
        for (j, &gamma) in far.grid.gammas().iter().enumerate() {
            let off = far.at(i, j) - smoothstep(direction(c, gamma).dot(axis));
            let error = far.errors[far.grid.bin_of(i, j)];
            worst = worst.max(off.abs() - 4.0 * error);
            if smoothstep(direction(c, gamma).dot(axis)) > 900.0 {
                (sum, count) = (sum + off, count + 1);
            }
        }
    }
    assert!(count >= 4 && worst < 15.0, "{count} {worst}");
    near(sum / f64::from(count), 0.0, 10.0, "mean of the differences around the peak");
    near(distribution.beam().unwrap().peak, 1000.0, 50.0, "peak");
}

#[test]
fn grids_do_not_depend_on_threads_parts_or_numbers_of_particles() {
    let scene = REFLECTOR.scene();
    let grid = adapted(&scene, &settings(1000, 1));
    let part = TraceSettings { part: JobPart::try_new(2, 3), ..settings(77_777, 3) };
    assert_eq!(adapted(&scene, &part), grid);
    let dark = resolved(SceneBuilder::new().light(point_light(DVec3::ZERO, 0.0)));
    assert_eq!(adapted(&dark, &part), FarFieldGrid::try_new(24, 36).unwrap());
    let tally = Tally::new(&Receivers::default(), Some(grid)).far_field().unwrap();
    assert_eq!(tally.summary(), None);
    let cancelled = CancelFlag::default();
    cancelled.cancel();
    assert_eq!(adapted_grid(&scene, &part, &cancelled).unwrap(), None);
}

/// All rays that leave the scene.
fn rays_of(scene: &Scene, settings: &TraceSettings, particles: u64) -> Vec<EscapedRay> {
    let mut rays = Vec::new();
    let visit = |ray: &EscapedRay| {
        rays.push(*ray);
        Ok::<(), ()>(())
    };
    let end = escaped_rays(scene, settings, particles, &mut Silent, &CancelFlag::default(), visit);
    assert_eq!(end, Ok(JobEnd::Complete));
    rays
}

#[test]
fn escaped_rays_as_a_light_have_the_far_field_of_the_scene() {
    let scene = REFLECTOR.scene();
    let (particles, settings) = (100_001, settings(100_001, 2));
    let rays = rays_of(&scene, &settings, particles);
    // The same particles.
    let receivers = Receivers::default();
    let grid = adapted(&scene, &settings);
    let tally = Tally::new(&receivers, Some(grid.clone()));
    let outcome = trace(&scene, &receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap();
    let (far, escaped) = (outcome.tally.far_field().unwrap(), outcome.tally.balance().escaped);
    let flux: f64 = rays.iter().map(|ray| ray.lumens).sum();
    assert!((flux / escaped - 1.0).abs() < 1e-9, "{flux} {escaped}");
    // All from the mirror.
    let on_mirror = |p: DVec3| (p.z + p.truncate().length_squared() / 0.04).abs() < 1e-6;
    assert!(rays.iter().all(|ray| ray.direction.is_normalized() && on_mirror(ray.origin)));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| rays_of(&scene, &settings, particles)) == rays);
    let source: Vec<SourceRay> = rays
        .iter()
        .map(|ray| SourceRay {
            origin: ray.origin.as_vec3().to_array(),
            direction: ray.direction.as_vec3().to_array(),
            lumens: ray.lumens as f32,
        })
        .collect();
    let kind = LightKind::Rays { rays: source.into(), from: DVec3::ZERO };
    let light = LightDescription { kind, ..LightDescription::point(DVec3::ZERO, 1.0) };
    let again = far_field(&resolved(SceneBuilder::new().light(light)), 300_000, Some(grid));
    assert!((again.flux() / far.flux() - 1.0).abs() < 1e-6, "{} {}", again.flux(), far.flux());
    let peak = far.candela.iter().copied().fold(0.0, f64::max);
    for (bin, (a, b)) in far.candela.iter().zip(&again.candela).enumerate() {
        let error = far.errors[bin].hypot(again.errors[bin]);
        assert!((a - b).abs() <= ERRORS * error + 1e-6 * peak, "{bin}: {a} and {b} +- {error}");
    }
}

#[test]
fn few_rays_report_their_end() {
    struct Fractions(Vec<f64>);

    impl ProgressSink for Fractions {
        fn on_progress(&mut self, progress: &JobProgress<'_>) {
            self.0.push(progress.fraction);
        }
    }

    let scene = spot(DVec3::NEG_Z, 10.0, 1.0);
    for particles in [1, 49, 1000] {
        let (mut sink, settings) = (Fractions(Vec::new()), settings(particles, 1));
        let visit = |_: &EscapedRay| Ok::<(), ()>(());
        let end = escaped_rays(&scene, &settings, particles, &mut sink, &CancelFlag::default(), visit);
        assert_eq!((end, sink.0.last()), (Ok(JobEnd::Complete), Some(&1.0)), "{particles}");
    }
}

#[test]
fn cancelled_rays_end_at_once() {
    let cancel = CancelFlag::default();
    let (scene, settings) = (spot(DVec3::NEG_Z, 10.0, 1.0), settings(u64::MAX >> 1, 1));
    let mut count = 0;
    let visit = |_: &EscapedRay| {
        count += 1;
        cancel.cancel();
        Ok::<(), ()>(())
    };
    let end = escaped_rays(&scene, &settings, u64::MAX >> 1, &mut Silent, &cancel, visit);
    assert_eq!(end, Ok(JobEnd::Interrupted));
    // The rest of the particles that were traced together.
    let together = 16 * 1024 * rayon::current_num_threads();
    assert!((1..=together).contains(&count), "{count}");
    // An error of the receiver ends it, too.
    let full = |_: &EscapedRay| Err("full");
    let settings = TraceSettings { seed: 2, ..settings };
    let end = escaped_rays(&scene, &settings, 10, &mut Silent, &CancelFlag::default(), full);
    assert_eq!(end, Err("full"));
}
