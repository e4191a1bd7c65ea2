//! Selection of lights by their estimated light at a point.
//!
//! Up to [`MAX_LIGHT_GROUPS`] groups of lights are compared side by side; a group is a light, if there are few, or a binary tree of lights near one another. In a
//! tree, the selection descends by the importance of bounds on the lights below (@contyestevez2018), down to leaves whose lights are compared
//! side by side. A light whose bounds exclude it has the probability 0, all others are above.

mod build;
mod importance;

use std::ops::Range;

use self::build::{BoundedLight, ranges};
use self::importance::{DistantCluster, LightCluster};
use super::LightId;
use super::extent::LightExtent;
use crate::interaction::LightSampleContext;

/// Largest number of groups of lights.
pub const MAX_LIGHT_GROUPS: usize = 16;

/// Largest number of groups of infinitely far lights.
const DISTANT_GROUPS: usize = 4;

/// Largest number of lights in a leaf.
const LEAF_LIGHTS: usize = 8;

/// Fraction of the probability that is spread evenly over the groups from which light may arrive, because their light may be blocked.
const EVEN_SHARE: f64 = 0.1;

/// A light selected at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedLight {
    /// The light.
    pub id: LightId,
    /// Its probability, above 0.
    pub probability: f64,
    /// Its group.
    pub group: usize,
    /// Probability of its group.
    pub group_probability: f64,
}

/// Selects lights by bounds on their light at a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightTree {
    groups: Vec<LightGroup>,
    nodes: Vec<LightNode>,
    /// Lights in boxes, in the order of the leaves.
    lights: Vec<(LightId, LightCluster)>,
    /// Lights infinitely far away, in the order of their groups.
    distant: Vec<(LightId, DistantCluster)>,
    /// For each light of the scene; `None` if it is never selected.
    places: Vec<Option<LightPlace>>,
}

/// A group of lights.
#[derive(Clone, Debug)]
enum LightGroup {
    /// A tree, by its root.
    Bounded(u32),
    /// A range of the infinitely far lights.
    Distant(Range<usize>),
}

#[derive(Clone, Copy, Debug)]
struct LightNode {
    cluster: LightCluster,
    content: LightNodeContent,
}

#[derive(Clone, Copy, Debug)]
enum LightNodeContent {
    /// The first of two nodes.
    Inner { children: u32 },
    /// Some of the lights.
    Leaf { first: u32, count: u32 },
}

impl LightNodeContent {
    const EMPTY: Self = Self::Leaf { first: 0, count: 0 };
}

/// Where a light is in the tree.
#[derive(Clone, Copy, Debug)]
struct LightPlace {
    group: u8,
    /// Number of nodes above the leaf, and the side on which each is left, from the lowest bit on.
    depth: u32,
    path: u64,
    /// Number of the light in its leaf or group.
    number: u32,
}

/// A weighted choice.
struct Choice {
    index: usize,
    probability: f64,
    /// The remaining random number, in [0, 1).
    xi: f64,
}

/// Chooses an index by weight; `None` if all weights are 0.
#[inline]
fn choose(weights: &[f64], xi: f64) -> Option<Choice> {
    let total: f64 = weights.iter().sum();
    let mut left = xi * total;
    // Rounding may carry the sum past the end; the last that can be chosen takes it.
    let last = weights.iter().rposition(|&weight| weight > 0.0)?;
    let mut index = 0;
    while index < last && left >= weights[index] {
        left -= weights[index];
        index += 1;
    }
    let weight = weights[index];
    Some(Choice { index, probability: weight / total, xi: (left / weight).clamp(0.0, 1.0f64.next_down()) })
}

/// Fraction of `weights` at `index`; 0 if all are 0.
#[inline]
fn fraction(weights: &[f64], index: usize) -> f64 {
    let weight = weights.get(index).copied().unwrap_or(0.0);
    if weight > 0.0 { weight / weights.iter().sum::<f64>() } else { 0.0 }
}

