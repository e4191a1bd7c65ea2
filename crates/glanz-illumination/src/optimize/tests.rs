//! Designs with known answers.

use std::time::Duration;

use glanz_job::{CancelFlag, JobEnd, JobProgress, ProgressSink, ResourceBudget, Silent};
use glanz_math::DVec3;
use glanz_scene::Description;
use glanz_scene::SceneBuilder;
use glanz_scene::description::{
    BezierPatchesDescription, DesignDescription, GeometryDescription, LightDescription, MaterialKind,
    ReceiverSide, ShapeDescription, TargetDescription, TargetKind, VariableDescription, VariableQuantity,
};

use super::ray_model::RayModel;
use super::{OptimizeError, OptimizeOutcome, OptimizeSettings, OptimizeState, TargetMeasure, optimize};

const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// A Bézier patch over a square of the half side `half`, with the height `z` at the place of each control point.
fn patch(degree: usize, half: f64, z: impl Fn(f64, f64) -> f64) -> GeometryDescription {
    let place = |i: usize| half * (2.0 * i as f64 / degree as f64 - 1.0);
    let points = (0..=degree).flat_map(|i| (0..=degree).map(move |j| (i, j)));
    let points = points.map(|(i, j)| [place(i), place(j), z(place(i), place(j)), 1.0]).collect();
    let (degree_u, degree_v) = (degree, degree);
    GeometryDescription::BezierPatches(BezierPatchesDescription { degree_u, degree_v, patches: vec![points] })
}

fn mirror() -> MaterialKind {
    MaterialKind::mirror(1.0)
}

fn variable(quantity: VariableQuantity, direction: DVec3) -> VariableDescription {
    VariableDescription { quantity, direction, range: FREE, numbers: None }
}

fn control_point(shape: usize, point: usize) -> VariableDescription {
    variable(VariableQuantity::ControlPoints { shape, points: vec![point] }, DVec3::Z)
}

fn target(shape: usize, kind: TargetKind) -> TargetDescription {
    TargetDescription { shape, kind, weight: 1.0, location: None }
}

fn described(builder: SceneBuilder, design: DesignDescription) -> Description {
    Description { design, ..builder.describe().unwrap() }
}

/// The control points' heights of the paraboloid z = (x^2 + y^2) / (4 f) as a biquadratic patch, by the polar form of x^2: the product of the ends of an edge,
/// which is -half^2 in the middle and half^2 at both ends.
fn paraboloid(half: f64, f: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, y| {
        let square = |x: f64| if x.abs() < 0.5 * half { -half * half } else { half * half };
        (square(x) + square(y)) / (4.0 * f)
    }
}

/// A point light in the focus, 0.1 m, of a paraboloid of 0.2 x 0.2 m, whose control points are lifted by up to 4 mm; all but the corner ones are free.
fn bent_paraboloid() -> (Description, Vec<f64>) {
    let bend =
        |i: usize| if i.is_multiple_of(2) && i != 4 { 0.0 } else { 0.002 * ((i * i) as f64).sin() + 0.002 };
    let ideal = paraboloid(0.1, 0.1);
    let mut geometry = patch(2, 0.1, ideal);
    let free: Vec<usize> = vec![1, 3, 4, 5, 7];
    for &i in &free {
        geometry.control_point_mut(i).unwrap()[2] += bend(i);
    }
    let builder =
        SceneBuilder::new().shape(geometry, mirror()).light(LightDescription::point([0.0, 0.0, 0.1], 1.0));
    let design = DesignDescription {
        variables: free.iter().map(|&i| control_point(0, i)).collect(),
        targets: vec![target(0, TargetKind::Collimation { direction: DVec3::Z })],
    };
    (described(builder, design), free.iter().map(|&i| -bend(i)).collect())
}

fn run(description: &Description, settings: &OptimizeSettings) -> Result<OptimizeOutcome, OptimizeError> {
    optimize(description, settings, None, &mut Silent, &CancelFlag::default(), &ResourceBudget::default())
}

#[test]
fn bent_paraboloid_becomes_itself_again() {
    let (description, expected) = bent_paraboloid();
    let settings = OptimizeSettings { rays: 2000, ..OptimizeSettings::default() };
    let outcome = run(&description, &settings).unwrap();
    let [TargetMeasure::Collimation { angle: before }] = outcome.measures[0][..] else { panic!() };
    let [TargetMeasure::Collimation { angle: after }] = outcome.measures[1][..] else { panic!() };
    assert!(before > 0.02 && after < 1e-6, "{before} {after} {}", outcome.iterations);
    for (found, expected) in outcome.displacements.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-7, "{outcome:?} {expected}");
    }
    assert!(outcome.by_gradient && outcome.end == JobEnd::Complete);
}

