//! The binary tree of boxes, by the surface area heuristic.
//!
//! Good splits are found in a binary tree, of which [`super::collapse`] then makes eight-wide nodes. Nodes are split down
//! to blocks of primitives that are tested at once; `collapse` decides which of them to gather into one leaf.
//!
//! A tree of `n` primitives has at most `2 n - 1` nodes. Room for all of them is allocated beforehand: the threads that
//! build the two halves of a node write to two halves of a slice, and the result does not depend on their number.
//!
//! # Source
//! @wald2007 for binning.

use super::BuildOptions;
use super::collapse::{CollapseCosts, CollapsePlan};

/// Largest depth of the binary tree, so that traversal needs a stack of fixed size only.
pub(crate) const MAX_DEPTH: usize = 64;

/// Largest number of primitives for which splits are searched between all neighbours instead of bins.
const SWEEP: usize = 8;

/// Largest number of primitives for which 8 bins per axis are used instead of 16.
const FEW: usize = 64;

/// Smallest number of primitives for which the halves of a node are built in parallel.
const PARALLEL: usize = 4096;

/// Smallest number of primitives for which a node is binned in parallel.
const PARALLEL_BINS: usize = 1 << 16;

/// A box in unit coordinates. The fourth lanes are padding, so that the compiler uses whole vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box4 {
    pub(crate) min: [f32; 4],
    pub(crate) max: [f32; 4],
}

impl Box4 {
    pub(crate) const EMPTY: Self = Self { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| if other.min[i] < self.min[i] { other.min[i] } else { self.min[i] }),
            max: std::array::from_fn(|i| if other.max[i] > self.max[i] { other.max[i] } else { self.max[i] }),
        }
    }

    /// Half the area of the six sides; 0 if empty.
    #[inline(always)]
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|i| (self.max[i] - self.min[i]).max(0.0));
        x * (y + z) + y * z
    }

    /// Twice the centre.
    #[inline(always)]
    fn middle(&self) -> [f32; 4] {
        std::array::from_fn(|i| self.min[i] + self.max[i])
    }

    #[inline(always)]
    fn including(self, point: [f32; 4]) -> Self {
        self.union(Self { min: point, max: point })
    }
}

/// The box of a primitive, with the bits of its index in the fourth lane of `min`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BvhPrimitive(Box4);

impl BvhPrimitive {
    pub(crate) fn new(min: [f32; 3], max: [f32; 3], index: u32) -> Self {
        Self(Box4 {
            min: [min[0], min[1], min[2], f32::from_bits(index)],
            max: [max[0], max[1], max[2], 0.0],
        })
    }

    pub(crate) fn index(&self) -> u32 {
        self.0.min[3].to_bits()
    }
}

/// A node of the binary tree. The left child follows its parent, the right one follows the left subtree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
    /// Primitives below.
    pub(crate) count: u32,
    pub(crate) plan: CollapsePlan,
}

impl BinaryNode {
    pub(crate) const EMPTY: Self = Self { min: [0.0; 3], max: [0.0; 3], count: 0, plan: CollapsePlan::EMPTY };

    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|i| self.max[i] - self.min[i]);
        x * (y + z) + y * z
    }
}

/// Builds the tree over `items`, which it reorders, into `nodes`, of length `2 items.len() - 1`. Returns the costs of the root.
pub(crate) fn build(
    items: &mut [BvhPrimitive],
    nodes: &mut [BinaryNode],
    depth: usize,
    options: &BuildOptions,
) -> CollapseCosts {
    let Some((node, below)) = nodes.split_first_mut() else { return CollapseCosts::ZERO };
    let extent = PrimitiveExtent::of(items);
    *node = BinaryNode {
        min: [extent.bounds.min[0], extent.bounds.min[1], extent.bounds.min[2]],
        max: [extent.bounds.max[0], extent.bounds.max[1], extent.bounds.max[2]],
        count: items.len() as u32,
        plan: CollapsePlan::EMPTY,
    };
    // A test of a block costs as much as one of any part of it.
    if items.len() <= options.block.min(options.max_leaf).max(1) {
        let (plan, costs) = CollapsePlan::new(node, None, options);
        node.plan = plan;
        return costs;
    }
    let middle = split(items, &extent.middles, depth, options.block).clamp(1, items.len() - 1);
    let (left_items, right_items) = items.split_at_mut(middle);
    let (left, right) = below.split_at_mut(2 * middle - 1);
    let (left, right) = if left_items.len() + right_items.len() >= PARALLEL {
        rayon::join(
            || build(left_items, left, depth + 1, options),
            || build(right_items, right, depth + 1, options),
        )
    } else {
        (build(left_items, left, depth + 1, options), build(right_items, right, depth + 1, options))
    };
    let (plan, costs) = CollapsePlan::new(node, Some([left, right]), options);
    node.plan = plan;
    costs
}

