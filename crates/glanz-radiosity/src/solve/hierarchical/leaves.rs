//! Form factors from each leaf to the other ends of its links and of those of its ancestors.
//!
//! A link distributes its light evenly over all leaves below its end. In corners this overestimates distant light and
//! underestimates light from behind an edge, so that errors of links accumulate there. The last solution therefore uses a form factor
//! from every leaf.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::gather::NodeLinks;
use super::hierarchy::{ElementHierarchy, HierarchyNode};
use crate::elements::ElementPoint;
use crate::form_factor::polygon::{from_point, in_front};
use crate::form_factor::{is_unoccluded, kernel};

/// Distance over radius below which the quadrature points of a polygon are too few to integrate over it.
const NEAR: f64 = 3.0;

/// Rays from a leaf to the other end of an ancestor's link that is partly occluded; one if it is not. Without the ray for unoccluded
/// links, the mean would be too bright.
const RAYS: usize = 2;

/// Rays per unit of form factor: few rays would see a large, partly occluded node entirely or not at all.
const RAYS_PER_FACTOR: f32 = 24.0;

/// Smallest number of nodes per task of a thread.
const MIN_NODES: usize = 64;

/// Form factors from each leaf to other nodes.
#[derive(Debug)]
pub(super) struct LeafFormFactors {
    /// Numbers of nodes with form factors, by the number of the leaf; empty for nodes with children.
    rows: Vec<Vec<(u32, f32)>>,
    pub(super) rays: u64,
}

impl LeafFormFactors {
    /// Computes them for all leaves; `None` if they would be more than `limit`.
    pub(super) fn new(
        hierarchy: &ElementHierarchy<'_>,
        node_links: &NodeLinks,
        limit: usize,
    ) -> Option<Self> {
        let leaves =
            || (0..hierarchy.nodes.len()).filter(|&number| hierarchy.nodes[number].children().is_empty());
        let count: usize = leaves()
            .map(|leaf| hierarchy.path(leaf).map(|node| node_links.of_node(node).len()).sum::<usize>())
            .sum();
        if count > limit {
            return None;
        }
        let made: Vec<(Vec<(u32, f32)>, u64)> = (0..hierarchy.nodes.len())
            .into_par_iter()
            .with_min_len(MIN_NODES)
            .map(|number| row(hierarchy, node_links, number))
            .collect();
        let rays = made.iter().map(|(_, rays)| rays).sum();
        Some(Self { rows: made.into_iter().map(|(row, _)| row).collect(), rays })
    }

    /// Irradiance of each leaf.
    pub(super) fn gather(&self, hierarchy: &ElementHierarchy<'_>) -> Vec<Spectrum> {
        let received = |row: &Vec<(u32, f32)>| {
            let mut received = Spectrum::BLACK;
            for &(node, factor) in row {
                received += hierarchy.light[node as usize].radiosity * factor;
            }
            received
        };
        self.rows.par_iter().with_min_len(MIN_NODES).map(received).collect()
    }
}

/// Form factors of a leaf, and the number of rays.
fn row(hierarchy: &ElementHierarchy<'_>, node_links: &NodeLinks, number: usize) -> (Vec<(u32, f32)>, u64) {
    let leaf = &hierarchy.nodes[number];
    let (mut row, mut rays) = (Vec::new(), 0);
    if !leaf.children().is_empty() {
        return (row, rays);
    }
    for node in hierarchy.path(number) {
        for end in node_links.of_node(node) {
            if node == number {
                row.push((end.node, end.factor));
                continue;
            }
            let other = &hierarchy.nodes[end.node as usize];
            let mut factor = form_factor(leaf, other) as f32;
            if factor > 0.0 {
                let count =
                    if end.visibility < 1.0 { RAYS } else { 1 }.max((RAYS_PER_FACTOR * factor) as usize);
                let (share, sent) =
                    sample_visibility(hierarchy, leaf, other, number ^ end.node as usize, count);
                rays += sent;
                factor *= share.unwrap_or(end.visibility);
            }
            if factor > 0.0 {
                row.push((end.node, factor));
            }
        }
    }
    let sum: f32 = row.iter().map(|(_, factor)| factor).sum();
    let scale = leaf.scale(sum);
    row.iter_mut().for_each(|(_, factor)| *factor *= scale);
    (row, rays)
}

