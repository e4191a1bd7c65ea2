//! Densities over the directions of the sphere that are fine where much light comes from.
//!
//! Directions lie in the unit square by a map that keeps areas and distorts little (@clarberg2008): the upper hemisphere is the inner
//! diamond, the lower one the four corners. A tree of quarters of the square holds the share of light in each; within a leaf the
//! density is constant. That is a density in the Haar basis, with the wavelets left out where little light is: chapter 2 of document
//! 003, and the directional tree of @muller2017. Both map by (cos theta, phi), which makes a lamp overhead a strip along a side of the
//! square that quarters cannot follow.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glanz_math::{DVec2, DVec3};

/// Share of a tree's light above which a quarter is divided.
const SPLIT_SHARE: f64 = 0.01;

/// Effective samples that a square must have, or its light is spread evenly over it: a few bright samples are no peak. Its
/// quarters remain, for the next pass to tell more.
const SAMPLES_PER_SQUARE: f64 = 4.0;

/// Quarterings at most: the smallest leaves have 4 pi / 4^10 = 1.2e-5 sr.
const MAX_DEPTH: u32 = 10;

/// Quarterings of every square at least, so that a tree finds out where new light comes from.
const LEAST_DEPTH: u32 = 3;

/// Quarterings of a tree that knows nothing yet.
const FIRST_DEPTH: u32 = 4;

/// Child number that means: not divided.
const NONE: u32 = 0;

/// A square and its quarters: low x low y, high x low y, low x high y, high x high y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quarters {
    /// Light in each quarter, in any unit.
    pub(crate) light: [f32; 4],
    /// Index of each quarter's own quarters, larger than the index of this; [`NONE`] if it is a leaf.
    pub(crate) child: [u32; 4],
}

/// A direction drawn from a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Draw {
    /// Unit direction.
    pub(crate) direction: DVec3,
    /// Its density per steradian.
    pub(crate) pdf: f64,
    /// The leaf: four times the index of the square plus the number of the quarter.
    pub(crate) leaf: u32,
}

/// The trees of all cells, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DirectionTrees(pub(crate) Vec<Quarters>);

impl DirectionTrees {
    /// Adds a tree of equal leaves without light; its root.
    pub(crate) fn push_blank(&mut self) -> u32 {
        let mut tree = Vec::new();
        blank(&mut tree, FIRST_DEPTH);
        self.push(&tree)
    }

    /// Adds a copy of `tree`, whose first element is the root; its root here.
    pub(crate) fn push(&mut self, tree: &[Quarters]) -> u32 {
        let root = self.0.len() as u32;
        self.0.extend(tree.iter().map(|quarters| Quarters {
            light: quarters.light,
            child: quarters.child.map(|child| if child == NONE { NONE } else { child + root }),
        }));
        root
    }

    /// Whether the tree holds any light.
    pub(crate) fn is_lit(&self, root: u32) -> bool {
        self.0.get(root as usize).is_some_and(|quarters| quarters.light.iter().any(|&light| light > 0.0))
    }

    /// Light of a leaf; that of a tree built by [`DirectionTrees::refined`] is relative to the whole tree.
    pub(crate) fn light(&self, leaf: u32) -> f64 {
        self.0.get(leaf as usize / 4).map_or(0.0, |quarters| f64::from(quarters.light[leaf as usize % 4]))
    }

