//! Selection of lights from points: probabilities, and the light that is found with them.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glanz_geometry::bezier::TensorPatch;
use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::statistics::chi_square;
use glanz_scene::description::*;
use glanz_scene::{Interaction, LightId, LightSampleContext, MAX_LIGHT_GROUPS, Scene, SceneBuilder};

/// A sequence of random numbers.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = combine(self.0, 1);
        unit_f64(self.0)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn pair(&mut self) -> DVec2 {
        DVec2::new(self.next(), self.next())
    }

    fn point(&mut self, size: f64) -> DVec3 {
        size * DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = (TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    fn turned(&mut self) -> DMat4 {
        DMat4::from_axis_angle(self.direction(), TAU * self.next())
    }
}

fn bright(light: Spectrum) -> f64 {
    f64::from(light.mean(&Wavelengths::default()))
}

fn luminaire(polars: [f64; 4], candela: [f64; 8], opening: Option<LuminousOpening>) -> LightKind {
    let distribution = IntensityDistribution::try_new(
        AngularSystem::C,
        Symmetry::None,
        &[0.0, 180.0],
        polars.to_vec(),
        candela.to_vec(),
    );
    LightKind::Photometric { distribution: Arc::new(distribution.unwrap()), opening, from: DVec3::ZERO }
}

/// Lights of all kinds, apart from the infinitely far ones, about the origin.
fn kinds(numbers: &mut Numbers) -> Vec<LightKind> {
    let spot = |cone_angle, inner_angle| LightKind::Spot {
        from: DVec3::ZERO,
        to: DVec3::X,
        cone_angle,
        inner_angle,
        falloff: SpotFalloff::Smoothstep,
    };
    let opening = |shape| Some(LuminousOpening { shape, size: [0.5, 0.2, 0.3] });
    let down = [0.0, 30.0, 60.0, 80.0];
    vec![
        LightKind::Point { from: DVec3::ZERO, range: None },
        LightKind::Point { from: DVec3::ZERO, range: Some(numbers.between(0.5, 3.0)) },
        spot(numbers.between(0.01, PI), 0.0),
        spot(numbers.between(0.2, 1.0), 0.2),
        spot(PI, 1.0),
        luminaire(down, [9.0, 4.0, 2.0, 0.0, 9.0, 5.0, 0.0, 0.0], None),
        luminaire([120.0, 140.0, 160.0, 180.0], [0.0, 4.0, 2.0, 0.0, 0.0, 5.0, 1.0, 1.0], None),
        luminaire(down, [9.0, 4.0, 2.0, 0.0, 9.0, 5.0, 0.0, 0.0], opening(OpeningShape::Box)),
        luminaire([60.0, 90.0, 120.0, 150.0], [1.0; 8], opening(OpeningShape::VerticalCylinder)),
        luminaire([0.0, 90.0, 120.0, 180.0], [1.0; 8], opening(OpeningShape::Ellipsoid)),
    ]
}

/// Surfaces of all forms that can be sampled, about the origin.
fn surfaces() -> Vec<ShapeDescription> {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.8)];
    let patch = TensorPatch::try_from_points(1, 1, &corners, None).unwrap();
    let bilinear = GeometryDescription::Bilinear { positions: corners.to_vec(), indices: vec![[0, 1, 2, 3]] };
    let degenerate = [DVec3::ZERO, DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.8)];
    let degenerate =
        GeometryDescription::Bilinear { positions: degenerate.to_vec(), indices: vec![[0, 1, 2, 3]] };
    let roof = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.8), DVec3::new(2.0, 0.0, 0.5)];
    vec![
        ShapeDescription::disk(0.4),
        ShapeDescription::rectangle([-0.3, 0.3], [-0.1, 0.2]),
        ShapeDescription::mesh(roof[..3].to_vec(), vec![[0, 1, 2]]),
        ShapeDescription::mesh(roof, vec![[0, 1, 2], [1, 3, 2], [1, 4, 3], [0, 0, 1]]),
        bilinear.into(),
        degenerate.into(),
        ShapeDescription::bezier_patches(&[patch]),
        ShapeDescription::sphere(0.3),
        ShapeDescription::cylinder(0.1, [0.0, 1.0]),
        ShapeDescription::torus(0.4, 0.1),
        ShapeDescription::cuboid([0.0; 3], [0.3, 0.2, 0.1]),
    ]
}

