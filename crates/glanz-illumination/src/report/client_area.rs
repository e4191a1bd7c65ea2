//! The illuminance of areas on the pages of a client: isolux lines over false colours, numbers, small pictures.

use glanz_math::DVec2;
use glanz_report::number::significant;
use glanz_report::svg::escaped;
use glanz_report::{ColourScale, HeatMap, MapAxis, ValueGrid, colour_bar, levels, thumbnail};

use super::LuxReport;
use super::client_page::{figure_table, section};
use super::lit_quantity::LitQuantity;
use super::scale::{lux_field, lux_scale};
use super::text::printable;
use crate::LuxMap;
use crate::planning::ReceiverPlace;

/// Largest width and height of the drawing of an area, pixels: two of them, with their captions, fit a sheet of A4.
const LARGEST: [f64; 2] = [490.0, 320.0];

/// Least number of parts along the longer side over which colours and isolux lines are interpolated.
const PARTS: usize = 96;

/// Largest width and height of a small picture, and the largest number of them.
const SMALL: [f64; 2] = [300.0, 190.0];
const MOST_SMALL: usize = 24;

/// Half of the size of the mark of a luminaire without a known opening, metres.
const MARK: f64 = 0.06;

/// The sheet of one area: isolux lines, and a grid of values. `map`: in the shown quantity.
pub(super) fn area_section(report: &LuxReport, quantity: &LitQuantity, map: &LuxMap) -> String {
    let layout = report.layout.as_ref();
    let place = layout.and_then(|layout| layout.receiver(&map.name));
    let level = place.filter(|place| place.is_level);
    let floor = layout.map_or(0.0, |layout| layout.corners[0].z);
    let axes = match place {
        Some(place) if place.is_level => MapAxis::of_room(place.corner.to_array()),
        Some(place) if place.is_upright => MapAxis::of_wall(place.height - 0.5 * map.size[1] - floor),
        _ => MapAxis::DIRECTIONS,
    };
    let outlines = level.map_or_else(Vec::new, |place| luminaire_outlines(report, place, map.size));
    let label = quantity.label();
    let summary = map.summary();
    let scale = lux_scale(&[map]);
    let name = printable(&map.name);
    let title = format!("{name}: {label}");
    let mut caption = vec![format!(
        "Mean {}, least {}, largest {} {unit}; U0 = {:.2}.",
        significant(summary.mean),
        significant(summary.minimum),
        significant(summary.maximum),
        summary.u0,
        unit = quantity.unit,
    )];
    let field = lux_field(map).refined(PARTS);
    if field != lux_field(map) {
        caption.push("Colours and lines are interpolated between the middles of the cells.".to_owned());
    }
    if !outlines.is_empty() {
        caption.push("Thin outlines: luminaires above.".to_owned());
    }
    caption.extend(logarithmic_note(&scale, quantity));
    let drawing = HeatMap {
        quantity: &label,
        axes,
        largest: LARGEST,
        levels: levels(summary.minimum, summary.maximum),
        outlines,
        ..HeatMap::new(&title, quantity.unit, field, scale)
    };
    let title = format!("{name}: values of the {label}");
    let grid =
        ValueGrid { title: &title, field: lux_field(map), axes, largest: LARGEST, caption: Vec::new() };
    let [width, depth] = map.size.map(significant);
    let height = level.map(|place| place.height - floor).filter(|height| *height > 0.005);
    let height = height.map_or_else(String::new, |height| format!(", {height:.2} m above the floor"));
    let kind =
        place.and_then(|place| place.kind).map_or_else(String::new, |kind| format!(", {} area", kind.name()));
    let words =
        format!("{width} m \u{d7} {depth} m{height}{kind}; {} \u{d7} {} cells.", map.cells[0], map.cells[1]);
    let caption = format!("<figcaption>{}</figcaption>\n", escaped(&caption.join(" ")));
    let figures =
        format!("<figure>\n{}{caption}</figure>\n<figure>\n{}</figure>\n", drawing.svg(), grid.svg());
    section(&format!("{name}: {}", quantity.name), &format!("<p>{}</p>\n{figures}", escaped(&words)))
}

/// A sentence on a scale of equal factors.
fn logarithmic_note(scale: &ColourScale, quantity: &LitQuantity) -> Option<String> {
    let floor = scale.floor()?;
    Some(format!(
        "Colours by equal factors; what is below {} {} has the lowest.",
        significant(floor),
        quantity.unit
    ))
}

/// The luminaires over an area, in fractions of its sides.
fn luminaire_outlines(report: &LuxReport, area: &ReceiverPlace, size: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let Some(layout) = &report.layout else { return Vec::new() };
    let places = layout.luminaires.iter().flat_map(|group| &group.places);
    let above = places.filter(|place| place.position.z > area.height);
    let outlines = above.map(|place| {
        let centre = place.position.truncate();
        let mark = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].map(|off| centre + MARK * off);
        if place.outline.is_empty() { mark.to_vec() } else { place.outline.clone() }
    });
    let share = |point: &DVec2| ((*point - area.corner) / DVec2::from(size)).to_array();
    let shares = outlines.map(|outline| outline.iter().map(share).collect::<Vec<_>>());
    // Those that reach beyond the area are left out, as they would leave the drawing.
    shares.filter(|outline| outline.iter().flatten().all(|share| (0.0..=1.0).contains(share))).collect()
}

/// The sheet of all areas without sheets of their own: a table and small pictures with one scale. `maps`: in the shown quantity.
pub(super) fn surface_section(quantity: &LitQuantity, maps: &[&LuxMap]) -> String {
    let label = quantity.label();
    let scale = lux_scale(maps);
    let mut body = figure_table(&format!("Other surfaces: {label}"), maps).html();
    body += &format!("<figure>\n{}</figure>\n", colour_bar(&scale, &label, 640.0));
    if let Some(note) = logarithmic_note(&scale, quantity) {
        body += &format!("<p class=\"note\">{note}</p>\n");
    }
    let pictures = maps.iter().take(MOST_SMALL).map(|map| {
        let name = printable(&map.name);
        let [width, height] = map.size.map(significant);
        let caption = format!("{name}, {width} m \u{d7} {height} m");
        let svg = thumbnail(&lux_field(map), &scale, SMALL, &format!("{name}: {label}"));
        format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escaped(&caption))
    });
    body += &format!("<div class=\"small\">\n{}</div>\n", pictures.collect::<String>());
    if maps.len() > MOST_SMALL {
        body +=
            &format!("<p class=\"note\">{} more are in files of their own.</p>\n", maps.len() - MOST_SMALL);
    }
    body += "<p class=\"note\">Flat surfaces are seen from the side that light falls on, walls with their upper edge above.</p>\n";
    section("Other surfaces", &body)
}
