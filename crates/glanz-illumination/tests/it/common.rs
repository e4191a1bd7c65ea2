//! Scenes for tests, and their maps.

use glanz_illumination::*;
use glanz_job::{CancelFlag, Silent};
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// Radiance, W/(m^2 sr), or intensity, W/sr, of white that is one candela per square metre or one candela.
pub(crate) const CANDELA: f32 = 1.0 / 683.0;

pub(crate) fn diffuse(reflectance: f32) -> MaterialKind {
    MaterialKind::diffuse(reflectance)
}

pub(crate) fn mirror(reflectance: f32) -> MaterialKind {
    MaterialKind::mirror(reflectance)
}

/// The rectangle of these lengths about the origin, facing +z.
pub(crate) fn rectangle(x: f64, y: f64) -> ShapeDescription {
    ShapeDescription::rectangle([-0.5 * x, 0.5 * x], [-0.5 * y, 0.5 * y])
}

/// White light of this luminance, cd/m^2.
pub(crate) fn candela_per_area(luminance: f32) -> EmissionDescription {
    EmissionDescription { scale: luminance, ..CANDELA.into() }
}

/// A point of white light, candela.
pub(crate) fn point_light(from: DVec3, candela: f32) -> LightDescription {
    LightDescription { scale: candela, ..LightDescription::point(from, CANDELA) }
}

pub(crate) fn resolved(builder: SceneBuilder) -> Scene {
    builder.resolve().unwrap().0
}

pub(crate) fn request(name: &str, shape: u32, fineness: GridResolution) -> ReceiverRequest {
    ReceiverRequest { name: name.into(), shape, side: ReceiverSide::Front, fineness }
}

/// Traces until the goal on all processors.
pub(crate) fn traced(scene: &Scene, receivers: &Receivers, goal: TraceGoal) -> TraceOutcome {
    let settings = TraceSettings { seed: 3, max_events: 1000, threads: 0, goal, part: None };
    let tally = Tally::new(receivers, None);
    trace(scene, receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap()
}

/// Maps of as many particles, and the balance.
pub(crate) fn maps(
    scene: &Scene,
    requests: &[ReceiverRequest],
    particles: u64,
) -> (Vec<LuxMap>, FluxBalance) {
    let receivers = Receivers::try_new(scene, requests).unwrap();
    let goal = TraceGoal { particles: Some(particles), ..TraceGoal::default() };
    let outcome = traced(scene, &receivers, goal);
    (outcome.tally.lux_maps(&receivers), outcome.tally.balance())
}

/// Mean of a function of the position over each cell of a flat map whose directions are x and y, by Gauss's rule with 4 x 4 places.
pub(crate) fn cell_means(map: &LuxMap, lux: impl Fn(DVec2) -> f64) -> Vec<f64> {
    let half =
        [map.size[0] / f64::from(map.cells[0]), map.size[1] / f64::from(map.cells[1])].map(|d| 0.5 * d);
    let nodes = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    ];
    let nodes: Vec<(f64, f64)> = nodes.iter().flat_map(|&(x, w)| [(x, 0.5 * w), (-x, 0.5 * w)]).collect();
    let mean = |p: &DVec3| {
        let mut sum = 0.0;
        for (&(x, wx), &(y, wy)) in nodes.iter().flat_map(|a| nodes.iter().map(move |b| (a, b))) {
            sum += wx * wy * lux(DVec2::new(p.x + x * half[0], p.y + y * half[1]));
        }
        sum
    };
    map.positions.iter().map(mean).collect()
}

/// Standard errors from 16 replicates within which 400 values lie with a probability of 99 %: for maps whose paths differ from run to run.
pub(crate) const ERRORS: f64 = 6.0;

/// Every cell within four standard errors of `expected`, none of which is above `most` of it.
pub(crate) fn assert_map(map: &LuxMap, expected: &[f64], most: f64) {
    assert_map_within(map, expected, most, 4.0);
}

/// As [`assert_map`], within another number of standard errors.
pub(crate) fn assert_map_within(map: &LuxMap, expected: &[f64], most: f64, errors: f64) {
    assert_eq!(map.lux.len(), expected.len());
    for (cell, &expected) in expected.iter().enumerate().filter(|(cell, _)| map.areas[*cell] > 0.0) {
        let (lux, error) = (map.lux[cell], map.errors[cell]);
        assert!(
            (lux - expected).abs() <= errors * error,
            "{} cell {cell}: {lux} +- {error}, not {expected}",
            map.name
        );
        assert!(error <= most * expected, "{} cell {cell}: {lux} +- {error}", map.name);
    }
}