/// A lamp of 4 cm below a bent mirror of 0.2 x 0.2 m, which lights a receiver of 0.6 x 0.4 m at the floor a metre below.
fn reflector(targets: Vec<TargetDescription>, variables: Vec<VariableDescription>) -> Description {
    let bent = patch(3, 0.1, |x, y| 0.05 + 0.3 * x * y - x * x + 0.1 * y);
    let receiver = ShapeDescription::rectangle([-0.3, 0.3], [-0.2, 0.2]).translated([0.1, 0.0, -1.0]);
    let lamp = ShapeDescription::disk(0.02).emitting(1.0).translated([0.01, 0.02, -0.05]);
    let builder = SceneBuilder::new()
        .shape(bent, mirror())
        .shape(receiver, MaterialKind::diffuse(0.0))
        .shape(lamp, MaterialKind::diffuse(0.0))
        .light(LightDescription::point([-0.03, 0.0, -0.04], 0.001));
    described(builder, DesignDescription { variables, targets })
}

#[test]
fn gradient_agrees_with_differences() {
    let sideways = VariableQuantity::ControlPoints { shape: 0, points: vec![0, 3, 15] };
    let variables = vec![
        control_point(0, 5),
        control_point(0, 2),
        variable(sideways, DVec3::new(0.6, 0.0, 0.8)),
        variable(VariableQuantity::ShapeOffset { shape: 0 }, DVec3::Y),
        variable(VariableQuantity::ShapeOffset { shape: 2 }, DVec3::X),
        variable(VariableQuantity::LightPosition { light: 0 }, DVec3::Z),
    ];
    let values = TargetKind::Values { cells: [2, 2], values: vec![1.0, 2.0, 0.0, 1.0] };
    let targets = vec![
        target(1, TargetKind::Even { margin: 0.1 }),
        target(1, values),
        target(1, TargetKind::Peak),
        target(1, TargetKind::Flux),
        TargetDescription { weight: 3.0, ..target(0, TargetKind::Collimation { direction: DVec3::NEG_Z }) },
    ];
    for only in 0..=targets.len() {
        let own = targets.get(only).map_or(targets.clone(), |target| vec![target.clone()]);
        let model =
            RayModel::new(&reflector(own, variables.clone()), 3000, 1, &ResourceBudget::default()).unwrap();
        let at = [0.003, -0.002, 0.001, 0.004, -0.002, 0.001];
        let value = model.value(&at, true);
        for (i, slope) in value.gradient.iter().enumerate() {
            // The error of central differences falls with the square of the step, that of rounding grows with its inverse.
            let shifted = |h: f64| {
                let mut moved = at;
                moved[i] += h;
                model.value(&moved, false).merit
            };
            let h = 2e-6;
            let difference = (shifted(h) - shifted(-h)) / (2.0 * h);
            let size = value.gradient.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            assert!((slope - difference).abs() < 1e-6 * size, "{only} {i}: {slope} {difference}");
        }
    }
}

#[test]
fn flux_on_a_receiver_is_that_of_the_image_of_the_lamp() {
    // A point 0.5 m above a mirror of 2 x 2 m lights a square of the side 1 m, 1 m above the mirror and facing it, like one 0.5 m below it.
    let flat = ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let facing = ShapeDescription::rectangle([-0.5, 0.5], [-0.5, 0.5]).translated([0.0, 0.0, 1.0]).reversed();
    let builder = SceneBuilder::new()
        .shape(flat, mirror())
        .shape(facing, MaterialKind::diffuse(0.0))
        .light(LightDescription::point([0.0, 0.0, 0.5], 1.0));
    let design = DesignDescription {
        variables: vec![variable(VariableQuantity::LightPosition { light: 0 }, DVec3::Z)],
        targets: vec![target(1, TargetKind::Flux)],
    };
    let model = RayModel::new(&described(builder, design), 1 << 14, 0, &ResourceBudget::default()).unwrap();
    // The solid angle of a rectangle with the half sides a, a from a distance d is 4 asin(a^2 / (a^2 + d^2)).
    let expected = (0.25_f64 / (0.25 + 2.25)).asin() / std::f64::consts::PI;
    let TargetMeasure::Flux { share } = model.value(&[0.0], false).measures[0] else { panic!() };
    assert!((share / expected - 1.0).abs() < 0.006, "{share} {expected}");
    // 0.2 m higher, the image is 0.2 m lower.
    let expected = (0.25_f64 / (0.25 + 2.89)).asin() / std::f64::consts::PI;
    let TargetMeasure::Flux { share } = model.value(&[0.2], false).measures[0] else { panic!() };
    assert!((share / expected - 1.0).abs() < 0.006, "{share} {expected}");
}

