//! The rating of a planned room against radiosity by elements, which shares no code with particles and paths.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_illumination::planning::*;
use glanz_illumination::*;
use glanz_job::CancelFlag;
use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_math::DVec3;
use glanz_radiosity::form_factor::polygon::{from_point, in_front};
use glanz_scene::Scene;
use glanz_scene::description::LuminaireDescription;

use crate::common::traced;

/// Candela straight down of a luminaire that emits by the cosine.
const CANDELA: f64 = 800.0;

fn panel() -> LuminaireKind {
    let gammas: Vec<f64> = (0..=180).map(|i| 0.5 * f64::from(i)).collect();
    let candela = gammas.iter().map(|gamma| CANDELA * gamma.to_radians().cos().max(0.0)).collect();
    let distribution =
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], gammas, candela).unwrap();
    LuminaireKind {
        description: Arc::new(LuminaireDescription {
            name: "panel".to_owned(),
            opening: LuminousOpening { shape: OpeningShape::Rectangle, size: [0.6, 0.6, 0.0] },
            watts: 25.0,
            ..LuminaireDescription::default()
        }),
        distribution: Arc::new(distribution),
    }
}

fn plan() -> RoomPlan {
    RoomPlan {
        size: DVec3::new(6.0, 4.0, 3.0),
        reflectances: [0.7, 0.5, 0.2],
        luminaire: panel(),
        grid: [3, 2],
        height: 2.8,
        turn: 0.0,
        work_plane: 0.75,
        eye: 1.2,
        margin: 0.5,
    }
}

/// A square of a wall with its exitance.
struct Element {
    center: DVec3,
    normal: DVec3,
    corners: [DVec3; 4],
    reflectance: f64,
    exitance: f64,
}

/// Illuminance from the luminaires, whose light leaves their centres.
fn direct(lamps: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let of_lamp = |lamp: &DVec3| {
        let offset = *lamp - point;
        let r = offset.length();
        CANDELA * (offset.z / r).max(0.0) * (offset.dot(normal) / r).max(0.0) / (r * r)
    };
    lamps.iter().map(of_lamp).sum()
}

/// Illuminance from the elements.
fn reflected(elements: &[Element], point: DVec3, normal: DVec3) -> f64 {
    let of_element = |element: &Element| {
        // Counterclockwise as seen from inside of the room.
        let visible = in_front(&element.corners, point, normal);
        if visible.len() < 3 { 0.0 } else { element.exitance * from_point(point, normal, &visible) }
    };
    elements.iter().map(of_element).sum()
}

/// Elements of half a metre in balance.
fn solved(plan: &RoomPlan, lamps: &[DVec3]) -> Vec<Element> {
    let DVec3 { x, y, z } = plan.size;
    let [ceiling, wall, floor] = plan.reflectances;
    let (i, j, k) = (DVec3::X, DVec3::Y, DVec3::Z);
    let faces = [
        (DVec3::ZERO, i * x, j * y, floor),
        (k * z, j * y, i * x, ceiling),
        (DVec3::ZERO, j * y, k * z, wall),
        (i * x, k * z, j * y, wall),
        (DVec3::ZERO, k * z, i * x, wall),
        (j * y, i * x, k * z, wall),
    ];
    let mut elements = Vec::new();
    for (corner, u, v, reflectance) in faces {
        let [nu, nv] = [u, v].map(|side| (side.length() / 0.5).round() as u32);
        for (a, b) in (0..nu).flat_map(|a| (0..nv).map(move |b| (a, b))) {
            let at = |a: f64, b: f64| corner + u * (a / f64::from(nu)) + v * (b / f64::from(nv));
            let (a, b) = (f64::from(a), f64::from(b));
            let corners = [at(a, b), at(a + 1.0, b), at(a + 1.0, b + 1.0), at(a, b + 1.0)];
            let (center, normal) = (at(a + 0.5, b + 0.5), u.cross(v).normalize());
            elements.push(Element { center, normal, corners, reflectance, exitance: 0.0 });
        }
    }
    let own: Vec<f64> = elements.iter().map(|e| direct(lamps, e.center, e.normal)).collect();
    for _ in 0..12 {
        for number in 0..elements.len() {
            let (center, normal) = (elements[number].center, elements[number].normal);
            let lux = own[number] + reflected(&elements, center, normal);
            elements[number].exitance = elements[number].reflectance * lux;
        }
    }
    elements
}

