//! Tests of the pages that a client reads.

use std::sync::Arc;

use glanz_math::{DVec2, DVec3};
use glanz_report::{FactList, FactValue};
use glanz_scene::description::{LuminaireDescription, ZoneKind};

use super::html::tests::unbalanced;
use super::{LitQuantity, LuxReport};
use crate::planning::test_luminaires::{downlight, lambertian};
use crate::planning::{
    LightingCriterion, LightingTask, LuminaireGroup, MaintenanceFactor, OtherLight, PlacedLuminaire,
    PlanReport, ReceiverPlace, RequirementVerdict, RoomLayout, RoomSurface, RoomSurfaceKind,
};
use crate::{DaylightFactors, LuxMap};

fn rectangle([x, y]: [f64; 2], [w, d]: [f64; 2]) -> Vec<DVec2> {
    [[x, y], [x + w, y], [x + w, y + d], [x, y + d]].map(DVec2::from).to_vec()
}

/// A map of 12 x 8 cells whose illuminance rises from 300 lx by `slope` lx per column.
fn map(name: &str, size: [f64; 2], slope: f64) -> LuxMap {
    LuxMap {
        name: name.into(),
        cells: [12, 8],
        size,
        positions: vec![DVec3::ZERO; 96],
        areas: vec![size[0] * size[1] / 96.0; 96],
        lux: (0..96).map(|i| 300.0 + slope * f64::from(i % 12)).collect(),
        errors: vec![2.0; 96],
        statistics: None,
    }
}

fn place(number: usize, name: &str, kind: Option<ZoneKind>, is_level: bool, height: f64) -> ReceiverPlace {
    let outline = rectangle([0.5, 0.5], [5.0, 3.0]);
    ReceiverPlace {
        number,
        name: name.into(),
        kind,
        is_level,
        is_grid: true,
        frame: Some([DVec3::new(0.5, 0.5, height), DVec3::X, if is_level { DVec3::Y } else { DVec3::Z }]),
        height,
        outline,
    }
}

/// A room of 6 m x 4 m x 2.8 m with four luminaires of 36 W, named `name`, a desk and a wall.
fn report(name: &str, desk: Option<ZoneKind>) -> LuxReport {
    let description = LuminaireDescription {
        name: name.into(),
        maker: name.into(),
        file: "panel.ies".into(),
        color: "4000 K".into(),
        watts: 36.0,
        flux: 1000.0 * std::f64::consts::PI,
        ..LuminaireDescription::default()
    };
    let description = Some(Arc::new(description));
    let lamps: Vec<PlacedLuminaire> = [[1.5, 1.0], [4.5, 1.0], [1.5, 3.0], [4.5, 3.0]]
        .map(|[x, y]| PlacedLuminaire {
            description: description.clone(),
            ..downlight(lambertian(1000.0), DVec3::new(x, y, 2.8))
        })
        .to_vec();
    let surface = |surface, reflectance| RoomSurface {
        surface,
        area: 24.0,
        reflectance: Some(reflectance),
        reflectance_range: Some([reflectance; 2]),
    };
    let layout = RoomLayout {
        corners: [DVec3::ZERO, DVec3::new(6.0, 4.0, 2.8)],
        floor: vec![rectangle([0.0, 0.0], [6.0, 4.0])],
        walls: Vec::new(),
        furniture: vec![rectangle([1.0, 1.0], [1.6, 0.8])],
        furniture_left_out: 0,
        surfaces: vec![surface(RoomSurfaceKind::Floor, 0.2), surface(RoomSurfaceKind::Ceiling, 0.7)],
        receivers: vec![place(0, "desk", desk, true, 0.75), place(1, "wall", None, false, 1.4)],
        luminaires: LuminaireGroup::of(&lamps),
        other_lights: Vec::new(),
    };
    let mut facts = FactList::default();
    facts.push("Glanz version", "glanz_version", "1.2.3");
    facts.push("scene", "scene", name);
    facts.push("method", "method", "auto");
    facts.push("end, UTC", "end_utc", "2026-11-26T16:05:00Z");
    LuxReport {
        title: name.into(),
        maps: vec![map("desk", [5.0, 3.0], 20.0), map("wall", [4.0, 2.8], 0.0)],
        layout: Some(layout),
        facts,
        ..LuxReport::default()
    }
}

