//! Traversal by many rays at once.
//!
//! The rays of an octant of directions descend together. A node is tested against each ray of its list with its planes in
//! registers, and the bits of the boxes that the rays meet become the lists of its children. Lists wait on a stack, nearest
//! child on top, and their rays in memory that is used last in, first out. The rays of short lists traverse the rest of the tree
//! one by one, but in turns, so that several reach leaves together.

use std::cell::RefCell;

use super::compact_ray::{self, CompactRay};
use super::node::{NodeChild, UnitRay, WIDTH, WideNode, far_sides};
use super::simd::Simd;
use super::simd::lanes::{LANES, first_lanes};
use super::single_ray_traversal::SingleRayTraversal;
use super::{Bvh, BvhLeaf};
use crate::batch::BoundedRay;

/// Length up to which the rays of a list traverse the tree one by one.
const SHORT_LIST_LENGTH: usize = 2;

/// Number of rays that do so in turns: more than a vector, since not all of their leaves are solved.
const TRAVERSALS_IN_TURNS: usize = 2 * LANES;

/// The caller's work at the leaves, for streams. Methods are `#[inline(always)]`: see [`LeafVisitor`](super::LeafVisitor).
pub(crate) trait StreamVisitor {
    /// Prepares the rays at the positions `ids` of `rays`, which may meet leaves.
    fn prepare<S: Simd>(&mut self, simd: S, ids: &[u32], rays: &mut [CompactRay]);
    /// Intersects rays with a leaf; may shorten them.
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]);
    /// The same for the first `count` pairs of a leaf and a ray.
    fn pairs<S: Simd>(
        &mut self,
        simd: S,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        count: usize,
        rays: &mut [CompactRay],
    );
    /// Ends the search in the leaves visited so far.
    fn finish<S: Simd>(&mut self, simd: S, rays: &mut [CompactRay]);
    /// Prefetches a leaf that will be visited soon.
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf);
}

/// Lists of positions of rays, one behind the other, each with room for a vector behind it.
#[derive(Default)]
struct ListArena {
    ids: Vec<u32>,
}

impl ListArena {
    /// Makes room for lists up to `end`.
    fn reserve(&mut self, end: usize) {
        if self.ids.len() < end {
            self.ids.resize(end.next_power_of_two(), 0);
        }
    }

    /// The vector at `start`.
    #[inline(always)]
    fn vector(&self, start: usize) -> [u32; LANES] {
        self.ids.get(start..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default()
    }

    #[inline(always)]
    fn vector_mut(&mut self, start: usize) -> Option<&mut [u32; LANES]> {
        self.ids.get_mut(start..).and_then(|rest| rest.first_chunk_mut())
    }
}

/// A child that is to be visited by a list of rays.
struct PendingChild {
    child: NodeChild,
    start: usize,
    end: usize,
}

/// Memory of a stream, reused by the next one.
#[derive(Default)]
pub(crate) struct StreamScratch {
    rays: Vec<CompactRay>,
    octants: [Vec<u32>; 8],
    arena: ListArena,
    pending: Vec<PendingChild>,
    /// Subtrees, each with a ray that traverses it by itself.
    single_rays: Vec<(NodeChild, u32)>,
    /// The traversals that take turns; all of them at their ends between calls.
    traversals: Vec<SingleRayTraversal>,
    /// For each eight rays of a list and each child, the rays that may meet it.
    masks: Vec<u64>,
    met: Vec<u32>,
}

impl Bvh {
    /// Visits the leaves that each of `rays` may meet, roughly nearest first. A ray is known to `visit` by its position.
    #[inline(always)]
    pub(crate) fn stream<S: Simd>(
        &self,
        simd: S,
        rays: &[BoundedRay],
        scratch: &mut StreamScratch,
        visit: &mut impl StreamVisitor,
    ) {
        scratch.prepare(simd, self, rays);
        for octant in 0..8 {
            let count = scratch.octants[octant].len();
            if count > 0 {
                scratch.arena.reserve(count + LANES);
                scratch.arena.ids[..count].copy_from_slice(&scratch.octants[octant]);
                scratch.traverse(simd, self, octant, count, visit);
            }
        }
        visit.finish(simd, &mut scratch.rays);
    }
}

/// Largest number of rays for which a thread keeps its memory, of some hundred bytes a ray.
const KEPT_RAYS: usize = 1 << 16;

thread_local! {
    /// The memory of earlier streams, as much as were nested: getting it from the system would take as long as the rays.
    static POOL: RefCell<Vec<StreamScratch>> = const { RefCell::new(Vec::new()) };
}

impl StreamScratch {
    /// Memory of this thread. A pair of functions instead of one with a closure: closures are not compiled for vector instructions.
    pub(crate) fn take() -> Self {
        // A thread that ends has no pool any more.
        POOL.try_with(|pool| pool.borrow_mut().pop()).ok().flatten().unwrap_or_default()
    }

    /// Keeps the memory for the next stream of this thread, unless it is that of a very large batch.
    pub(crate) fn put_back(self) {
        if self.rays.capacity() <= KEPT_RAYS {
            let _ = POOL.try_with(|pool| pool.borrow_mut().push(self));
        }
    }