/// About `count` lights of all kinds within 10 m, and `distant` ones.
fn mixed(count: usize, distant: bool, numbers: &mut Numbers) -> Scene {
    let mut builder = SceneBuilder::new();
    let mut number = 0;
    while number < count {
        let kinds = kinds(numbers).into_iter().map(|kind| LightDescription::new(kind, 1.0));
        let lights: Vec<_> = kinds.collect();
        for light in lights {
            let (to_world, scale) =
                (DMat4::from_translation(numbers.point(10.0)) * numbers.turned(), numbers.next() as f32);
            builder = builder.light(LightDescription { to_world, scale, ..light });
            number += 1;
        }
        for mut shape in surfaces() {
            if numbers.next() < 0.5 {
                shape = shape.reversed();
            }
            let sizes = DVec3::from_array(std::array::from_fn(|_| numbers.between(0.3, 1.0)));
            let mirrored = if numbers.next() < 0.5 { 1.0 } else { -1.0 };
            let to_world = DMat4::from_translation(numbers.point(10.0))
                * numbers.turned()
                * DMat4::from_scale(DVec3::new(mirrored * sizes.x, sizes.y, sizes.z));
            let emission =
                EmissionDescription { two_sided: numbers.next() < 0.3, ..(numbers.next() as f32).into() };
            builder =
                builder.shape(shape.emitting(emission).transformed(to_world), MaterialKind::diffuse(0.0));
            number += 1;
        }
    }
    if distant {
        let (from, to) = (DVec3::new(1.0, -2.0, 3.0), DVec3::ZERO);
        for kind in [
            LightKind::Distant { from, to },
            LightKind::Distant { from: -from, to },
            LightKind::Sun { from, to, angular_radius: 0.1 },
            LightKind::Sun { from: to, to: from, angular_radius: 1.5 },
            LightKind::Infinite,
        ] {
            builder = builder.light(LightDescription::new(kind, 0.01));
        }
    }
    builder.resolve().unwrap().0
}

/// A point of a surface with this position and normal, seen from its front.
fn receiver(position: DVec3, normal: DVec3) -> Interaction {
    let plate = SceneBuilder::new().shape(ShapeDescription::disk(1.0), MaterialKind::diffuse(0.5));
    let scene = plate.resolve().unwrap().0;
    let mut at = scene.intersect(&Ray::new(DVec3::Z, -DVec3::Z), f64::INFINITY).unwrap();
    (at.point.position, at.point.error) = (position, DVec3::ZERO);
    (at.point.normal, at.point.shading_normal, at.wo) = (normal, normal, normal);
    at
}

fn context(at: &Interaction) -> LightSampleContext {
    LightSampleContext { normal: Some(at.point.normal), ..at.light_sample_context() }
}

fn ids(scene: &Scene) -> impl Iterator<Item = LightId> + use<> {
    (0..scene.lights().len() as u32).map(LightId)
}

#[test]
fn light_that_arrives_has_a_probability() {
    let mut numbers = Numbers(1);
    let mut arrived = 0;
    for count in [1, 60, 600] {
        let scene = mixed(count, true, &mut numbers);
        for _ in 0..200 {
            // Some points are close to a light.
            let at = receiver(numbers.point(12.0), numbers.direction());
            let from = context(&at);
            for id in ids(&scene) {
                let both = scene.light_probability(id, &at.light_sample_context());
                let front = scene.light_probability(id, &from);
                for _ in 0..2 {
                    let Some(sample) = scene.sample_light(id, &at, numbers.pair()) else { continue };
                    if sample.radiance.is_black() {
                        continue;
                    }
                    arrived += 1;
                    assert!(both > 0.0, "{:?}", scene.light(id));
                    assert!(front > 0.0 || at.point.normal.dot(sample.wi) <= 0.0, "{:?}", scene.light(id));
                }
            }
        }
    }
    assert!(arrived > 100_000, "{arrived}");
}

