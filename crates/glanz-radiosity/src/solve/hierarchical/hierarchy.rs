//! The hierarchy of nodes: clusters above the start elements, quarters below them.

use glanz_light::Spectrum;
use glanz_math::DVec3;
use rayon::prelude::*;

use super::extent::NodeExtent;
use crate::elements::{Element, Elements};

/// Distance that opposite normals add in clustering, relative to the extent of the scene: the kernel varies little over nodes with similar
/// normals.
const NORMAL_WEIGHT: f64 = 0.25;

/// Largest product of reflectance and sum of form factors of an element, unless its reflectance alone is larger.
const STABLE_REFLECTANCE: f32 = 0.95;

/// A node of the hierarchy: a cluster or an element.
#[derive(Debug)]
pub(super) struct HierarchyNode {
    /// The element; `None` for a cluster.
    pub(super) element: Option<Element>,
    pub(super) extent: NodeExtent,
    /// Sum of the areas of the leaves below, m^2.
    pub(super) area: f64,
    parent: Option<u32>,
    /// Numbers of the children, larger than its own; the first `count` are valid.
    children: [u32; 4],
    count: u8,
    /// Whether an element without children can be divided.
    divisible: bool,
}

impl HierarchyNode {
    pub(super) fn children(&self) -> &[u32] {
        &self.children[..usize::from(self.count)]
    }

    /// Factor on the light of an element whose form factors have the sum `sum`, which errors may raise above 1: sweeps converge only if
    /// it reflects less than is sent. Where the reflectance is low enough, sums are not cut, since cutting only errors that are too large
    /// would bias the mean.
    pub(super) fn scale(&self, sum: f32) -> f32 {
        let reflected = self.element.as_ref().map_or(1.0, |element| element.reflectance.max_component());
        (1.0_f32.max(STABLE_REFLECTANCE / reflected) / sum).min(1.0)
    }

    /// Whether it has children, or can be divided.
    pub(super) fn is_divisible(&self) -> bool {
        self.count > 0 || self.divisible
    }
}

/// Function for the radiant exitance of an element without light from other elements, in units of radiance times pi.
pub type Exitance<'a> = &'a (dyn Fn(&Element) -> Spectrum + Sync);

/// Light of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NodeLight {
    /// Radiosity, in units of radiance times pi.
    pub(super) radiosity: Spectrum,
    /// Irradiance by the links of the node, of its ancestors and, as a mean, of its descendants, in the same units.
    pub(super) irradiance: Spectrum,
}

/// The hierarchy of clusters and elements.
pub(super) struct ElementHierarchy<'a> {
    elements: Elements<'a>,
    exitance: Exitance<'a>,
    /// All nodes, parents before children.
    pub(super) nodes: Vec<HierarchyNode>,
    /// Light of each node.
    pub(super) light: Vec<NodeLight>,
    /// Number of the node of each start element.
    start_nodes: Vec<u32>,
    /// Longest side, metres, below which elements are not divided.
    shortest_divisible: f64,
}

impl<'a> ElementHierarchy<'a> {
    /// Builds clusters over elements. `side`: longest side, metres, below which no quarters are made.
    pub(super) fn new(mut elements: Elements<'a>, exitance: Exitance<'a>, side: f64) -> Self {
        let mut list = std::mem::take(&mut elements.list);
        let start_nodes = vec![0; list.len()];
        list.par_iter_mut().for_each(|element| element.emission = exitance(element));
        let extents: Vec<NodeExtent> =
            list.par_iter().map(|e| NodeExtent::of_element(&elements, e)).collect();
        let keys = keys(&list);
        let shortest_divisible = 2.0 * side * (1.0 - 1e-9);
        let mut hierarchy = Self {
            elements,
            exitance,
            nodes: Vec::new(),
            light: Vec::new(),
            start_nodes,
            shortest_divisible,
        };
        let mut order: Vec<usize> = (0..list.len()).collect();
        let members: Vec<(&NodeExtent, &Element)> = extents.iter().zip(&list).collect();
        hierarchy.cluster(&mut order, &members, &keys, None);
        hierarchy
    }