/// The unoccluded fraction of at most `count` rays, and their number; `None` if no points face each other. `turn` varies their ends
/// between neighbouring leaves.
fn sample_visibility(
    hierarchy: &ElementHierarchy<'_>,
    leaf: &HierarchyNode,
    other: &HierarchyNode,
    turn: usize,
    count: usize,
) -> (Option<f32>, u64) {
    let (from, to) = (&leaf.extent.points, &other.extent.probes);
    let (mut free, mut sent) = (0_u8, 0_u8);
    // Opposite points of both, few of which neighbours use too; if they face away, the next ones.
    for i in 0..from.len() * to.len() {
        let (opposite, next) = (i % count, i / count);
        let start = &from[(turn / 2 + opposite * from.len().div_ceil(count) + next) % from.len()];
        let end = &to[(turn + opposite * to.len().div_ceil(count) + next / from.len()) % to.len()];
        if kernel(start, end) > 0.0 {
            sent += 1;
            free += u8::from(is_unoccluded(hierarchy.elements().scene, start, end));
            if usize::from(sent) == count {
                break;
            }
        }
    }
    ((sent > 0).then(|| f32::from(free) / f32::from(sent)), u64::from(sent))
}

/// Unoccluded form factor from a leaf to a node: the mean over the points of the leaf.
fn form_factor(leaf: &HierarchyNode, to: &HierarchyNode) -> f64 {
    let is_near = to.extent.center.distance(leaf.extent.center) < NEAR * to.extent.radius;
    let polygon = to.element.as_ref().and_then(|element| element.polygon.as_ref()).filter(|_| is_near);
    let factor = |from: &ElementPoint| match polygon {
        Some(corners) if (from.position - to.extent.center).dot(to.extent.axis) > 0.0 => {
            from_point(from.position, from.normal, &in_front(corners, from.position, from.normal))
        }
        Some(_) => 0.0,
        None => to.extent.points.iter().map(|node| kernel(from, node) * node.area).sum::<f64>().min(1.0),
    };
    let (sum, area) = leaf
        .extent
        .points
        .iter()
        .fold((0.0, 0.0), |(sum, area), from| (sum + from.area * factor(from), area + from.area));
    if area > 0.0 { sum / area } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;
    use glanz_scene::description::ShapeDescription;

    use super::*;
    use crate::elements::{ElementSettings, Elements};
    use crate::scenes::{parallelogram, scene};

    /// Half of the points of the inside of a tube face away from a wall; rays from these would say nothing about occlusion.
    #[test]
    fn rays_connect_points_that_face_each_other() {
        let tube = ShapeDescription::cylinder(0.1, [0.0, 2.0]);
        let wall = parallelogram(DVec3::new(1.0, -1.0, 0.0), DVec3::Z * 2.0, DVec3::Y * 2.0);
        let scene = scene(vec![(tube, 0.5, 0.0), (wall, 0.5, 0.0)]);
        let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
        let hierarchy = ElementHierarchy::new(elements, &|element| element.emission, 0.1);
        let side = |surface: u32, back: bool| {
            let is_side = |node: &&HierarchyNode| {
                node.element.as_ref().is_some_and(|e| e.patch.surface == surface && e.patch.back == back)
            };
            hierarchy.nodes.iter().find(is_side).unwrap()
        };
        let (inside, outside, wall) = (side(0, true), side(0, false), side(1, false));
        assert!(form_factor(inside, wall) > 0.0 && form_factor(outside, wall) > 0.0);
        for (turn, count) in (0..64).flat_map(|turn| [(turn, 1), (turn, 2), (turn, 5)]) {
            assert_eq!(sample_visibility(&hierarchy, inside, wall, turn, count), (Some(0.0), count as u64));
            assert_eq!(sample_visibility(&hierarchy, outside, wall, turn, count), (Some(1.0), count as u64));
        }
        let (share, rays) = sample_visibility(&hierarchy, wall, side(1, true), 0, 2);
        assert_eq!((share, rays), (None, 0));
    }
}
