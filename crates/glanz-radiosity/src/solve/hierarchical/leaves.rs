//! Light as each leaf sees the other ends of its links, and of those of the nodes above it.
//!
//! A link brings its light evenly to all that is below its end. In a corner that is too much of what is far and too little of what
//! is behind an edge: errors of links would gather there. In the end every leaf looks itself.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::gather::Neighbours;
use super::tree::{Branch, Tree};
use crate::elements::Node;
use crate::form_factor::polygon::{from_point, in_front};
use crate::form_factor::{is_free, kernel};

/// Distance over radius below which the places of a polygon do not integrate over it.
const NEAR: f64 = 3.0;

/// Rays from a leaf to the other end of a link of a node above, if something is in the way of that; otherwise one. Were only the
/// latter taken at their word, too much light would arrive in the mean.
const RAYS: usize = 2;

/// Rays for what fills the whole view of a leaf: what is near and hidden in part would be seen whole or not at all by a few.
const PER_FACTOR: f32 = 24.0;

/// Nodes that one thread takes at once, at least.
const BLOCK: usize = 64;

/// Form factors from each leaf to the other ends.
#[derive(Debug)]
pub(super) struct Leaves {
    /// By the number of the branch; none where it is no leaf.
    rows: Vec<Vec<(u32, f32)>>,
    pub(super) rays: u64,
}

impl Leaves {
    /// Of all leaves; `None` if they would be more than `limit`.
    pub(super) fn new(tree: &Tree<'_>, neighbours: &Neighbours, limit: usize) -> Option<Self> {
        let leaves =
            || (0..tree.branches.len()).filter(|&number| tree.branches[number].children().is_empty());
        let count: usize =
            leaves().map(|leaf| tree.path(leaf).map(|node| neighbours.of(node).len()).sum::<usize>()).sum();
        if count > limit {
            return None;
        }
        let made: Vec<(Vec<(u32, f32)>, u64)> = (0..tree.branches.len())
            .into_par_iter()
            .with_min_len(BLOCK)
            .map(|number| row(tree, neighbours, number))
            .collect();
        let rays = made.iter().map(|(_, rays)| rays).sum();
        Some(Self { rows: made.into_iter().map(|(row, _)| row).collect(), rays })
    }

    /// What meets each leaf.
    pub(super) fn gather(&self, tree: &Tree<'_>) -> Vec<Spectrum> {
        let of = |row: &Vec<(u32, f32)>| {
            let mut received = Spectrum::BLACK;
            for &(node, factor) in row {
                received += tree.light[node as usize].radiosity * factor;
            }
            received
        };
        self.rows.par_iter().with_min_len(BLOCK).map(of).collect()
    }
}

/// Form factors of a leaf, and the rays that it took.
fn row(tree: &Tree<'_>, neighbours: &Neighbours, number: usize) -> (Vec<(u32, f32)>, u64) {
    let leaf = &tree.branches[number];
    let (mut row, mut rays) = (Vec::new(), 0);
    if !leaf.children().is_empty() {
        return (row, rays);
    }
    for node in tree.path(number) {
        for source in neighbours.of(node) {
            if node == number {
                row.push((source.node, source.factor));
                continue;
            }
            let other = &tree.branches[source.node as usize];
            let mut factor = form_factor(leaf, other) as f32;
            if factor > 0.0 {
                let count = if source.free < 1.0 { RAYS } else { 1 }.max((PER_FACTOR * factor) as usize);
                let (share, sent) = look(tree, leaf, other, number ^ source.node as usize, count);
                rays += sent;
                factor *= share.unwrap_or(source.free);
            }
            if factor > 0.0 {
                row.push((source.node, factor));
            }
        }
    }
    let sum: f32 = row.iter().map(|(_, factor)| factor).sum();
    let scale = leaf.scale(sum);
    row.iter_mut().for_each(|(_, factor)| *factor *= scale);
    (row, rays)
}

/// The share of a few rays that arrive, and how many there were; `None` if no places face each other.
fn look(tree: &Tree<'_>, leaf: &Branch, other: &Branch, turn: usize, count: usize) -> (Option<f32>, u64) {
    let (from, to) = (&leaf.extent.nodes, &other.extent.probes);
    let (mut free, mut sent) = (0_u8, 0_u8);
    // Opposite places of both, of which few are the same as those of neighbours; if these face away, the next ones.
    for i in 0..from.len() * to.len() {
        let (opposite, next) = (i % count, i / count);
        let start = &from[(turn / 2 + opposite * from.len().div_ceil(count) + next) % from.len()];
        let end = &to[(turn + opposite * to.len().div_ceil(count) + next / from.len()) % to.len()];
        if kernel(start, end) > 0.0 {
            sent += 1;
            free += u8::from(is_free(tree.elements().scene, start, end));
            if usize::from(sent) == count {
                break;
            }
        }
    }
    ((sent > 0).then(|| f32::from(free) / f32::from(sent)), u64::from(sent))
}

/// From a leaf to a node if nothing stands between: the mean over the places of the leaf.
fn form_factor(leaf: &Branch, to: &Branch) -> f64 {
    let is_near = to.extent.center.distance(leaf.extent.center) < NEAR * to.extent.radius;
    let polygon = to.element.as_ref().and_then(|element| element.polygon.as_ref()).filter(|_| is_near);
    let of = |from: &Node| match polygon {
        Some(corners) if (from.position - to.extent.center).dot(to.extent.axis) > 0.0 => {
            from_point(from.position, from.normal, &in_front(corners, from.position, from.normal))
        }
        Some(_) => 0.0,
        None => to.extent.nodes.iter().map(|node| kernel(from, node) * node.area).sum::<f64>().min(1.0),
    };
    let (sum, area) = leaf
        .extent
        .nodes
        .iter()
        .fold((0.0, 0.0), |(sum, area), from| (sum + from.area * of(from), area + from.area));
    if area > 0.0 { sum / area } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;
    use glanz_scene::description::ShapeDescription;

    use super::*;
    use crate::elements::{ElementSettings, Elements};
    use crate::scenes::{parallelogram, scene};

    /// Of the inside of a tube half of any places face away from a wall; what is behind the other half does not follow from the tube's
    /// surroundings.
    #[test]
    fn rays_begin_and_end_at_places_that_face_each_other() {
        let tube = ShapeDescription::cylinder(0.1, [0.0, 2.0]);
        let wall = parallelogram(DVec3::new(1.0, -1.0, 0.0), DVec3::Z * 2.0, DVec3::Y * 2.0);
        let scene = scene(vec![(tube, 0.5, 0.0), (wall, 0.5, 0.0)]);
        let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
        let tree = Tree::new(elements, &|element| element.emission, 0.1);
        let side = |surface: u32, back: bool| {
            let is_it = |branch: &&Branch| {
                branch.element.as_ref().is_some_and(|e| e.patch.surface == surface && e.patch.back == back)
            };
            tree.branches.iter().find(is_it).unwrap()
        };
        let (inside, outside, wall) = (side(0, true), side(0, false), side(1, false));
        assert!(form_factor(inside, wall) > 0.0 && form_factor(outside, wall) > 0.0);
        for (turn, count) in (0..64).flat_map(|turn| [(turn, 1), (turn, 2), (turn, 5)]) {
            assert_eq!(look(&tree, inside, wall, turn, count), (Some(0.0), count as u64));
            assert_eq!(look(&tree, outside, wall, turn, count), (Some(1.0), count as u64));
        }
        let (share, rays) = look(&tree, wall, side(1, true), 0, 2);
        assert_eq!((share, rays), (None, 0));
    }
}
