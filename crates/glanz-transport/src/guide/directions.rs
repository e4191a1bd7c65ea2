//! Densities over the sphere of directions, with high resolution in directions of much light.
//!
//! Directions are mapped to the unit square, with equal areas and little distortion (@clarberg2008): the upper hemisphere becomes the inner
//! diamond, the lower one the four corners. A tree of squares, each divided into 4 x 4 parts, stores the fraction of the density in each
//! part; within a leaf the density is constant. This is a density in the Haar basis without the wavelets where there is little light:
//! chapter 2 of document 003, and the directional tree of @muller2017. Both map by (cos theta, phi), by which a light overhead becomes a
//! strip along a side of the square, which squares approximate badly.

use std::f64::consts::PI;

use glanz_math::{DVec2, DVec3};
use glanz_sampling::warp::{equal_area_sphere, equal_area_sphere_inverse};

/// Fraction of a tree above which a part is divided.
const SPLIT_SHARE: f64 = 0.03;

/// Number of virtual samples, spread evenly over the parts of a square, so that a few bright samples do not make a peak.
const EVEN_SAMPLES: f64 = 4.0;

/// Largest number of levels: the smallest leaves have 4 pi / 16^5 = 1.2e-5 sr.
const MAX_LEVELS: u32 = 5;

/// Levels of an untrained tree.
const FIRST_LEVELS: u32 = 2;

/// Child number of parts that are not divided.
const NONE: u16 = 0;

/// Sum of the shares of a square.
const WHOLE: u32 = u16::MAX as u32;

/// A square in 4 x 4 parts, column by column: part i has column i / 4 and row i % 4. It is one cache line, so that two halvings
/// in both directions need one access to memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(align(64))]
pub(crate) struct QuadtreeNode {
    /// Share of each part in units of 1 / [`WHOLE`] of the square; all 0 without light.
    pub(crate) share: [u16; 16],
    /// Index of each part's own square, counted from the root, larger than the index of this; [`NONE`] if it is a leaf.
    pub(crate) child: [u16; 16],
}

/// A direction sampled from a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionSample {
    /// Unit direction.
    pub(crate) direction: DVec3,
    /// Its density per steradian.
    pub(crate) pdf: f64,
    /// The leaf: sixteen times the index of the square plus the number of the part.
    pub(crate) leaf: u32,
}

/// The trees of all cells, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DirectionTrees(pub(crate) Vec<QuadtreeNode>);

impl DirectionTrees {
    /// Adds a tree of equal leaves without light; returns its root.
    pub(crate) fn push_blank(&mut self) -> u32 {
        let mut tree = Vec::new();
        blank(&mut tree, FIRST_LEVELS);
        self.push(&tree)
    }

    /// Adds a tree whose first element is its root; returns the new number of the root.
    pub(crate) fn push(&mut self, tree: &[QuadtreeNode]) -> u32 {
        let root = self.0.len() as u32;
        self.0.extend(tree);
        root
    }

    /// A copy of a tree; its first element is the root.
    pub(crate) fn tree(&self, root: u32) -> Vec<QuadtreeNode> {
        // Children follow their parents and the children of earlier parts.
        let (mut tree, mut end) = (Vec::new(), 0);
        while let Some(square) = self.0.get(root as usize + tree.len()).filter(|_| tree.len() <= end) {
            end = square.child.iter().fold(end, |end, &child| end.max(usize::from(child)));
            tree.push(*square);
        }
        tree
    }

    /// Whether the tree has any light.
    pub(crate) fn is_lit(&self, root: u32) -> bool {
        self.0.get(root as usize).is_some_and(|square| square.share != [0; 16])
    }

    /// Samples a direction from the tree with that root; `None` without light.
    ///
    /// Every step uses both components of `xi` and rescales the remainders, so that well distributed numbers give well distributed
    /// directions.
    #[inline]
    pub(crate) fn sample(&self, root: u32, mut xi: DVec2) -> Option<DirectionSample> {
        let (mut node, mut pdf) = (root, 1.0 / (4.0 * PI));
        let (mut corner, mut side) = (DVec2::ZERO, 1.0);
        loop {
            let QuadtreeNode { share, child } = self.0.get(node as usize)?;
            let (columns, _) = share.as_chunks::<4>();
            let sums: [u32; 4] =
                std::array::from_fn(|i| columns[i].iter().map(|&part| u32::from(part)).sum());
            let column = choose(&mut xi.x, sums, WHOLE)?;
            let rows = columns[column].map(u32::from);
            let row = choose(&mut xi.y, rows, sums[column])?;
            let part = 4 * column + row;
            pdf *= f64::from(share[part]) * (16.0 / f64::from(WHOLE));
            side *= 0.25;
            corner += side * DVec2::new(column as f64, row as f64);
            if child[part] == NONE {
                let leaf = 16 * node + part as u32;
                return Some(DirectionSample { direction: equal_area_sphere(corner + side * xi), pdf, leaf });
            }
            node = root + u32::from(child[part]);
        }
    }

