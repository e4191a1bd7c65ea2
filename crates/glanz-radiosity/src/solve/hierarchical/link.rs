//! Links: the exchange of light between two nodes, with a bound on its error.

use glanz_scene::Scene;

use super::extent::{CORNERS, can_face};
use super::hierarchy::{ElementHierarchy, HierarchyNode};
use crate::elements::{ElementPoint, Elements, Patch};
use crate::form_factor::polygon::{self, in_front};
use crate::form_factor::{is_unoccluded, kernel};

/// Sum of the radii over the distance above which the few points of two elements neither represent the variation of the kernel nor
/// integrate it.
const NEAR: f64 = 0.7;

/// Two nodes that exchange light in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub(super) a: u32,
    /// Number of the second node, `a` or more; `a` for the link of a node with itself.
    pub(super) b: u32,
    /// Area times form factor, m^2.
    pub(super) exchange: f32,
    /// Largest error of the exchange for any distribution of light on the two nodes, m^2.
    pub(super) error: f32,
    /// Unoccluded fraction, [0, 1].
    pub(super) visibility: f32,
}

/// Bounds on the exchange of two nodes from their extents, without rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExchangeBounds {
    /// Largest unoccluded exchange, m^2.
    pub(super) most: f64,
    /// Difference of the largest and smallest exchange, m^2.
    pub(super) error: f64,
}

/// Visibility of two nodes by shadow rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VisibilitySample {
    /// Unoccluded fraction of the rays, weighted by the kernel, [0, 1].
    fraction: f64,
    /// Number of rays.
    pub(super) rays: u32,
}

impl ElementHierarchy<'_> {
    /// Bounds on the exchange of two nodes; `None` if they exchange nothing.
    ///
    /// The kernel has a range over both nodes. For any distribution of light on one of them, the error of the irradiance at any point of the
    /// other is at most the flux times the width of that range (@smits1994 section 3 for clusters). For elements that are not near each
    /// other the range is taken over their probes; for other pairs it is bounded by spheres and cones.
    pub(super) fn exchange_bounds(&self, a: u32, b: u32) -> Option<ExchangeBounds> {
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let smaller = p.area.min(q.area);
        if a == b {
            return self.self_exchange(p);
        }
        let bounds = p.extent.range(&q.extent);
        if bounds.high == 0.0 {
            return None;
        }
        let scale = p.area * q.area;
        let Some((first, second)) = p.element.as_ref().zip(q.element.as_ref()) else {
            // No more than all light that leaves one node arrives.
            let most = smaller.min(scale * bounds.high);
            return Some(ExchangeBounds { most, error: (most - scale * bounds.low).max(0.0) });
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
            return Some(ExchangeBounds { most, error: most });
        }
        let most = smaller.min(scale * high);
        Some(ExchangeBounds { most, error: most - smaller.min(scale * low) })
    }

    /// Bounds on the exchange of a node with itself.
    ///
    /// On a patch that is a graph over a plane, with normals within an angle s of that of the plane, lines between two points lie
    /// within 2 s of their tangent planes: the form factor is at most sin^2 2 s.
    fn self_exchange(&self, node: &HierarchyNode) -> Option<ExchangeBounds> {
        if let Some(element) = &node.element {
            let probes = &node.extent.probes;
            if element.polygon.is_some() || pairs(probes, probes).all(|(a, b)| kernel(a, b) == 0.0) {
                return None;
            }
        }
        let steepest = (2.0 * node.extent.spread).min(std::f64::consts::FRAC_PI_2);
        let most = if node.element.is_some() { node.area * steepest.sin().powi(2) } else { node.area };
        Some(ExchangeBounds { most, error: most })
    }

    /// Unoccluded area times form factor, m^2, by the quadrature points of the nodes; for nodes near each other in closed form or by more
    /// points. `most`: an upper bound.
    pub(super) fn unoccluded(&self, a: u32, b: u32, most: f64) -> f64 {
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let is_near = p.extent.nearness(&q.extent) > NEAR;
        let sum = match (&p.element, &q.element) {
            (Some(first), Some(second)) if is_near => match (&first.polygon, &second.polygon) {
                (Some(corners), Some(others)) => polygon::exchange(
                    &in_front(corners, second.center.position, second.center.normal),
                    &in_front(others, first.center.position, first.center.normal),
                ),
                _ => {
                    let [mine, others] = [p, q].map(|node| fine_quadrature(self.elements(), node));
                    quadrature(&mine, &others)
                }
            },
            _ => quadrature(&p.extent.points, &q.extent.points),
        };
        sum.min(most)
    }

    /// Traces shadow rays between the probes of two nodes: from each corner of one to a corner of the other, and between the middles.
    pub(super) fn sample_visibility(&self, a: u32, b: u32) -> VisibilitySample {
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let probes = |node: &HierarchyNode| {
            let all = node.extent.probes.len();
            if node.element.is_some() { all.min(CORNERS) } else { all }
        };
        let (m, n) = (probes(p), probes(q));
        let (from, to) = (&p.extent.probes[..m], &q.extent.probes[..n]);
        // Neighbouring nodes connect other pairs of probes.
        let turn = (a ^ b) as usize;
        let mut visibility = VisibilitySample { fraction: 0.0, rays: 0 };
        let (mut unoccluded, mut all) = (0.0, 0.0);
        for i in 0..m.max(n) {
            let (Some(start), Some(end)) = (from.get(i % m.max(1)), to.get((i + turn) % n.max(1))) else {
                continue;
            };
            let weight = kernel(start, end);
            if weight > 0.0 {
                visibility.rays += 1;
                all += weight;
                unoccluded += if is_unoccluded(self.scene(), start, end) { weight } else { 0.0 };
            }
        }
        visibility.fraction = if all > 0.0 { unoccluded / all } else { 1.0 };
        visibility
    }

    fn scene(&self) -> &Scene {
        self.elements().scene
    }
}

