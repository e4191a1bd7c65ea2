//! The hierarchy that finds what a ray may meet. It sees boxes only, never surfaces.
//!
//! [`Bvh::build`] takes one box per primitive and sorts the primitives into [`Leaf`]s of a few; a query walks the tree and
//! hands every leaf whose box the ray may meet to a closure, nearest first. Whatever the ray, no leaf that it meets is
//! left out: the boxes are rounded outward, and the test in `node.rs` is conservative with a proof.
//!
//! ```
//! use glanz_geometry::bvh::{BuildOptions, Bvh};
//! use glanz_math::{Bounds3, DVec3, Ray};
//!
//! let boxes = [0.0, 3.0, 6.0].map(|x| Bounds3::new(DVec3::splat(x), DVec3::splat(x + 1.0)));
//! let bvh = Bvh::build(&boxes, &BuildOptions::default());
//! let ray = Ray::new(DVec3::new(3.5, 3.5, -1.0), DVec3::Z);
//! let mut met = Vec::new();
//! bvh.closest(&ray, f64::INFINITY, |leaf, t_max| {
//!     met.extend_from_slice(bvh.leaf(leaf));
//!     t_max
//! });
//! assert!(met.contains(&1));
//! ```
//!
//! How it hangs together: `build` finds a binary tree, `collapse` makes eight-wide nodes of it, `node` tests a ray
//! against a node, `traverse` walks, `simd` holds the vector instructions and all the unsafe code.

mod build;
mod collapse;
mod node;
pub(crate) mod simd;
mod traverse;

#[cfg(test)]
mod tests;

use glanz_math::{Bounds3, Ray};
use rayon::prelude::*;

use self::build::{BinaryNode, Item};
use self::collapse::Wide;
use self::node::{Node, UnitFrame};
use self::simd::{Isa, Simd, Task};
pub(crate) use self::traverse::Visit;
use self::traverse::{Any, Closest};

/// What the tree is built for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Most primitives in a leaf, at least 1.
    pub max_leaf: usize,
    /// Primitives of a leaf that are tested at once, at least 1: a leaf costs by blocks.
    pub block: usize,
    /// Cost of testing a block relative to that of testing a node.
    pub leaf_cost: f32,
}

impl Default for BuildOptions {
    /// For surfaces of all kinds, tested one by one and each dearer than a node.
    fn default() -> Self {
        Self { max_leaf: 4, block: 1, leaf_cost: 2.0 }
    }
}

/// A leaf of the tree, by its position in a depth-first walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf(u32);

impl Leaf {
    /// The leaf's number, below [`Bvh::leaf_count`].
    #[inline]
    #[must_use]
    pub fn ordinal(self) -> usize {
        self.0 as usize
    }
}

/// How large a tree came out, and how good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Inner nodes of up to eight children.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Primitives in the leaves.
    pub primitives: usize,
    /// Inner nodes above the deepest leaf.
    pub depth: usize,
    /// Expected cost, in tests of a node, of a random line through the root box (surface area heuristic).
    pub cost: f64,
    /// Memory of nodes and leaves, bytes.
    pub bytes: usize,
}

/// A hierarchy of boxes.
#[derive(Clone, Debug)]
pub struct Bvh {
    bounds: Bounds3,
    frame: UnitFrame,
    nodes: Vec<Node>,
    leaf_starts: Vec<u32>,
    items: Vec<u32>,
    depth: usize,
    cost: f64,
    isa: Isa,
}

impl Bvh {
    /// Builds the tree over `bounds`; primitives are known by their position in it.
    ///
    /// Primitives whose box is empty or not finite are left out: no query ever reports them. At most 2^31 boxes are
    /// looked at. The tree does not depend on the number of threads, and its depth is bounded whatever the boxes.
    #[must_use]
    pub fn build(bounds: &[Bounds3], options: &BuildOptions) -> Self {
        let bounds = &bounds[..bounds.len().min(1 << 31)];
        let usable = |b: &Bounds3| b.is_finite() && !b.is_empty();
        let around = |part: &&[Bounds3]| {
            part.iter().filter(|b| usable(b)).fold(Bounds3::EMPTY, |all, b| all.union(*b))
        };
        let parts: Vec<_> = bounds.chunks(PART).collect();
        let all = map(&parts, 1, around).into_iter().fold(Bounds3::EMPTY, Bounds3::union);
        let frame = UnitFrame::around(&all);
        let indices: Vec<u32> =
            (0..).zip(bounds).filter_map(|(index, b)| usable(b).then_some(index)).collect();
        let mut items = map(&indices, PART, |&index| {
            let (min, max) = frame.bounds(&bounds[index as usize]);
            Item::new(min, max, index)
        });
        let mut tree = vec![BinaryNode::EMPTY; (2 * items.len()).saturating_sub(1)];
        build::build(&mut items, &mut tree, 0, options);
        let wide = Wide::collapse(&tree);
        let cost = tree.first().map_or(0.0, |root| {
            let area = f64::from(root.half_area());
            if area > 0.0 { f64::from(root.plan.cost()) / area } else { 0.0 }
        });
        Self {
            bounds: all,
            frame,
            nodes: wide.nodes,
            leaf_starts: wide.leaf_starts,
            items: map(&items, PART, Item::index),
            depth: wide.depth,
            cost,
            isa: Isa::detect(),
        }
    }

