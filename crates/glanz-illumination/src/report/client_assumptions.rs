//! What a calculation assumes, in sentences for a client.

use glanz_report::FactValue;
use glanz_report::number::{plural, significant};
use glanz_report::svg::escaped;

use super::LuxReport;
use super::client_page::{fact, is_interrupted, short_section};
use super::lit_quantity::LitQuantity;
use super::text::{listed, printable};
use crate::LuxMap;
use crate::planning::RoomLayout;

/// Largest number of names in a sentence.
const MOST_NAMES: usize = 12;

/// What was assumed, and what was not judged.
pub(super) fn assumption_section(report: &LuxReport, quantity: &LitQuantity) -> String {
    let items: String =
        assumptions(report, quantity).iter().map(|words| format!("<li>{}</li>\n", escaped(words))).collect();
    short_section("Assumptions", &format!("<ul>\n{items}</ul>\n"))
}

/// What was assumed, in sentences.
fn assumptions(report: &LuxReport, quantity: &LitQuantity) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    list.extend(light_method(report).map(str::to_owned));
    list.extend(depth_limit(report));
    if report.facts.get("media").is_some() {
        list.push(
            "Fog and other media are left out: light passes them as if they were not there.".to_owned(),
        );
    }
    let is_daylight = quantity.unit == "%";
    if report.maps.is_empty() {
        // Nothing has figures.
    } else if is_daylight {
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
            listed(&covered, MOST_NAMES)
        ));
    }
    if !report.maps.is_empty() {
        list.push("Least and largest values are those of means over the cells of an area; U0 is the least over the mean.".to_owned());
        list.push(
            "The errors (\u{b1}) are those of the calculation. Tolerances of luminaires, voltages, surfaces and dimensions come on top of them."
                .to_owned(),
        );
    }
    match (&report.plan, &report.planning.task) {
        _ if is_daylight => {
            list.push("Requirements of standards are not judged by daylight alone.".to_owned());
        }
        (Some(_), Some(_)) => list.push(
            "The limits are those of open summaries of the standards named beside them. Whoever signs compares them with the text of the standard.".to_owned(),
        ),
        (None, Some(_)) if is_interrupted(report) => {
            list.push("The calculation was interrupted, so that no requirements are judged.".to_owned());
        }
        (None, Some(_)) if report.facts.get("rating_interrupted").is_some() => {
            list.push("The rating was interrupted, so that no requirements are judged.".to_owned());
        }
        (None, Some(_)) => list.push(
            "The scene declares no zones and no observers, so that no requirements are judged.".to_owned(),
        ),
        (_, None) => list.push("No task was chosen, so that no requirements of a standard for work places are judged.".to_owned()),
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
            "All light counts, with the reflections between surfaces: direct light and light by exact mirrors is integrated, light between other surfaces is followed by random paths, \
             and light that mirrors and glass focus, and light that lamps send to surfaces close to them, by particles."
        }
        "integrate" => {
            "Only direct light and light after one reflection in a mirror counts; light that walls, ceiling and furniture reflect is left out."
        }
        _ => {
            "All light counts, with the reflections between surfaces: it is followed from the lights by particles."
        }
    })
}

/// A sentence on the largest number of surfaces that light reaches, if it is below that by default.
fn depth_limit(report: &LuxReport) -> Option<String> {
    /// Largest number by default, beyond which hardly any light is left.
    const USUAL_DEPTH: u64 = 1000;
    let Some(FactValue::Count(depth)) = report.facts.get("max_depth") else { return None };
    let surfaces = plural(*depth, "surface", "surfaces");
    let sentence = || {
        format!(
            "Light is followed to at most {surfaces}, the lit one included; what comes after is left out."
        )
    };
    (*depth < USUAL_DEPTH).then(sentence)
}

/// Sentences on surfaces and luminaires.
fn add_layout_assumptions(layout: &RoomLayout, list: &mut Vec<String>) {
    if !layout.surfaces.is_empty() {
        let parts: Vec<String> = layout
            .surfaces
            .iter()
            .map(|part| match part.reflectance {
                Some(reflectance) => format!("{} {reflectance:.2}", part.surface.name()),
                None => format!("{} unknown", part.surface.name()),
            })
            .collect();
        let black = layout.surfaces.iter().all(|part| part.reflectance == Some(0.0));
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
    let dimmed = layout.luminaires.iter().filter_map(|group| {
        let percent = 100.0 * group.dimming()?;
        Some(format!("{} {percent:.1} %", printable(group.description.label())))
    });
    let dimmed: Vec<String> = dimmed.collect();
    if !dimmed.is_empty() {
        list.push(format!(
            "Shares of the flux of the photometric file, with all of the power: {}.",
            listed(&dimmed, MOST_NAMES)
        ));
    }
    if !layout.luminaires.is_empty() && layout.watts().is_none() {
        let reason = if layout.electric_lights().next().is_none() {
            "The power of at least one luminaire is not stated"
        } else {
            "There are lights without a photometric file, whose power is unknown"
        };
        list.push(format!("{reason}, so that there are no figures of power."));
    }
}
