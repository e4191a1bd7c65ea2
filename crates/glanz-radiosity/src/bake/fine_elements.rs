//! Elements that are small where other surfaces are near.
//!
//! Light varies over lengths in proportion to the distance of the surroundings (@ward1988). A larger element has the mean of light that
//! differs much: through the neck of a vase its inside would be lit as if it saw the rim, too, and walls would be too dark along the edges of
//! a room.

use glanz_geometry::SurfacePoint;
use glanz_job::Interrupted;
use glanz_math::{DVec2, Frame};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::warp;
use glanz_scene::ParametricPoint;
use rayon::prelude::*;

use super::BakeError;
use super::receiver::BakeReceiver;
use crate::elements::{Element, Elements};

/// Largest size of an element relative to the harmonic mean distance of its surroundings, and largest number of times that it is quartered:
/// of flat elements, and of curved ones.
const FLAT: Fineness = Fineness { max_size: 0.5, quarterings: 2 };
const CURVED: Fineness = Fineness { max_size: 0.25, quarterings: 4 };

/// Rays from each quadrature point of an element.
const RAYS: u32 = 16;

/// Key of the sampled directions.
const KEY: u64 = 0x6669_6e65;

/// Elements that are tested between two calls of the check.
const ELEMENTS_AT_ONCE: usize = 4096;

/// Largest sine of the angle between the normals of a flat element that trimming cuts, and largest distance of its corners from its plane,
/// relative to its size.
const FLATNESS: f64 = 1e-9;

/// Bounds of the size of elements.
#[derive(Clone, Copy)]
struct Fineness {
    max_size: f64,
    quarterings: u32,
}

/// The elements, quartered until they are small enough and cut at thin walls, or until they would be more than `max_elements`. `density`:
/// texels per metre, see [`Elements::cut_at_walls`]. `check`: called after every few thousand elements.
///
/// # Errors
/// Those of `check` and of [`Elements::cut_at_walls`].
pub(super) fn divided<'a>(
    elements: &Elements<'a>,
    density: f64,
    max_elements: usize,
    check: impl FnMut() -> Result<(), Interrupted>,
) -> Result<Elements<'a>, BakeError> {
    let mut fine = quartered(elements, [FLAT, CURVED], max_elements, check)?;
    // Walls that were too short to cut the whole element cut its quarters.
    let uncut = fine.list.clone();
    fine.cut_at_walls(density)?;
    if fine.list.len() > max_elements {
        fine.list = uncut;
    }
    Ok(fine)
}

/// As [`divided`], flat elements as they are.
pub(super) fn with_divided_curves<'a>(
    elements: &Elements<'a>,
    max_elements: usize,
    check: impl FnMut() -> Result<(), Interrupted>,
) -> Result<Elements<'a>, Interrupted> {
    quartered(elements, [Fineness { quarterings: 0, ..FLAT }, CURVED], max_elements, check)
}

/// `fineness`: that of flat and of curved elements.
fn quartered<'a>(
    elements: &Elements<'a>,
    [flat, curved]: [Fineness; 2],
    max_elements: usize,
    mut check: impl FnMut() -> Result<(), Interrupted>,
) -> Result<Elements<'a>, Interrupted> {
    // Elements, and whether each may be too large.
    let mut list: Vec<(Element, bool)> =
        elements.list.iter().map(|element| (element.clone(), true)).collect();
    let parts = |level: u32, element: &Element| {
        let fineness = if is_flat(elements, element) { flat } else { curved };
        let is_divided = level < fineness.quarterings && is_too_large(elements, element, fineness.max_size);
        if is_divided { elements.quarters(element) } else { Vec::new() }
    };
    'levels: for level in 0..flat.quarterings.max(curved.quarterings) {
        let mut next = Vec::with_capacity(list.len());
        for group in list.chunks(ELEMENTS_AT_ONCE) {
            check()?;
            let divided = |(element, is_open): &(Element, bool)| {
                let quarters = if *is_open { parts(level, element) } else { Vec::new() };
                if quarters.is_empty() {
                    return vec![(element.clone(), false)];
                }
                quarters.into_iter().map(|quarter| (quarter, true)).collect()
            };
            next.extend(group.par_iter().map(divided).collect::<Vec<_>>().into_iter().flatten());
            if next.len() > max_elements {
                break 'levels;
            }
        }
        list = next;
    }
    let list = list.into_iter().map(|(element, _)| element).collect();
    let Elements { scene, left_out, .. } = *elements;
    Ok(Elements { scene, surfaces: elements.surfaces.clone(), list, left_out })
}

/// Whether the surface beneath an element is flat, also where trimming cuts it.
fn is_flat(elements: &Elements<'_>, element: &Element) -> bool {
    let patch = &element.patch;
    let surface = elements.surfaces.get(patch.surface as usize).filter(|surface| surface.is_trimmed());
    let Some(surface) = surface else { return element.polygon.is_some() };
    let at = |uv: DVec2| surface.surface().untrimmed_at(patch.face, uv);
    let corners = patch.domain.corners();
    let corners: Option<Vec<SurfacePoint>> = corners.into_iter().map(at).collect();
    at(patch.domain.center()).zip(corners).is_some_and(|(center, corners)| {
        corners.iter().all(|corner| {
            let way = corner.position - center.position;
            corner.normal.cross(center.normal).length() <= FLATNESS
                && way.dot(center.normal).abs() <= FLATNESS * way.length()
        })
    })
}

/// `max_size`: relative to the distance of the surroundings.
fn is_too_large(elements: &Elements<'_>, element: &Element, max_size: f64) -> bool {
    let patch = &element.patch;
    let sobol = ScrambledSobol::new(KEY);
    let (mut nearness, mut rays) = (0.0, 0.0);
    for uv in patch.domain.quadrature_points() {
        let place = ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv };
        let Some(receiver) = BakeReceiver::new(elements, &place) else { continue };
        let frame = Frame::from_z(receiver.normal);
        for i in 0..RAYS {
            let [x, y] = sobol.pair(i.reverse_bits(), 0).map(unit);
            let direction = frame.to_world(warp::cosine_hemisphere(DVec2::new(x, y)));
            let hit = elements.scene.intersect(&receiver.at.spawn(direction), f64::INFINITY);
            nearness +=
                hit.map_or(0.0, |hit| hit.point.position.distance(receiver.at.point.position).recip());
            rays += 1.0;
        }
    }
    element.area.sqrt() * nearness > max_size * rays
}
