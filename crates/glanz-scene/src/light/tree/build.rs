//! Construction of the tree of lights.

use glanz_math::{Bounds3, DVec3};

use super::importance::LightCluster;
use super::{LEAF_LIGHTS, LightNode, LightNodeContent, LightPlace, LightTree};
use crate::light::LightId;
use crate::light::extent::EmissionBounds;

/// Intervals along each axis at whose borders lights may be divided.
const BUCKETS: usize = 12;

/// Depth from which on lights are divided into halves, so that paths fit into 64 bits.
const BALANCED_FROM: u32 = 32;

/// A light in a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundedLight {
    pub(super) id: LightId,
    pub(super) extent: EmissionBounds,
    /// W, above 0.
    pub(super) power: f64,
}

/// Bounds and power of several lights.
#[derive(Clone, Copy, Debug, Default)]
struct LightSum(Option<(EmissionBounds, f64)>);

impl LightSum {
    fn of(lights: &[BoundedLight]) -> Self {
        lights.iter().fold(Self::default(), |sum, light| sum.plus(Self(Some((light.extent, light.power)))))
    }

    fn plus(self, other: Self) -> Self {
        match (self.0, other.0) {
            (Some((a, p)), Some((b, q))) => Self(Some((a.union(&b), p + q))),
            (sum, None) | (None, sum) => Self(sum),
        }
    }

    /// Power times solid angle times squared diagonal.
    ///
    /// # Source
    /// @contyestevez2018 section 4.4; departure: the diagonal instead of the area, which vanishes for lights in a row.
    fn cost(self) -> f64 {
        self.0.map_or(0.0, |(extent, power)| {
            power * extent.solid_angle() * extent.bounds.diagonal().length_squared()
        })
    }

    fn cluster(self) -> Option<LightCluster> {
        self.0.map(|(extent, power)| LightCluster::new(&extent, power))
    }
}

/// Divides `lights` into at most `most` neighbouring ranges, of which each is as compact as possible.
pub(super) fn ranges(lights: &mut [BoundedLight], most: usize) -> Vec<std::ops::Range<usize>> {
    if lights.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![(LightSum::of(lights).cost(), 0..lights.len())];
    while parts.len() < most {
        // Costs are equal where all lights are at one point: the number decides.
        let divisible = parts.iter().enumerate().filter(|(_, (_, range))| range.len() > 1);
        let worst = divisible.max_by(|(_, (a, x)), (_, (b, y))| a.total_cmp(b).then(x.len().cmp(&y.len())));
        let Some((index, (_, range))) = worst.map(|(index, part)| (index, part.clone())) else { break };
        let middle = range.start + divide(&mut lights[range.clone()], false);
        let halves = [range.start..middle, middle..range.end];
        parts.splice(index..=index, halves.map(|half| (LightSum::of(&lights[half.clone()]).cost(), half)));
    }
    parts.into_iter().map(|(_, range)| range).collect()
}

/// Orders lights and returns the number of those of the first of two parts, neither of which is empty. `halves`: whether both have the same number.
///
/// # Source
/// @contyestevez2018 section 4.4.
fn divide(lights: &mut [BoundedLight], halves: bool) -> usize {
    let position = |light: &BoundedLight| light.extent.bounds.center();
    let span = Bounds3::from_points(lights.iter().map(position));
    let extent = span.diagonal();
    let bucket = |axis: usize, light: &BoundedLight| {
        let along = (position(light)[axis] - span.min[axis]) / extent[axis];
        ((along * BUCKETS as f64) as usize).min(BUCKETS - 1)
    };
    let best = (0..3).filter(|&axis| !halves && extent[axis] > 0.0).flat_map(|axis| {
        let mut buckets = [LightSum::default(); BUCKETS];
        for light in lights.iter() {
            let sum = &mut buckets[bucket(axis, light)];
            *sum = sum.plus(LightSum(Some((light.extent, light.power))));
        }
        // Long thin parts are worse than their cost.
        let shape = extent.max_element() / extent[axis];
        costs(&buckets).into_iter().enumerate().map(move |(border, cost)| (shape * cost, axis, border))
    });
    if let Some((_, axis, border)) = best.min_by(|(a, ..), (b, ..)| a.total_cmp(b)) {
        lights.sort_by_key(|light| bucket(axis, light));
        let first = lights.partition_point(|light| bucket(axis, light) <= border);
        if (1..lights.len()).contains(&first) {
            return first;
        }
    }
    let axis = longest(extent);
    lights.sort_by(|a, b| position(a)[axis].total_cmp(&position(b)[axis]).then(a.id.cmp(&b.id)));
    lights.len() / 2
}

/// Cost of a division after each bucket but the last.
fn costs(buckets: &[LightSum; BUCKETS]) -> [f64; BUCKETS - 1] {
    let mut costs = [0.0; BUCKETS - 1];
    let (mut below, mut above) = (LightSum::default(), LightSum::default());
    for i in 0..BUCKETS - 1 {
        below = below.plus(buckets[i]);
        costs[i] += below.cost();
        above = above.plus(buckets[BUCKETS - 1 - i]);
        costs[BUCKETS - 2 - i] += above.cost();
    }
    costs
}

fn longest(extent: DVec3) -> usize {
    let most = extent.max_element();
    (0..3).find(|&axis| extent[axis] == most).unwrap_or(0)
}

impl LightTree {
    /// Adds a subtree of `lights` and returns its root. `place`: the path of the subtree so far.
    pub(super) fn add_subtree(&mut self, lights: &mut [BoundedLight], group: u8) -> Option<u32> {
        let sum = LightSum::of(lights);
        let root = self.nodes.len() as u32;
        self.nodes.push(LightNode { cluster: sum.cluster()?, content: LightNodeContent::EMPTY });
        self.fill(root, lights, LightPlace { group, path: 0, depth: 0, number: 0 });
        Some(root)
    }

    /// Sets the contents of a node whose bounds are known.
    fn fill(&mut self, node: u32, lights: &mut [BoundedLight], place: LightPlace) {
        let content = if lights.len() <= LEAF_LIGHTS {
            self.add_leaf(lights, place)
        } else {
            let middle = divide(lights, place.depth >= BALANCED_FROM);
            let (below, above) = lights.split_at_mut(middle);
            let children = self.nodes.len() as u32;
            for part in [&*below, &*above] {
                if let Some(cluster) = LightSum::of(part).cluster() {
                    self.nodes.push(LightNode { cluster, content: LightNodeContent::EMPTY });
                }
            }
            for (side, part) in [below, above].into_iter().enumerate() {
                let path = place.path | (side as u64) << place.depth;
                let place = LightPlace { path, depth: place.depth + 1, ..place };
                self.fill(children + side as u32, part, place);
            }
            LightNodeContent::Inner { children }
        };
        if let Some(node) = self.nodes.get_mut(node as usize) {
            node.content = content;
        }
    }

    fn add_leaf(&mut self, lights: &[BoundedLight], place: LightPlace) -> LightNodeContent {
        let first = self.lights.len() as u32;
        for (number, light) in (0..).zip(lights) {
            self.lights.push((light.id, LightCluster::new(&light.extent, light.power)));
            if let Some(slot) = self.places.get_mut(light.id.0 as usize) {
                *slot = Some(LightPlace { number, ..place });
            }
        }
        LightNodeContent::Leaf { first, count: lights.len() as u32 }
    }
}
