//! The pages of a report that a client reads: summary, luminaires, plan, requirements, assumptions, areas, other surfaces.

use std::fmt::Write;

use glanz_report::number::{brief, metres, plural, significant};
use glanz_report::svg::escaped;
use glanz_report::{FactValue, Table, TableCell};

use super::LuxReport;
use super::client_area::{area_section, surface_section};
use super::client_assumptions::assumption_section;
use super::client_room::{luminaire_section, plan_section};
use super::lit_quantity::LitQuantity;
use super::text::{listed, printable};
use crate::planning::requirement::VerdictOutcome;
use crate::planning::{MaintenanceFactor, ReceiverPlace};
use crate::{DaylightFactors, LuxMap};

/// Relative error below which a figure has none.
const LEAST_ERROR: f64 = 0.005;

/// Largest number of requirements that the summary names.
const MOST_OPEN: usize = 8;

/// Keys of the facts about glare and cylinders in the facts of a plan.
const GLARE_KEYS: [&str; 5] = ["ugr", "observers", "cylindrical", "modelling", "unlit"];

/// A map with the place of its receiver, if that is known.
#[derive(Clone, Copy)]
pub(super) struct PlacedMap<'a> {
    pub(super) map: &'a LuxMap,
    pub(super) place: Option<&'a ReceiverPlace>,
}

impl PlacedMap<'_> {
    /// Whether its cells are rows and columns, as those of all but curved meshes are.
    pub(super) fn is_grid(&self) -> bool {
        self.place.is_none_or(|place| place.is_grid)
    }
}

/// The sections of a report for a client, most of which begin a sheet of paper.
pub(super) fn client_sections(report: &LuxReport) -> String {
    let quantity = LitQuantity::of(report);
    let (areas, others) = area_maps(report);
    let mut sections = vec![summary_section(report, &quantity, &areas)];
    if let Some(layout) = &report.layout {
        if !layout.luminaires.is_empty() || !layout.other_lights.is_empty() {
            sections.push(luminaire_section(layout));
        }
        sections.push(plan_section(layout));
    }
    sections.extend(requirement_section(report));
    sections.push(assumption_section(report, &quantity));
    sections.extend(areas.iter().map(|area| area_section(report, &quantity, area)));
    if !others.is_empty() {
        sections.push(surface_section(&quantity, &others));
    }
    sections.concat()
}

/// A section with its heading, which begins a sheet.
pub(super) fn section(heading: &str, body: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{body}</section>\n", escaped(heading))
}

/// A section with its heading, on the sheet of the one before if there is room.
pub(super) fn short_section(heading: &str, body: &str) -> String {
    format!("<section class=\"short\">\n<h2>{}</h2>\n{body}</section>\n", escaped(heading))
}

