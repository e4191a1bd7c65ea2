//! The hierarchy: clusters above the start elements, quarters below them.

use glanz_light::Spectrum;
use glanz_math::DVec3;
use rayon::prelude::*;

use super::extent::Extent;
use crate::elements::{Element, Elements, Patch};

/// How far apart in position elements of opposite normals count, as a share of the extent of the scene: nodes that face one way
/// exchange light by a kernel that varies little.
const NORMALS: f64 = 0.25;

/// Of the light that all send, what an element reflects at most, if its material does not reflect more.
const REFLECTED: f32 = 0.95;

/// A cluster or an element.
#[derive(Debug)]
pub(super) struct Branch {
    /// `None` in a cluster.
    pub(super) element: Option<Element>,
    pub(super) extent: Extent,
    /// Sum of what is below, m^2.
    pub(super) area: f64,
    parent: Option<u32>,
    /// They have larger numbers.
    children: [u32; 4],
    count: u8,
    /// Whether the children, if there are none, can be made.
    divisible: bool,
}

impl Branch {
    pub(super) fn children(&self) -> &[u32] {
        &self.children[..usize::from(self.count)]
    }

    /// What light is multiplied by if the form factors to an element come to `sum`, by errors more than 1: so that it reflects less
    /// than arrives, and sweeps converge. Where it reflects much less anyhow they are left as they are: errors that cancel
    /// in the mean would not, were only the large ones cut.
    pub(super) fn scale(&self, sum: f32) -> f32 {
        let reflected = self.element.as_ref().map_or(1.0, |element| element.reflectance.max_component());
        (1.0_f32.max(REFLECTED / reflected) / sum).min(1.0)
    }

    /// Whether links can go to something below it.
    pub(super) fn is_divisible(&self) -> bool {
        self.count > 0 || self.divisible
    }
}

/// Radiant exitance that an element has without light from other elements, in units of radiance times pi.
pub type Exitance<'a> = &'a (dyn Fn(&Element) -> Spectrum + Sync);

/// Light on a branch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Light {
    /// What leaves it.
    pub(super) radiosity: Spectrum,
    /// What meets it, of all links of it, of those above and, as a mean, below it.
    pub(super) irradiance: Spectrum,
}

/// Clusters and elements, parents before children.
pub(super) struct Tree<'a> {
    elements: Elements<'a>,
    exitance: Exitance<'a>,
    pub(super) branches: Vec<Branch>,
    pub(super) light: Vec<Light>,
    /// The branch of each start element.
    starts: Vec<u32>,
    /// Elements shorter than this are not divided.
    shortest: f64,
}

impl<'a> Tree<'a> {
    /// Clusters over elements, none of which is divided if its quarters were shorter than `side`.
    pub(super) fn new(mut elements: Elements<'a>, exitance: Exitance<'a>, side: f64) -> Self {
        let mut list = std::mem::take(&mut elements.list);
        let starts = vec![0; list.len()];
        list.par_iter_mut().for_each(|element| element.emission = exitance(element));
        let extents: Vec<Extent> = list.par_iter().map(|e| Extent::of_element(&elements, e)).collect();
        let keys = keys(&list);
        let shortest = 2.0 * side * (1.0 - 1e-9);
        let mut tree = Self { elements, exitance, branches: Vec::new(), light: Vec::new(), starts, shortest };
        let mut order: Vec<usize> = (0..list.len()).collect();
        let members: Vec<(&Extent, &Element)> = extents.iter().zip(&list).collect();
        tree.cluster(&mut order, &members, &keys, None);
        tree
    }

    /// A branch for some elements and all that are below it.
    fn cluster(
        &mut self,
        order: &mut [usize],
        members: &[(&Extent, &Element)],
        keys: &[[f64; 6]],
        parent: Option<u32>,
    ) {
        if let [start] = *order {
            let (extent, element) = members[start];
            self.starts[start] = self.add(Some(element.clone()), extent.clone(), element.area, parent);
        } else if !order.is_empty() {
            let axis = widest(order, keys);
            order.sort_unstable_by(|&i, &j| keys[i][axis].total_cmp(&keys[j][axis]).then(i.cmp(&j)));
            let inside: Vec<(&Extent, &Element)> = order.iter().map(|&i| members[i]).collect();
            let area = inside.iter().map(|(_, element)| element.area).sum();
            let here = self.add(None, Extent::around(&inside), area, parent);
            let (low, high) = order.split_at_mut(order.len() / 2);
            self.cluster(low, members, keys, Some(here));
            self.cluster(high, members, keys, Some(here));
        }
    }

    fn add(&mut self, element: Option<Element>, extent: Extent, area: f64, parent: Option<u32>) -> u32 {
        let number = self.branches.len() as u32;
        if let Some(above) = parent.and_then(|parent| self.branches.get_mut(parent as usize)) {
            above.children[usize::from(above.count)] = number;
            above.count += 1;
        }
        let irradiance = parent.map_or(Spectrum::BLACK, |parent| self.light[parent as usize].irradiance);
        let radiosity = element.as_ref().map_or(Spectrum::BLACK, |e| e.emission + e.reflectance * irradiance);
        let divisible = element.as_ref().is_some_and(|element| self.longest(element) >= self.shortest);
        self.branches.push(Branch { element, extent, area, parent, children: [0; 4], count: 0, divisible });
        self.light.push(Light { radiosity, irradiance });
        number
    }