    /// The rays, sorted into octants.
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, simd: S, bvh: &Bvh, rays: &[BoundedRay]) {
        self.rays.clear();
        self.rays.reserve(rays.len());
        self.octants.iter_mut().for_each(Vec::clear);
        let mut eight = [CompactRay::NONE; LANES];
        for chunk in rays.chunks(LANES) {
            let mut padded = [BoundedRay::NONE; LANES];
            let (full, mask) = match chunk.first_chunk() {
                Some(full) => (full, first_lanes(LANES)),
                None => {
                    padded.iter_mut().zip(chunk).for_each(|(slot, ray)| *slot = *ray);
                    (&padded, first_lanes(chunk.len()))
                }
            };
            let masks = compact_ray::prepare(simd, &bvh.frame, full, chunk.len(), &mut eight);
            let start = self.rays.len() as u32;
            self.rays.extend_from_slice(eight.get(..chunk.len()).unwrap_or_default());
            // Neighbours are most often in one octant.
            if let Some(octant) = masks.common_octant(mask) {
                self.octants[octant].extend(start..start + chunk.len() as u32);
                continue;
            }
            for (id, ray) in (start..).zip(eight.iter().take(chunk.len())) {
                if ray.is_open() {
                    self.octants[ray.octant()].push(id);
                }
            }
        }
    }

    /// Traverses the tree with the first `count` rays of the arena.
    #[inline(always)]
    fn traverse<S: Simd>(
        &mut self,
        simd: S,
        bvh: &Bvh,
        octant: usize,
        count: usize,
        visit: &mut impl StreamVisitor,
    ) {
        let root = NodeChild::node(0);
        if count <= SHORT_LIST_LENGTH {
            visit.prepare(simd, self.arena.ids.get(..count).unwrap_or_default(), &mut self.rays);
        }
        self.pending.push(PendingChild { child: root, start: 0, end: count });
        while let Some(PendingChild { child, start, end }) = self.pending.pop() {
            let Self { rays, arena, single_rays, .. } = self;
            let ids = arena.ids.get(start..end).unwrap_or_default();
            if ids.len() <= SHORT_LIST_LENGTH {
                single_rays.extend(ids.iter().map(|&id| (child, id)));
            } else if let Some(leaf) = child.as_leaf() {
                visit.leaf(simd, BvhLeaf(leaf), ids, rays);
            } else if let Some(node) = bvh.nodes.get(child.0 as usize) {
                let counts = self.test(simd, node, octant, start, end);
                if child == root {
                    self.prepare_met(simd, start, visit);
                }
                self.divide(simd, node, counts, start, end);
            }
        }
        self.traverse_single_rays(simd, bvh, visit);
    }

    /// Traverses subtrees with single rays.
    #[inline(always)]
    fn traverse_single_rays<S: Simd>(&mut self, simd: S, bvh: &Bvh, visit: &mut impl StreamVisitor) {
        let Self { rays, single_rays, traversals, .. } = self;
        if traversals.is_empty() {
            traversals.resize_with(TRAVERSALS_IN_TURNS, SingleRayTraversal::new);
        }
        let mut tasks = single_rays.drain(..);
        let mut open = tasks.len() > 0;
        while open {
            open = false;
            for group in traversals.chunks_mut(LANES) {
                let (mut ids, mut leaves, mut count) = ([0; LANES], [BvhLeaf(0); LANES], 0);
                for traversal in group {
                    if let Some(leaf) = traversal.advance(simd, bvh, rays, &mut tasks, &*visit) {
                        (ids[count], leaves[count]) = (traversal.id, leaf);
                        count += 1;
                    }
                }
                if count > 0 {
                    open = true;
                    visit.pairs(simd, &leaves, &ids, count, rays);
                }
            }
        }
    }

    /// Tests the rays of a list against a node; fills `masks` and returns the numbers of rays that may meet the children.
    #[inline(always)]
    fn test<S: Simd>(
        &mut self,
        simd: S,
        node: &WideNode,
        octant: usize,
        start: usize,
        end: usize,
    ) -> [usize; WIDTH] {
        let Self { rays, arena, masks, .. } = self;
        masks.clear();
        let planes = node.ordered_planes(simd, far_sides(octant));
        for chunk in arena.ids.get(start..end).unwrap_or_default().chunks(LANES) {
            let mut rows = 0;
            for (k, &id) in chunk.iter().enumerate() {
                if let Some(ray) = rays.get(id as usize) {
                    let (hits, _) = planes.intersect(simd, &UnitRay::load(simd, ray));
                    rows |= u64::from(hits) << (8 * k);
                }
            }
            masks.push(transposed(rows));
        }
        let mut counts = [0; WIDTH];
        // As many vectors as bytes can count.
        for part in masks.chunks(u8::MAX as usize / LANES) {
            let sums = part.iter().fold(0, |sums, &columns| sums + ones(columns));
            for (count, sum) in counts.iter_mut().zip(sums.to_le_bytes()) {
                *count += usize::from(sum);
            }
        }
        counts
    }

