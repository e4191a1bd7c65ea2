//! Links: what two nodes exchange, and how much more or less it may be.

use glanz_scene::Scene;

use super::extent::{CORNERS, can_face};
use super::tree::{Branch, Tree};
use crate::elements::{Elements, Node, Patch};
use crate::form_factor::polygon::{self, in_front};
use crate::form_factor::{is_free, kernel};

/// Sum of the radii over the distance above which the few places of two elements do not tell how the kernel varies, nor
/// integrate it.
const NEAR: f64 = 0.7;

/// Two nodes that exchange light, both ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub(super) a: u32,
    /// Not less than `a`; the same where a node sees itself.
    pub(super) b: u32,
    /// Area times form factor, m^2.
    pub(super) exchange: f32,
    /// How much more or less it may be for what is anywhere on one node and comes from anywhere on the other, m^2.
    pub(super) doubt: f32,
    /// Share of it that nothing stands in the way of.
    pub(super) free: f32,
}

/// What the positions of two nodes say, before rays do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Geometry {
    /// Largest exchange if nothing stands between.
    pub(super) most: f64,
    /// Largest less smallest exchange.
    pub(super) doubt: f64,
}

/// What rays say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Of those that could carry light, the share by the kernel that nothing stops.
    share: f64,
    pub(super) rays: u32,
}

impl Tree<'_> {
    /// Bounds on what two nodes exchange; `None` if it is nothing.
    ///
    /// The kernel lies in a range over both; light of whatever distribution on one then meets any place of the other with no
    /// larger error than its flux times the width of that range (@smits1994 section 3 for clusters). For elements that are not
    /// near each other the range is that over their corners and middles; of other pairs, spheres and cones bound it.
    pub(super) fn geometry(&self, a: u32, b: u32) -> Option<Geometry> {
        let (p, q) = (&self.branches[a as usize], &self.branches[b as usize]);
        let smaller = p.area.min(q.area);
        if a == b {
            return self.of_itself(p);
        }
        let bounds = p.extent.range(&q.extent);
        if bounds.high == 0.0 {
            return None;
        }
        let scale = p.area * q.area;
        let Some((first, second)) = p.element.as_ref().zip(q.element.as_ref()) else {
            // Light that leaves one arrives once at most.
            let most = smaller.min(scale * bounds.high);
            return Some(Geometry { most, doubt: (most - scale * bounds.low).max(0.0) });
        };
        if !can_face(first, second) {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for kernel in pairs(&p.extent.probes, &q.extent.probes).map(|(a, b)| kernel(a, b)) {
            (low, high) = (low.min(kernel), high.max(kernel));
        }
        let flat = first.polygon.is_some() && second.polygon.is_some();
        if high == 0.0 && !flat {
            return None;
        }
        if p.extent.nearness(&q.extent) > NEAR {
            let most = smaller.min(scale * bounds.high);
            return Some(Geometry { most, doubt: most });
        }
        let most = smaller.min(scale * high);
        Some(Geometry { most, doubt: most - smaller.min(scale * low) })
    }

    /// What a node sees of itself.
    ///
    /// In a part that is a graph over a plane, with normals no farther than s from that of the plane, lines between two places lie
    /// within 2 s of their tangent planes: the form factor is at most sin^2 2 s.
    fn of_itself(&self, node: &Branch) -> Option<Geometry> {
        if let Some(element) = &node.element {
            let probes = &node.extent.probes;
            if element.polygon.is_some() || pairs(probes, probes).all(|(a, b)| kernel(a, b) == 0.0) {
                return None;
            }
        }
        let steepest = (2.0 * node.extent.spread).min(std::f64::consts::FRAC_PI_2);
        let most = if node.element.is_some() { node.area * steepest.sin().powi(2) } else { node.area };
        Some(Geometry { most, doubt: most })
    }

    /// Area times form factor if nothing stands between, by the places of the nodes, or where these are near to each other in closed
    /// form or by more places.
    pub(super) fn unoccluded(&self, a: u32, b: u32, most: f64) -> f64 {
        let (p, q) = (&self.branches[a as usize], &self.branches[b as usize]);
        let is_near = p.extent.nearness(&q.extent) > NEAR;
        let sum = match (&p.element, &q.element) {
            (Some(first), Some(second)) if is_near => match (&first.polygon, &second.polygon) {
                (Some(corners), Some(others)) => polygon::exchange(
                    &in_front(corners, second.center.position, second.center.normal),
                    &in_front(others, first.center.position, first.center.normal),
                ),
                _ => {
                    let [mine, others] = [p, q].map(|branch| fine(self.elements(), branch));
                    quadrature(&mine, &others)
                }
            },
            _ => quadrature(&p.extent.nodes, &q.extent.nodes),
        };
        sum.min(most)
    }

    /// Sends rays between the places of two nodes: each corner of one to a corner of the other, and middle to middle.
    pub(super) fn look(&self, a: u32, b: u32) -> Seen {
        let (p, q) = (&self.branches[a as usize], &self.branches[b as usize]);
        let probes = |branch: &Branch| {
            let all = branch.extent.probes.len();
            if branch.element.is_some() { all.min(CORNERS) } else { all }
        };
        let (m, n) = (probes(p), probes(q));
        let (from, to) = (&p.extent.probes[..m], &q.extent.probes[..n]);
        // Neighbours look along other lines.
        let turn = (a ^ b) as usize;
        let mut seen = Seen { share: 0.0, rays: 0 };
        let (mut free, mut all) = (0.0, 0.0);
        for i in 0..m.max(n) {
            let (Some(start), Some(end)) = (from.get(i % m.max(1)), to.get((i + turn) % n.max(1))) else {
                continue;
            };
            let weight = kernel(start, end);
            if weight > 0.0 {
                seen.rays += 1;
                all += weight;
                free += if is_free(self.scene(), start, end) { weight } else { 0.0 };
            }
        }
        seen.share = if all > 0.0 { free / all } else { 1.0 };
        seen
    }

    fn scene(&self) -> &Scene {
        self.elements().scene
    }
}

