//! The pages of a report that a client reads: room, plan, luminaires, illuminances, requirements, assumptions.

use std::fmt::Write;

use glanz_math::DVec2;
use glanz_report::number::{brief, plural, significant};
use glanz_report::svg::escaped;
use glanz_report::{FactValue, FloorPlan, PlanArea, PlanSymbol, Table, TableCell};

use super::LuxReport;
use super::client_area::{area_section, surface_section};
use super::lit_quantity::{LitQuantity, shown_point};
use super::text::printable;
use crate::planning::requirement::VerdictOutcome;
use crate::planning::{LuminaireGroup, MaintenanceFactor, RoomLayout};
use crate::{DaylightFactors, LuxMap};

/// Largest number of luminaires whose places are listed.
const MOST_PLACES: usize = 120;

/// Relative error below which a figure has none.
const LEAST_ERROR: f64 = 0.005;

/// Largest number of lights that are no luminaires in their list.
const MOST_LIGHTS: usize = 24;

/// Largest number of requirements that the summary names.
const MOST_OPEN: usize = 8;

/// Keys of the facts about glare and cylinders in the facts of a plan.
const GLARE_KEYS: [&str; 5] = ["ugr", "observers", "cylindrical", "modelling", "unlit"];

/// The sections of a report for a client, most of which begin a sheet of paper.
pub(super) fn client_sections(report: &LuxReport) -> String {
    let quantity = LitQuantity::of(report);
    let maps: Vec<LuxMap> = report.maps.iter().map(|map| quantity.map(map)).collect();
    let (featured, others) = featured(report, &maps);
    let mut sections = vec![summary_section(report, &quantity, &featured)];
    if let Some(layout) = &report.layout {
        if !layout.luminaires.is_empty() || !layout.other_lights.is_empty() {
            sections.push(luminaire_section(layout));
        }
        sections.push(plan_section(layout));
    }
    sections.extend(requirement_section(report));
    sections.push(assumption_section(report, &quantity));
    sections.extend(featured.iter().map(|map| area_section(report, &quantity, map)));
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
fn short_section(heading: &str, body: &str) -> String {
    format!("<section class=\"short\">\n<h2>{}</h2>\n{body}</section>\n", escaped(heading))
}

/// The maps that have a sheet of their own, and all others: level areas that face up, declared zones first, then from the highest down; in a design without zones the map with most light, too.
fn featured<'a>(report: &LuxReport, maps: &'a [LuxMap]) -> (Vec<&'a LuxMap>, Vec<&'a LuxMap>) {
    /// Largest number of sheets.
    const MOST: usize = 12;
    let place = |map: &LuxMap| report.layout.as_ref()?.receiver(&map.name);
    let is_zone = |map: &LuxMap| place(map).is_some_and(|place| place.kind.is_some());
    let mut level: Vec<&LuxMap> =
        maps.iter().filter(|map| place(map).is_some_and(|place| place.is_level)).collect();
    let height = |map: &LuxMap| place(map).map_or(0.0, |place| place.height);
    level.sort_by(|a, b| is_zone(b).cmp(&is_zone(a)).then(height(b).total_cmp(&height(a))));
    if !maps.iter().any(is_zone) {
        let brightest = maps.iter().max_by(|a, b| a.summary().flux.total_cmp(&b.summary().flux));
        level.extend(brightest.filter(|map| !level.iter().any(|other| std::ptr::eq(*other, *map))));
    }
    level.truncate(MOST);
    let others = maps.iter().filter(|map| !level.iter().any(|other| std::ptr::eq(*other, *map)));
    let others = others.collect();
    (level, others)
}

