//! The illuminance of areas on the pages of a client: isolux lines over false colours, numbers, small pictures.

use glanz_math::{DVec2, DVec3};
use glanz_report::number::significant;
use glanz_report::svg::escaped;
use glanz_report::{CellField, ColourScale, HeatMap, MapAxis, ValueGrid, colour_bar, levels, thumbnail};

use super::LuxReport;
use super::client_page::{figure_table, section};
use super::lit_quantity::LitQuantity;
use super::scale::field_scale;
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

/// Least cosine between a direction of an area and an axis that is named in its drawing.
const ALONG: f64 = 1.0 - 1e-6;

/// The axes of the drawing of an area: those of the room for a level area along them, the height for an upright one.
fn axes(place: &ReceiverPlace, floor: f64) -> [MapAxis; 2] {
    match place.frame {
        Some([corner, across, up]) if place.is_level && across.x >= ALONG && up.y >= ALONG => {
            MapAxis::of_room(corner.truncate().to_array())
        }
        Some([corner, _, up]) if up.z >= ALONG => MapAxis::of_wall(corner.z - floor),
        _ => MapAxis::DIRECTIONS,
    }
}

/// The sheet of one area: isolux lines, and a grid of values.
pub(super) fn area_section(report: &LuxReport, quantity: &LitQuantity, map: &LuxMap) -> String {
    let layout = report.layout.as_ref();
    let place = layout.and_then(|layout| layout.receiver(&map.name));
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
    let grid = ValueGrid { title: &title, field: cells, axes, largest: LARGEST, caption: Vec::new() };
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

/// Whether the cells of a map are rows and columns, as those of all but curved meshes are.
pub(super) fn is_grid(report: &LuxReport, map: &LuxMap) -> bool {
    let place = report.layout.as_ref().and_then(|layout| layout.receiver(&map.name));
    place.is_none_or(|place| place.is_grid)
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
    let Some([corner, across, up]) = area.frame else { return Vec::new() };
    let share = |point: &DVec2| {
        let off: DVec3 = point.extend(corner.z) - corner;
        (DVec2::new(off.dot(across), off.dot(up)) / DVec2::from(size)).to_array()
    };
    let shares = outlines.map(|outline| outline.iter().map(share).collect::<Vec<_>>());
    // Those that reach beyond the area are left out, as they would leave the drawing.
    shares.filter(|outline| outline.iter().flatten().all(|share| (0.0..=1.0).contains(share))).collect()
}

/// The sheet of all areas without sheets of their own: a table, and small pictures with one scale of those whose cells are a grid.
pub(super) fn surface_section(report: &LuxReport, quantity: &LitQuantity, maps: &[&LuxMap]) -> String {
    let label = quantity.label();
    let mut body = figure_table(&format!("Other surfaces: {label}"), quantity, maps).html();
    let grids: Vec<&LuxMap> = maps.iter().copied().filter(|map| is_grid(report, map)).collect();
    let fields: Vec<CellField> = grids.iter().take(MOST_SMALL).map(|map| quantity.field(map)).collect();
    let scale = field_scale(&fields);
    if !fields.is_empty() {
        body += &format!("<figure>\n{}</figure>\n", colour_bar(&scale, &label, 640.0));
    }
    if let Some(note) = logarithmic_note(&scale, quantity) {
        body += &format!("<p class=\"note\">{note}</p>\n");
    }
    let pictures = grids.iter().zip(&fields).map(|(map, field)| {
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
    body += "<p class=\"note\">Flat surfaces are seen from the side that light falls on, walls with their upper edge above.</p>\n";
    section("Other surfaces", &body)
}
