//! The illuminance of areas on the pages of a client: isolux lines over false colours, numbers, small pictures.

use glanz_math::{DVec2, DVec3};
use glanz_report::number::{metres, significant};
use glanz_report::svg::escaped;
use glanz_report::{CellField, HeatMap, MapAxis, ValueGrid, colour_bar, levels, thumbnail};

use super::LuxReport;
use super::client_page::{PlacedMap, figure_table, section};
use super::lit_quantity::LitQuantity;
use super::scale::{field_scale, logarithmic_note};
use super::text::printable;
use crate::planning::ReceiverPlace;
use crate::receiver::{clipped, signed_area};

/// Largest width and height of the drawing of an area, pixels: two of them, with their captions, fit a sheet of A4.
const LARGEST: [f64; 2] = [490.0, 320.0];

/// Least number of parts along the longer side over which colours and isolux lines are interpolated.
const PARTS: usize = 96;

/// Largest width and height of a small picture, and the largest number of them.
const SMALL: [f64; 2] = [300.0, 190.0];
const MOST_SMALL: usize = 24;

/// Half of the size of the mark of a luminaire without a known opening, metres, and as a share of the shorter side of the area at most.
const MARK: f64 = 0.06;
const LARGEST_MARK: f64 = 0.04;

/// Least part of an area that the outline of a luminaire covers.
const LEAST_COVER: f64 = 1e-9;

/// Largest coordinate of an axis of a room, metres: those of maps have more digits than there is room for.
const FARTHEST: f64 = 1e4;

/// Least cosine between a direction of an area and an axis that is named in its drawing.
const ALONG: f64 = 1.0 - 1e-6;

/// The axes of the drawing of an area: those of the room for a level area along them, the height for an upright one.
fn axes(place: &ReceiverPlace, floor: f64) -> [MapAxis; 2] {
    match place.frame {
        Some([corner, across, up])
            if place.is_level
                && across.x >= ALONG
                && up.y >= ALONG
                && place.outline.iter().all(|point| point.abs().max_element() < FARTHEST) =>
        {
            MapAxis::of_room(corner.truncate().to_array())
        }
        Some([corner, _, up]) if up.z >= ALONG => MapAxis::of_wall(corner.z - floor),
        _ => MapAxis::DIRECTIONS,
    }
}

/// The sheet of one area: isolux lines, and a grid of values.
pub(super) fn area_section(report: &LuxReport, quantity: &LitQuantity, area: &PlacedMap<'_>) -> String {
    let PlacedMap { map, place } = *area;
    let layout = report.layout.as_ref();
    let level = place.filter(|place| place.is_level);
    let floor = layout.map_or(0.0, |layout| layout.corners[0].z);
    let axes = place.map_or(MapAxis::DIRECTIONS, |place| axes(place, floor));
    let outlines = level.map_or_else(Vec::new, |place| luminaire_outlines(report, place, map.size));
    let label = quantity.label();
    let summary = quantity.summary(map);
    let cells = quantity.field(map);
    let scale = field_scale(std::slice::from_ref(&cells));
    let name = printable(&map.name);
    let title = format!("{name}: {label}");
    let [width, depth] = map.size.map(significant);
    let height = level.map(|place| place.height - floor).filter(|height| *height > 5e-4);
    let height = height.map_or_else(String::new, |height| format!(", {} m above the floor", metres(height)));
    let kind =
        place.and_then(|place| place.kind).map_or_else(String::new, |kind| format!(", {} area", kind.name()));
    let words =
        format!("{width} m \u{d7} {depth} m{height}{kind}; {} \u{d7} {} cells.", map.cells[0], map.cells[1]);
    let heading = format!("{name}: {}", quantity.name);
    if summary.area <= 0.0 {
        let words = format!("{words} Nothing of the area receives light.");
        return section(&heading, &format!("<p>{}</p>\n", escaped(&words)));
    }
    let mut caption = vec![format!(
        "Mean {}, least {}, largest {} {unit}; U0 = {:.2}.",
        significant(summary.mean),
        significant(summary.minimum),
        significant(summary.maximum),
        summary.u0,
        unit = quantity.unit,
    )];
    let field = cells.refined(PARTS);
    if field != cells {
        caption.push("Colours and lines are interpolated between the middles of the cells.".to_owned());
    }
    if !outlines.is_empty() {
        caption.push("Thin outlines: luminaires above.".to_owned());
    }
    if place.is_some_and(|place| place.frame.is_none()) {
        caption.push("The directions are those of the parameters of the surface.".to_owned());
    }
    caption.extend(logarithmic_note(&scale, quantity.unit));
    let drawing = HeatMap {
        quantity: &label,
        axes,
        largest: LARGEST,
        levels: levels(summary.minimum, summary.maximum),
        outlines,
        ..HeatMap::new(&title, quantity.unit, field, scale)
    };
    let title = format!("{name}: values of the {label}");
    let grid = ValueGrid { title: &title, field: cells, axes, largest: LARGEST };
    let caption = format!("<figcaption>{}</figcaption>\n", escaped(&caption.join(" ")));
    let figures =
        format!("<figure>\n{}{caption}</figure>\n<figure>\n{}</figure>\n", drawing.svg(), grid.svg());
    section(&heading, &format!("<p>{}</p>\n{figures}", escaped(&words)))
}