/// A small lamp that faces a flat mirror of 0.2 x 0.2 m from 5 cm below lights a rectangle on the floor behind it; control points move in mirror symmetric groups.
fn flat_start(degree: usize, cells: [u32; 2]) -> Description {
    let flat = patch(degree, 0.1, |_, _| 0.0);
    let mut receiver = ShapeDescription::rectangle([-0.5, 0.5], [-0.35, 0.35])
        .translated([0.0, 0.0, -1.0])
        .receiver("floor");
    receiver.receiver.as_mut().unwrap().cells = Some(cells);
    let lamp = ShapeDescription::disk(0.002).emitting(100.0).translated([0.0, 0.0, -0.05]);
    let builder = SceneBuilder::new()
        .shape(flat, mirror())
        .shape(receiver, MaterialKind::diffuse(0.0))
        .shape(lamp, MaterialKind::diffuse(0.0));
    let n = degree + 1;
    let half = n.div_ceil(2);
    let groups = (0..half).flat_map(|i| (0..half).map(move |j| (i, j)));
    let variables = groups.map(|(i, j)| {
        let mut points =
            vec![i * n + j, (degree - i) * n + j, i * n + degree - j, (degree - i) * n + degree - j];
        points.sort_unstable();
        points.dedup();
        variable(VariableQuantity::ControlPoints { shape: 0, points }, DVec3::Z)
    });
    let design = DesignDescription {
        variables: variables.collect(),
        targets: vec![target(1, TargetKind::Even { margin: 0.05 })],
    };
    described(builder, design)
}

#[test]
fn flat_mirror_is_bent_until_it_lights_a_rectangle_evenly() {
    let settings = OptimizeSettings { rays: 6000, iterations: 150, ..OptimizeSettings::default() };
    let description = flat_start(6, [10, 7]);
    let outcome = run(&description, &settings).unwrap();
    let [TargetMeasure::Distribution { deviation: before, share: small }] = outcome.measures[0][..] else {
        panic!()
    };
    let [TargetMeasure::Distribution { deviation, share }] = outcome.measures[1][..] else { panic!() };
    assert!(
        before > 0.8 && small < 0.25 && deviation < 0.2 && share > 0.7,
        "{before} {small} {deviation} {share}"
    );
}

/// Collects the states, and cancels after a number of steps.
struct Recorder {
    states: Vec<OptimizeState>,
    steps: u64,
    last: u64,
    cancel: CancelFlag,
}

impl ProgressSink<OptimizeState> for Recorder {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.steps = progress.count.unwrap().done;
        if self.steps == self.last {
            self.cancel.cancel();
        }
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        Some(Duration::ZERO)
    }

    fn on_checkpoint(&mut self, state: &OptimizeState) {
        self.states.push(state.clone());
    }
}

#[test]
fn interrupted_search_returns_its_best_and_resumes_to_the_same_bits() {
    // Two levels of cells do not count in the first two rounds, then one.
    let description = flat_start(4, [28, 20]);
    let settings = OptimizeSettings { rays: 1000, iterations: 130, seed: 5, ..OptimizeSettings::default() };
    let whole = run(&description, &settings).unwrap();
    let cancel = CancelFlag::default();
    let mut recorder = Recorder { states: Vec::new(), steps: 0, last: 75, cancel: cancel.clone() };
    let broken =
        optimize(&description, &settings, None, &mut recorder, &cancel, &ResourceBudget::default()).unwrap();
    assert_eq!((broken.end, recorder.steps), (JobEnd::Interrupted, 75));
    // Better than the scene, and than the beginning of the round that was broken off.
    assert_eq!(recorder.states.last(), Some(&broken.state));
    assert!(broken.merit[1] < broken.merit[0] && broken.displacements != broken.state.displacements);
    let resumed = optimize(
        &description,
        &settings,
        Some(broken.state),
        &mut Silent,
        &CancelFlag::default(),
        &ResourceBudget::default(),
    );
    assert_eq!(resumed.unwrap(), whole);
}