#[test]
fn rating_of_a_room_agrees_with_radiosity_by_elements() {
    let plan = plan();
    let lamps: Vec<DVec3> = plan.luminaires().iter().map(|luminaire| luminaire.position).collect();
    let elements = solved(&plan, &lamps);
    let (scene, _) = Scene::resolve(plan.description().unwrap()).unwrap();
    let receivers =
        Receivers::try_new(&scene, &ReceiverRequest::of_scene(&scene, GridResolution::Longer(8))).unwrap();
    let goal = TraceGoal { particles: Some(400_000), ..TraceGoal::default() };
    let maps = traced(&scene, &receivers, goal).tally.lux_maps(&receivers);
    let mut request = plan.request();
    // A few of the points, and of the observers.
    request.points = request.points.into_iter().step_by(11).collect();
    request.observers = request.observers.into_iter().step_by(29).collect();
    let settings = PlanningSettings {
        task: LightingTask::of_reference("34.2"),
        maintenance: MaintenanceFactor::Whole(0.8),
        ..PlanningSettings::default()
    };
    let mut shares = Vec::new();
    let mut on_progress = |share| shares.push(share);
    let report = request.rate(&scene, &maps, &settings, &mut on_progress, &CancelFlag::default()).unwrap();
    assert_eq!(shares.last(), Some(&1.0));
    let near = |what: &str, found: f64, expected: f64, tolerance: f64| {
        assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, {expected}");
    };

    for map in &maps {
        let normal = match map.name.as_str() {
            "floor" | "work plane" => DVec3::Z,
            "ceiling" => DVec3::NEG_Z,
            "wall x=0" => DVec3::X,
            "wall x=6" => DVec3::NEG_X,
            "wall y=0" => DVec3::Y,
            _ => DVec3::NEG_Y,
        };
        let lux = |p: &DVec3| direct(&lamps, *p, normal) + reflected(&elements, *p, normal);
        let mean = map.positions.iter().map(lux).sum::<f64>() / map.positions.len() as f64;
        // The middles of cells instead of their means.
        near(&map.name, map.summary().mean, mean, 0.015);
    }
    let of = |zone: &str, criterion| {
        let verdict = report.verdicts.iter().find(|v| v.zone == zone && v.requirement.criterion == criterion);
        verdict.unwrap_or_else(|| panic!("{zone}"))
    };
    let em = of("work plane", LightingCriterion::MeanIlluminance);
    assert_eq!(em.value, 0.8 * maps[6].summary().mean);
    assert_eq!(em.outcome, VerdictOutcome::NotMet);
    assert_eq!(of("wall x=0", LightingCriterion::MeanIlluminance).outcome, VerdictOutcome::Met);

    let mut largest = f64::NEG_INFINITY;
    assert_eq!(report.ratings.len(), 7);
    for rating in &report.ratings {
        let (eye, view) = (rating.observer.eye(), rating.observer.view());
        let background = reflected(&elements, eye, view) / PI;
        near("background", rating.background.value, background, 0.03);
        let [low, high] = rating.background.interval;
        assert!(low < 1.01 * background && high > 0.99 * background, "{rating:?}, {background}");
        // The sum over luminaires of L^2 omega / p^2, with the constant luminance I / A of a luminaire that emits by the cosine.
        let mut glare = 0.0;
        for lamp in &lamps {
            let offset = *lamp - eye;
            let (r, along) = (offset.length(), offset.dot(view));
            let side = offset.cross(view).z.abs();
            if along <= 0.0 || side > 3.0 * along || offset.z > 2.0 * along {
                continue;
            }
            let sigma = (along / r).acos().to_degrees();
            let tau = (side / offset.z).atan().to_degrees();
            let p = ((35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp()) * 1e-3 * sigma
                + (21.0 + 0.26667 * tau - 0.002963 * tau * tau) * 1e-5 * sigma * sigma)
                .exp();
            let omega = 0.36 * (offset.z / r) / (r * r);
            glare += (CANDELA / 0.36 / p).powi(2) * omega;
        }
        if glare == 0.0 {
            assert_eq!(rating.ugr(), None);
            continue;
        }
        let ugr = 8.0 * (0.25 * glare / background).log10();
        assert!((rating.ugr().unwrap() - ugr).abs() < 0.1, "{rating:?}, {ugr}");
        largest = largest.max(ugr);
    }
    assert!(largest > 10.0 && (report.largest_ugr().0 - largest).abs() < 0.1, "{largest}");

    for point in &report.cylindrical {
        // By definition: the mean over the vertical planes of all azimuths.
        let azimuths = 48;
        let vertical = |n: u32| {
            let (sin, cos) = (2.0 * PI * (f64::from(n) + 0.5) / f64::from(azimuths)).sin_cos();
            let normal = DVec3::new(cos, sin, 0.0);
            direct(&lamps, point.position, normal) + reflected(&elements, point.position, normal)
        };
        let cylindrical = 0.8 * (0..azimuths).map(vertical).sum::<f64>() / f64::from(azimuths);
        near("cylinder", point.cylindrical.value, cylindrical, 0.02);
        let horizontal =
            0.8 * (direct(&lamps, point.position, DVec3::Z) + reflected(&elements, point.position, DVec3::Z));
        near("horizontal", point.horizontal.value, horizontal, 0.02);
    }
    let text = report.fact_table().plain() + &report.verdict_table().plain();
    for part in ["power per area, W/m2", "6.250", "not met", "UGR", "34.2"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["facts"]["maintenance_factor"], 0.8);
    assert_eq!(json["verdicts"][0]["outcome"], "not_met");
    assert_eq!(json["verdicts"][0]["criterion"], "mean_illuminance");
}

#[test]
fn glare_of_luminaires_without_an_opening_is_refused_and_undecided() {
    let mut plan = plan();
    plan.luminaire.description =
        Arc::new(LuminaireDescription { name: "panel".to_owned(), ..LuminaireDescription::default() });
    let (scene, _) = Scene::resolve(plan.description().unwrap()).unwrap();
    let mut request = plan.request();
    request.points.clear();
    let settings = PlanningSettings {
        task: LightingTask::of_reference("34.1"),
        directions: 16,
        ..PlanningSettings::default()
    };
    let report = request.rate(&scene, &[], &settings, &mut |_| {}, &CancelFlag::default()).unwrap();
    let glare =
        |verdict: &&RequirementVerdict| verdict.requirement.criterion == LightingCriterion::GlareRating;
    let verdicts: Vec<&RequirementVerdict> = report.verdicts.iter().filter(glare).collect();
    let [verdict] = verdicts.as_slice() else { panic!("{:?}", report.verdicts) };
    assert_eq!(verdict.outcome, VerdictOutcome::Undecided);
    assert!(report.glare_refusal.as_ref().unwrap().contains("panel has no luminous area"));
    assert!(report.fact_table().plain().contains("no luminous area"));
}