    /// Draws a direction from the tree with that root; `None` without light.
    ///
    /// Every step uses one side of `xi` and stretches what is left of it, so that well spread numbers give well spread
    /// directions.
    #[inline]
    pub(crate) fn sample(&self, root: u32, mut xi: DVec2) -> Option<Draw> {
        let (mut node, mut pdf) = (root, 1.0 / (4.0 * PI));
        let (mut corner, mut side) = (DVec2::ZERO, 1.0);
        loop {
            let Quarters { light, child } = *self.0.get(node as usize)?;
            let [a, b, c, d] = light.map(f64::from);
            let (low, high) = (a + c, b + d);
            let all = low + high;
            if all <= 0.0 {
                return None;
            }
            let right = choose(&mut xi.x, low, high);
            let (below, above) = if right { (b, d) } else { (a, c) };
            let top = choose(&mut xi.y, below, above);
            let quarter = usize::from(right) + 2 * usize::from(top);
            pdf *= 4.0 * if top { above } else { below } / all;
            side *= 0.5;
            corner += DVec2::new(if right { side } else { 0.0 }, if top { side } else { 0.0 });
            if child[quarter] == NONE {
                let leaf = 4 * node + quarter as u32;
                return Some(Draw { direction: to_sphere(corner + side * xi), pdf, leaf });
            }
            node = child[quarter];
        }
    }

    /// Density per steradian of `direction` and its leaf.
    #[inline]
    pub(crate) fn pdf(&self, root: u32, direction: DVec3) -> (f64, u32) {
        let (mut node, mut pdf, mut place) = (root, 1.0 / (4.0 * PI), to_square(direction));
        loop {
            let Some(Quarters { light, child }) = self.0.get(node as usize) else { return (0.0, 0) };
            place *= 2.0;
            let (right, top) = (place.x >= 1.0, place.y >= 1.0);
            place -= DVec2::new(f64::from(u8::from(right)), f64::from(u8::from(top)));
            let quarter = usize::from(right) + 2 * usize::from(top);
            let light = light.map(f64::from);
            let all = (light[0] + light[2]) + (light[1] + light[3]);
            pdf = if all > 0.0 { pdf * 4.0 * light[quarter] / all } else { 0.0 };
            if child[quarter] == NONE {
                return (pdf, 4 * node + quarter as u32);
            }
            node = child[quarter];
        }
    }

    /// The tree with that root, its light as `leaf_light` says, divided anew: fine where the light is. The root is the first
    /// element. `None` if there is no light.
    ///
    /// `effective`: equal samples that would tell as much of the light; squares with fewer than a few of them are even.
    pub(crate) fn refined(
        &self,
        root: u32,
        effective: f64,
        leaf_light: &dyn Fn(u32) -> f64,
    ) -> Option<Vec<Quarters>> {
        let light = self.gather(root, leaf_light);
        let all: f64 = light.iter().sum();
        let least = SAMPLES_PER_SQUARE / effective * all;
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let mut refinement = Refinement { old: self, leaf_light, all, least, tree: Vec::new() };
        refinement.divide(Some(root), light, 1);
        Some(refinement.tree)
    }

    /// Light of the whole tree.
    pub(crate) fn total(&self, root: u32, leaf_light: &dyn Fn(u32) -> f64) -> f64 {
        self.gather(root, leaf_light).iter().sum()
    }

    /// Light of the four quarters of `node`, all leaves below them added up.
    fn gather(&self, node: u32, leaf_light: &dyn Fn(u32) -> f64) -> [f64; 4] {
        let Some(quarters) = self.0.get(node as usize) else { return [0.0; 4] };
        std::array::from_fn(|i| match quarters.child[i] {
            NONE => leaf_light(4 * node + i as u32),
            child => self.gather(child, leaf_light).iter().sum(),
        })
    }

    /// Whether these are trees: no node below two others, none too deep; and whether light is a number that is not negative.
    pub(crate) fn is_valid(&self) -> bool {
        let mut depths: Vec<Option<u32>> = vec![None; self.0.len()];
        for (i, quarters) in self.0.iter().enumerate() {
            let depth = depths.get(i).copied().flatten().unwrap_or(1) + 1;
            for &child in quarters.child.iter().filter(|&&child| child != NONE) {
                let fine = child as usize > i && depth <= MAX_DEPTH;
                if !fine || depths.get_mut(child as usize).is_none_or(|slot| slot.replace(depth).is_some()) {
                    return false;
                }
            }
        }
        self.0.iter().all(|quarters| quarters.light.iter().all(|&l| l >= 0.0 && l.is_finite()))
    }
}

