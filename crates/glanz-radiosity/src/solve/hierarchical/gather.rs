//! Light over links, all nodes at once.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::link::Link;
use super::tree::{Branch, Tree};
use crate::elements::Node;
use crate::form_factor::kernel;
use crate::form_factor::polygon::{from_point, in_front};

/// Nodes that one thread takes at once, at least.
const BLOCK: usize = 256;

/// Distance over radius below which the places of a polygon do not integrate over it.
const NEAR: f64 = 3.0;

/// One end of a link, seen from the other.
#[derive(Clone, Copy, Debug, Default)]
struct Source {
    node: u32,
    /// Share of its radiosity that arrives.
    factor: f32,
    /// What of it nothing stands in the way of.
    free: f32,
}

/// The links of each node.
#[derive(Debug)]
pub(super) struct Neighbours {
    /// Where those of a node begin.
    begins: Vec<usize>,
    /// The other ends.
    list: Vec<Source>,
}

impl Neighbours {
    /// Sorted by node, for each in the order of the links.
    pub(super) fn new(tree: &Tree<'_>, links: &[Link]) -> Self {
        let carrying = || links.iter().filter(|link| link.exchange > 0.0);
        let mut begins = vec![0; tree.branches.len() + 1];
        for link in carrying() {
            begins[link.a as usize + 1] += 1;
            begins[link.b as usize + 1] += usize::from(link.a != link.b);
        }
        for i in 1..begins.len() {
            begins[i] += begins[i - 1];
        }
        let mut ends = begins.clone();
        let mut list = vec![Source::default(); begins.last().copied().unwrap_or(0)];
        let mut put = |at: u32, node: u32, link: &Link| {
            let end = &mut ends[at as usize];
            let factor = (f64::from(link.exchange) / tree.branches[at as usize].area) as f32;
            list[*end] = Source { node, factor, free: link.free };
            *end += 1;
        };
        for link in carrying() {
            put(link.a, link.b, link);
            if link.a != link.b {
                put(link.b, link.a, link);
            }
        }
        Self { begins, list }
    }

    /// What the links of each node bring to it alone, and their form factors.
    pub(super) fn gather(&self, tree: &Tree<'_>) -> Vec<(Spectrum, f32)> {
        let of = |number: usize| {
            let mut received = (Spectrum::BLACK, 0.0);
            for source in self.of(number) {
                received.0 += tree.light[source.node as usize].radiosity * source.factor;
                received.1 += source.factor;
            }
            received
        };
        (0..tree.branches.len()).into_par_iter().with_min_len(BLOCK).map(of).collect()
    }

    /// What all links of a leaf and of the nodes above it bring to it with their form factors, if these do not spread their light
    /// evenly but as the leaf sees the other end: what they say of what stands between is kept. Nothing for nodes that are no leaves.
    pub(super) fn gather_at_leaves(&self, tree: &Tree<'_>) -> Vec<(Spectrum, f32)> {
        let of = |number: usize| {
            let leaf = &tree.branches[number];
            let (mut received, mut factors) = (Spectrum::BLACK, 0.0_f32);
            if !leaf.children().is_empty() {
                return (received, factors);
            }
            let mut above = Some(number as u32);
            while let Some(node) = above {
                for source in self.of(node as usize) {
                    let factor = if node as usize == number {
                        source.factor
                    } else {
                        source.free * form_factor(leaf, &tree.branches[source.node as usize]) as f32
                    };
                    received += tree.light[source.node as usize].radiosity * factor;
                    factors += factor;
                }
                above = tree.branches[node as usize].parent();
            }
            // More than all is an error.
            let scale = 1.0 / factors.max(1.0);
            (received * scale, factors * scale)
        };
        (0..tree.branches.len()).into_par_iter().with_min_len(BLOCK).map(of).collect()
    }

    fn of(&self, number: usize) -> &[Source] {
        &self.list[self.begins[number]..self.begins[number + 1]]
    }
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
    let (sum, area) = leaf.extent.nodes.iter().fold((0.0, 0.0), |(sum, area), from| {
        (sum + from.area * of(from), area + from.area)
    });
    if area > 0.0 { sum / area } else { 0.0 }
}