fn plan(maintenance: MaintenanceFactor) -> PlanReport {
    PlanReport {
        assumptions: FactList::default(),
        maintenance,
        maintenance_factor: maintenance.value().unwrap(),
        task: None,
        verdicts: Vec::new(),
        ratings: Vec::new(),
        glare_refusal: None,
        cylindrical: Vec::new(),
        luminaires: 4,
        flux: 12566.0,
        watts: 144.0,
        area: 24.0,
        task_illuminance: None,
        has_daylight: false,
    }
}

#[test]
fn figures_agree_with_the_calculation_by_hand() {
    let mut report = report("office", Some(ZoneKind::Task));
    let parts = MaintenanceFactor::Parts {
        lamp_lumens: 0.9,
        lamp_survival: 1.0,
        luminaire: 0.95,
        room_surfaces: 0.94,
    };
    report.planning.maintenance = parts;
    report.plan = Some(plan(parts));
    let html = report.html();
    // 4 x 36 W over 24 m2; the mean of 300, 320, ... 520 lx is 410 lx, times 0.8037 is 329.517: 6 / 3.29517 = 1.8208.
    // Errors of 2 lx are bounds: 1.6 lx of the mean, 0.5 %.
    for words in [
        "6.00 m \u{d7} 4.00 m \u{d7} 2.80 m",
        "<td>144.0 W</td>",
        "<td>6.000 W/m\u{b2}</td>",
        "per area and 100 lx (desk)</td><td>1.821 W/m\u{b2}</td>",
        "0.8037 = 0.9 lamp flux \u{d7} 1 lamp survival \u{d7} 0.95 luminaires \u{d7} 0.94 room surfaces",
        "Mean 329.5, least 241.1, largest 417.9 lx; U0 = 0.73.",
        "reflectance, ceiling</td><td>0.70</td>",
        "4, together 12566 lm when new",
        // 1000 cd of 1000 pi lm.
        "Largest in these planes: 1000 cd, 318.3 cd/klm.",
        "<td>87.3 lm/W</td>",
        "4000 K",
        "2026-11-26 \u{b7} Glanz 1.2.3",
        "desk: maintained illuminance, lx",
    ] {
        assert!(html.contains(words), "{words}\n{html}");
    }
    let json = serde_json::to_value(&report).unwrap();
    let near =
        |found: &serde_json::Value, expected: f64| (found.as_f64().unwrap() / expected - 1.0).abs() < 1e-9;
    assert!(near(&json["shown"]["receivers"][0]["mean"], 410.0 * 0.8037), "{json}");
    assert!(
        near(&json["power"]["w_m2_100lx"], 600.0 / (410.0 * 0.8037)) && json["power"]["reference"] == "desk"
    );
    assert_eq!(
        (&json["luminaires"][0]["count"], &json["luminaires"][0]["power_w"]),
        (&4.into(), &36.0.into())
    );
    assert_eq!(json["room"]["size_m"], serde_json::json!([6.0, 4.0, 2.8]));
}

#[test]
fn isolux_lines_and_values_are_labelled_in_the_coordinates_of_the_room() {
    let html = report("office", None).html();
    // From 300 to 520 lx: levels of 25; of 12 columns each has its own number.
    for words in [">350</text>", ">400</text>", ">450</text>", ">320</text>", ">520</text>", ">x, m</text>"] {
        assert!(html.contains(words), "{words}");
    }
    // The desk's axes begin at 0.5 m.
    assert!(html.contains("desk: values of the illuminance, lx") && html.contains("Means over 12 x 8 areas"));
    assert!(html.contains("Other surfaces: illuminance, lx") && html.contains("wall, 4.000 m"));
    assert!(html.contains("new installation: no light loss") && html.contains("No task was chosen"));
}

#[test]
fn pages_are_well_formed_whatever_the_names() {
    let nasty = "</style><script>alert('1')</script> & \"co\" \u{5149}\u{1b}";
    let html = report(nasty, None).html();
    assert_eq!(unbalanced(&html), Vec::<String>::new());
    assert!(!html.contains("<script") && !html.contains('\u{1b}') && html.contains('\u{5149}'));
    assert_eq!(html.matches("</style>").count(), 1);
}