#[test]
fn points_on_the_horizon_of_lights_have_a_probability() {
    // Light that leaves or arrives almost along the surface, down to angles of rounding.
    let disk = ShapeDescription::disk(0.5).emitting(EmissionDescription::from(1.0));
    let other =
        ShapeDescription::disk(0.5).emitting(EmissionDescription::from(1.0)).translated([0.0, 0.0, 50.0]);
    let scene = SceneBuilder::new().shapes([disk, other], MaterialKind::diffuse(0.0)).resolve().unwrap().0;
    let mut numbers = Numbers(2);
    for angle in (1..50).map(|power| 0.5_f64.powi(power)) {
        let at = receiver(DVec3::new(3.0, 0.0, angle), -DVec3::X);
        let flat = receiver(DVec3::new(0.3, 0.1, 2.0), DVec3::new(1.0, 0.0, -angle).normalize());
        for at in [at, flat] {
            let sampled = (0..100).filter_map(|_| scene.sample_light(LightId(0), &at, numbers.pair()));
            let arrives = sampled.into_iter().any(|sample| at.point.normal.dot(sample.wi) > 0.0);
            assert!(!arrives || scene.light_probability(LightId(0), &context(&at)) > 0.0, "{angle}");
        }
    }
}

#[test]
fn light_through_the_nearer_of_two_windows_is_selected() {
    // Squares of 2 m side, through which light goes inwards at x = -5 and x = 5.
    let window = |corner: DVec3, to_second: DVec3, to_last: DVec3| {
        let portal = [corner, corner + to_second, corner + to_second + to_last, corner + to_last];
        LightDescription::new(LightKind::PortalInfinite { image: None, portal }, 1.0)
    };
    let (y, z) = (2.0 * DVec3::Y, 2.0 * DVec3::Z);
    let [left, right] =
        [window(DVec3::new(-5.0, -1.0, -1.0), y, z), window(DVec3::new(5.0, -1.0, -1.0), z, y)];
    let scene = SceneBuilder::new().light(left).light(right).resolve().unwrap().0;
    let probabilities = |x: f64| {
        let from = receiver(DVec3::new(x, 0.2, 0.3), DVec3::Z).light_sample_context();
        [LightId(0), LightId(1)].map(|id| scene.light_probability(id, &from))
    };
    // By the squared distances 2 and 81, and a share of 0.1 for both.
    assert!(probabilities(-4.0)[0] > 0.9, "{:?}", probabilities(-4.0));
    assert!(probabilities(4.0)[1] > 0.9);
    // Behind a window none of its light arrives, which shows outside of the sphere around it.
    assert_eq!(probabilities(-7.5), [0.0, 1.0]);
    let mut numbers = Numbers(9);
    let mut arrived = 0;
    for _ in 0..2000 {
        let at = receiver(numbers.point(8.0), numbers.direction());
        for id in ids(&scene) {
            let Some(sample) = scene.sample_light(id, &at, numbers.pair()) else { continue };
            arrived += 1;
            assert!(scene.light_probability(id, &at.light_sample_context()) > 0.0);
            let is_lit = at.point.normal.dot(sample.wi) > 0.0;
            assert!(!is_lit || scene.light_probability(id, &context(&at)) > 0.0);
        }
    }
    assert!(arrived > 2000, "{arrived}");
}

