//! Elements that are small where other surfaces are near.
//!
//! Light varies over lengths in proportion to the distance of the surroundings (@ward1988). A larger element has the mean of light that
//! differs much: through the neck of a vase its inside would be lit as if it saw the rim, too, and walls would be too dark along the edges of
//! a room.

use glanz_math::{DVec2, Frame};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::warp;
use glanz_scene::ParametricPoint;
use rayon::prelude::*;

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

/// Bounds of the size of elements.
#[derive(Clone, Copy)]
struct Fineness {
    max_size: f64,
    quarterings: u32,
}

/// The elements, quartered until they are small enough; unchanged if they would be more than `max_elements`.
pub(super) fn divided<'a>(elements: &Elements<'a>, max_elements: usize) -> Elements<'a> {
    let of_element = |element: &Element| {
        let fineness = if element.polygon.is_some() { FLAT } else { CURVED };
        quartered(elements, element.clone(), fineness)
    };
    let fine: Vec<Element> = elements.list.par_iter().flat_map_iter(of_element).collect();
    let list = if fine.len() > max_elements { elements.list.clone() } else { fine };
    Elements { scene: elements.scene, surfaces: elements.surfaces.clone(), list, left_out: elements.left_out }
}

fn quartered(elements: &Elements<'_>, element: Element, fineness: Fineness) -> Vec<Element> {
    if fineness.quarterings == 0 || !is_too_large(elements, &element, fineness.max_size) {
        return vec![element];
    }
    let rest = Fineness { quarterings: fineness.quarterings - 1, ..fineness };
    elements.quarters(&element).into_iter().flat_map(|quarter| quartered(elements, quarter, rest)).collect()
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