/// Number of blocks, and so the cost of a test, of `count` primitives.
fn blocks(count: usize, block: usize) -> f32 {
    count.div_ceil(block.max(1)) as f32
}

/// The box around some primitives and the box around their (doubled) centres.
#[derive(Clone, Copy)]
struct PrimitiveExtent {
    bounds: Box4,
    middles: Box4,
}

impl PrimitiveExtent {
    const EMPTY: Self = Self { bounds: Box4::EMPTY, middles: Box4::EMPTY };

    fn of(items: &[BvhPrimitive]) -> Self {
        parallel_fold(items, &Self::EMPTY, Self::add, Self::merge)
    }

    #[inline(always)]
    fn add(&mut self, item: &BvhPrimitive) {
        self.bounds = self.bounds.union(item.0);
        self.middles = self.middles.including(item.0.middle());
    }

    fn merge(&mut self, other: &Self) {
        self.bounds = self.bounds.union(other.bounds);
        self.middles = self.middles.union(other.middles);
    }
}

/// Folds over many items in parallel. `merge` must be exactly associative and commutative (as minimum, maximum and
/// counting are), so that the result does not depend on the threads.
fn parallel_fold<T: Clone + Send + Sync>(
    items: &[BvhPrimitive],
    empty: &T,
    add: impl Fn(&mut T, &BvhPrimitive) + Sync,
    merge: impl Fn(&mut T, &T) + Sync,
) -> T {
    use rayon::prelude::*;
    let fold = |items: &[BvhPrimitive]| {
        let mut all = empty.clone();
        items.iter().for_each(|item| add(&mut all, item));
        all
    };
    if items.len() < PARALLEL_BINS {
        return fold(items);
    }
    let parts = items.par_chunks(PARALLEL_BINS / 4).map(fold);
    parts.reduce(
        || empty.clone(),
        |mut a, b| {
            merge(&mut a, &b);
            a
        },
    )
}

/// Reorders `items` into a left and a right part; returns the length of the left one.
fn split(items: &mut [BvhPrimitive], middles: &Box4, depth: usize, block: usize) -> usize {
    let half = items.len() / 2;
    // A tree of exact halves has ceil(log2 n) levels below this node; where these reach the largest depth, halve.
    let levels = usize::BITS - (items.len() - 1).leading_zeros();
    let size: [f32; 3] = std::array::from_fn(|axis| middles.max[axis] - middles.min[axis]);
    if depth + levels as usize >= MAX_DEPTH {
        let axis = (0..3).fold(0, |widest, axis| if size[axis] > size[widest] { axis } else { widest });
        items.select_nth_unstable_by(half, |a, b| order(a, b, axis));
        return half;
    }
    if size.iter().all(|&s| s <= 0.0) {
        return half;
    }
    if items.len() <= SWEEP {
        sweep(items, block)
    } else if items.len() <= FEW {
        binned::<8>(items, middles, block)
    } else {
        binned::<16>(items, middles, block)
    }
}

/// Order along an axis; the index decides between equals, so that the order is total.
fn order(a: &BvhPrimitive, b: &BvhPrimitive, axis: usize) -> std::cmp::Ordering {
    a.0.middle()[axis].total_cmp(&b.0.middle()[axis]).then(a.index().cmp(&b.index()))
}

/// The best split of a few items between any two neighbours on any axis.
fn sweep(items: &mut [BvhPrimitive], block: usize) -> usize {
    let mut best = (f32::INFINITY, 0, items.len() / 2);
    for axis in 0..3 {
        items.sort_unstable_by(|a, b| order(a, b, axis));
        let mut right_areas = [0.0; SWEEP];
        let mut right = Box4::EMPTY;
        for (area, item) in right_areas.iter_mut().zip(items.iter()).rev().skip(SWEEP - items.len()) {
            right = right.union(item.0);
            *area = right.half_area();
        }
        let mut left = Box4::EMPTY;
        for (count, (item, &area)) in (1..).zip(items.iter().zip(&right_areas[1..])) {
            if count == items.len() {
                break;
            }
            left = left.union(item.0);
            let cost = left.half_area() * blocks(count, block) + area * blocks(items.len() - count, block);
            if cost < best.0 {
                best = (cost, axis, count);
            }
        }
    }
    if best.1 != 2 {
        items.sort_unstable_by(|a, b| order(a, b, best.1));
    }
    best.2
}