    /// Longest side of an element, metres.
    fn longest(&self, element: &Element) -> f64 {
        let corners = element.patch.part.corners();
        let middle = element.patch.part.center();
        let at = |uv| self.elements.place(&element.patch, uv).map(|node| node.position);
        let length = |points: &[Option<DVec3>]| {
            points
                .windows(2)
                .map(|pair| pair[0].zip(pair[1]).map_or(0.0, |(a, b)| a.distance(b)))
                .sum::<f64>()
        };
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let around = sides.map(|(&a, &b)| length(&[at(a), at(0.5 * (a + b)), at(b)]));
        // Sides may shrink to points or be cut away.
        let across = corners.iter().map(|&corner| length(&[at(corner), at(middle)]));
        around.chain(across).fold(0.0, f64::max)
    }

    /// Makes quarters of these, which are elements without children, in order; the last argument of both kinds of light follows.
    pub(super) fn divide(&mut self, numbers: &[u32]) {
        let made: Vec<Vec<(Element, Extent)>> = numbers
            .par_iter()
            .map(|&number| {
                let Some(element) = &self.branches[number as usize].element else { return Vec::new() };
                let quarters = element.patch.part.quarters();
                let patches = quarters.into_iter().map(|part| Patch { part, ..element.patch });
                let with_extent = |mut element: Element| {
                    element.emission = (self.exitance)(&element);
                    let extent = Extent::of_element(&self.elements, &element);
                    (element, extent)
                };
                patches.filter_map(|patch| self.elements.element(patch)).map(with_extent).collect()
            })
            .collect();
        for (&number, quarters) in numbers.iter().zip(made) {
            let area: f64 = quarters.iter().map(|(element, _)| element.area).sum();
            for (element, extent) in quarters {
                let of = element.area;
                self.add(Some(element), extent, of, Some(number));
            }
            let here = &mut self.branches[number as usize];
            here.divisible = false;
            if here.count > 0 {
                // Quarters know the area of what is curved or cut better.
                let more = area - here.area;
                let mut above = Some(number);
                while let Some(branch) = above.and_then(|above| self.branches.get_mut(above as usize)) {
                    branch.area += more;
                    above = branch.parent;
                }
            }
        }
    }

    /// A branch and all above it.
    pub(super) fn path(&self, number: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(number), |&node| self.branches[node].parent.map(|parent| parent as usize))
    }

    /// All light that leaves, as area times the largest band of the mean radiosity.
    pub(super) fn flux(&self) -> f64 {
        let root = self.branches.first().zip(self.light.first());
        root.map_or(0.0, |(branch, light)| branch.area * f64::from(light.radiosity.max_component()))
    }

    /// What the links of each branch bring to it alone, with their form factors, pushed down to the leaves
    /// (@hanrahan1991 section 4.2).
    pub(super) fn push(&self, gathered: &[(Spectrum, f32)]) -> Vec<(Spectrum, f32)> {
        let mut pushed: Vec<(Spectrum, f32)> = Vec::with_capacity(gathered.len());
        for (branch, &(irradiance, factors)) in self.branches.iter().zip(gathered) {
            let above = branch.parent.map_or((Spectrum::BLACK, 0.0), |parent| pushed[parent as usize]);
            pushed.push((above.0 + irradiance, above.1 + factors));
        }
        pushed
    }

    /// From the irradiance of leaves the light on all, radiosity pulled up as a mean over areas; returns the largest change of
    /// radiosity of a leaf.
    pub(super) fn pull(&mut self, irradiance: impl Fn(usize, &Branch) -> Spectrum) -> f32 {
        let mut change = 0.0_f32;
        for (number, branch) in self.branches.iter().enumerate().rev() {
            if let (0, Some(element)) = (branch.count, &branch.element) {
                let light = &mut self.light[number];
                light.irradiance = irradiance(number, branch);
                let radiosity = element.emission + element.reflectance * light.irradiance;
                change = change.max((radiosity - light.radiosity).map(f32::abs).max_component());
                light.radiosity = radiosity;
            } else {
                self.light[number] = self.mean(branch);
            }
        }
        change
    }

    /// Of what is right below, by areas.
    fn mean(&self, branch: &Branch) -> Light {
        let mut mean = Light::default();
        for &child in branch.children() {
            let share = (self.branches[child as usize].area / branch.area) as f32;
            mean.radiosity += self.light[child as usize].radiosity * share;
            mean.irradiance += self.light[child as usize].irradiance * share;
        }
        mean
    }

    pub(super) fn elements(&self) -> &Elements<'a> {
        &self.elements
    }

    /// The leaves with their light; those of a start element follow one another, in its place.
    pub(super) fn into_leaves(mut self) -> (Elements<'a>, Vec<Light>) {
        let mut light = Vec::new();
        let mut open: Vec<u32> = self.starts.iter().rev().copied().collect();
        while let Some(number) = open.pop() {
            let branch = &mut self.branches[number as usize];
            open.extend(branch.children().iter().rev());
            if branch.count == 0
                && let Some(mut element) = branch.element.take()
            {
                element.area = branch.area;
                self.elements.list.push(element);
                light.push(self.light[number as usize]);
            }
        }
        (self.elements, light)
    }
}

/// Position and scaled normal of each element.
fn keys(list: &[Element]) -> Vec<[f64; 6]> {
    let (low, high) = list.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), element| {
        (low.min(element.center.position), high.max(element.center.position))
    });
    let scale = NORMALS * 0.5 * (high - low).length();
    let key = |element: &Element| {
        let ([x, y, z], [a, b, c]) = (element.center.position.to_array(), element.center.normal.to_array());
        [x, y, z, scale * a, scale * b, scale * c]
    };
    list.iter().map(key).collect()
}

/// Of six directions, the one in which these reach farthest.
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