impl LightTree {
    /// `lights`: of each light extent and power, W; a light of power 0 is never selected. `radius`: of the sphere around the scene, metres.
    pub(crate) fn new(lights: &[(LightExtent, f64)], radius: f64) -> Self {
        let mut tree = Self { places: vec![None; lights.len()], ..Self::default() };
        let (mut bounded, mut distant) = (Vec::new(), Vec::new());
        for (id, &(extent, power)) in (0..).map(LightId).zip(lights) {
            if !(power > 0.0 && power.is_finite()) {
                continue;
            }
            match extent {
                LightExtent::Bounded(extent) => bounded.push(BoundedLight { id, extent, power }),
                LightExtent::Distant(directions) => {
                    distant.push((id, DistantCluster::new(&directions, power, radius)));
                }
            }
        }
        tree.add_distant(distant);
        let free = MAX_LIGHT_GROUPS - tree.groups.len();
        for range in ranges(&mut bounded, free) {
            let group = tree.groups.len() as u8;
            if let Some(root) = bounded.get_mut(range).and_then(|lights| tree.add_subtree(lights, group)) {
                tree.groups.push(LightGroup::Bounded(root));
            }
        }
        tree
    }

    /// Adds the groups of the infinitely far lights.
    fn add_distant(&mut self, lights: Vec<(LightId, DistantCluster)>) {
        let each = lights.len().div_ceil(DISTANT_GROUPS).max(1);
        for (group, part) in (0..).zip(lights.chunks(each)) {
            for (number, &(id, _)) in (0..).zip(part) {
                if let Some(place) = self.places.get_mut(id.0 as usize) {
                    *place = Some(LightPlace { group, depth: 0, path: 0, number });
                }
            }
            let first = group as usize * each;
            self.groups.push(LightGroup::Distant(first..first + part.len()));
        }
        self.distant = lights;
    }

    /// Whether a light is ever selected.
    pub(crate) fn contains(&self, light: LightId) -> bool {
        self.place(light).is_some()
    }

    fn place(&self, light: LightId) -> Option<&LightPlace> {
        self.places.get(light.0 as usize)?.as_ref()
    }

    /// Number of groups.
    pub(crate) fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The group of `light`; `None` if it is never selected.
    pub(crate) fn group(&self, light: LightId) -> Option<usize> {
        self.place(light).map(|place| usize::from(place.group))
    }

    /// Probability of each group: 1 if there is only one, else 0 for those from which no light can arrive.
    #[inline]
    pub(crate) fn group_probabilities(&self, from: &LightSampleContext) -> [f64; MAX_LIGHT_GROUPS] {
        let mut weights = [0.0; MAX_LIGHT_GROUPS];
        if let [_] = self.groups[..] {
            weights[0] = 1.0;
            return weights;
        }
        let (mut total, mut count) = (0.0, 0.0);
        for (weight, group) in weights.iter_mut().zip(&self.groups) {
            *weight = self.group_importance(group, from);
            total += *weight;
            count += f64::from(u8::from(*weight > 0.0));
        }
        for weight in weights.iter_mut().take(self.groups.len()).filter(|weight| **weight > 0.0) {
            *weight = (1.0 - EVEN_SHARE) * *weight / total + EVEN_SHARE / count;
        }
        weights
    }