    /// Adds a node for the elements `order` and all nodes below it.
    fn cluster(
        &mut self,
        order: &mut [usize],
        members: &[(&NodeExtent, &Element)],
        keys: &[[f64; 6]],
        parent: Option<u32>,
    ) {
        if let [start] = *order {
            let (extent, element) = members[start];
            self.start_nodes[start] = self.add(Some(element.clone()), extent.clone(), element.area, parent);
        } else if !order.is_empty() {
            let axis = widest(order, keys);
            order.sort_unstable_by(|&i, &j| keys[i][axis].total_cmp(&keys[j][axis]).then(i.cmp(&j)));
            let inside: Vec<(&NodeExtent, &Element)> = order.iter().map(|&i| members[i]).collect();
            let area = inside.iter().map(|(_, element)| element.area).sum();
            let here = self.add(None, NodeExtent::around(&inside), area, parent);
            let (low, high) = order.split_at_mut(order.len() / 2);
            self.cluster(low, members, keys, Some(here));
            self.cluster(high, members, keys, Some(here));
        }
    }

    fn add(&mut self, element: Option<Element>, extent: NodeExtent, area: f64, parent: Option<u32>) -> u32 {
        let number = self.nodes.len() as u32;
        if let Some(above) = parent.and_then(|parent| self.nodes.get_mut(parent as usize)) {
            above.children[usize::from(above.count)] = number;
            above.count += 1;
        }
        let irradiance = parent.map_or(Spectrum::BLACK, |parent| self.light[parent as usize].irradiance);
        let radiosity = element.as_ref().map_or(Spectrum::BLACK, |e| e.emission + e.reflectance * irradiance);
        let divisible =
            element.as_ref().is_some_and(|element| self.longest_side(element) >= self.shortest_divisible);
        self.nodes.push(HierarchyNode {
            element,
            extent,
            area,
            parent,
            children: [0; 4],
            count: 0,
            divisible,
        });
        self.light.push(NodeLight { radiosity, irradiance });
        number
    }

    /// Longest side of an element, metres.
    fn longest_side(&self, element: &Element) -> f64 {
        let corners = element.patch.domain.corners();
        let middle = element.patch.domain.center();
        let at = |uv| self.elements.point(&element.patch, uv).map(|node| node.position);
        let length = |points: &[Option<DVec3>]| {
            points
                .windows(2)
                .map(|pair| pair[0].zip(pair[1]).map_or(0.0, |(a, b)| a.distance(b)))
                .sum::<f64>()
        };
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let around = sides.map(|(&a, &b)| length(&[at(a), at(0.5 * (a + b)), at(b)]));
        // Sides may shrink to points or be trimmed away.
        let across = corners.iter().map(|&corner| length(&[at(corner), at(middle)]));
        around.chain(across).fold(0.0, f64::max)
    }

    /// Divides elements without children into quarters, in order.
    pub(super) fn divide(&mut self, numbers: &[u32]) {
        let made: Vec<Vec<(Element, NodeExtent)>> = numbers
            .par_iter()
            .map(|&number| {
                let Some(element) = &self.nodes[number as usize].element else { return Vec::new() };
                let with_extent = |mut element: Element| {
                    element.emission = (self.exitance)(&element);
                    let extent = NodeExtent::of_element(&self.elements, &element);
                    (element, extent)
                };
                self.elements.quarters(element).into_iter().map(with_extent).collect()
            })
            .collect();
        for (&number, quarters) in numbers.iter().zip(made) {
            let area: f64 = quarters.iter().map(|(element, _)| element.area).sum();
            for (element, extent) in quarters {
                let of = element.area;
                self.add(Some(element), extent, of, Some(number));
            }
            let here = &mut self.nodes[number as usize];
            here.divisible = false;
            if here.count > 0 {
                // The areas of the quarters are more exact where the element is curved or trimmed.
                let more = area - here.area;
                let mut above = Some(number);
                while let Some(node) = above.and_then(|above| self.nodes.get_mut(above as usize)) {
                    node.area += more;
                    above = node.parent;
                }
            }
        }
    }

    /// Number of leaves.
    pub(super) fn leaves(&self) -> usize {
        self.nodes.iter().filter(|node| node.count == 0).count()
    }