impl Link {
    /// With what rays have said. If they all say the same, others may still not: by Laplace's rule of succession one of n + 2 is
    /// taken to (departure: @hanrahan1991 takes them at their word). If they do not, all is in doubt.
    pub(super) fn new([a, b]: [u32; 2], geometry: &Geometry, unoccluded: f64, seen: &Seen) -> Self {
        let other = 1.0 / f64::from(seen.rays + 2);
        let doubt = if seen.share == 1.0 {
            geometry.doubt.max(other * geometry.most)
        } else if seen.share == 0.0 {
            other * geometry.most
        } else {
            geometry.most
        };
        let exchange = (seen.share * unoccluded) as f32;
        Self { a, b, exchange, doubt: doubt as f32, free: seen.share as f32 }
    }
}

fn pairs<'a>(a: &'a [Node], b: &'a [Node]) -> impl Iterator<Item = (&'a Node, &'a Node)> {
    a.iter().flat_map(move |a| b.iter().map(move |b| (a, b)))
}

/// The double integral of the kernel. Places that nearly touch would see more than there is: no pair exchanges more than the
/// smaller of its areas. A place and itself are left out, and the others stand for them.
fn quadrature(a: &[Node], b: &[Node]) -> f64 {
    let (mut sum, mut taken, mut all) = (0.0, 0.0, 0.0);
    for (p, q) in pairs(a, b) {
        all += p.area * q.area;
        if p.position != q.position {
            taken += p.area * q.area;
            sum += (kernel(p, q) * p.area * q.area).min(p.area.min(q.area));
        }
    }
    if taken > 0.0 { sum * all / taken } else { 0.0 }
}

/// The places of the quarters of an element.
fn fine(elements: &Elements<'_>, branch: &Branch) -> Vec<Node> {
    let Some(element) = &branch.element else { return branch.extent.nodes.clone() };
    let quarters = element.patch.part.quarters();
    let patches = quarters.into_iter().map(|part| Patch { part, ..element.patch });
    let mut nodes: Vec<Node> = patches.flat_map(|patch| elements.nodes(&patch)).collect();
    let scale = branch.area / nodes.iter().map(|node| node.area).sum::<f64>();
    nodes.iter_mut().for_each(|node| node.area *= scale);
    nodes
}