    /// The box around all primitives; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// The primitives in `leaf`.
    #[inline]
    #[must_use]
    pub fn leaf(&self, leaf: Leaf) -> &[u32] {
        let ends = self.leaf_starts.get(leaf.ordinal()).zip(self.leaf_starts.get(leaf.ordinal() + 1));
        ends.and_then(|(&start, &end)| self.items.get(start as usize..end as usize)).unwrap_or_default()
    }

    /// How many leaves there are.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.leaf_starts.len().saturating_sub(1)
    }

    /// All leaves, in depth-first order.
    pub fn leaves(&self) -> impl ExactSizeIterator<Item = Leaf> + Clone + use<> {
        (0..self.leaf_count() as u32).map(Leaf)
    }

    /// Walks through the leaves that `ray` may meet at parameters from 0 to `t_max`, nearest first.
    ///
    /// `visit` gets a leaf and the present end of the ray, and returns the new one: the parameter of a closer hit, or
    /// what it got. A hit at exactly `t_max` is not culled, so that ties can be broken by the caller.
    ///
    /// Directions need not be of unit length. A ray with NaN in it, or whose direction is zero, meets nothing.
    #[inline]
    pub fn closest(&self, ray: &Ray, t_max: f64, visit: impl FnMut(Leaf, f64) -> f64) {
        self.isa.run(Closest { bvh: self, ray, t_max, visit: Closure(visit) });
    }

    /// Walks through the leaves that `ray` may meet at parameters from 0 to `t_max` until `visit` says yes; says
    /// whether it did.
    #[inline]
    pub fn any(&self, ray: &Ray, t_max: f64, visit: impl FnMut(Leaf) -> bool) -> bool {
        self.isa.run(Any { bvh: self, ray, t_max, visit: Question(visit) })
    }

    /// [`Bvh::closest`] from inside code that is already compiled for `simd`.
    #[inline(always)]
    pub(crate) fn closest_with<S: Simd>(&self, simd: S, ray: &Ray, t_max: f64, visit: impl Visit) {
        Closest { bvh: self, ray, t_max, visit }.run(simd);
    }

    /// [`Bvh::any`] from inside code that is already compiled for `simd`.
    #[inline(always)]
    pub(crate) fn any_with<S: Simd>(&self, simd: S, ray: &Ray, t_max: f64, visit: impl Visit) -> bool {
        Any { bvh: self, ray, t_max, visit }.run(simd)
    }

    /// The instruction set that queries run with.
    pub(crate) fn isa(&self) -> Isa {
        self.isa
    }

    /// The same tree, queried with other instructions.
    #[cfg(test)]
    pub(crate) fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// How large the tree came out, and how good.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            nodes: self.nodes.len(),
            leaves: self.leaf_count(),
            primitives: self.items.len(),
            depth: self.depth,
            cost: self.cost,
            bytes: size_of_val(&*self.nodes) + size_of_val(&*self.leaf_starts) + size_of_val(&*self.items),
        }
    }
}

/// Elements that are worth a task of their own.
pub(crate) const PART: usize = 1 << 12;

/// `f` of every element, in parallel if there are more than `part` of them. Scenes have thousands of small meshes: waking
/// a thread would cost more than building one.
pub(crate) fn map<T: Sync, U: Send>(list: &[T], part: usize, f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    if list.len() <= part {
        list.iter().map(f).collect()
    } else {
        list.par_iter().with_min_len(part).map(f).collect()
    }
}

/// A closure at the leaves.
struct Closure<F>(F);

impl<F: FnMut(Leaf, f64) -> f64> Visit for Closure<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        (self.0)(leaf, t_max)
    }
}

/// A closure that says yes or no.
struct Question<F>(F);

impl<F: FnMut(Leaf) -> bool> Visit for Question<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        if (self.0)(leaf) { f64::NEG_INFINITY } else { t_max }
    }
}