/// A fact of the calculation as people read it.
fn fact(report: &LuxReport, key: &str) -> Option<String> {
    report.facts.get(key).map(FactValue::shown)
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

fn summary_section(report: &LuxReport, quantity: &LitQuantity, featured: &[&LuxMap]) -> String {
    let mut body = format!("<p class=\"origin\">Lighting report \u{b7} {}</p>\n", escaped(&origin(report)));
    if report.facts.get("complete") == Some(&FactValue::Flag(false)) {
        body +=
            "<p class=\"warning\">The calculation ended before its goal: all figures are preliminary.</p>\n";
    }
    body += &room_table(report, quantity).html();
    if !report.daylight.is_empty() {
        body += &DaylightFactors::table(&report.daylight).html();
    }
    if !featured.is_empty() {
        body += &figure_table(&format!("Results: {}", quantity.label()), featured).html();
        body += "<p class=\"note\">\u{b1}: half of the interval within which the figure of the calculation lies (95 %); left out below 0.5 %.</p>\n";
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
            .take(MOST_OPEN)
            .map(|verdict| {
                let symbol = verdict.requirement.criterion.symbol();
                format!("{} {symbol} ({})", printable(&verdict.zone), verdict.outcome)
            })
            .collect();
        let names = if names.is_empty() {
            String::new()
        } else {
            format!(" Not met or undecided: {}.", names.join(", "))
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
        let [x, y, z] = layout.size().to_array().map(|length| format!("{length:.2}"));
        line("size (x, y, height)", format!("{x} m \u{d7} {y} m \u{d7} {z} m"));
        line("floor area", format!("{} m\u{b2}", significant(layout.floor_area())));
        for part in &layout.surfaces {
            let [low, high] = part.reflectance_range;
            let range = if high - low > 0.005 { format!(" ({low:.2} to {high:.2})") } else { String::new() };
            let name = format!("reflectance, {}", part.surface.name());
            line(&name, format!("{:.2}{range}", part.reflectance));
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
    if let Some(plan) = &report.plan {
        let parts = match plan.maintenance {
            MaintenanceFactor::Whole(_) => String::new(),
            MaintenanceFactor::Parts { lamp_lumens, lamp_survival, luminaire, room_surfaces } => format!(
                " = {lamp_lumens} lamp flux \u{d7} {lamp_survival} lamp survival \u{d7} {luminaire} luminaires \u{d7} {room_surfaces} room surfaces"
            ),
        };
        line("maintenance factor", format!("{}{parts}", significant(plan.maintenance_factor)));
        if let Some(task) = &plan.task {
            line("task", format!("EN 12464-1:2021, {}: {}", task.reference, task.name));
        }
    }
    line("figures are", quantity.label());
    table
}

/// Mean, least, largest value and uniformity of maps, with their errors.
pub(super) fn figure_table(caption: &str, maps: &[&LuxMap]) -> Table {
    let columns = [
        ("area", "area"),
        ("mean", "mean"),
        ("minimum", "least"),
        ("maximum", "largest"),
        ("u0", "U0 (least / mean)"),
    ];
    let mut table = Table::new("figures", caption, &columns);
    for map in maps {
        let summary = map.summary();
        let shown = |value: f64, interval: [f64; 2]| TableCell::Text(with_error(value, interval));
        table.push([
            TableCell::Text(printable(&map.name)),
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
    if half < LEAST_ERROR * value.abs() || !half.is_finite() {
        return significant(value);
    }
    // As many decimals as the error has.
    let half = brief(half);
    let decimals = half.split_once('.').filter(|_| !half.contains('e')).map_or(0, |(_, digits)| digits.len());
    format!("{value:.decimals$} \u{b1} {half}")
}

fn uniformity_with_error(value: f64, [low, high]: [f64; 2]) -> String {
    let half = (high - value).max(value - low);
    if half < LEAST_ERROR { format!("{value:.2}") } else { format!("{value:.2} \u{b1} {half:.2}") }
}

fn points(outline: &[DVec2]) -> Vec<[f64; 2]> {
    outline.iter().map(|point| point.to_array()).collect()
}

fn plan_section(layout: &RoomLayout) -> String {
    let outlines = |list: &[Vec<DVec2>]| list.iter().map(|outline| points(outline)).collect();
    let [low, high] = layout.corners.map(|corner| corner.truncate().to_array());
    let near = 1e-3 * layout.size().length();
    // An area as large as the floor is the floor.
    let is_own = |outline: &[DVec2]| {
        let reach = |corner: DVec2| outline.iter().any(|point| point.distance(corner) <= near);
        !layout.corners.iter().all(|corner| reach(corner.truncate()))
    };
    let level = layout.receivers.iter().filter(|place| place.is_level);
    let areas: Vec<PlanArea> = level
        .filter(|place| is_own(&place.outline))
        .map(|place| PlanArea { name: printable(&place.name), corners: points(&place.outline) })
        .collect();
    let placed = layout.luminaires.iter().flat_map(|group| &group.places);
    let mut symbols: Vec<PlanSymbol> = placed
        .map(|place| PlanSymbol {
            label: place.number.to_string(),
            centre: place.position.truncate().to_array(),
            outline: points(&place.outline),
        })
        .collect();
    symbols.sort_by_key(|symbol| symbol.label.parse::<u32>().unwrap_or(u32::MAX));
    for (label, light) in letters().zip(&layout.other_lights) {
        if let Some([x, y, _]) = light.position {
            symbols.push(PlanSymbol { label, centre: [x, y], outline: points(&light.outline) });
        }
    }
    let plan = FloorPlan {
        title: "Plan from above",
        corners: [low, high],
        walls: outlines(&layout.walls),
        furniture: outlines(&layout.furniture),
        areas,
        symbols,
    };
    let mut body = format!("<figure>\n{}</figure>\n", plan.svg());
    body += "<p class=\"note\">Yellow: luminaires with their numbers, by the size of their luminous opening. Dashed blue: areas of measurement. Grey: furniture and \
             other things, by their convex outlines.</p>\n";
    body += &place_table(layout);
    section("Plan", &body)
}

/// Labels of lights that are no luminaires: A to Z, then L27 and so on.
fn letters() -> impl Iterator<Item = String> {
    ('A'..='Z').map(String::from).chain((27_u32..).map(|number| format!("L{number}")))
}

/// The places of the luminaires.
fn place_table(layout: &RoomLayout) -> String {
    let mut places: Vec<_> = layout
        .luminaires
        .iter()
        .flat_map(|group| group.places.iter().map(move |place| (place, group)))
        .collect();
    if places.is_empty() {
        return String::new();
    }
    places.sort_by_key(|(place, _)| place.number);
    let columns = [
        ("number", "no."),
        ("x_m", "x, m"),
        ("y_m", "y, m"),
        ("z_m", "height, m"),
        ("turn_degrees", "turn, \u{b0}"),
        ("tilt_degrees", "tilt, \u{b0}"),
        ("luminaire", "luminaire"),
    ];
    let mut table = Table::new("places", "Places of the luminaires (middle of the light)", &columns);
    let floor = layout.corners[0].z;
    for (place, group) in places.iter().take(MOST_PLACES) {
        let [x, y, z] = place.position.to_array();
        let metres = |length: f64| TableCell::Text(format!("{:.2}", length + 0.0));
        let degrees = |angle: f64| TableCell::Text(format!("{:.0}", angle + 0.0));
        table.push([
            u64::from(place.number).into(),
            metres(x),
            metres(y),
            metres(z - floor),
            degrees(place.turn),
            degrees(place.tilt),
            TableCell::Text(printable(group.description.label())),
        ]);
    }
    let more = places.len().saturating_sub(MOST_PLACES);
    let note = if more > 0 {
        format!("<p class=\"note\">{more} more are in report.json.</p>\n")
    } else {
        String::new()
    };
    table.html() + &note
}

fn luminaire_section(layout: &RoomLayout) -> String {
    let floor = layout.corners[0].z;
    let cards: String = layout.luminaires.iter().map(|group| luminaire_card(group, floor)).collect();
    let mut body = cards;
    if !layout.other_lights.is_empty() {
        let columns = [
            ("label", "in the plan"),
            ("light", "light"),
            ("flux_lm", "flux, lm"),
            ("position_m", "x, y, z, m"),
        ];
        let mut table = Table::new("lights", "Lights without a photometric file", &columns);
        for (label, light) in letters().zip(&layout.other_lights).take(MOST_LIGHTS) {
            let position = light.position.map(|position| shown_point(position.into()));
            let position = position.map_or(TableCell::Missing, TableCell::Text);
            let label = light.position.map_or(TableCell::Missing, |_| TableCell::Text(label));
            table.push([label, light.kind.into(), light.flux.into(), position]);
        }
        body += &table.html();
        let more = layout.other_lights.len().saturating_sub(MOST_LIGHTS);
        if more > 0 {
            let _ = writeln!(body, "<p class=\"note\">{more} more are in report.json.</p>");
        }
    }
    let heading = if layout.luminaires.is_empty() { "Lights" } else { "Luminaires" };
    short_section(heading, &body)
}

/// The polar plot of a kind of luminaire beside what is known of it.
fn luminaire_card(group: &LuminaireGroup, floor: f64) -> String {
    let description = &group.description;
    let mut table = Table::new("luminaire", description.label(), &[("fact", "luminaire"), ("value", "")]);
    let mut line = |name: &str, value: &str| {
        if !value.trim().is_empty() {
            table.push([name.into(), TableCell::Text(printable(value))]);
        }
    };
    line("pieces", &group.places.len().to_string());
    line("maker", &description.maker);
    line("catalogue number", &description.catalog_number);
    line("lamps", &description.lamps);
    line("luminous flux", &format!("{} lm", significant(group.flux)));
    let watts = description.watts;
    let power = if watts > 0.0 { format!("{} W", significant(watts)) } else { "not stated".to_owned() };
    line("electric power", &power);
    if let Some(efficacy) = group.efficacy() {
        line("luminous efficacy", &format!("{efficacy:.1} lm/W"));
    }
    line("colour, colour temperature", &description.color);
    line("colour rendering", &description.rendering);
    let [low, high] = group.heights().map(|height| format!("{:.2}", height - floor));
    let heights = if low == high { format!("{low} m") } else { format!("{low} m to {high} m") };
    line("height of the middle of the light", &heights);
    let lengths = description.opening.size.into_iter().filter(|length| *length > 0.0);
    let lengths: Vec<String> = lengths.map(|length| format!("{length:.3} m")).collect();
    line("luminous opening", &lengths.join(" \u{d7} "));
    line("photometric file", &description.file);
    let table = table.html();
    format!("<div class=\"card\">\n<figure>\n{}</figure>\n{table}</div>\n", group.polar.svg())
}

/// Verdicts, glare and modelling; none if nothing of it was asked for.
fn requirement_section(report: &LuxReport) -> Option<String> {
    let plan = report.plan.as_ref()?;
    let mut table =
        Table::new("glare", "Glare and modelling", &[("fact", "glare and modelling"), ("value", "")]);
    for fact in plan.facts().iter().filter(|fact| GLARE_KEYS.iter().any(|key| fact.key.starts_with(key))) {
        table.push([fact.name.into(), TableCell::Text(printable(&fact.value.shown()))]);
    }
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

fn assumption_section(report: &LuxReport, quantity: &LitQuantity) -> String {
    let items: String =
        assumptions(report, quantity).iter().map(|words| format!("<li>{}</li>\n", escaped(words))).collect();
    short_section("Assumptions", &format!("<ul>\n{items}</ul>\n"))
}

/// What was assumed, in sentences.
fn assumptions(report: &LuxReport, quantity: &LitQuantity) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    list.extend(light_method(report).map(str::to_owned));
    if quantity.unit == "%" {
        list.push(
            "Daylight factors are shares of the illuminance of the open ground under the overcast sky of the CIE, which does not depend on the hour or the direction of the windows. \
             Electric light is off."
                .to_owned(),
        );
    } else if quantity.factor == 1.0 {
        list.push(
            "All figures are those of the new installation: no light loss by age and dirt is taken off."
                .to_owned(),
        );
    } else {
        list.push(format!(
            "Illuminances are maintained ones: those of the new installation times the maintenance factor {}. UGR is that of the new installation.",
            significant(quantity.factor)
        ));
    }
    if let Some(layout) = &report.layout {
        add_layout_assumptions(layout, &mut list);
    }
    let count = |map: &LuxMap| map.areas.iter().filter(|area| **area <= 0.0).count();
    let covered: Vec<String> = report
        .maps
        .iter()
        .filter(|map| count(map) > 0)
        .map(|map| format!("{} ({} of {} cells)", printable(&map.name), count(map), map.areas.len()))
        .collect();
    if !covered.is_empty() {
        list.push(format!(
            "Parts of areas that things stand on or reach through, or that are cut away, do not count: {}.",
            covered.join(", ")
        ));
    }
    list.push("Least and largest values are those of means over the cells of an area; U0 is the least over the mean.".to_owned());
    list.push(
        "The errors (\u{b1}) are those of the calculation. Tolerances of luminaires, voltages, surfaces and dimensions come on top of them."
            .to_owned(),
    );
    match &report.plan {
        Some(plan) if plan.task.is_some() => list.push(
            "The limits are those of open summaries of the standards named beside them. Whoever signs compares them with the text of the standard.".to_owned(),
        ),
        _ => list.push("No task was chosen, so that no requirements of a standard for work places are judged.".to_owned()),
    }
    if let Some(reason) = report.plan.as_ref().and_then(|plan| plan.glare_refusal.as_ref()) {
        list.push(format!("Glare (UGR) is not rated: {}.", printable(reason)));
    }
    list
}

/// How the light was computed.
fn light_method(report: &LuxReport) -> Option<&'static str> {
    Some(match fact(report, "method")?.as_str() {
        "auto" => {
            "All light counts, with all reflections between surfaces: direct light and light by exact mirrors is integrated, light between other surfaces is followed by random paths, \
             and light that mirrors and glass focus by particles."
        }
        "integrate" => {
            "Only direct light and light after one reflection in a mirror counts; light that walls, ceiling and furniture reflect is left out."
        }
        _ => {
            "All light counts, with all reflections between surfaces: it is followed from the lights by particles."
        }
    })
}

/// Sentences on surfaces and luminaires.
fn add_layout_assumptions(layout: &RoomLayout, list: &mut Vec<String>) {
    if !layout.surfaces.is_empty() {
        let parts: Vec<String> = layout
            .surfaces
            .iter()
            .map(|part| format!("{} {:.2}", part.surface.name(), part.reflectance))
            .collect();
        let black = layout.surfaces.iter().all(|part| part.reflectance == 0.0);
        let note = if black {
            " They absorb all light, so that all light on them comes from the lights, mirrors and other things."
        } else {
            ""
        };
        list.push(format!(
            "Reflectances are those of the scene, means over the area: {}.{note}",
            parts.join(", ")
        ));
    }
    let [from_points, from_openings] =
        [true, false].map(|is_point| layout.luminaires.iter().any(|group| group.is_point == is_point));
    match (from_points, from_openings) {
        (true, false) => list.push(
            "The light of luminaires leaves their photometric centres, as their files measure it; close to large luminaires, the illuminance is less even in truth."
                .to_owned(),
        ),
        (false, true) => list.push("The light of luminaires leaves their whole luminous opening, evenly.".to_owned()),
        (true, true) => list.push(
            "The light of some luminaires leaves their photometric centres, that of others their whole luminous opening, as the scene has it.".to_owned(),
        ),
        (false, false) => {}
    }
    for group in &layout.luminaires {
        if let Some(share) = group.dimming() {
            list.push(format!(
                "{}: {:.1} % of the flux of its file, with all of its power.",
                printable(group.description.label()),
                100.0 * share
            ));
        }
    }
    if !layout.luminaires.is_empty() && layout.watts().is_none() {
        list.push(
            "The power of at least one luminaire is not stated, so that there are no figures of power."
                .to_owned(),
        );
    }
}
