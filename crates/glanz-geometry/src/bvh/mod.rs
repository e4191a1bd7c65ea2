//! A bounding volume hierarchy over boxes, independent of surfaces.
//!
//! [`Bvh::build`] takes one box per primitive and groups the primitives into [`BvhLeaf`]s of a few. A query traverses the
//! tree and calls a closure with every leaf whose box the ray may meet, nearest first. No leaf that the ray meets is ever
//! culled: the boxes are rounded outward, and the test in `node.rs` is conservative, with a proof.
//!
//! ```
//! use glanz_geometry::bvh::{BuildOptions, Bvh};
//! use glanz_math::{Bounds3, DVec3, Ray};
//!
//! let boxes = [0.0, 3.0, 6.0].map(|x| Bounds3::new(DVec3::splat(x), DVec3::splat(x + 1.0)));
//! let bvh = Bvh::build(&boxes, &BuildOptions::default());
//! let ray = Ray::new(DVec3::new(3.5, 3.5, -1.0), DVec3::Z);
//! let mut visited = Vec::new();
//! bvh.closest(&ray, f64::INFINITY, |leaf, t_max| {
//!     visited.extend_from_slice(bvh.leaf(leaf));
//!     t_max
//! });
//! assert!(visited.contains(&1));
//! ```
//!
//! Files: `build` (the binary tree), `collapse` (eight-wide nodes from it), `node` (a ray against a node), `traversal`
//! (nearest first), `query` (closest hit, any hit and all hits of a surface), `stream`, `single_ray_traversal` and
//! `compact_ray` (many rays at once), `batch` (the same for callers of other crates), `simd` (vector instructions and all the
//! unsafe code).

mod batch;
mod build;
mod collapse;
mod compact_ray;
mod node;
pub(crate) mod query;
pub(crate) mod simd;
mod single_ray_traversal;
pub(crate) mod stream;
mod traversal;

#[cfg(test)]
mod tests;

use glanz_math::{Bounds3, Ray};
use rayon::prelude::*;

pub use self::batch::BatchVisitor;
use self::build::{BinaryNode, BvhPrimitive};
use self::collapse::WideTree;
pub(crate) use self::compact_ray::CompactRay;
use self::node::{UnitFrame, WideNode};
use self::simd::{Isa, Simd, Task, prefer_large_pages};
pub(crate) use self::traversal::LeafVisitor;
use self::traversal::{AnyTraversal, ClosestTraversal};

/// Leaf size and costs for which the tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Largest number of primitives in a leaf, at least 1.
    pub max_leaf: usize,
    /// Primitives of a leaf that are tested at once, at least 1: a leaf costs by blocks.
    pub block: usize,
    /// Cost of a test of a block relative to that of a node.
    pub leaf_cost: f32,
}

impl Default for BuildOptions {
    /// Options for surfaces of all kinds, which are tested one by one, each at a higher cost than a node.
    fn default() -> Self {
        Self { max_leaf: 4, block: 1, leaf_cost: 2.0 }
    }
}

/// A leaf of the tree, by its position in depth-first order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BvhLeaf(u32);

impl BvhLeaf {
    /// The leaf's number, below [`Bvh::leaf_count`].
    #[inline]
    #[must_use]
    pub fn ordinal(self) -> usize {
        self.0 as usize
    }
}

/// Size and expected cost of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhStatistics {
    /// Inner nodes of up to eight children.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Primitives in the leaves.
    pub primitives: usize,
    /// Inner nodes above the deepest leaf.
    pub depth: usize,
    /// Expected cost of a random line through the root box, in tests of a node (surface area heuristic).
    pub cost: f64,
    /// Memory of nodes and leaves, bytes.
    pub bytes: usize,
}

/// A hierarchy of boxes.
#[derive(Clone, Debug)]
pub struct Bvh {
    bounds: Bounds3,
    frame: UnitFrame,
    nodes: Vec<WideNode>,
    leaf_starts: Vec<u32>,
    items: Vec<u32>,
    leaf_count: usize,
    primitive_count: usize,
    depth: usize,
    cost: f64,
    isa: Isa,
}

