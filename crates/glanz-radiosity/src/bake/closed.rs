//! Charts on the dark insides of solids.

use glanz_geometry::Surface;
use glanz_math::DVec2;
use glanz_scene::PlacedSurface;

use super::direct_light::DirectMap;
use crate::charts::Chart;
use crate::elements::Elements;

/// Whether each chart is on the inside of a closed convex surface that receives no direct light there.
///
/// Opaque closed surfaces let no other light in. Rays cannot find this: a solid that stands on a floor shares points with it, and
/// rays from inside hit the lit floor there.
pub(super) fn dark_insides(elements: &Elements<'_>, charts: &[Chart], direct: &[DirectMap]) -> Vec<bool> {
    let mut is_dark = vec![true; elements.surfaces.len()];
    let insides: Vec<bool> = charts.iter().map(|chart| is_inside(elements, chart)).collect();
    for ((chart, direct), inside) in charts.iter().zip(direct).zip(&insides) {
        is_dark[chart.surface as usize] &= !inside || !direct.is_lit();
    }
    charts.iter().zip(insides).map(|(chart, inside)| inside && is_dark[chart.surface as usize]).collect()
}

fn is_inside(elements: &Elements<'_>, chart: &Chart) -> bool {
    let Some(surface) = elements.surfaces.get(chart.surface as usize).filter(|s| is_closed(s)) else {
        return false;
    };
    let middle = 0.5 * DVec2::new(f64::from(chart.size[0]) - 1.0, f64::from(chart.size[1]) - 1.0);
    let found =
        chart.surface_point(surface, middle).and_then(|place| surface.at(place.face, place.uv, place.back));
    found.is_some_and(|at| at.at.wo.dot(surface.bounds().center() - at.at.point.position) > 0.0)
}

fn is_closed(surface: &PlacedSurface<'_>) -> bool {
    match surface.surface() {
        Surface::Cuboid(_) | Surface::Polyhedron(_) => true,
        Surface::Sphere(sphere) => sphere.is_whole(),
        _ => false,
    }
}