    /// Density per steradian of `direction` and its leaf.
    #[inline]
    pub(crate) fn pdf(&self, root: u32, direction: DVec3) -> (f64, u32) {
        let (mut node, mut pdf, mut place) = (root, 1.0 / (4.0 * PI), equal_area_sphere_inverse(direction));
        loop {
            let Some(QuadtreeNode { share, child }) = self.0.get(node as usize) else { return (0.0, 0) };
            place *= 4.0;
            let (column, row) = (place.x as usize & 3, place.y as usize & 3);
            place -= DVec2::new(column as f64, row as f64);
            let part = 4 * column + row;
            pdf *= f64::from(share[part]) * (16.0 / f64::from(WHOLE));
            if child[part] == NONE {
                return (pdf, 16 * node + part as u32);
            }
            node = root + u32::from(child[part]);
        }
    }

    /// The tree with that root, with fractions by `weight` and divided anew: finer where the weight is large. The root is the first
    /// element. `None` if all weights are 0.
    ///
    /// `weight`: weight of a leaf, in any unit. `effective`: effective number of samples, that of equal samples with the same variance.
    pub(crate) fn refined(
        &self,
        root: u32,
        effective: f64,
        weight: &dyn Fn(QuadtreeLeaf) -> f64,
    ) -> Option<Vec<QuadtreeNode>> {
        let whole = QuadtreeChild::whole(root);
        let weights = self.gather(root, whole, weight);
        let all: f64 = weights.iter().sum();
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let mut refinement = TreeRefinement { old: self, root, weight, all, effective, tree: Vec::new() };
        refinement.divide(Some(whole), weights, 1);
        Some(refinement.tree)
    }

    /// Weight of the whole tree.
    pub(crate) fn total(&self, root: u32, weight: &dyn Fn(QuadtreeLeaf) -> f64) -> f64 {
        self.gather(root, QuadtreeChild::whole(root), weight).iter().sum()
    }

    /// Weights of the parts of a square, all leaves below them added up.
    fn gather(&self, root: u32, of: QuadtreeChild, weight: &dyn Fn(QuadtreeLeaf) -> f64) -> [f64; 16] {
        std::array::from_fn(|i| match self.part(root, of, i) {
            (share, None) => {
                weight(QuadtreeLeaf { number: 16 * of.node + i as u32, share, area: of.area / 16.0 })
            }
            (_, Some(below)) => self.gather(root, below, weight).iter().sum(),
        })
    }

    /// Fraction of a part in the tree, and its square if it is divided.
    fn part(&self, root: u32, of: QuadtreeChild, i: usize) -> (f64, Option<QuadtreeChild>) {
        let Some(square) = self.0.get(of.node as usize) else { return (0.0, None) };
        let share = of.share * f64::from(square.share[i]) / f64::from(WHOLE);
        let child = square.child[i];
        (
            share,
            (child != NONE).then_some(QuadtreeChild {
                node: root + u32::from(child),
                share,
                area: of.area / 16.0,
            }),
        )
    }

    /// Whether there is a valid tree at each of these roots: no node with two parents, none too deep, none unreachable, and valid
    /// fractions.
    pub(crate) fn is_valid(&self, roots: impl Iterator<Item = u32>) -> bool {
        let mut levels: Vec<Option<(u32, u32)>> = vec![None; self.0.len()];
        for root in roots {
            match levels.get_mut(root as usize) {
                Some(slot @ None) => *slot = Some((root, 1)),
                _ => return false,
            }
        }
        for (i, square) in self.0.iter().enumerate() {
            let Some((root, level)) = levels.get(i).copied().flatten() else { return false };
            for &child in square.child.iter().filter(|&&child| child != NONE) {
                let index = root as usize + usize::from(child);
                let fine = index > i && level < MAX_LEVELS;
                let below = (root, level + 1);
                if !fine || levels.get_mut(index).is_none_or(|slot| slot.replace(below).is_some()) {
                    return false;
                }
            }
            let sum: u32 = square.share.iter().map(|&share| u32::from(share)).sum();
            if sum != 0 && sum != WHOLE {
                return false;
            }
        }
        true
    }
}

