//! Light over links, all nodes at once.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::link::Link;
use super::tree::Tree;

/// Nodes that one thread takes at once, at least.
const BLOCK: usize = 256;

/// One end of a link, seen from the other.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source {
    pub(super) node: u32,
    /// Share of its radiosity that arrives.
    pub(super) factor: f32,
    /// What of it nothing stands in the way of.
    pub(super) free: f32,
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
    /// Sorted by node, for each in the order of the links; those that carry nothing are left out on demand.
    pub(super) fn new(tree: &Tree<'_>, links: &[Link], all: bool) -> Self {
        let carrying = || links.iter().filter(|link| all || link.exchange > 0.0);
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

    pub(super) fn of(&self, number: usize) -> &[Source] {
        &self.list[self.begins[number]..self.begins[number + 1]]
    }
}