#[test]
fn designs_without_zones_show_the_brightest_receiver_too() {
    let mut bright = report("hall", None);
    bright.maps[1].lux = vec![5000.0; 96];
    let html = bright.html();
    assert!(html.contains("<h2>wall: illuminance</h2>") && !html.contains("Other surfaces"));
    let declared = LuxReport { maps: bright.maps, ..report("hall", Some(ZoneKind::Task)) }.html();
    assert!(!declared.contains("<h2>wall: illuminance</h2>") && declared.contains("Other surfaces"));
    // Of the room nothing is known: neither plan nor power.
    let bare = LuxReport { layout: None, ..report("hall", None) };
    assert!(!bare.html().contains("Plan from above") && bare.installed_power().is_none());
}

#[test]
fn areas_that_are_turned_keep_their_luminaires_in_place() {
    let mut turned = report("office", Some(ZoneKind::Task));
    // Rows of 5 m along y, columns of 3 m along -x, from (5.5, 0.5): of the luminaires at x = 1.5 and 4.5, the latter two are above.
    turned.layout.as_mut().unwrap().receivers[0].frame =
        Some([DVec3::new(5.5, 0.5, 0.75), DVec3::Y, DVec3::NEG_X]);
    let html = turned.html();
    let sheet = html.split("<h2>").find(|part| part.starts_with("desk: illuminance")).unwrap();
    assert!(sheet.contains("first direction, m") && !sheet.contains(">x, m<"));
    assert_eq!(sheet.matches("stroke=\"#333333\"").count(), 2);
}

#[test]
fn curved_meshes_have_no_pictures() {
    let mut curved = report("office", None);
    curved.layout.as_mut().unwrap().receivers[1].is_grid = false;
    curved.maps[1].lux = vec![5000.0; 96];
    let html = curved.html();
    assert!(html.contains("Other surfaces") && !html.contains("wall, 4.000 m"));
    assert!(html.contains("Pictures of 1 more are in files of their own."));
}

#[test]
fn power_refers_to_the_task_of_the_plan_and_to_luminaires_alone() {
    let mut planned = report("office", Some(ZoneKind::Task));
    let rated = PlanReport { task_illuminance: Some(500.0), ..plan(MaintenanceFactor::default()) };
    planned.plan = Some(rated);
    // 144 W over 24 m2 at 500 lx; the appendix has the same.
    let power = planned.installed_power().unwrap();
    assert_eq!(power.reference, Some(("task area".to_owned(), 500.0)));
    assert_eq!(power.density_per_100_lux(), Some(1.2));
    planned.layout.as_mut().unwrap().other_lights.push(OtherLight {
        kind: "point",
        flux: Some(800.0),
        position: Some([3.0, 2.0, 2.0]),
        outline: Vec::new(),
    });
    assert_eq!(planned.installed_power(), None);
    assert!(planned.html().contains("lights without a photometric file, whose power is unknown"));
}

#[test]
fn letters_are_explained_if_a_light_has_one() {
    let mut lit = report("office", None);
    for (position, has_letters) in [(None, false), (Some([3.0, 2.0, 2.0]), true)] {
        let light = OtherLight { kind: "emitting surface", flux: None, position, outline: Vec::new() };
        lit.layout.as_mut().unwrap().other_lights.push(light);
        assert_eq!(lit.html().contains("letters: other lights"), has_letters);
    }
}

#[test]
fn maintenance_and_task_are_shown_without_a_rating() {
    let mut asked = report("office", None);
    asked.planning.maintenance = MaintenanceFactor::Whole(0.8);
    asked.planning.task = LightingTask::of_reference("34.2");
    let html = asked.html();
    // 0.8 of the mean of 410 lx.
    assert!(html.contains("Mean 328.0, ") && html.contains("maintained illuminance, lx"));
    assert!(html.contains("EN 12464-1:2021, 34.2: ") && html.contains("declares no zones and no observers"));
    asked.facts.push("interrupted", "interrupted", true);
    assert!(asked.html().contains("The calculation was interrupted, so that no requirements are judged."));
}

#[test]
fn errors_have_as_many_digits_as_their_values() {
    let mut dim = report("office", None);
    let map = &mut dim.maps[0];
    (map.lux, map.errors) = (vec![0.05; 96], vec![4e-4; 96]);
    // 0.8 % of 0.05; of 410 lx, 12.5 are more than 0.5 %.
    assert!(dim.html().contains("<td>0.05000 \u{b1} 4.0e-4</td>"));
    dim.maps[0].lux = vec![410.0; 96];
    dim.maps[0].errors = vec![12.5; 96];
    assert!(dim.html().contains("<td>410 \u{b1} 12</td>"));
    // A single path has no spread.
    dim.maps[0].errors = vec![f64::INFINITY; 96];
    assert!(dim.html().contains("<td>410.0 (error unknown)</td>"));
}

