//! Links whose error is too large become links between what is below.

use glanz_job::Interrupted;
use rayon::prelude::*;

use super::link::{Geometry, Link};
use super::tree::Tree;

/// Links that are divided between two questions whether to go on.
const CHUNK: usize = 1 << 13;

/// A link on its way.
#[derive(Clone, Copy, Debug)]
struct Open {
    nodes: [u32; 2],
    /// `None` if it was clear without rays that it has to be divided.
    link: Option<Link>,
}

/// Links, and what it took to find them.
#[derive(Debug, Default)]
pub(super) struct Refinement {
    pub(super) links: Vec<Link>,
    pub(super) rays: u64,
    /// Whether links were left as they were because of their number or on demand.
    pub(super) stopped: bool,
}

/// When links are good enough, and how many there may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    /// Largest flux that one may carry too much or too little.
    pub(super) error: f64,
    pub(super) links: usize,
}

/// What became of the quarters of a link.
#[derive(Debug, Default)]
struct Split {
    open: Vec<Open>,
    done: Vec<Link>,
    rays: u64,
}

impl Tree<'_> {
    /// Flux that a doubt may cost.
    pub(super) fn error(&self, [a, b]: [u32; 2], doubt: f64) -> f64 {
        let radiosity = |node: u32| self.light[node as usize].radiosity.max_component();
        f64::from(radiosity(a).max(radiosity(b))) * doubt
    }

    /// The node of a pair to be divided: the larger one, or the other if that cannot be.
    fn divided(&self, [a, b]: [u32; 2]) -> Option<u32> {
        let [p, q] = [a, b].map(|node| &self.branches[node as usize]);
        let (first, second) = if p.extent.radius >= q.extent.radius { (a, b) } else { (b, a) };
        [first, second].into_iter().find(|&node| self.branches[node as usize].is_divisible())
    }

    /// Whether a pair has to be divided, and can be.
    fn is_open(&self, nodes: [u32; 2], doubt: f64, demand: &Demand) -> bool {
        self.error(nodes, doubt) > demand.error && self.divided(nodes).is_some()
    }

    /// The link of a pair, with rays.
    fn link(&self, nodes: [u32; 2], geometry: &Geometry, rays: &mut u64) -> Link {
        let seen = self.look(nodes[0], nodes[1]);
        *rays += u64::from(seen.rays);
        Link::new(nodes, geometry, self.unoccluded(nodes[0], nodes[1], geometry.most), &seen)
    }

    /// The links below a pair of which one node is divided.
    fn split(&self, open: &Open, demand: &Demand) -> Split {
        let mut split = Split::default();
        let nodes = open.nodes;
        let children = self.divided(nodes).map_or(&[][..], |node| self.branches[node as usize].children());
        if children.is_empty() {
            // Nothing of what was to be divided has quarters: the other node is next, or none.
            if self.divided(nodes).is_some() {
                split.open.push(*open);
            } else {
                let (link, rays) = open.settled(self);
                (split.done, split.rays) = (link.into_iter().collect(), rays);
            }
            return split;
        }
        let divided = self.divided(nodes);
        let mut take = |a: u32, b: u32| {
            let nodes = [a.min(b), a.max(b)];
            let Some(geometry) = self.geometry(nodes[0], nodes[1]) else { return };
            if self.is_open(nodes, geometry.doubt, demand) {
                split.open.push(Open { nodes, link: None });
                return;
            }
            let link = self.link(nodes, &geometry, &mut split.rays);
            if self.is_open(nodes, f64::from(link.doubt), demand) {
                split.open.push(Open { nodes, link: Some(link) });
            } else {
                split.done.push(link);
            }
        };
        if nodes[0] == nodes[1] {
            for (i, &a) in children.iter().enumerate() {
                children[i..].iter().for_each(|&b| take(a, b));
            }
        } else {
            let other = if divided == Some(nodes[0]) { nodes[1] } else { nodes[0] };
            children.iter().for_each(|&child| take(child, other));
        }
        split
    }
}

impl Refinement {
    /// The one link from which all others come: of everything with itself.
    pub(super) fn new(tree: &Tree<'_>) -> Self {
        let mut new = Self::default();
        let geometry = if tree.branches.is_empty() { None } else { tree.geometry(0, 0) };
        new.links.extend(geometry.map(|geometry| tree.link([0, 0], &geometry, &mut new.rays)));
        new
    }

    /// Divides until the demand is met or nodes are as small as they may be.
    ///
    /// Level by level: which nodes are divided, and so their numbers, does not depend on threads. `pause`: called now and then; after
    /// an error every link stays where it is, and those without rays get some.
    pub(super) fn refine(
        &mut self,
        tree: &mut Tree<'_>,
        demand: &Demand,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let links = std::mem::take(&mut self.links);
        let mut open = Vec::new();
        for link in links {
            if tree.is_open([link.a, link.b], f64::from(link.doubt), demand) {
                open.push(Open { nodes: [link.a, link.b], link: Some(link) });
            } else {
                self.links.push(link);
            }
        }
        while !open.is_empty() && !self.stopped {
            let mut whole: Vec<u32> = open.iter().filter_map(|open| tree.divided(open.nodes)).collect();
            whole.retain(|&node| tree.branches[node as usize].children().is_empty());
            whole.sort_unstable();
            whole.dedup();
            tree.divide(&whole);
            let mut next = Vec::new();
            for chunk in open.chunks(CHUNK) {
                self.stopped |= self.links.len() + next.len() > demand.links || pause().is_err();
                if self.stopped {
                    next.extend_from_slice(chunk);
                    continue;
                }
                let splits: Vec<Split> = chunk.par_iter().map(|open| tree.split(open, demand)).collect();
                for split in splits {
                    self.rays += split.rays;
                    self.links.extend(split.done);
                    next.extend(split.open);
                }
            }
            open = next;
        }
        let rest: Vec<(Option<Link>, u64)> = open.par_iter().map(|open| open.settled(tree)).collect();
        for (link, rays) in rest {
            self.links.extend(link);
            self.rays += rays;
        }
    }
}

impl Open {
    /// The link as it is.
    fn settled(&self, tree: &Tree<'_>) -> (Option<Link>, u64) {
        let mut rays = 0;
        let [a, b] = self.nodes;
        let made = || tree.geometry(a, b).map(|geometry| tree.link([a, b], &geometry, &mut rays));
        let link = self.link.or_else(made);
        (link, rays)
    }
}