    /// A node and its ancestors.
    pub(super) fn path(&self, number: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(number), |&node| self.nodes[node].parent.map(|parent| parent as usize))
    }

    /// Flux of the whole scene: area times the largest band of the mean radiosity.
    pub(super) fn flux(&self) -> f64 {
        let root = self.nodes.first().zip(self.light.first());
        root.map_or(0.0, |(node, light)| node.area * f64::from(light.radiosity.max_component()))
    }

    /// Pushes the irradiance of each node's own links, with the sums of their form factors, down to the leaves (@hanrahan1991 section
    /// 4.2).
    pub(super) fn push(&self, gathered: &[(Spectrum, f32)]) -> Vec<(Spectrum, f32)> {
        let mut pushed: Vec<(Spectrum, f32)> = Vec::with_capacity(gathered.len());
        for (node, &(irradiance, factors)) in self.nodes.iter().zip(gathered) {
            let above = node.parent.map_or((Spectrum::BLACK, 0.0), |parent| pushed[parent as usize]);
            pushed.push((above.0 + irradiance, above.1 + factors));
        }
        pushed
    }

    /// Computes the light of all nodes from the irradiance of leaves, pulling radiosity up as a mean over areas; returns the largest
    /// change of the radiosity of a leaf.
    pub(super) fn pull(&mut self, irradiance: impl Fn(usize, &HierarchyNode) -> Spectrum) -> f32 {
        let mut change = 0.0_f32;
        for (number, node) in self.nodes.iter().enumerate().rev() {
            if let (0, Some(element)) = (node.count, &node.element) {
                let light = &mut self.light[number];
                light.irradiance = irradiance(number, node);
                let radiosity = element.emission + element.reflectance * light.irradiance;
                change = change.max((radiosity - light.radiosity).map(f32::abs).max_component());
                light.radiosity = radiosity;
            } else {
                self.light[number] = self.mean(node);
            }
        }
        change
    }

    /// Mean of the children's light over their areas.
    fn mean(&self, node: &HierarchyNode) -> NodeLight {
        let mut mean = NodeLight::default();
        for &child in node.children() {
            let share = (self.nodes[child as usize].area / node.area) as f32;
            mean.radiosity += self.light[child as usize].radiosity * share;
            mean.irradiance += self.light[child as usize].irradiance * share;
        }
        mean
    }

    pub(super) fn elements(&self) -> &Elements<'a> {
        &self.elements
    }

    /// The leaves with their light; those of a start element are contiguous, in the order of the start elements.
    pub(super) fn into_leaves(mut self) -> (Elements<'a>, Vec<NodeLight>) {
        let mut light = Vec::new();
        let mut open: Vec<u32> = self.start_nodes.iter().rev().copied().collect();
        while let Some(number) = open.pop() {
            let node = &mut self.nodes[number as usize];
            open.extend(node.children().iter().rev());
            if node.count == 0
                && let Some(mut element) = node.element.take()
            {
                element.area = node.area;
                self.elements.list.push(element);
                light.push(self.light[number as usize]);
            }
        }
        (self.elements, light)
    }
}

/// Sort keys for clustering: position and scaled normal of each element.
fn keys(list: &[Element]) -> Vec<[f64; 6]> {
    let (low, high) = list.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), element| {
        (low.min(element.center.position), high.max(element.center.position))
    });
    let scale = NORMAL_WEIGHT * 0.5 * (high - low).length();
    let key = |element: &Element| {
        let ([x, y, z], [a, b, c]) = (element.center.position.to_array(), element.center.normal.to_array());
        [x, y, z, scale * a, scale * b, scale * c]
    };
    list.iter().map(key).collect()
}

/// The axis of the keys along which the elements extend farthest.
fn widest(order: &[usize], keys: &[[f64; 6]]) -> usize {
    let reach = |axis: usize| {
        let ends = order.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            (low.min(keys[i][axis]), high.max(keys[i][axis]))
        });
        ends.1 - ends.0
    };
    let reaches: [f64; 6] = std::array::from_fn(reach);
    (0..6).max_by(|&i, &j| reaches[i].total_cmp(&reaches[j])).unwrap_or(0)
}
