//! Plan and luminaires on the pages of a client.

use glanz_math::DVec2;
use glanz_report::number::{concise, metres, significant};
use glanz_report::{FloorPlan, PlanArea, PlanSymbol, Table, TableCell};

use super::client_page::{section, short_section};
use super::text::printable;
use crate::planning::{LuminaireGroup, RoomLayout};

/// Largest number of luminaires whose places are listed.
const MOST_PLACES: usize = 120;

/// Largest number of kinds of luminaires with a card, and of symbols in the plan.
const MOST_CARDS: usize = 24;
const MOST_SYMBOLS: usize = 2000;

/// Largest number of areas of measurement in the plan.
const MOST_AREAS: usize = 60;

/// Largest number of lights that are no luminaires in their list.
const MOST_LIGHTS: usize = 24;

fn points(outline: &[DVec2]) -> Vec<[f64; 2]> {
    outline.iter().map(|point| point.to_array()).collect()
}

/// The plan, and the places of the luminaires.
pub(super) fn plan_section(layout: &RoomLayout) -> String {
    let outlines = |list: &[Vec<DVec2>]| list.iter().map(|outline| points(outline)).collect::<Vec<_>>();
    let corners = layout.plan_corners().map(|corner| corner.to_array());
    let near = 1e-3 * layout.size().length();
    // An area as large as the floor is the floor.
    let is_own = |outline: &[DVec2]| {
        let reach = |corner: DVec2| outline.iter().any(|point| point.distance(corner) <= near);
        !layout.corners.iter().all(|corner| reach(corner.truncate()))
    };
    let level = layout.receivers.iter().filter(|place| place.is_level);
    let own = || level.clone().filter(|place| is_own(&place.outline));
    let areas_left_out = own().count().saturating_sub(MOST_AREAS);
    let areas: Vec<PlanArea> = own()
        .take(MOST_AREAS)
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
    let left_out = symbols.len().saturating_sub(MOST_SYMBOLS);
    symbols.truncate(MOST_SYMBOLS);
    let plan = FloorPlan {
        title: "Plan from above",
        corners,
        room: layout.corners.map(|corner| corner.truncate().to_array()),
        walls: [outlines(&layout.floor), outlines(&layout.walls)].concat(),
        furniture: outlines(&layout.furniture),
        areas,
        symbols,
    };
    let mut body = format!("<figure>\n{}</figure>\n", plan.svg());
    let has_letters = layout.other_lights.iter().any(|light| light.position.is_some());
    let letters = if has_letters { "; letters: other lights" } else { "" };
    body += &format!(
        "<p class=\"note\">Yellow: luminaires with their numbers, by the size of their luminous opening{letters}. Dashed blue: areas of measurement. Grey: furniture and \
         other things, by their convex outlines.</p>\n"
    );
    if layout.furniture_left_out > 0 {
        body += &format!(
            "<p class=\"note\">Furniture: the smallest {} are not drawn.</p>\n",
            layout.furniture_left_out
        );
    }
    body += &left_out_note("Symbols", left_out);
    body += &left_out_note("Areas", areas_left_out);
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
        let length = |length: f64| TableCell::Text(metres(length));
        // 359.9 degrees are rounded to 0.
        let degrees = |angle: f64| TableCell::Text(format!("{:.0}", angle.round().rem_euclid(360.0) + 0.0));
        table.push([
            u64::from(place.number).into(),
            length(x),
            length(y),
            length(z - floor),
            degrees(place.turn),
            degrees(place.tilt),
            TableCell::Text(printable(group.description.label())),
        ]);
    }
    table.html() + &left_out_note("Luminaires", places.len().saturating_sub(MOST_PLACES))
}

/// A sentence on things that are left out, if there are any.
fn left_out_note(things: &str, count: usize) -> String {
    if count == 0 {
        return String::new();
    }
    format!("<p class=\"note\">{things}: {count} more in report.json.</p>\n")
}

/// The kinds of luminaires, and all other lights.
pub(super) fn luminaire_section(layout: &RoomLayout) -> String {
    let floor = layout.corners[0].z;
    let cards: String =
        layout.luminaires.iter().take(MOST_CARDS).map(|group| luminaire_card(group, floor)).collect();
    let left_out = layout.luminaires.len().saturating_sub(MOST_CARDS);
    let mut body = cards + &left_out_note("Kinds of luminaires", left_out);
    if !layout.other_lights.is_empty() {
        let columns = [
            ("label", "in the plan"),
            ("light", "light"),
            ("flux_lm", "flux, lm"),
            ("position_m", "x, y, z, m"),
        ];
        let mut table = Table::new("lights", "Lights without a photometric file", &columns);
        for (label, light) in letters().zip(&layout.other_lights).take(MOST_LIGHTS) {
            let position = light.position.map(|position| position.map(metres).join(", "));
            let position = position.map_or(TableCell::Missing, TableCell::Text);
            let label = light.position.map_or(TableCell::Missing, |_| TableCell::Text(label));
            table.push([label, light.kind.into(), light.flux.into(), position]);
        }
        body += &table.html();
        body += &left_out_note("Lights", layout.other_lights.len().saturating_sub(MOST_LIGHTS));
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
    let [low, high] = group.heights().map(|height| metres(height - floor));
    let heights = if low == high { format!("{low} m") } else { format!("{low} m to {high} m") };
    line("height of the middle of the light", &heights);
    let lengths = description.opening.size.into_iter().filter(|length| *length > 0.0);
    let lengths: Vec<String> = lengths.map(|length| format!("{} m", concise(length))).collect();
    line("luminous opening", &lengths.join(" \u{d7} "));
    line("photometric file", &description.file);
    let table = table.html();
    format!("<div class=\"card\">\n<figure>\n{}</figure>\n{table}</div>\n", group.polar.svg())
}