/// The luminaires over an area, or what of them is above it, in fractions of its sides.
fn luminaire_outlines(report: &LuxReport, area: &ReceiverPlace, size: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let Some(layout) = &report.layout else { return Vec::new() };
    let places = layout.luminaires.iter().flat_map(|group| &group.places);
    let above = places.filter(|place| place.position.z > area.height);
    let outlines = above.map(|place| {
        let centre = place.position.truncate();
        let half = MARK.min(LARGEST_MARK * size[0].min(size[1]));
        let mark = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].map(|off| centre + half * off);
        if place.outline.is_empty() { mark.to_vec() } else { place.outline.clone() }
    });
    let Some([corner, across, up]) = area.frame else { return Vec::new() };
    let share = |point: &DVec2| {
        let off: DVec3 = point.extend(corner.z) - corner;
        DVec2::new(off.dot(across), off.dot(up)) / DVec2::from(size)
    };
    let within = outlines.filter_map(|outline| {
        let mut part: Vec<DVec2> = outline.iter().map(share).collect();
        for (axis, bound, is_above) in [(0, 0.0, true), (0, 1.0, false), (1, 0.0, true), (1, 1.0, false)] {
            part = clipped(&part, axis, bound, is_above);
        }
        // Those that only touch the area are not above it; the opening of a wall light is a line from above.
        let is_line = outline.len() < 3;
        let is_seen = if is_line { part.len() > 1 } else { signed_area(&part).abs() > LEAST_COVER };
        is_seen.then(|| part.iter().map(|share| share.to_array()).collect())
    });
    within.collect()
}

/// The sheet of all areas without sheets of their own: a table, and small pictures with one scale of those whose cells are a grid.
pub(super) fn surface_section(quantity: &LitQuantity, maps: &[PlacedMap<'_>]) -> String {
    let label = quantity.label();
    let mut body = figure_table(&format!("Other surfaces: {label}"), quantity, maps).html();
    let grids: Vec<PlacedMap<'_>> = maps.iter().copied().filter(PlacedMap::is_grid).collect();
    let fields: Vec<CellField> = grids.iter().take(MOST_SMALL).map(|area| quantity.field(area.map)).collect();
    let scale = field_scale(&fields);
    if !fields.is_empty() {
        body += &format!("<figure>\n{}</figure>\n", colour_bar(&scale, &label, 640.0));
    }
    if let Some(note) = logarithmic_note(&scale, quantity.unit) {
        body += &format!("<p class=\"note\">{note}</p>\n");
    }
    let pictures = grids.iter().zip(&fields).map(|(PlacedMap { map, .. }, field)| {
        let name = printable(&map.name);
        let [width, height] = map.size.map(significant);
        let caption = format!("{name}, {width} m \u{d7} {height} m");
        let svg = thumbnail(field, &scale, SMALL, &format!("{name}: {label}"));
        format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escaped(&caption))
    });
    body += &format!("<div class=\"small\">\n{}</div>\n", pictures.collect::<String>());
    if maps.len() > fields.len() {
        body += &format!(
            "<p class=\"note\">Pictures of {} more are in files of their own.</p>\n",
            maps.len() - fields.len()
        );
    }
    body += "<p class=\"note\">Flat surfaces that are not trimmed are seen from the side that light falls on, walls with their upper edge above; others follow their own parameters.</p>\n";
    section("Other surfaces", &body)
}
