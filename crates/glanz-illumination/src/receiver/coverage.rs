//! Parts of receivers that other things cover, such as furniture that stands on a floor.

use glanz_math::{DVec2, DVec3, Frame, Ray};
use glanz_scene::{PlacedSurface, Scene};
use glanz_shading::Material;
use rayon::prelude::*;

use super::{Receiver, ReceiverPoint};

/// Points of a cell along each direction that tell whether something covers a part of it.
const COARSE: [f64; 3] = [0.02, 0.5, 0.98];

/// Points of a cell that is partly covered, and the steps between them: those of an additive sequence of low discrepancy, by which the share of a rectangle
/// has errors of less than 0.01; those of a grid would be up to 0.03, since edges are mostly parallel to it.
const FINE: u32 = 512;
const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// Largest number of cells for which parts are known; of more, a cell counts as covered if its middle is.
const CELLS: usize = 1 << 18;

/// Distance from the receiver at which a covering thing may begin, relative to the side of a square of the size of a cell.
const GAP: f64 = 1e-3;

/// Share of a receiver inside a surface from which on that is the room in which the receiver is.
const ROOM: f64 = 0.5;

/// Directions from a point, about its normal z: one along it and four around.
const DIRECTIONS: [DVec3; 5] = [
    DVec3::Z,
    DVec3::new(0.8, 0.1, 0.6),
    DVec3::new(-0.1, 0.8, 0.6),
    DVec3::new(-0.8, -0.1, 0.6),
    DVec3::new(0.1, -0.8, 0.6),
];

/// The covered share of each cell of a receiver, [0, 1].
///
/// A point is covered if it is inside a thing that light does not pass: all rays from it hit backs of surfaces first. Surfaces around most of
/// the receiver are those of the room.
pub(super) fn covered_shares(scene: &Scene, placed: &[PlacedSurface<'_>], receiver: &Receiver) -> Vec<f64> {
    let Some(surface) = placed.get(receiver.surface() as usize) else { return vec![0.0; receiver.len()] };
    let coarse: &[f64] = if receiver.len() > CELLS { &COARSE[1..2] } else { &COARSE };
    let points: Vec<DVec2> =
        coarse.iter().flat_map(|&v| coarse.iter().map(move |&u| DVec2::new(u, v))).collect();
    let covers = |cell: usize, at: &DVec2| {
        Some(cover(scene, placed, receiver, cell, &receiver.place(surface, cell, *at)?))
    };
    let found: Vec<Vec<Option<u32>>> = (0..receiver.len())
        .into_par_iter()
        .map(|cell| points.iter().filter_map(|at| covers(cell, at)).collect())
        .collect();
    let rooms = rooms(&found);
    let is_covered = |cover: &Option<u32>| cover.is_some_and(|surface| !rooms.contains(&surface));
    let share = |covers: &[Option<u32>]| {
        covers.iter().filter(|cover| is_covered(cover)).count() as f64 / covers.len().max(1) as f64
    };
    let refined = |(cell, coarse): (usize, &Vec<Option<u32>>)| {
        let coarse = share(coarse);
        if coarse == 0.0 || coarse == 1.0 {
            return coarse;
        }
        let fine = (0..FINE).map(|k| (0.5 + f64::from(k) * STEP).fract());
        let fine: Vec<Option<u32>> = fine.filter_map(|at| covers(cell, &at)).collect();
        share(&fine)
    };
    found.par_iter().enumerate().map(refined).collect()
}

/// The surfaces around most points.
fn rooms(found: &[Vec<Option<u32>>]) -> Vec<u32> {
    let all = found.iter().map(Vec::len).sum::<usize>();
    let mut surfaces: Vec<u32> = found.iter().flatten().flatten().copied().collect();
    surfaces.sort_unstable();
    let around = surfaces.chunk_by(|a, b| a == b).filter(|same| same.len() as f64 > ROOM * all as f64);
    around.filter_map(|same| same.first().copied()).collect()
}

/// The surface along the normal of a point in a covering thing.
fn cover(
    scene: &Scene,
    placed: &[PlacedSurface<'_>],
    receiver: &Receiver,
    cell: usize,
    point: &ReceiverPoint,
) -> Option<u32> {
    let gap = GAP * receiver.areas().get(cell)?.sqrt();
    let (origin, frame) = (point.position + gap * point.normal, Frame::from_z(point.normal));
    let mut along = None;
    for direction in DIRECTIONS {
        let ray = Ray::new(origin, frame.to_world(direction.normalize()));
        let (_, place) = scene.intersect_parametric(&ray, f64::INFINITY)?;
        let material = placed.get(place.surface as usize)?.material(place.face);
        let material = scene.materials().get(material as usize)?;
        let passes =
            matches!(material, Material::Interface) || material.lobes().iter().any(|lobe| lobe.transmission);
        if !place.back || place.surface == receiver.surface() || passes {
            return None;
        }
        along.get_or_insert(place.surface);
    }
    along
}