impl Bvh {
    /// Builds the tree over `bounds`; a primitive is identified by its position there.
    ///
    /// Primitives whose box is empty or not finite are left out, and so are all after the first 2^31. The tree does not
    /// depend on the number of threads, and its depth is bounded for all inputs.
    #[must_use]
    pub fn build(bounds: &[Bounds3], options: &BuildOptions) -> Self {
        let (all, frame, items) = Self::items(bounds);
        Self::of_items(all, frame, items, options)
    }

    /// [`Bvh::build`] over boxes that are freed before the tree takes its memory.
    pub(crate) fn build_over(bounds: Vec<Bounds3>, options: &BuildOptions) -> Self {
        let (all, frame, items) = Self::items(&bounds);
        drop(bounds);
        Self::of_items(all, frame, items, options)
    }

    /// The box around all usable boxes, its frame, and the usable boxes in it.
    fn items(bounds: &[Bounds3]) -> (Bounds3, UnitFrame, Vec<BvhPrimitive>) {
        let bounds = &bounds[..bounds.len().min(1 << 31)];
        let usable = |b: &Bounds3| b.is_finite() && !b.is_empty();
        let around = |part: &&[Bounds3]| {
            part.iter().filter(|b| usable(b)).fold(Bounds3::EMPTY, |all, b| all.union(*b))
        };
        let parts: Vec<_> = bounds.chunks(PARALLEL_CHUNK).collect();
        let all = parallel_map(&parts, 1, around).into_iter().fold(Bounds3::EMPTY, Bounds3::union);
        let frame = UnitFrame::around(&all);
        let indices: Vec<u32> =
            (0..).zip(bounds).filter_map(|(index, b)| usable(b).then_some(index)).collect();
        let items = parallel_map(&indices, PARALLEL_CHUNK, |&index| {
            let (min, max) = frame.bounds(&bounds[index as usize]);
            BvhPrimitive::new(min, max, index)
        });
        (all, frame, items)
    }