#[test]
fn lamp_moves_to_the_focus_and_a_radius_is_found_without_derivatives() {
    // A spherical mirror has its focus near half of its radius: the lamp begins 8 mm beside it and 1 cm too high.
    let scene = |design: DesignDescription| {
        let bowl = ShapeDescription::sphere(1.0).translated([0.0, 0.0, 1.0]);
        let bowl = match bowl.geometry {
            GeometryDescription::Sphere { radius, phi_max, .. } => {
                let geometry = GeometryDescription::Sphere { radius, z: [-1.0, -0.995], phi_max };
                ShapeDescription { geometry, ..bowl }
            }
            _ => bowl,
        };
        let builder =
            SceneBuilder::new().shape(bowl, mirror()).light(LightDescription::point([0.008, 0.0, 0.51], 1.0));
        described(builder, design)
    };
    let collimation = || vec![target(0, TargetKind::Collimation { direction: DVec3::Z })];
    let lamp = |direction| variable(VariableQuantity::LightPosition { light: 0 }, direction);
    let settings = OptimizeSettings { rays: 500, iterations: 300, seed: 1, ..OptimizeSettings::default() };
    let variables = vec![lamp(DVec3::X), lamp(DVec3::Z)];
    let moved = run(&scene(DesignDescription { variables, targets: collimation() }), &settings).unwrap();
    assert!(moved.by_gradient && (moved.displacements[0] + 0.008).abs() < 1e-4, "{moved:?}");
    assert!((moved.displacements[1] + 0.01).abs() < 2e-3, "{moved:?}");

    let radius = VariableDescription {
        range: [-0.05, 0.2],
        ..variable(VariableQuantity::Radius { shape: 0 }, DVec3::ZERO)
    };
    let bounded = |variable| VariableDescription { range: [-0.02, 0.02], ..variable };
    let variables = vec![bounded(lamp(DVec3::X)), radius];
    let mut wider = scene(DesignDescription { variables, targets: collimation() });
    // The whole bowl scales: its bottom stays where the lamp is half a radius above it.
    wider.world.shapes[0].geometry = match wider.world.shapes[0].geometry {
        GeometryDescription::Sphere { radius, phi_max, .. } => {
            GeometryDescription::Paraboloid { radius: 0.1 * radius, z: [0.0, 0.005], phi_max }
        }
        _ => panic!(),
    };
    wider.world.shapes[0].to_parent = glanz_math::DMat4::IDENTITY;
    // z = h r^2 / R^2 has the focal length R^2 / (4 h): 0.51 m for R = 0.101 m.
    let found = run(&wider, &settings).unwrap();
    assert!(!found.by_gradient && (found.displacements[0] + 0.008).abs() < 1e-5, "{found:?}");
    assert!((found.displacements[1] - ((4.0 * 0.005 * 0.51_f64).sqrt() - 0.1)).abs() < 1e-5, "{found:?}");
}

#[test]
fn displacements_into_the_dark_are_given_up() {
    // A ball around the focus of the paraboloid: where the light would be parallel, none leaves the lamp.
    let builder = SceneBuilder::new()
        .shape(patch(2, 0.1, paraboloid(0.1, 0.1)), mirror())
        .shape(ShapeDescription::sphere(0.005).translated([0.0, 0.0, 0.1]), MaterialKind::diffuse(0.0))
        .light(LightDescription::point([0.01, 0.0, 0.1], 1.0));
    let design = DesignDescription {
        variables: vec![variable(VariableQuantity::LightPosition { light: 0 }, DVec3::X)],
        targets: vec![target(0, TargetKind::Collimation { direction: DVec3::Z })],
    };
    let description = described(builder, design);
    let model = RayModel::new(&description, 500, 0, &ResourceBudget::default()).unwrap();
    let mut dark = model.clone();
    dark.refresh(&description, &[-0.01]).unwrap();
    // With the shadows of the beginning, the focus is ideal; with its own, it is the worst.
    assert!(model.value(&[-0.01], false).merit < 1e-12);
    assert_eq!(dark.value(&[-0.01], true).merit, 4.0);
    assert_eq!(dark.value(&[-0.01], true).gradient, [0.0]);
    let settings = OptimizeSettings { rays: 500, iterations: 100, ..OptimizeSettings::default() };
    let outcome = run(&description, &settings).unwrap();
    assert_eq!(outcome.end, JobEnd::Complete);
    assert!(outcome.merit[1] <= outcome.merit[0] && outcome.merit[1] > 0.0, "{outcome:?}");
}