/// A leaf of a tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadtreeLeaf {
    /// Its number among those of all trees.
    pub(crate) number: u32,
    /// Its share in the tree.
    pub(crate) share: f64,
    /// Its share in the sphere.
    pub(crate) area: f64,
}

/// A square of a tree.
#[derive(Clone, Copy)]
struct QuadtreeChild {
    node: u32,
    /// Its shares in the tree and in the sphere.
    share: f64,
    area: f64,
}

impl QuadtreeChild {
    fn whole(root: u32) -> Self {
        Self { node: root, share: 1.0, area: 1.0 }
    }
}

/// A tree under construction.
struct TreeRefinement<'a> {
    old: &'a DirectionTrees,
    root: u32,
    weight: &'a dyn Fn(QuadtreeLeaf) -> f64,
    all: f64,
    effective: f64,
    tree: Vec<QuadtreeNode>,
}

impl TreeRefinement<'_> {
    /// Adds the square with these weights of its parts, and the squares below it; returns its index. `old`: the same square in the old tree.
    fn divide(&mut self, old: Option<QuadtreeChild>, weights: [f64; 16], level: u32) -> u16 {
        let weights = self.evened(weights);
        let index = self.tree.len();
        self.tree.push(QuadtreeNode { share: shares(weights), child: [NONE; 16] });
        for (i, inside) in weights.into_iter().enumerate() {
            // There are at most 1 / SPLIT_SHARE squares on each level, so that the numbers of all fit.
            if level >= MAX_LEVELS || inside <= SPLIT_SHARE * self.all {
                continue;
            }
            let below = old.and_then(|old| self.old.part(self.root, old, i).1);
            // The distribution of the weight within a leaf is unknown.
            let parts =
                below.map_or([inside / 16.0; 16], |below| self.old.gather(self.root, below, self.weight));
            let child = self.divide(below, parts, level + 1);
            if let Some(square) = self.tree.get_mut(index) {
                square.child[i] = child;
            }
        }
        index as u16
    }

    /// Weights of the parts of a square with [`EVEN_SAMPLES`] added, scaled to the same sum.
    fn evened(&self, weights: [f64; 16]) -> [f64; 16] {
        let sum: f64 = weights.iter().sum();
        let samples = self.effective * sum / self.all;
        if sum <= 0.0 || samples.is_infinite() {
            return weights;
        }
        weights.map(|weight| (samples * weight + EVEN_SAMPLES * sum / 16.0) / (samples + EVEN_SAMPLES))
    }
}

/// Weights in units of 1 / [`WHOLE`] of their sum, which is positive; positive weights stay positive, and the sum is preserved.
fn shares(weights: [f64; 16]) -> [u16; 16] {
    let sum: f64 = weights.iter().sum();
    let mut shares =
        weights.map(
            |weight| if weight > 0.0 { (weight / sum * f64::from(WHOLE)).round().max(1.0) as u16 } else { 0 },
        );
    let total: u32 = shares.iter().map(|&share| u32::from(share)).sum();
    if let Some(largest) = shares.iter_mut().max() {
        *largest = (u32::from(*largest) + WHOLE - total) as u16;
    }
    shares
}

/// Adds a tree of squares without light with this number of levels, its root included; returns the index of the root.
fn blank(tree: &mut Vec<QuadtreeNode>, levels: u32) -> u16 {
    let index = tree.len();
    tree.push(QuadtreeNode::default());
    if levels > 1 {
        let child = std::array::from_fn(|_| blank(tree, levels - 1));
        if let Some(square) = tree.get_mut(index) {
            square.child = child;
        }
    }
    index as u16
}

/// Selects one of four weights by `xi`, which is then rescaled to [0, 1). `sum`: sum of the weights. `None` if it is 0.
#[inline]
fn choose(xi: &mut f64, weights: [u32; 4], sum: u32) -> Option<usize> {
    let at = *xi * f64::from(sum);
    let [a, b, c, _] = weights;
    let borders = [0, a, a + b, a + b + c];
    let whole = at as u32;
    let index = usize::from(whole >= borders[1])
        + usize::from(whole >= borders[2])
        + usize::from(whole >= borders[3]);
    if weights[index] == 0 {
        return None;
    }
    *xi = ((at - f64::from(borders[index])) / f64::from(weights[index])).min(1.0 - f64::EPSILON / 2.0);
    Some(index)
}

#[cfg(test)]
mod tests;