    /// Lets `visit` prepare the rays of the list at `start` that meet a child of the node tested last.
    #[inline(always)]
    fn prepare_met<S: Simd>(&mut self, simd: S, start: usize, visit: &mut impl StreamVisitor) {
        let Self { rays, arena, masks, met, .. } = self;
        met.clear();
        for (index, columns) in masks.iter().enumerate() {
            let ids = arena.vector(start + LANES * index);
            let any = columns.to_le_bytes().into_iter().fold(0, |any, column| any | column);
            let mut packed = [0; LANES];
            simd.compress_ids(any.into(), &ids, &mut packed);
            met.extend_from_slice(packed.get(..any.count_ones() as usize).unwrap_or_default());
        }
        visit.prepare(simd, met, rays);
    }

    /// Makes the lists of the children of a node behind the list of its rays.
    #[inline(always)]
    fn divide<S: Simd>(
        &mut self,
        simd: S,
        node: &WideNode,
        counts: [usize; WIDTH],
        start: usize,
        end: usize,
    ) {
        let Self { rays, arena, pending, masks, .. } = self;
        let first = arena.ids.get(start).and_then(|&id| rays.get(id as usize));
        let Some(ray) = first else { return };
        // The order in which the first ray meets the boxes serves all.
        let entries = node.intersect(simd, &UnitRay::load(simd, ray)).1;
        let entries = simd.store(entries).0;
        let (order, met) = nearest_first(&counts, &entries);
        let mut places = [0; WIDTH];
        // The list may be continued by a vector of its own.
        let mut top = end + LANES;
        for &slot in order.iter().take(met).rev() {
            places[slot] = top;
            pending.push(PendingChild { child: node.children[slot], start: top, end: top + counts[slot] });
            top += counts[slot] + LANES;
        }
        arena.reserve(top);
        for (index, columns) in masks.iter().enumerate() {
            let ids = arena.vector(start + LANES * index);
            for &slot in order.iter().take(met) {
                let mask = (columns >> (8 * slot)) as u32 & 0xff;
                if let Some(list) = arena.vector_mut(places[slot]) {
                    simd.compress_ids(mask, &ids, list);
                }
                places[slot] += mask.count_ones() as usize;
            }
        }
    }
}

/// The children that rays meet, nearest first, and their number. Sorted by counting smaller keys, since the branches of a comparison
/// sort are mispredicted.
#[inline(always)]
fn nearest_first(counts: &[usize; WIDTH], entries: &[f32; WIDTH]) -> ([usize; WIDTH], usize) {
    // Entries are not negative, so that their bits are in their order. The last bits become the slot, so that all keys differ.
    let slots = WIDTH as u32 - 1;
    let (mut keys, mut met) = ([0; WIDTH], 0);
    for (slot, key) in (0..).zip(&mut keys) {
        let at = slot as usize;
        let is_met = counts[at] > 0;
        *key = (if is_met { entries[at].to_bits() } else { u32::MAX }) & !slots | slot;
        met += usize::from(is_met);
    }
    let mut ranks = [0; WIDTH];
    for key in keys {
        for (rank, other) in ranks.iter_mut().zip(keys) {
            *rank += u32::from(key < other);
        }
    }
    let mut order = [0; WIDTH];
    for (slot, rank) in ranks.into_iter().enumerate() {
        order[rank as usize & (WIDTH - 1)] = slot;
    }
    (order, met)
}

/// A matrix of 8 x 8 bits, a row per byte, transposed: blocks of 1, 2 and 4 bits change places with those across the diagonal.
#[inline(always)]
fn transposed(rows: u64) -> u64 {
    let mut x = rows;
    for (shift, mask) in
        [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)]
    {
        let swapped = (x ^ (x >> shift)) & mask;
        x ^= swapped ^ (swapped << shift);
    }
    x
}

/// The number of ones of each byte.
#[inline(always)]
fn ones(x: u64) -> u64 {
    let pairs = x - (x >> 1 & 0x5555_5555_5555_5555);
    let fours = (pairs & 0x3333_3333_3333_3333) + (pairs >> 2 & 0x3333_3333_3333_3333);
    (fours + (fours >> 4)) & 0x0f0f_0f0f_0f0f_0f0f
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_that_are_met_come_nearest_first() {
        let counts = [3, 0, 1, 1, 0, 2, 0, 9];
        let entries = [0.5, 0.0, 0.25, 0.0, f32::INFINITY, 7.0, 1.0, 0.25];
        let (order, met) = nearest_first(&counts, &entries);
        assert_eq!(&order[..met], [3, 2, 7, 0, 5]);
    }

    #[test]
    fn bits_are_transposed_and_counted() {
        let rows = 0x0123_4567_89ab_cdef_u64.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let columns = transposed(rows);
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert_eq!(rows >> (8 * i + j) & 1, columns >> (8 * j + i) & 1);
        }
        let counts = rows.to_le_bytes().map(|byte| byte.count_ones() as u8);
        assert_eq!(ones(rows), u64::from_le_bytes(counts));
    }
}