#[test]
fn all_patches_of_a_lamp_move_with_it() {
    let corners = |x: f64| [[x, 0.0], [x, 0.02], [x + 0.02, 0.0], [x + 0.02, 0.02]];
    let points = |x: f64| corners(x).map(|[x, y]| [x, y, 0.0, 1.0]).to_vec();
    let patches =
        BezierPatchesDescription { degree_u: 1, degree_v: 1, patches: vec![points(-0.03), points(0.01)] };
    let lamp = ShapeDescription::from(GeometryDescription::BezierPatches(patches))
        .emitting(1.0)
        .translated([0.0, 0.0, -0.05]);
    let builder = SceneBuilder::new()
        .shape(patch(1, 0.1, |_, _| 0.0), mirror())
        .shape(lamp, MaterialKind::diffuse(0.0));
    let design = DesignDescription {
        variables: vec![variable(VariableQuantity::ShapeOffset { shape: 1 }, DVec3::X)],
        targets: vec![target(0, TargetKind::Collimation { direction: DVec3::NEG_Z })],
    };
    let description = described(builder, design);
    let moved =
        RayModel::new(&description, 1000, 3, &ResourceBudget::default()).unwrap().value(&[0.01], false).merit;
    let anew = RayModel::new(&description.displaced(&[0.01]), 1000, 3, &ResourceBudget::default())
        .unwrap()
        .value(&[], false)
        .merit;
    assert!((moved / anew - 1.0).abs() < 1e-12, "{moved} {anew}");

    // Its control points are not followed by rays with fixed flux.
    let mut bent = description;
    bent.design.variables = vec![control_point(1, 0)];
    let settings = OptimizeSettings { rays: 200, iterations: 1, ..OptimizeSettings::default() };
    assert!(!run(&bent, &settings).unwrap().by_gradient);
    bent.design.variables = vec![control_point(0, 0)];
    assert!(run(&bent, &settings).unwrap().by_gradient);
}

#[test]
fn receivers_count_light_on_their_side_and_are_whole_rectangles() {
    let design = || DesignDescription {
        variables: vec![variable(VariableQuantity::LightPosition { light: 0 }, DVec3::Z)],
        targets: vec![target(1, TargetKind::Flux)],
    };
    let model = |receiver: ShapeDescription, others: Vec<ShapeDescription>| {
        let flat = ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
        let mut builder = SceneBuilder::new()
            .shape(flat, mirror())
            .shape(receiver.translated([0.0, 0.0, 1.0]), MaterialKind::diffuse(0.0))
            .light(LightDescription::point([0.0, 0.0, 0.5], 1.0));
        for other in others {
            builder = builder.shape(other, MaterialKind::diffuse(0.0));
        }
        RayModel::new(&described(builder, design()), 4000, 0, &ResourceBudget::default())
    };
    let share = |receiver: ShapeDescription| {
        let TargetMeasure::Flux { share } =
            model(receiver, Vec::new()).unwrap().value(&[], false).measures[0]
        else {
            panic!()
        };
        share
    };
    // The normal u x v of the patch is that of z, away from the light.
    let mut back = ShapeDescription::from(patch(1, 0.5, |_, _| 0.0)).receiver("ceiling");
    assert_eq!(share(back.clone()), 0.0);
    back.receiver.as_mut().unwrap().side = ReceiverSide::Back;
    let expected = (0.25_f64 / (0.25 + 2.25)).asin() / std::f64::consts::PI;
    assert!((share(back.clone()) / expected - 1.0).abs() < 0.02);
    back.reverse_orientation = true;
    assert_eq!(share(back), 0.0);
    assert!(share(ShapeDescription::from(patch(1, 0.5, |_, _| 0.0)).reversed()) > 0.9 * expected);

    let skewed = ShapeDescription::parallelogram([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]);
    assert!(matches!(model(skewed, Vec::new()), Err(OptimizeError::NoRectangle { index: 0 })));
    let curved = |x: f64, y: f64| [x + 0.3 * y, y];
    let mut skewed = patch(2, 0.5, |_, _| 0.0);
    for i in 0..9 {
        let point = skewed.control_point_mut(i).unwrap();
        [point[0], point[1]] = curved(point[0], point[1]);
    }
    assert!(matches!(model(skewed.into(), Vec::new()), Err(OptimizeError::NoRectangle { index: 0 })));
    // A box covers a quarter.
    let cover = || vec![ShapeDescription::cuboid([0.0, 0.0, 0.9], [0.6, 0.6, 1.1])];
    let rectangle = ShapeDescription::rectangle([-0.5, 0.5], [-0.5, 0.5]).reversed();
    assert!(model(rectangle, cover()).is_ok());
    let disk = ShapeDescription::disk(0.5).reversed();
    assert!(matches!(model(disk, cover()), Err(OptimizeError::NoRectangle { index: 0 })));
}

