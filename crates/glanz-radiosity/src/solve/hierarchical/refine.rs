//! Refinement: links whose error is too large are replaced by links between children of their nodes.

use glanz_job::Interrupted;
use rayon::prelude::*;

use super::hierarchy::ElementHierarchy;
use super::link::{ExchangeBounds, Link};

/// Links that are divided between two tests for cancelling.
const LINKS_AT_ONCE: usize = 1 << 13;

/// A pair of nodes whose link may have to be divided.
#[derive(Clone, Copy, Debug)]
struct OpenLink {
    nodes: [u32; 2],
    /// `None` if the bounds without rays show that it has to be divided.
    link: Option<Link>,
}

/// All links, and the effort spent on them.
#[derive(Debug, Default)]
pub(super) struct Refinement {
    pub(super) links: Vec<Link>,
    pub(super) rays: u64,
    /// Whether refinement ended early, because of the number of links or elements, or because it was cancelled.
    pub(super) stopped: bool,
}

/// Accuracy and number of links at which refinement ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct RefinementGoal {
    /// Largest error of the flux of a link, in units of radiosity times m^2.
    pub(super) error: f64,
    /// Largest number of links, approximately.
    pub(super) links: usize,
    /// Largest number of elements.
    pub(super) elements: usize,
}

/// Result of the division of a link.
#[derive(Debug, Default)]
struct LinkSplit {
    open: Vec<OpenLink>,
    done: Vec<Link>,
    rays: u64,
}

impl ElementHierarchy<'_> {
    /// Error of the flux between two nodes for an error of their exchange, m^2.
    pub(super) fn flux_error(&self, [a, b]: [u32; 2], error: f64) -> f64 {
        let radiosity = |node: u32| self.light[node as usize].radiosity.max_component();
        f64::from(radiosity(a).max(radiosity(b))) * error
    }

    /// The node of a pair to divide: the larger one, or the other if the larger one is not divisible.
    fn divided(&self, [a, b]: [u32; 2]) -> Option<u32> {
        let [p, q] = [a, b].map(|node| &self.nodes[node as usize]);
        let (first, second) = if p.extent.radius >= q.extent.radius { (a, b) } else { (b, a) };
        [first, second].into_iter().find(|&node| self.nodes[node as usize].is_divisible())
    }

    /// Whether the link of a pair has to be divided and can be.
    fn is_open(&self, nodes: [u32; 2], error: f64, goal: &RefinementGoal) -> bool {
        self.flux_error(nodes, error) > goal.error && self.divided(nodes).is_some()
    }

    /// The link of a pair, with visibility by rays.
    fn link(&self, nodes: [u32; 2], bounds: &ExchangeBounds, rays: &mut u64) -> Link {
        let visibility = self.sample_visibility(nodes[0], nodes[1]);
        *rays += u64::from(visibility.rays);
        Link::new(nodes, bounds, self.unoccluded(nodes[0], nodes[1], bounds.most), &visibility)
    }

    /// Replaces a link by those of the children of one of its nodes.
    fn split(&self, open: &OpenLink, goal: &RefinementGoal) -> LinkSplit {
        let mut split = LinkSplit::default();
        let nodes = open.nodes;
        let children = self.divided(nodes).map_or(&[][..], |node| self.nodes[node as usize].children());
        if children.is_empty() {
            // Trimming left no quarters of the node to divide: the other node is next, if it is divisible.
            if self.divided(nodes).is_some() {
                split.open.push(*open);
            } else {
                let (link, rays) = open.completed(self);
                (split.done, split.rays) = (link.into_iter().collect(), rays);
            }
            return split;
        }
        let divided = self.divided(nodes);
        let mut add = |a: u32, b: u32| {
            let nodes = [a.min(b), a.max(b)];
            let Some(bounds) = self.exchange_bounds(nodes[0], nodes[1]) else { return };
            if self.is_open(nodes, bounds.error, goal) {
                split.open.push(OpenLink { nodes, link: None });
                return;
            }
            let link = self.link(nodes, &bounds, &mut split.rays);
            if self.is_open(nodes, f64::from(link.error), goal) {
                split.open.push(OpenLink { nodes, link: Some(link) });
            } else {
                split.done.push(link);
            }
        };
        if nodes[0] == nodes[1] {
            for (i, &a) in children.iter().enumerate() {
                children[i..].iter().for_each(|&b| add(a, b));
            }
        } else {
            let other = if divided == Some(nodes[0]) { nodes[1] } else { nodes[0] };
            children.iter().for_each(|&child| add(child, other));
        }
        split
    }
}

impl Refinement {
    /// Starts with the link of the root with itself.
    pub(super) fn new(hierarchy: &ElementHierarchy<'_>) -> Self {
        let mut new = Self::default();
        let bounds = if hierarchy.nodes.is_empty() { None } else { hierarchy.exchange_bounds(0, 0) };
        new.links.extend(bounds.map(|bounds| hierarchy.link([0, 0], &bounds, &mut new.rays)));
        new
    }

    /// Divides links until the goal is met or nodes have their smallest size.
    ///
    /// Links are divided level by level, so that the numbers of new nodes do not depend on threads. `pause` is called repeatedly; after
    /// an error no further link is divided, and rays are traced for links that have none.
    pub(super) fn refine(
        &mut self,
        hierarchy: &mut ElementHierarchy<'_>,
        goal: &RefinementGoal,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let links = std::mem::take(&mut self.links);
        let mut open = Vec::new();
        for link in links {
            if hierarchy.is_open([link.a, link.b], f64::from(link.error), goal) {
                open.push(OpenLink { nodes: [link.a, link.b], link: Some(link) });
            } else {
                self.links.push(link);
            }
        }
        while !open.is_empty() && !self.stopped {
            let mut whole: Vec<u32> = open.iter().filter_map(|open| hierarchy.divided(open.nodes)).collect();
            whole.retain(|&node| hierarchy.nodes[node as usize].children().is_empty());
            whole.sort_unstable();
            whole.dedup();
            // Each element that is divided leaves four.
            self.stopped |= !whole.is_empty() && hierarchy.leaves() + 3 * whole.len() > goal.elements;
            if self.stopped {
                break;
            }
            hierarchy.divide(&whole);
            let mut next = Vec::new();
            for chunk in open.chunks(LINKS_AT_ONCE) {
                self.stopped |= self.links.len() + next.len() > goal.links || pause().is_err();
                if self.stopped {
                    next.extend_from_slice(chunk);
                    continue;
                }
                let splits: Vec<LinkSplit> =
                    chunk.par_iter().map(|open| hierarchy.split(open, goal)).collect();
                for split in splits {
                    self.rays += split.rays;
                    self.links.extend(split.done);
                    next.extend(split.open);
                }
            }
            open = next;
        }
        let rest: Vec<(Option<Link>, u64)> = open.par_iter().map(|open| open.completed(hierarchy)).collect();
        for (link, rays) in rest {
            self.links.extend(link);
            self.rays += rays;
        }
    }
}

impl OpenLink {
    /// The link without further division, and the number of rays.
    fn completed(&self, hierarchy: &ElementHierarchy<'_>) -> (Option<Link>, u64) {
        let mut rays = 0;
        let [a, b] = self.nodes;
        let made =
            || hierarchy.exchange_bounds(a, b).map(|bounds| hierarchy.link([a, b], &bounds, &mut rays));
        let link = self.link.or_else(made);
        (link, rays)
    }
}
