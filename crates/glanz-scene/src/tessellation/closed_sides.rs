//! Sides of patches that are one line, or a point.

use glanz_math::DVec2;

use super::patch::MeshPatch;
use super::shared_edge::{EdgePlace, EdgeUse};

/// Places on a side that are compared.
const PLACES: [f64; 7] = [0.0, 0.13, 0.29, 0.5, 0.67, 0.83, 1.0];

/// Whether the sides of each axis are one line, within a distance (metres).
pub(super) fn closed_axes(patch: &MeshPatch, tolerance: f64) -> [bool; 2] {
    /// The middle is at least this many tolerances away: both sides of a sliver are not one line.
    const APART: f64 = 100.0;
    if patch.sides.len() != 4 {
        return [false; 2];
    }
    let [low, high] = patch.window();
    [0, 1].map(|axis| {
        let at = |across: f64, along: f64| {
            let mut t = DVec2::splat(along);
            t[axis] = across;
            patch.point(low + (high - low) * t)
        };
        let apart = |along: &f64| at(0.0, *along).distance(at(1.0, *along));
        let away = PLACES.iter().map(|&along| at(0.0, along).distance(at(0.5, along))).fold(0.0, f64::max);
        PLACES.iter().all(|along| apart(along) <= tolerance) && away > APART * tolerance
    })
}

/// Whether each side is a point, within a distance (metres).
pub(super) fn pole_sides(patch: &MeshPatch, tolerance: f64) -> Vec<bool> {
    let side = |number: usize| {
        let a_use = EdgeUse { patch: 0, place: EdgePlace::Side(number), range: [0.0, 1.0] };
        let first = patch.point(a_use.at(patch, 0.0));
        PLACES.iter().all(|&t| patch.point(a_use.at(patch, t)).distance(first) <= tolerance)
    };
    (0..patch.sides.len()).map(side).collect()
}