/// Boxes and numbers of the primitives in the bins of the three axes.
#[derive(Clone)]
struct Bins<const BINS: usize> {
    bounds: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl<const BINS: usize> Bins<BINS> {
    const EMPTY: Self = Self { bounds: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    #[inline(always)]
    fn add(&mut self, binning: &Binning<BINS>, item: &BvhPrimitive) {
        let middle = item.0.middle();
        let bins: [usize; 4] = std::array::from_fn(|axis| binning.bin(middle[axis], axis));
        for (axis, &bin) in bins[..3].iter().enumerate() {
            self.bounds[axis][bin] = self.bounds[axis][bin].union(item.0);
            self.counts[axis][bin] += 1;
        }
    }

    fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }
}

/// The map from a doubled centre to its bin: the nearest of `BINS` evenly spaced points from the smallest to the largest.
#[derive(Clone, Copy)]
struct Binning<const BINS: usize> {
    start: [f32; 4],
    scale: [f32; 4],
}

impl<const BINS: usize> Binning<BINS> {
    fn new(middles: &Box4) -> Self {
        let scale = std::array::from_fn(|axis| {
            let scale = (BINS - 1) as f32 / (middles.max[axis] - middles.min[axis]);
            // If the axis has no extent, or one so small that the quotient overflows, all fall into the first bin.
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { start: middles.min, scale }
    }

    #[inline(always)]
    fn bin(&self, middle: f32, axis: usize) -> usize {
        // Beyond 2^23 the spacing of floats is 1: the sum is rounded to an integer, which is in its last bits. A
        // conversion, which handles NaN and overflow, takes several times as long.
        const ROUND: f32 = (1 << 23) as f32;
        ((middle - self.start[axis]) * self.scale[axis] + ROUND).to_bits() as usize & (BINS - 1)
    }
}

/// The best split between bins.
fn binned<const BINS: usize>(items: &mut [BvhPrimitive], middles: &Box4, block: usize) -> usize {
    let binning = Binning::<BINS>::new(middles);
    let bins = parallel_fold(items, &Bins::<BINS>::EMPTY, |bins, item| bins.add(&binning, item), Bins::merge);
    let Some((axis, first_right)) = best_plane(&bins, block) else { return items.len() / 2 };
    partition(items, |item| binning.bin(item.0.middle()[axis], axis) < first_right)
}

/// The axis and the first bin of the right side with the smallest cost; `None` if all lie in one bin.
fn best_plane<const BINS: usize>(bins: &Bins<BINS>, block: usize) -> Option<(usize, usize)> {
    let mut best = None;
    let mut least = f32::INFINITY;
    for axis in 0..3 {
        let (bounds, counts) = (&bins.bounds[axis], &bins.counts[axis]);
        let mut right_costs = [0.0; BINS];
        let (mut right, mut count) = (Box4::EMPTY, 0);
        for bin in (1..BINS).rev() {
            right = right.union(bounds[bin]);
            count += counts[bin];
            right_costs[bin] =
                if count == 0 { f32::INFINITY } else { right.half_area() * blocks(count as usize, block) };
        }
        let (mut left, mut count) = (Box4::EMPTY, 0);
        for bin in 1..BINS {
            left = left.union(bounds[bin - 1]);
            count += counts[bin - 1];
            let cost = left.half_area() * blocks(count as usize, block) + right_costs[bin];
            if count > 0 && cost < least {
                least = cost;
                best = Some((axis, bin));
            }
        }
    }
    best
}

/// Moves the items of the left part to the front; returns their number.
fn partition(items: &mut [BvhPrimitive], is_left: impl Fn(&BvhPrimitive) -> bool) -> usize {
    // Every item is swapped, needed or not: a branch would be mispredicted every other time.
    let mut left = 0;
    for i in 0..items.len() {
        let goes_left = is_left(&items[i]);
        items.swap(left, i);
        left += usize::from(goes_left);
    }
    left
}