    /// The probabilities of the groups that exist, without the empty places after them: these would be summed as well.
    #[inline]
    fn of_groups<'a>(&self, probabilities: &'a [f64; MAX_LIGHT_GROUPS]) -> &'a [f64] {
        probabilities.get(..self.groups.len()).unwrap_or_default()
    }

    #[inline]
    fn group_importance(&self, group: &LightGroup, from: &LightSampleContext) -> f64 {
        match group {
            LightGroup::Bounded(root) => self.node_importance(*root, from),
            LightGroup::Distant(range) => {
                self.distant(range).iter().map(|(_, light)| light.importance(from)).sum()
            }
        }
    }

    fn distant(&self, range: &Range<usize>) -> &[(LightId, DistantCluster)] {
        self.distant.get(range.clone()).unwrap_or_default()
    }

    #[inline]
    fn node_importance(&self, node: u32, from: &LightSampleContext) -> f64 {
        self.nodes.get(node as usize).map_or(0.0, |node| node.cluster.importance(from))
    }

    /// A light by a number uniform in [0, 1); `None` if there is none, or perhaps if no light can arrive.
    #[inline]
    pub(crate) fn select(&self, from: &LightSampleContext, xi: f64) -> Option<SelectedLight> {
        self.select_by_groups(from, &self.group_probabilities(from), xi)
    }

    /// As [`LightTree::select`], by other `probabilities` of the groups, or weights in proportion to them.
    #[inline]
    pub(crate) fn select_by_groups(
        &self,
        from: &LightSampleContext,
        probabilities: &[f64; MAX_LIGHT_GROUPS],
        xi: f64,
    ) -> Option<SelectedLight> {
        let Choice { index: group, probability: group_probability, xi } =
            choose(self.of_groups(probabilities), xi)?;
        let (id, inside) = match self.groups.get(group)? {
            LightGroup::Bounded(root) => self.descend(*root, from, xi)?,
            LightGroup::Distant(range) => self.select_distant(self.distant(range), from, xi)?,
        };
        Some(SelectedLight { id, probability: group_probability * inside, group, group_probability })
    }

    /// A light below a node and its probability among those.
    #[inline]
    fn descend(&self, root: u32, from: &LightSampleContext, mut xi: f64) -> Option<(LightId, f64)> {
        let (mut node, mut probability) = (root, 1.0);
        loop {
            match self.nodes.get(node as usize)?.content {
                LightNodeContent::Inner { children } => {
                    let choice = choose(&self.child_weights(children, from), xi)?;
                    node = children + choice.index as u32;
                    (probability, xi) = (probability * choice.probability, choice.xi);
                }
                LightNodeContent::Leaf { first, count: 1 } => {
                    return Some((self.lights.get(first as usize)?.0, probability));
                }
                LightNodeContent::Leaf { first, count } => {
                    let choice = choose(&self.leaf_weights(first, count, from), xi)?;
                    let (id, _) = self.lights.get(first as usize + choice.index)?;
                    return Some((*id, probability * choice.probability));
                }
            }
        }
    }

    #[inline]
    fn child_weights(&self, children: u32, from: &LightSampleContext) -> [f64; 2] {
        [children, children + 1].map(|child| self.node_importance(child, from))
    }

    #[inline]
    fn leaf_weights(&self, first: u32, count: u32, from: &LightSampleContext) -> [f64; LEAF_LIGHTS] {
        let mut weights = [0.0; LEAF_LIGHTS];
        let lights = self.lights.iter().skip(first as usize).take(count as usize);
        for (weight, (_, light)) in weights.iter_mut().zip(lights) {
            *weight = light.importance(from);
        }
        weights
    }

    fn select_distant(
        &self,
        lights: &[(LightId, DistantCluster)],
        from: &LightSampleContext,
        xi: f64,
    ) -> Option<(LightId, f64)> {
        if let [(id, _)] = lights {
            return Some((*id, 1.0));
        }
        let weights: Vec<f64> = lights.iter().map(|(_, light)| light.importance(from)).collect();
        let choice = choose(&weights, xi)?;
        Some((lights.get(choice.index)?.0, choice.probability))
    }

    /// The probability with which [`LightTree::select`] selects `light`.
    #[inline]
    pub(crate) fn probability(&self, light: LightId, from: &LightSampleContext) -> f64 {
        self.probability_by_groups(light, from, &self.group_probabilities(from))
    }

    /// The probability with which [`LightTree::select_by_groups`] selects `light`.
    #[inline]
    pub(crate) fn probability_by_groups(
        &self,
        light: LightId,
        from: &LightSampleContext,
        probabilities: &[f64; MAX_LIGHT_GROUPS],
    ) -> f64 {
        let Some(place) = self.place(light) else { return 0.0 };
        let group = usize::from(place.group);
        let of_group = fraction(self.of_groups(probabilities), group);
        if of_group <= 0.0 {
            return 0.0;
        }
        of_group
            * match self.groups.get(group) {
                Some(LightGroup::Bounded(root)) => self.probability_below(*root, place, from),
                Some(LightGroup::Distant(range)) => {
                    self.probability_of_distant(self.distant(range), place, from)
                }
                None => 0.0,
            }
    }

    /// Probability of a light among those below a node.
    #[inline]
    fn probability_below(&self, root: u32, place: &LightPlace, from: &LightSampleContext) -> f64 {
        let (mut node, mut path, mut probability) = (root, place.path, 1.0);
        while let Some(&LightNode { content, .. }) = self.nodes.get(node as usize) {
            match content {
                LightNodeContent::Inner { children } => {
                    let side = (path & 1) as usize;
                    probability *= fraction(&self.child_weights(children, from), side);
                    (node, path) = (children + side as u32, path >> 1);
                }
                LightNodeContent::Leaf { count: 1, .. } => return probability,
                LightNodeContent::Leaf { first, count } => {
                    return probability
                        * fraction(&self.leaf_weights(first, count, from), place.number as usize);
                }
            }
        }
        0.0
    }

    fn probability_of_distant(
        &self,
        lights: &[(LightId, DistantCluster)],
        place: &LightPlace,
        from: &LightSampleContext,
    ) -> f64 {
        if let [_] = lights {
            return 1.0;
        }
        let weights: Vec<f64> = lights.iter().map(|(_, light)| light.importance(from)).collect();
        fraction(&weights, place.number as usize)
    }
}