/// The maps that have a sheet of their own, and all others: level areas that face up, declared zones first, then from the highest down; in a design without zones the map with most light, too.
fn area_maps(report: &LuxReport) -> (Vec<PlacedMap<'_>>, Vec<PlacedMap<'_>>) {
    /// Largest number of sheets.
    const MOST: usize = 12;
    let place = |number: usize| report.layout.as_ref()?.receiver(number);
    let maps: Vec<PlacedMap<'_>> =
        report.maps.iter().enumerate().map(|(number, map)| PlacedMap { map, place: place(number) }).collect();
    let is_zone = |area: &PlacedMap<'_>| area.place.is_some_and(|place| place.kind.is_some());
    let grids = || maps.iter().filter(|area| area.is_grid()).copied();
    let mut areas: Vec<PlacedMap<'_>> =
        grids().filter(|area| area.place.is_some_and(|place| place.is_level)).collect();
    let height = |area: &PlacedMap<'_>| area.place.map_or(0.0, |place| place.height);
    areas.sort_by(|a, b| is_zone(b).cmp(&is_zone(a)).then(height(b).total_cmp(&height(a))));
    let is_in = |list: &[PlacedMap<'_>], area: &PlacedMap<'_>| {
        list.iter().any(|other| std::ptr::eq(other.map, area.map))
    };
    areas.truncate(MOST);
    if !maps.iter().any(is_zone) {
        let flux = |area: PlacedMap<'_>| area.map.summary().flux;
        let brightest = grids().max_by(|a, b| flux(*a).total_cmp(&flux(*b)));
        if let Some(area) = brightest.filter(|area| !is_in(&areas, area)) {
            areas.truncate(MOST - 1);
            areas.push(area);
        }
    }
    let others = maps.iter().filter(|area| !is_in(&areas, area)).copied().collect();
    (areas, others)
}

/// A fact of the calculation as people read it.
pub(super) fn fact(report: &LuxReport, key: &str) -> Option<String> {
    report.facts.get(key).map(FactValue::shown)
}

/// Whether a calculation was interrupted.
pub(super) fn is_interrupted(report: &LuxReport) -> bool {
    report.facts.get("interrupted") == Some(&FactValue::Flag(true))
}

/// Whether a calculation ended before its goal. One that has a time alone has no other goal.
fn is_preliminary(report: &LuxReport) -> bool {
    let has_goal =
        ["goal_particles", "goal_relative_error"].iter().any(|key| report.facts.get(key).is_some());
    report.facts.get("complete") == Some(&FactValue::Flag(false)) && (has_goal || is_interrupted(report))
}

/// The day of the calculation.
fn day(report: &LuxReport) -> Option<String> {
    fact(report, "end_utc").and_then(|end| Some(end.split('T').next()?.to_owned()))
}

/// Program, scene and day, for the head and the foot of the sheets.
pub(super) fn origin(report: &LuxReport) -> String {
    let scene = fact(report, "scene").map(|scene| format!("Scene: {scene}"));
    let program = fact(report, "glanz_version").map(|version| format!("Glanz {version}"));
    let parts = [scene, day(report), program];
    printable(&parts.into_iter().flatten().collect::<Vec<_>>().join(" \u{b7} "))
}

fn summary_section(report: &LuxReport, quantity: &LitQuantity, areas: &[PlacedMap<'_>]) -> String {
    let mut body = format!("<p class=\"origin\">Lighting report \u{b7} {}</p>\n", escaped(&origin(report)));
    if is_preliminary(report) {
        body +=
            "<p class=\"warning\">The calculation ended before its goal: all figures are preliminary.</p>\n";
    }
    body += &room_table(report, quantity).html();
    if !report.daylight.is_empty() {
        body += &DaylightFactors::table(&report.daylight).html();
    }
    if !areas.is_empty() {
        body += &figure_table(&format!("Results: {}", quantity.label()), quantity, areas).html();
        let meaning = match fact(report, "method").as_deref() {
            Some("integrate") => "estimated bound of the error of the integration",
            _ => {
                "half of the interval within which the figure of the calculation lies with a probability of 95 %"
            }
        };
        body +=
            &format!("<p class=\"note\">\u{b1}: {meaning}; left out below 0.5 %, for U0 below 0.005.</p>\n");
    }
    if let Some(plan) = &report.plan
        && !plan.verdicts.is_empty()
    {
        let count =
            |outcome| plan.verdicts.iter().filter(|verdict| verdict.outcome == outcome).count() as u64;
        let [met, not_met, undecided] =
            [VerdictOutcome::Met, VerdictOutcome::NotMet, VerdictOutcome::Undecided].map(count);
        let open = plan.verdicts.iter().filter(|verdict| verdict.outcome != VerdictOutcome::Met);
        let names: Vec<String> = open
            .map(|verdict| {
                let symbol = verdict.requirement.criterion.symbol();
                format!("{} {symbol} ({})", printable(&verdict.zone), verdict.outcome)
            })
            .collect();
        let names = if names.is_empty() {
            String::new()
        } else {
            format!(" Not met or undecided: {}.", listed(&names, MOST_OPEN))
        };
        let _ = writeln!(
            body,
            "<p><strong>{}: {met} met, {not_met} not met, {undecided} undecided.</strong>{} Their list follows.</p>",
            plural(plan.verdicts.len() as u64, "requirement", "requirements"),
            escaped(&names),
        );
    }
    section("Summary", &body)
}

/// Size, surfaces, luminaires and power.
fn room_table(report: &LuxReport, quantity: &LitQuantity) -> Table {
    let mut table =
        Table::new("room", "Room and installation", &[("fact", "room and installation"), ("value", "")]);
    let mut line = |name: &str, value: String| table.push([name.into(), TableCell::Text(printable(&value))]);
    if let Some(layout) = &report.layout {
        let [x, y, z] = layout.size().to_array().map(metres);
        line("size (x, y, height)", format!("{x} m \u{d7} {y} m \u{d7} {z} m"));
        if layout.floor_area() > 0.0 {
            line("floor area", format!("{} m\u{b2}", significant(layout.floor_area())));
        }
        for part in &layout.surfaces {
            let (Some(mean), Some([low, high])) = (part.reflectance, part.reflectance_range) else {
                continue;
            };
            let range = if high - low > 0.005 { format!(" ({low:.2} to {high:.2})") } else { String::new() };
            let name = format!("reflectance, {}", part.surface.name());
            line(&name, format!("{mean:.2}{range}"));
        }
        let count: usize = layout.luminaires.iter().map(|group| group.places.len()).sum();
        if count > 0 {
            let flux: f64 =
                layout.luminaires.iter().map(|group| group.places.len() as f64 * group.flux).sum();
            let flux = format!("{count}, together {} lm when new", significant(flux));
            line("luminaires", flux);
        }
        if !layout.other_lights.is_empty() && report.daylight.is_empty() {
            let known = report.balance.as_ref().filter(|_| count == 0);
            let flux = known.map_or_else(String::new, |balance| {
                format!(", together {} lm", significant(balance.emitted))
            });
            line("lights without a photometric file", format!("{}{flux}", layout.other_lights.len()));
        }
    }
    if let Some(power) = report.installed_power()
        && let Some(density) = power.density()
    {
        line("electric power", format!("{} W", significant(power.watts)));
        line("power per area", format!("{} W/m\u{b2}", significant(density)));
        if let (Some(density), Some((name, _))) = (power.density_per_100_lux(), &power.reference) {
            let name = format!("power per area and 100 lx ({name})");
            line(&name, format!("{} W/m\u{b2}", significant(density)));
        }
    }
    // Daylight factors are neither maintained illuminances nor judged.
    let settings = Some(&report.planning).filter(|_| report.daylight.is_empty());
    if let Some(settings) = settings
        && (report.plan.is_some() || settings.maintenance != MaintenanceFactor::default())
    {
        let parts = match settings.maintenance {
            MaintenanceFactor::Whole(_) => String::new(),
            MaintenanceFactor::Parts { lamp_lumens, lamp_survival, luminaire, room_surfaces } => format!(
                " = {lamp_lumens} lamp flux \u{d7} {lamp_survival} lamp survival \u{d7} {luminaire} luminaires \u{d7} {room_surfaces} room surfaces"
            ),
        };
        line("maintenance factor", format!("{}{parts}", significant(report.maintenance_factor())));
    }
    if let Some(task) = settings.and_then(|settings| settings.task.as_ref()) {
        line("task", task.label());
    }
    if !report.maps.is_empty() {
        line("figures are", quantity.label());
    }
    table
}

/// Mean, least, largest value and uniformity of maps, with their errors.
pub(super) fn figure_table(caption: &str, quantity: &LitQuantity, areas: &[PlacedMap<'_>]) -> Table {
    let columns = [
        ("area", "area"),
        ("mean", "mean"),
        ("minimum", "least"),
        ("maximum", "largest"),
        ("u0", "U0 (least / mean)"),
    ];
    let mut table = Table::new("figures", caption, &columns);
    for PlacedMap { map, .. } in areas {
        let summary = quantity.summary(map);
        let shown = |value: f64, interval: [f64; 2]| TableCell::Text(with_error(value, interval));
        let name = TableCell::Text(printable(&map.name));
        if summary.area <= 0.0 {
            // What is covered as a whole has no figures.
            table.push([name]);
            continue;
        }
        table.push([
            name,
            shown(summary.mean, summary.mean_interval),
            shown(summary.minimum, summary.minimum_interval),
            shown(summary.maximum, summary.maximum_interval),
            TableCell::Text(uniformity_with_error(summary.u0, summary.u0_interval)),
        ]);
    }
    table
}

/// A value with half of its interval.
fn with_error(value: f64, [low, high]: [f64; 2]) -> String {
    let half = (high - value).max(value - low);
    if !half.is_finite() {
        return format!("{} (error unknown)", significant(value));
    }
    if half <= LEAST_ERROR * value.abs() {
        return significant(value);
    }
    // As many decimals as the error has.
    let half = brief(half);
    if half.contains('e') {
        return format!("{} \u{b1} {half}", significant(value));
    }
    let decimals = half.split_once('.').map_or(0, |(_, digits)| digits.len());
    format!("{value:.decimals$} \u{b1} {half}")
}

fn uniformity_with_error(value: f64, [low, high]: [f64; 2]) -> String {
    let half = (high - value).max(value - low);
    match half {
        _ if !half.is_finite() => format!("{value:.2} (error unknown)"),
        _ if half < LEAST_ERROR => format!("{value:.2}"),
        _ => format!("{value:.2} \u{b1} {half:.2}"),
    }
}

/// Verdicts, glare and modelling; none if nothing of it was asked for.
fn requirement_section(report: &LuxReport) -> Option<String> {
    let plan = report.plan.as_ref()?;
    let is_shown = |key: &str| GLARE_KEYS.iter().any(|start| key.starts_with(start));
    let table = plan.facts().table("glare", "Glare and modelling", "glare and modelling", is_shown);
    let mut body = String::new();
    if !plan.verdicts.is_empty() {
        body += &plan.verdict_table().html();
        body += "<p class=\"note\">Met: the whole interval of the value is on the allowed side of the limit. Undecided: the limit lies within the interval, or the value is \
                 unknown. Colour rendering is not judged.</p>\n";
    }
    if !table.rows().is_empty() {
        body += &table.html();
    }
    (!body.is_empty()).then(|| section("Requirements", &body))
}