#[test]
fn probabilities_add_up_to_one() {
    let mut numbers = Numbers(3);
    // Lights at random, of which each shines on few points: bounds of many include points that those of each exclude.
    for (count, distant, least) in [(1, false, 0.9), (1, true, 0.9), (100, false, 0.98), (1000, true, 0.98)] {
        let scene = mixed(count, distant, &mut numbers);
        let mut total = 0.0;
        for _ in 0..50 {
            let at = receiver(numbers.point(12.0), numbers.direction());
            let sum: f64 =
                ids(&scene).map(|id| scene.light_probability(id, &at.light_sample_context())).sum();
            assert!(sum < 1.0 + 1e-12, "{count}: {sum}");
            total += sum;
            let groups = scene.light_group_probabilities(&context(&at));
            let all: f64 = groups.iter().sum();
            // Nothing arrives on the backs of all lights.
            assert!((all - 1.0).abs() < 1e-12 || all == 0.0, "{all}");
            assert!(groups[scene.light_group_count()..].iter().all(|&probability| probability == 0.0));
        }
        assert!(total > 50.0 * least, "{count}: {total}");
    }
    // Lights that are groups of their own.
    let spots = (0..MAX_LIGHT_GROUPS).map(|_| {
        let from = numbers.point(10.0);
        LightDescription::spot(from, from + numbers.direction(), [1.0, 0.5], 1.0)
    });
    let scene = spots
        .collect::<Vec<_>>()
        .into_iter()
        .fold(SceneBuilder::new(), SceneBuilder::light)
        .resolve()
        .unwrap()
        .0;
    let mut lit = 0;
    for _ in 0..1000 {
        let from = context(&receiver(numbers.point(12.0), numbers.direction()));
        let sum: f64 = ids(&scene).map(|id| scene.light_probability(id, &from)).sum();
        assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-12, "{sum}");
        assert_eq!(sum > 0.0, scene.select_light(&from, 0.3).is_some());
        lit += u32::from(sum > 0.0);
    }
    assert!((500..1000).contains(&lit), "{lit}");
}

#[test]
fn selection_follows_the_probabilities() {
    let mut numbers = Numbers(4);
    let n = 100_000;
    for (count, distant, by_groups) in
        [(1, true, false), (60, false, false), (1000, true, false), (1000, true, true)]
    {
        let scene = mixed(count, distant, &mut numbers);
        let at = receiver(numbers.point(8.0), numbers.direction());
        let from = context(&at);
        // Any weights, of which some vanish.
        let weights: [f64; MAX_LIGHT_GROUPS] =
            std::array::from_fn(|group| (group % 3) as f64 * numbers.next());
        let probability = |id| match by_groups {
            true => scene.light_probability_by_groups(id, &from, &weights),
            false => scene.light_probability(id, &from),
        };
        let mut expected: Vec<f64> = ids(&scene).map(probability).collect();
        let none = (1.0 - expected.iter().sum::<f64>()).max(0.0);
        expected.push(if none < 1e-12 { 0.0 } else { none });
        let mut observed = vec![0; expected.len()];
        for i in 0..n {
            let xi = unit_f64(combine(5, i));
            let selected = match by_groups {
                true => scene.select_light_by_groups(&from, &weights, xi),
                false => scene.select_light(&from, xi),
            };
            let Some(selected) = selected else {
                observed[expected.len() - 1] += 1;
                continue;
            };
            assert_eq!(selected.probability, expected[selected.id.0 as usize]);
            assert_eq!(scene.light_group(selected.id), Some(selected.group));
            observed[selected.id.0 as usize] += 1;
        }
        let expected: Vec<f64> = expected.iter().map(|p| p * n as f64).collect();
        let test = chi_square(&observed, &expected);
        assert!(test.p_value > 0.001, "{count}: {test:?}");
    }
}

