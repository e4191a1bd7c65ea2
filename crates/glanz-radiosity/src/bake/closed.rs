//! Charts on the dark insides of solids.

use glanz_geometry::Surface;
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::PlacedSurface;
use rayon::prelude::*;

use super::direct_light::DirectMap;
use crate::charts::Chart;
use crate::elements::{Element, ElementPoint, Elements};

/// Bound on the rounding of positions on a solid, relative to its size.
const ROUNDING: f64 = 1e-9;

/// Whether each chart is on the inside of a closed convex surface that contains no light: no direct light falls on its inside, and nothing
/// within it emits light or receives direct light.
///
/// Opaque closed surfaces let no other light in. Rays cannot find this: a solid that stands on a floor shares points with it, and
/// rays from inside hit the lit floor there.
pub(super) fn dark_insides(elements: &Elements<'_>, charts: &[Chart], direct: &[DirectMap]) -> Vec<bool> {
    let count = elements.surfaces.len();
    let insides: Vec<bool> = charts.iter().map(|chart| is_inside(elements, chart)).collect();
    let (mut is_lit, mut is_dark, mut has_inside) =
        (vec![false; count], vec![true; count], vec![false; count]);
    for ((chart, direct), inside) in charts.iter().zip(direct).zip(&insides) {
        let surface = chart.surface as usize;
        is_lit[surface] |= direct.is_lit();
        is_dark[surface] &= !inside || !direct.is_lit();
        has_inside[surface] |= inside;
    }
    let bounds: Vec<Bounds3> = elements.surfaces.iter().map(PlacedSurface::bounds).collect();
    // Elements that emit light or lie on a surface with direct light.
    let shines = |element: &&Element| {
        !element.emission.is_black() || is_lit.get(element.patch.surface as usize).is_some_and(|lit| *lit)
    };
    let shining: Vec<&[Element]> = elements
        .list
        .chunk_by(|a, b| a.patch.surface == b.patch.surface)
        .filter(|list| list.iter().any(|element| shines(&element)))
        .collect();
    let contains_light = |solid: usize| {
        let surface = &elements.surfaces[solid];
        let own = bounds[solid].expanded(ROUNDING * bounds[solid].diagonal().length());
        let is_within = |element: &&Element| {
            let ElementPoint { position, normal, .. } = element.center;
            if element.patch.surface as usize == solid {
                return !element.emission.is_black() && normal.dot(own.center() - position) > 0.0;
            }
            contains(surface, position)
        };
        shining.iter().any(|list| {
            let other = bounds[list[0].patch.surface as usize];
            let is_near = other.min.cmpge(own.min).all() && other.max.cmple(own.max).all();
            is_near && list.iter().filter(shines).any(|element| is_within(&element))
        })
    };
    let is_dark: Vec<bool> = (0..count)
        .into_par_iter()
        .map(|solid| has_inside[solid] && is_dark[solid] && !contains_light(solid))
        .collect();
    charts.iter().zip(insides).map(|(chart, inside)| inside && is_dark[chart.surface as usize]).collect()
}

/// Whether a point is inside a closed convex surface.
fn contains(surface: &PlacedSurface<'_>, point: DVec3) -> bool {
    if let Surface::Sphere(sphere) = surface.surface() {
        return surface.to_world().inverse().point(point).length() < sphere.radius() * (1.0 - ROUNDING);
    }
    let bounds = surface.bounds();
    let (center, rounding) = (bounds.center(), ROUNDING * bounds.diagonal().length());
    (0..surface.faces()).all(|face| {
        let middle = surface.face_domain(face).corners();
        let middle = middle.iter().sum::<DVec2>() / middle.len() as f64;
        surface.at(face, middle, false).is_some_and(|at| {
            let off = |p: DVec3| (p - at.at.point.position).dot(at.at.point.normal);
            off(point) * off(center).signum() > rounding
        })
    })
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