impl Link {
    /// Combines bounds, unoccluded exchange and visibility. If all n rays agree, another ray may still disagree: by Laplace's rule of
    /// succession with probability 1 / (n + 2) (departure: @hanrahan1991 assumes that it does not). If they disagree, the error is the
    /// largest exchange.
    pub(super) fn new(
        [a, b]: [u32; 2],
        bounds: &ExchangeBounds,
        unoccluded: f64,
        visibility: &VisibilitySample,
    ) -> Self {
        let other = 1.0 / f64::from(visibility.rays + 2);
        let error = if visibility.fraction == 1.0 {
            bounds.error.max(other * bounds.most)
        } else if visibility.fraction == 0.0 {
            other * bounds.most
        } else {
            bounds.most
        };
        let exchange = (visibility.fraction * unoccluded) as f32;
        Self { a, b, exchange, error: error as f32, visibility: visibility.fraction as f32 }
    }
}

fn pairs<'a>(
    a: &'a [ElementPoint],
    b: &'a [ElementPoint],
) -> impl Iterator<Item = (&'a ElementPoint, &'a ElementPoint)> {
    a.iter().flat_map(move |a| b.iter().map(move |b| (a, b)))
}

/// The double integral of the kernel, m^2. Because the kernel is unbounded for points that nearly touch, no pair exchanges more than the
/// smaller of its areas. Pairs of coinciding points are replaced by the mean of the others.
fn quadrature(a: &[ElementPoint], b: &[ElementPoint]) -> f64 {
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

/// Quadrature points of the quarters of an element.
fn fine_quadrature(elements: &Elements<'_>, node: &HierarchyNode) -> Vec<ElementPoint> {
    let Some(element) = &node.element else { return node.extent.points.clone() };
    let quarters = element.patch.domain.quarters();
    let patches = quarters.into_iter().map(|part| Patch { domain: part, ..element.patch });
    let mut nodes: Vec<ElementPoint> = patches.flat_map(|patch| elements.quadrature_points(&patch)).collect();
    let scale = node.area / nodes.iter().map(|node| node.area).sum::<f64>();
    nodes.iter_mut().for_each(|node| node.area *= scale);
    nodes
}