    /// The tree over `items` in the frame of the box `all`.
    fn of_items(
        all: Bounds3,
        frame: UnitFrame,
        mut items: Vec<BvhPrimitive>,
        options: &BuildOptions,
    ) -> Self {
        let mut tree = Vec::with_capacity(2 * items.len());
        prefer_large_pages(&mut tree);
        tree.resize((2 * items.len()).saturating_sub(1), BinaryNode::EMPTY);
        let costs = build::build(&mut items, &mut tree, 0, options);
        // Before the wide tree takes its memory.
        let indices = parallel_map(&items, PARALLEL_CHUNK, BvhPrimitive::index);
        drop(items);
        let wide = WideTree::collapse(&tree);
        let cost = tree.first().map_or(0.0, |root| {
            let area = f64::from(root.half_area());
            if area > 0.0 { f64::from(costs.of_root()) / area } else { 0.0 }
        });
        drop(tree);
        Self {
            bounds: all,
            frame,
            nodes: wide.nodes,
            leaf_count: wide.leaf_starts.len().saturating_sub(1),
            primitive_count: indices.len(),
            leaf_starts: wide.leaf_starts,
            items: indices,
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
    pub fn leaf(&self, leaf: BvhLeaf) -> &[u32] {
        let ends = self.leaf_starts.get(leaf.ordinal()).zip(self.leaf_starts.get(leaf.ordinal() + 1));
        ends.and_then(|(&start, &end)| self.items.get(start as usize..end as usize)).unwrap_or_default()
    }

    /// Number of leaves.
    #[must_use]
    pub fn leaf_count(&self) -> usize {
        self.leaf_count
    }

    /// Drops the primitives of the leaves, for a surface that lays out its own by the ordinals of the leaves: [`Bvh::leaf`] has none
    /// from then on.
    pub(crate) fn forget_items(&mut self) {
        (self.leaf_starts, self.items) = (Vec::new(), Vec::new());
    }

    /// All leaves, in depth-first order.
    pub fn leaves(&self) -> impl ExactSizeIterator<Item = BvhLeaf> + Clone + use<> {
        (0..self.leaf_count() as u32).map(BvhLeaf)
    }

    /// Visits the leaves that `ray` may meet at parameters from 0 to `t_max`, nearest first.
    ///
    /// `visit` takes a leaf and the current end of the ray, and returns the new end: the parameter of a closer hit, or the
    /// current end. A hit at exactly `t_max` is not culled, so that the caller can break ties.
    ///
    /// Directions need not be of unit length. A ray that contains NaN, or whose direction is zero, meets nothing.
    #[inline]
    pub fn closest(&self, ray: &Ray, t_max: f64, visit: impl FnMut(BvhLeaf, f64) -> f64) {
        self.isa.run(ClosestTraversal { bvh: self, ray, t_max, visit: ClosestClosure(visit) });
    }

    /// Visits the leaves that `ray` may meet at parameters from 0 to `t_max` until `visit` returns true; returns whether
    /// it did.
    #[inline]
    pub fn any(&self, ray: &Ray, t_max: f64, visit: impl FnMut(BvhLeaf) -> bool) -> bool {
        self.isa.run(AnyTraversal { bvh: self, ray, t_max, visit: AnyClosure(visit) })
    }

    /// [`Bvh::closest`] for callers that are themselves compiled for `simd`.
    #[inline(always)]
    pub(crate) fn closest_with<S: Simd>(&self, simd: S, ray: &Ray, t_max: f64, visit: impl LeafVisitor) {
        ClosestTraversal { bvh: self, ray, t_max, visit }.run(simd);
    }

    /// [`Bvh::any`] for callers that are themselves compiled for `simd`.
    #[inline(always)]
    pub(crate) fn any_with<S: Simd>(&self, simd: S, ray: &Ray, t_max: f64, visit: impl LeafVisitor) -> bool {
        AnyTraversal { bvh: self, ray, t_max, visit }.run(simd)
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

    /// Size and expected cost.
    #[must_use]
    pub fn statistics(&self) -> BvhStatistics {
        BvhStatistics {
            nodes: self.nodes.len(),
            leaves: self.leaf_count(),
            primitives: self.primitive_count,
            depth: self.depth,
            cost: self.cost,
            bytes: size_of_val(&*self.nodes) + size_of_val(&*self.leaf_starts) + size_of_val(&*self.items),
        }
    }
}

/// Smallest number of elements that is worth a parallel task.
pub(crate) const PARALLEL_CHUNK: usize = 1 << 12;

/// `f` of every element, in parallel if there are more than `chunk` of them. Scenes have thousands of small meshes: waking
/// a thread would take longer than building one of them. Long lists are backed by large pages.
pub(crate) fn parallel_map<T: Sync, U: Send>(
    list: &[T],
    chunk: usize,
    f: impl Fn(&T) -> U + Sync + Send,
) -> Vec<U> {
    if list.len() <= chunk {
        return list.iter().map(f).collect();
    }
    let mut all = Vec::with_capacity(list.len());
    prefer_large_pages(&mut all);
    list.par_iter().with_min_len(chunk).map(f).collect_into_vec(&mut all);
    all
}

/// All that `append` adds to a list for each element of `list` and its position, in the order of `list`; in parallel if there are more
/// than `chunk`. Chunks do not depend on the number of threads.
pub(crate) fn parallel_flat_map<T: Sync, U: Send>(
    list: &[T],
    chunk: usize,
    append: impl Fn(usize, &T, &mut Vec<U>) + Sync + Send,
) -> Vec<U> {
    let chunks: Vec<_> = (0..).step_by(chunk).zip(list.chunks(chunk)).collect();
    let parts = parallel_map(&chunks, 1, |&(first, elements)| {
        let mut part = Vec::new();
        (first..).zip(elements).for_each(|(index, element)| append(index, element, &mut part));
        part
    });
    let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
    prefer_large_pages(&mut all);
    parts.into_iter().for_each(|part| all.extend(part));
    all
}

/// The closure of [`Bvh::closest`] as a visitor.
struct ClosestClosure<F>(F);

impl<F: FnMut(BvhLeaf, f64) -> f64> LeafVisitor for ClosestClosure<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: BvhLeaf, t_max: f64) -> f64 {
        (self.0)(leaf, t_max)
    }
}

/// The closure of [`Bvh::any`] as a visitor.
struct AnyClosure<F>(F);

impl<F: FnMut(BvhLeaf) -> bool> LeafVisitor for AnyClosure<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: BvhLeaf, t_max: f64) -> f64 {
        if (self.0)(leaf) { f64::NEG_INFINITY } else { t_max }
    }
}
