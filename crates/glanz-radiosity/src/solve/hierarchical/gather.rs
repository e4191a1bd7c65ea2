//! Light over links, all nodes at once.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::link::Link;
use super::tree::Tree;

/// Nodes that one thread takes at once, at least.
const BLOCK: usize = 256;

/// The links of each node.
#[derive(Debug)]
pub(super) struct Neighbours {
    /// Where those of a node begin.
    begins: Vec<usize>,
    /// The other node, and the share of its radiosity that arrives.
    list: Vec<(u32, f32)>,
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
        let mut list = vec![(0, 0.0); begins.last().copied().unwrap_or(0)];
        let mut put = |at: u32, other: u32, exchange: f32| {
            let end = &mut ends[at as usize];
            list[*end] = (other, (f64::from(exchange) / tree.branches[at as usize].area) as f32);
            *end += 1;
        };
        for link in carrying() {
            put(link.a, link.b, link.exchange);
            if link.a != link.b {
                put(link.b, link.a, link.exchange);
            }
        }
        Self { begins, list }
    }

    /// What the links of each node bring to it alone.
    pub(super) fn gather(&self, tree: &Tree<'_>) -> Vec<Spectrum> {
        let of = |ends: &[usize]| {
            let mut received = Spectrum::BLACK;
            for &(other, share) in &self.list[ends[0]..ends[1]] {
                received += tree.light[other as usize].radiosity * share;
            }
            received
        };
        self.begins.par_windows(2).with_min_len(BLOCK).map(of).collect()
    }
}