#[test]
fn limits_of_the_calculation_are_named() {
    let mut shallow = report("office", None);
    assert!(!shallow.html().contains("what comes after is left out"));
    shallow.facts.push("depth", "max_depth", 2_u64);
    shallow.facts.push("media", "media", "left out");
    let html = shallow.html();
    assert!(
        html.contains("at most 2 surfaces, the lit one included;")
            && html.contains("Fog and other media are left out")
    );
    assert!(html.contains("with a probability of 95 %"));
    shallow.facts.push("method", "method", "integrate");
    let html = shallow.html();
    assert!(html.contains("estimated bound of the error") && !html.contains("probability of 95 %"));
}

#[test]
fn many_kinds_of_luminaires_have_some_cards() {
    let mut many = report("hall", None);
    let layout = many.layout.as_mut().unwrap();
    let dimmed = |i: u32| PlacedLuminaire {
        factor: 1.0 / f64::from(i),
        ..downlight(lambertian(1000.0), DVec3::new(1.0, 1.0, 2.8))
    };
    layout.luminaires = LuminaireGroup::of(&(1..=30).map(dimmed).collect::<Vec<_>>());
    let html = many.html();
    assert_eq!(html.matches("class=\"card\"").count(), 24);
    assert!(html.contains("Kinds of luminaires: 6 more in report.json."));
}

#[test]
fn daylight_is_shown_in_per_cent() {
    let mut day = report("office", None);
    day.daylight = day.maps.iter().map(DaylightFactors::of).collect();
    // 410 lx of 10 000 lx.
    let html = day.html();
    assert_eq!(LitQuantity::of(&day).label(), "daylight factor, %");
    assert!(
        html.contains("Mean 4.100, least 3.000, largest 5.200 %")
            && html.contains("desk: daylight factor, %")
    );
    // Neither maintained nor judged.
    day.planning.maintenance = MaintenanceFactor::Whole(0.8);
    day.planning.task = LightingTask::of_reference("34.2");
    let html = day.html();
    assert!(html.contains("not judged by daylight alone") && !html.contains("maintenance factor"));
    assert!(!html.contains("EN 12464") && !html.contains("declares no zones"));
}

#[test]
fn covered_areas_have_no_figures() {
    let mut covered = report("office", Some(ZoneKind::Task));
    covered.maps[0].areas = vec![0.0; 96];
    let html = covered.html();
    assert!(html.contains("<td>desk</td><td>-</td><td>-</td><td>-</td><td>-</td>"), "{html}");
    let sheet = html.split("<h2>").find(|part| part.starts_with("desk: illuminance")).unwrap();
    assert!(sheet.contains("Nothing of the area receives light.") && !sheet.contains("<svg"));
    let shown = &serde_json::to_value(&covered).unwrap()["shown"]["receivers"];
    assert!(shown[0]["mean"].is_null() && shown[1]["mean"].is_number());
}

#[test]
fn receivers_of_one_name_have_their_own_places() {
    let mut twins = report("office", None);
    twins.maps[1] = map("desk", [5.0, 3.0], 40.0);
    let layout = twins.layout.as_mut().unwrap();
    layout.receivers[1] = place(1, "desk", None, true, 1.75);
    // The higher one comes first, and is that to which the power refers: the mean of 300, 340, ... 740 lx.
    let html = twins.html();
    let order = ["1.75 m above the floor", "0.75 m above the floor"].map(|words| html.find(words).unwrap());
    assert!(order[0] < order[1]);
    assert!((twins.installed_power().unwrap().reference.unwrap().1 - 520.0).abs() < 1e-9);
}

