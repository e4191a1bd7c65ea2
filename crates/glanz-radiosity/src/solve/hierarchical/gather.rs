//! Transport of light over links, for all nodes at once.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::hierarchy::ElementHierarchy;
use super::link::Link;

/// Smallest number of nodes per task of a thread.
const MIN_NODES: usize = 256;

/// The other end of a link of a node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinkEnd {
    pub(super) node: u32,
    /// Form factor from the node to the other end.
    pub(super) factor: f32,
    /// Unoccluded fraction, [0, 1].
    pub(super) visibility: f32,
}

/// The links of each node.
#[derive(Debug)]
pub(super) struct NodeLinks {
    /// Index of the first link of each node, and the number of all.
    first: Vec<usize>,
    /// The other ends of the links, node by node.
    list: Vec<LinkEnd>,
}

impl NodeLinks {
    /// Sorts links by node, for each node in the given order; `all`: also those without exchange.
    pub(super) fn new(hierarchy: &ElementHierarchy<'_>, links: &[Link], all: bool) -> Self {
        let carrying = || links.iter().filter(|link| all || link.exchange > 0.0);
        let mut first = vec![0; hierarchy.nodes.len() + 1];
        for link in carrying() {
            first[link.a as usize + 1] += 1;
            first[link.b as usize + 1] += usize::from(link.a != link.b);
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut list = vec![LinkEnd::default(); first.last().copied().unwrap_or(0)];
        let mut add = |at: u32, node: u32, link: &Link| {
            let slot = &mut next[at as usize];
            let factor = (f64::from(link.exchange) / hierarchy.nodes[at as usize].area) as f32;
            list[*slot] = LinkEnd { node, factor, visibility: link.visibility };
            *slot += 1;
        };
        for link in carrying() {
            add(link.a, link.b, link);
            if link.a != link.b {
                add(link.b, link.a, link);
            }
        }
        Self { first, list }
    }

    /// Irradiance of each node by its own links, and the sum of their form factors.
    pub(super) fn gather(&self, hierarchy: &ElementHierarchy<'_>) -> Vec<(Spectrum, f32)> {
        let received = |number: usize| {
            let mut received = (Spectrum::BLACK, 0.0);
            for end in self.of_node(number) {
                received.0 += hierarchy.light[end.node as usize].radiosity * end.factor;
                received.1 += end.factor;
            }
            received
        };
        (0..hierarchy.nodes.len()).into_par_iter().with_min_len(MIN_NODES).map(received).collect()
    }

    pub(super) fn of_node(&self, number: usize) -> &[LinkEnd] {
        &self.list[self.first[number]..self.first[number + 1]]
    }
}