#[test]
fn blocked_light_is_missing_in_the_share() {
    // A plate just below the receiver hides its right half from the light of the mirror.
    let scene = |plate: f64| {
        let facing =
            ShapeDescription::rectangle([-0.5, 0.5], [-0.5, 0.5]).translated([0.0, 0.0, 1.0]).reversed();
        let plate = ShapeDescription::rectangle([0.0, 1.0], [-1.0, 1.0]).translated([plate, 0.0, 0.99]);
        let mut receiver = facing;
        receiver.receiver = None;
        let builder = SceneBuilder::new()
            .shape(ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]), mirror())
            .shape(receiver, MaterialKind::diffuse(0.0))
            .shape(plate, MaterialKind::diffuse(0.0))
            .light(LightDescription::point([0.0, 0.0, 0.5], 1.0));
        let design = DesignDescription {
            variables: vec![variable(VariableQuantity::LightPosition { light: 0 }, DVec3::Z)],
            targets: vec![target(1, TargetKind::Even { margin: 0.0 })],
        };
        let model =
            RayModel::new(&described(builder, design), 1 << 14, 0, &ResourceBudget::default()).unwrap();
        let value = model.value(&[], false);
        let TargetMeasure::Distribution { share, .. } = value.measures[0] else { panic!() };
        (share, value.merit)
    };
    let ((open, open_merit), (half, half_merit)) = (scene(5.0), scene(0.0));
    // The line x = 0 divides the light into halves; the total stays.
    assert!((half / open - 0.5).abs() < 0.01, "{half} {open}");
    assert!(half_merit > open_merit, "{half_merit} {open_merit}");
}

#[test]
fn scenes_without_a_task_or_light_are_refused() {
    let settings = OptimizeSettings { rays: 100, ..OptimizeSettings::default() };
    let changed = |change: &dyn Fn(&mut Description)| {
        let mut description = bent_paraboloid().0;
        change(&mut description);
        run(&description, &settings).unwrap_err()
    };
    assert!(matches!(changed(&|d| d.design.variables.clear()), OptimizeError::NoVariable));
    assert!(matches!(changed(&|d| d.design.targets.clear()), OptimizeError::NoTarget));
    assert!(matches!(changed(&|d| d.lights.clear()), OptimizeError::NoLight));
    assert!(matches!(
        changed(&|d| d.lights = vec![LightDescription::point([0.0, 0.0, 0.1], 0.0)]),
        OptimizeError::NoLight
    ));
    let spot = LightDescription::spot([0.0, 0.0, 0.1], [0.0, 0.0, 0.0], [0.5, 0.4], 1.0);
    let error = changed(&|d| d.lights.push(spot.clone()));
    assert!(matches!(error, OptimizeError::Light { kind: "spot", .. }), "{error}");
    assert!(matches!(
        changed(&|d| d.materials[0] = MaterialKind::diffuse(0.5).into()),
        OptimizeError::NoReflection(_)
    ));
    let error = changed(&|d| d.design.targets = vec![target(0, TargetKind::Peak)]);
    assert!(matches!(error, OptimizeError::NoRectangle { index: 0 }), "{error}");
    let state = OptimizeState { displacements: vec![0.0; 4], ..OptimizeState::default() };
    let search = optimize(
        &bent_paraboloid().0,
        &settings,
        Some(state),
        &mut Silent,
        &CancelFlag::default(),
        &ResourceBudget::default(),
    );
    assert!(matches!(search, Err(OptimizeError::State { found: 4, expected: 5 })));
    // No ray is as good as one.
    assert!(run(&bent_paraboloid().0, &OptimizeSettings { rays: 0, iterations: 1, ..settings }).is_ok());
    // A lamp that shines away from the mirror.
    let mut dark = flat_start(2, [4, 4]);
    dark.world.shapes[2].reverse_orientation = true;
    assert!(matches!(run(&dark, &settings), Err(OptimizeError::NoReflection(_))));
}