#[test]
fn a_single_light_is_always_selected() {
    let disk = || ShapeDescription::disk(0.4).emitting(EmissionDescription::from(1.0));
    let scene = SceneBuilder::new().shape(disk(), MaterialKind::diffuse(0.0)).resolve().unwrap().0;
    // Also from behind.
    let from = context(&receiver(-DVec3::Z, -DVec3::Z));
    let selected = scene.select_light(&from, 0.7).unwrap();
    assert_eq!((selected.id, selected.probability), (LightId(0), 1.0));
    assert_eq!(scene.light_probability(LightId(0), &from), 1.0);
    assert_eq!((scene.light_group_count(), scene.is_selectable(LightId(0))), (1, true));
    assert!(!scene.is_selectable(LightId(1)));
    let empty = SceneBuilder::new().resolve().unwrap().0;
    assert!(empty.select_light(&from, 0.5).is_none() && empty.light_probability(LightId(0), &from) == 0.0);
}

#[test]
fn lights_at_one_place_are_told_apart() {
    let light = |i: u32| LightDescription::point([1.0, 2.0, 3.0], 1.0 + i as f32);
    let scene = (0..500).map(light).fold(SceneBuilder::new(), SceneBuilder::light).resolve().unwrap().0;
    let from = context(&receiver(DVec3::ZERO, DVec3::Z));
    let all: Vec<f64> = ids(&scene).map(|id| scene.light_probability(id, &from)).collect();
    assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(all.iter().all(|&probability| probability > 0.0));
}

/// Mean and variance of the irradiance at points of the floor by one light each, selected from the point or by power alone, relative to the exact value.
fn estimates(scene: &Scene, by_power: bool) -> [f64; 2] {
    let mut numbers = Numbers(6);
    let (mut sum, mut squares) = (0.0, 0.0);
    const PLACES: u32 = 200;
    const SAMPLES: u32 = 50;
    for _ in 0..PLACES {
        let at = receiver(DVec3::new(numbers.between(0.0, 20.0), numbers.between(0.0, 20.0), 0.0), DVec3::Z);
        let light = |id, xi| {
            let sample = scene.sample_light(id, &at, xi)?;
            Some(bright(sample.radiance) * sample.wi.z.max(0.0) / sample.pdf.0)
        };
        let exact: f64 = ids(scene).filter_map(|id| light(id, DVec2::splat(0.5))).sum();
        for _ in 0..SAMPLES {
            let xi = numbers.next();
            let selected = match by_power {
                true => scene.select_emitter(xi),
                false => {
                    scene.select_light(&context(&at), xi).map(|selected| (selected.id, selected.probability))
                }
            };
            let estimate =
                selected.and_then(|(id, probability)| Some(light(id, numbers.pair())? / probability));
            let relative = estimate.unwrap_or(0.0) / exact;
            sum += relative;
            squares += (relative - 1.0).powi(2);
        }
    }
    [sum, squares].map(|sum| sum / f64::from(PLACES * SAMPLES))
}

#[test]
fn a_thousand_lights_have_a_tenth_of_the_variance_of_selection_by_power() {
    let mut numbers = Numbers(7);
    let mut builder = SceneBuilder::new();
    for i in 0..1000 {
        let from =
            DVec3::new(numbers.between(0.0, 20.0), numbers.between(0.0, 20.0), numbers.between(1.0, 4.0));
        let intensity = 10.0_f64.powf(numbers.between(-1.0, 1.0)) as f32;
        let to = from + numbers.direction();
        builder = builder.light(match i % 2 {
            0 => LightDescription::point(from, intensity),
            _ => LightDescription::spot(from, to, [0.8, 0.6], intensity),
        });
    }
    let scene = builder.resolve().unwrap().0;
    let [[mean, variance], [mean_by_power, by_power]] =
        [false, true].map(|by_power| estimates(&scene, by_power));
    // Both are right within four standard errors.
    for (mean, variance) in [(mean, variance), (mean_by_power, by_power)] {
        assert!((mean - 1.0).abs() < 4.0 * (variance / 10_000.0).sqrt(), "{mean} {variance}");
    }
    assert!(variance < 0.1 * by_power, "{variance} {by_power}");
}