/// A tree under construction.
struct Refinement<'a> {
    old: &'a DirectionTrees,
    leaf_light: &'a dyn Fn(u32) -> f64,
    all: f64,
    /// Light up to which a square is even.
    least: f64,
    tree: Vec<Quarters>,
}

impl Refinement<'_> {
    /// Adds the square with this light in its quarters, and what is below it; its index. `old`: the same square in the old tree.
    fn divide(&mut self, old: Option<u32>, light: [f64; 4], depth: u32) -> u32 {
        let index = self.tree.len();
        self.tree.push(Quarters { light: light.map(|l| (l / self.all) as f32), child: [NONE; 4] });
        for (i, inside) in light.into_iter().enumerate() {
            if depth >= MAX_DEPTH || depth >= LEAST_DEPTH && inside <= SPLIT_SHARE * self.all {
                continue;
            }
            let node = old.and_then(|node| self.old.0.get(node as usize)).map_or(NONE, |q| q.child[i]);
            let below = (node != NONE).then_some(node);
            // A leaf knows its light, not where in it.
            let known = below.filter(|_| inside > self.least);
            let quarters = known.map_or([inside / 4.0; 4], |node| self.old.gather(node, self.leaf_light));
            let child = self.divide(below, quarters, depth + 1);
            if let Some(quarters) = self.tree.get_mut(index) {
                quarters.child[i] = child;
            }
        }
        index as u32
    }
}

/// Adds a square without light, divided `depth` times, and what is below it; its index.
fn blank(tree: &mut Vec<Quarters>, depth: u32) -> u32 {
    let index = tree.len();
    tree.push(Quarters { light: [0.0; 4], child: [NONE; 4] });
    if depth > 1 {
        let child = std::array::from_fn(|_| blank(tree, depth - 1));
        if let Some(quarters) = tree.get_mut(index) {
            quarters.child = child;
        }
    }
    index as u32
}

/// Whether `xi` falls to `high`; it is stretched to [0, 1) again. One of `low` and `high` is positive.
#[inline]
fn choose(xi: &mut f64, low: f64, high: f64) -> bool {
    let p = low / (low + high);
    let is_high = *xi >= p;
    let stretched = if is_high { (*xi - p) / (1.0 - p) } else { *xi / p };
    *xi = stretched.clamp(0.0, 1.0 - f64::EPSILON / 2.0);
    is_high
}

/// The direction at a point of the unit square.
#[inline]
fn to_sphere(place: DVec2) -> DVec3 {
    let signed = 2.0 * place - 1.0;
    let DVec2 { x: u, y: v } = signed.abs();
    // Above 0 in the upper hemisphere; r is the distance to the nearer pole.
    let height = 1.0 - (u + v);
    let r = 1.0 - height.abs();
    let phi = if r > 0.0 { FRAC_PI_4 * ((v - u) / r + 1.0) } else { 0.0 };
    let (sin_phi, cos_phi) = phi.sin_cos();
    let sin = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new(
        (sin * cos_phi).copysign(signed.x),
        (sin * sin_phi).copysign(signed.y),
        (1.0 - r * r).copysign(height),
    )
}

/// The point of the unit square [0, 1)^2 of a unit direction.
#[inline]
fn to_square(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction.abs();
    // r^2 = 1 - z without cancellation.
    let r = ((x * x + y * y) / (1.0 + z)).sqrt();
    let (large, small) = if x < y { (y, x) } else { (x, y) };
    let angle = if large > 0.0 { (small / large).atan() / FRAC_PI_2 } else { 0.0 };
    let v = r * if x < y { 1.0 - angle } else { angle };
    let (u, v) = if direction.z < 0.0 { (1.0 - v, 1.0 - (r - v)) } else { (r - v, v) };
    let place = 0.5 * DVec2::new(u.copysign(direction.x), v.copysign(direction.y)) + 0.5;
    place.clamp(DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON / 2.0))
}

#[cfg(test)]
mod tests;