#[test]
fn luminaires_are_drawn_as_far_as_they_are_above_an_area() {
    let mut office = report("office", Some(ZoneKind::Task));
    // The area of 5 m x 3 m begins at x = 1.5, in the middle of two luminaires of 0.6 m, and ends at y = 2.8.
    let desk = &mut office.layout.as_mut().unwrap().receivers[0];
    desk.frame = Some([DVec3::new(1.5, -0.2, 0.75), DVec3::X, DVec3::Y]);
    let html = office.html();
    let sheet = html.split("<h2>").find(|part| part.starts_with("desk: illuminance")).unwrap();
    let outlines: Vec<&str> = sheet.lines().filter(|line| line.contains("stroke=\"#333333\"")).collect();
    // Of the two from y = 2.7 to 3.3, 0.1 m is above the area.
    assert_eq!(outlines.len(), 4);
    // 490 pixels for 5 m, from 66 on: the half of 0.3 m ends at 66 + 29.4.
    let halves = outlines.iter().filter(|line| line.contains("66.0,") && line.contains("95.4,"));
    assert_eq!(halves.count(), 2, "{outlines:?}");
}

#[test]
fn axes_of_maps_are_not_those_of_their_drawings() {
    let mut far = report("office", None);
    let desk = &mut far.layout.as_mut().unwrap().receivers[0];
    desk.outline.iter_mut().for_each(|corner| *corner += DVec2::new(4.5e5, 5.4e6));
    let html = far.html();
    let sheet = html.split("<h2>").find(|part| part.starts_with("desk: illuminance")).unwrap();
    assert!(sheet.contains("first direction, m") && !sheet.contains(">x, m<"));
}

#[test]
fn power_per_illuminance_needs_light_that_is_all_electric() {
    let mut open = report("office", Some(ZoneKind::Task));
    let rated = PlanReport {
        task_illuminance: Some(500.0),
        has_daylight: true,
        ..plan(MaintenanceFactor::default())
    };
    open.plan = Some(rated);
    open.layout.as_mut().unwrap().other_lights.push(OtherLight {
        kind: OtherLight::SKY,
        flux: None,
        position: None,
        outline: Vec::new(),
    });
    let html = open.html();
    assert!(html.contains("<td>6.000 W/m\u{b2}</td>") && !html.contains("100 lx"), "{html}");
}

#[test]
fn open_requirements_beyond_the_first_are_counted() {
    let mut judged = report("office", None);
    let task = LightingTask::of_reference("34.2").unwrap();
    let verdict = |i: u32| {
        let requirement = task.requirement(LightingCriterion::MeanIlluminance, 500.0);
        RequirementVerdict::new(format!("zone {i}"), requirement, 100.0, [99.0, 101.0])
    };
    let verdicts = (0..11).map(verdict).collect();
    judged.plan = Some(PlanReport { verdicts, ..plan(MaintenanceFactor::default()) });
    let html = judged.html();
    assert!(html.contains("11 requirements: 0 met, 11 not met") && html.contains(" and 3 more. Their list"));
}

#[test]
fn reports_without_receivers_have_no_sentences_about_figures() {
    let bare = LuxReport { maps: Vec::new(), ..report("lamp", None) };
    let html = bare.html();
    for words in
        ["figures are", "Least and largest", "The errors", "new installation: no", "The tables below"]
    {
        assert!(!html.contains(words), "{words}");
    }
    assert!(report("lamp", None).html().contains("The errors"));
}

#[test]
fn interrupted_ratings_leave_complete_figures() {
    let mut rated = report("office", Some(ZoneKind::Task));
    rated.planning.task = LightingTask::of_reference("34.2");
    rated.facts.push("goal: relative error", "goal_relative_error", FactValue::Fraction(0.01));
    rated.facts.push("complete", "complete", true);
    rated.facts.push("rating interrupted", "rating_interrupted", true);
    let html = rated.html();
    assert!(html.contains("The rating was interrupted, so that no requirements are judged."));
    assert!(!html.contains("preliminary"));
}

#[test]
fn interrupted_calculations_are_marked_and_refusals_named() {
    let mut stopped = report("office", None);
    stopped.facts.push("complete", "complete", FactValue::Flag(false));
    // A time alone is a goal that is always reached.
    assert!(!stopped.html().contains("ended before its goal"));
    stopped.facts.push("goal: relative error", "goal_relative_error", FactValue::Fraction(0.01));
    let refusal = Some("luminaire 1 has no luminous area".to_owned());
    stopped.plan = Some(PlanReport { glare_refusal: refusal, ..plan(MaintenanceFactor::default()) });
    let html = stopped.html();
    assert!(
        html.contains("ended before its goal") && html.contains("Glare (UGR) is not rated: luminaire 1 has")
    );
}
