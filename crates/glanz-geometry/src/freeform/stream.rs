//! Batches of rays through a freeform surface.
//!
//! [`Bvh::stream`](crate::bvh::Bvh) brings lists of rays to the leaves. A leaf is projected along eight of them at once; pairs of a
//! ray and a leaf that it may meet in one point at most wait in groups until eight can be solved side by side. All other
//! pairs go through the search for a single one. Each pair gives the same bits as in a query of one ray, and of all its roots a ray
//! keeps the first by [`order`], so that answers depend neither on the other rays nor on the sequence of leaves. A leaf that is
//! skipped because its box lies behind the closest hit has no root before it: every root is a point of the leaf within a few times
//! the noise from the ray, about 1e-13 of the size of the coordinates, and boxes are padded by 6e-8 of the extent of the surface. Beyond 1024
//! extents from the origin of the coordinates a surface has its own, and boxes are rounded outward by the rounding of the common ones.

use std::cell::Cell;

use glanz_math::DVec2;

use super::Freeform;
use super::group_solver::GroupSolver;
use super::leaf::PatchLeaf;
use super::leaf_lanes::{LeafLanes, ProjectionLanes};
use super::net_lanes::NetBuffer;
use super::pair_queue::{FIELDS, MIXED_GROUP, PairQueue};
use super::query::{hit, order};
use super::ray_lanes::{CompactLine, RaySpaceLanes};
use super::root::SearchScratch;
use super::subpatches::{LeafSearch, SubpatchList};
use crate::batch::BoundedRay;
use crate::bvh::simd::lanes::{LANES, first_lanes};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::stream::{StreamScratch, StreamVisitor};
use crate::bvh::{BvhLeaf, CompactRay};
use crate::hit::{Hit, HitBorder};

/// Number of rays that are traced together: as many as caches hold.
const RAYS_PER_STREAM: usize = 4096;

thread_local! {
    /// The memory of the last batch: giving it back to the system and getting it again would take as long as the rays.
    static MEMORY: Cell<Option<Box<BatchMemory>>> = const { Cell::new(None) };
}

/// Memory that batches reuse.
struct BatchMemory {
    stream: StreamScratch,
    lines: Vec<CompactLine>,
    queue: PairQueue,
    net: NetBuffer,
    search: SearchScratch,
    /// Hits of which only the presence counts.
    hits: Vec<Option<Hit>>,
}

impl Freeform {
    /// The closest hit of each ray.
    pub(super) fn closest_hits(&self, rays: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
        let mut memory = BatchMemory::take();
        self.batch(rays, false, hits, &mut memory);
        memory.put_back();
    }

    /// Whether each ray has a hit.
    pub(super) fn any_hits(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        let mut memory = BatchMemory::take();
        let mut hits = std::mem::take(&mut memory.hits);
        occluded.clear();
        occluded.reserve(rays.len());
        // Stream by stream, so that the memory that is kept does not grow with the batch.
        for part in rays.chunks(RAYS_PER_STREAM) {
            self.batch(part, true, &mut hits, &mut memory);
            occluded.extend(hits.iter().map(Option::is_some));
        }
        memory.hits = hits;
        memory.put_back();
    }

    /// The closest hit, or any hit, of each ray.
    fn batch(&self, rays: &[BoundedRay], any: bool, hits: &mut Vec<Option<Hit>>, memory: &mut BatchMemory) {
        hits.clear();
        hits.resize(rays.len(), None);
        self.bvh.isa().run(BatchQuery { surface: self, rays, any, hits, memory });
        self.counters.add(&mut memory.search);
    }
}

impl BatchMemory {
    /// The memory of this thread.
    fn take() -> Box<Self> {
        MEMORY.try_with(Cell::take).ok().flatten().unwrap_or_else(|| {
            let (stream, search) = (StreamScratch::default(), SearchScratch::default());
            let (queue, net) = (PairQueue::new(), NetBuffer::default());
            Box::new(Self { stream, lines: Vec::new(), queue, net, search, hits: Vec::new() })
        })
    }

    /// Keeps the memory for the next batch of this thread.
    fn put_back(self: Box<Self>) {
        // A thread that ends keeps nothing.
        let _ = MEMORY.try_with(|memory| memory.set(Some(self)));
    }
}

/// The closest hit, or any hit, of each ray of a batch.
struct BatchQuery<'a> {
    surface: &'a Freeform,
    rays: &'a [BoundedRay],
    /// Whether any hit ends the search.
    any: bool,
    /// One entry per ray, `None` at first.
    hits: &'a mut [Option<Hit>],
    memory: &'a mut BatchMemory,
}

impl Task for BatchQuery<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { surface, rays, any, hits, memory } = self;
        let BatchMemory { stream, lines, queue, net, search, .. } = memory;
        let by_subpatch = matches!(*surface.subpatches, SubpatchList::General(_));
        for (rays, hits) in rays.chunks(RAYS_PER_STREAM).zip(hits.chunks_mut(RAYS_PER_STREAM)) {
            lines.clear();
            let (lines, queue, net, search) = (&mut *lines, &mut *queue, &mut *net, &mut *search);
            let mut searcher =
                StreamSearcher { surface, bounded: rays, hits, any, by_subpatch, lines, queue, net, search };
            surface.bvh.stream(simd, rays, stream, &mut searcher);
        }
    }
}

/// The search in the leaves for the rays of a stream.
pub(super) struct StreamSearcher<'a> {
    pub(super) surface: &'a Freeform,
    bounded: &'a [BoundedRay],
    hits: &'a mut [Option<Hit>],
    any: bool,
    /// Whether pairs wait by subpatch.
    by_subpatch: bool,
    /// Rays that have met a box, by their slots.
    lines: &'a mut Vec<CompactLine>,
    pub(super) queue: &'a mut PairQueue,
    pub(super) net: &'a mut NetBuffer,
    search: &'a mut SearchScratch,
}

impl StreamVisitor for StreamSearcher<'_> {
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, simd: S, ids: &[u32], rays: &mut [CompactRay]) {
        for chunk in ids.chunks(LANES) {
            let mut eight = [&BoundedRay::NONE; LANES];
            for ((&id, eight), slot) in chunk.iter().zip(&mut eight).zip(self.lines.len() as u32..) {
                if let (Some(ray), Some(bounded)) = (rays.get_mut(id as usize), self.bounded.get(id as usize))
                {
                    ray.slot = slot;
                    *eight = bounded;
                }
            }
            let lines = CompactLine::eight(simd, &self.surface.frame, &eight);
            self.lines.extend_from_slice(lines.get(..chunk.len()).unwrap_or_default());
        }
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        let Some(found) = self.surface.leaves.get(leaf.ordinal()) else { return };
        let (lanes, leaves) = (LeafLanes::splat(simd, found), [leaf; LANES]);
        for chunk in ids.chunks(LANES) {
            let mut eight = [chunk[0]; LANES];
            eight[..chunk.len()].copy_from_slice(chunk);
            self.examine(simd, first_lanes(chunk.len()), &lanes, &leaves, &eight, rays);
        }
    }

    #[inline(always)]
    fn pairs<S: Simd>(
        &mut self,
        simd: S,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        count: usize,
        rays: &mut [CompactRay],
    ) {
        let surface = self.surface;
        let Some(first) = surface.leaves.get(leaves[0].ordinal()) else { return };
        let (mut found, mut eight) = ([first; LANES], [ids[0]; LANES]);
        for (k, (leaf, id)) in leaves.iter().zip(ids).enumerate().take(count) {
            if let Some(leaf) = surface.leaves.get(leaf.ordinal()) {
                (found[k], eight[k]) = (leaf, *id);
            }
        }
        let lanes = LeafLanes::new(simd, &found);
        self.examine(simd, first_lanes(count), &lanes, leaves, &eight, rays);
    }

    #[inline(always)]
    fn finish<S: Simd>(&mut self, simd: S, rays: &mut [CompactRay]) {
        if self.by_subpatch {
            for index in PairQueue::subpatch_groups() {
                self.release(simd, index, rays);
            }
        }
        if self.queue.group(MIXED_GROUP).count > 0 {
            self.solve(simd, MIXED_GROUP, rays);
        }
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        if let Some(leaf) = self.surface.leaves.get(leaf.ordinal()) {
            simd.prefetch(leaf);
        }
    }
}

impl StreamSearcher<'_> {
    /// The line of a ray.
    #[inline(always)]
    fn line(&self, id: u32, rays: &[CompactRay]) -> &CompactLine {
        let slot = rays.get(id as usize).map_or(usize::MAX, |ray| ray.slot as usize);
        self.lines.get(slot).unwrap_or(&CompactLine::ZERO)
    }

    /// The spaces of eight rays.
    #[inline(always)]
    pub(super) fn spaces<S: Simd>(
        &self,
        simd: S,
        ids: &[u32; LANES],
        rays: &[CompactRay],
    ) -> RaySpaceLanes<S> {
        let mut lines = [&CompactLine::ZERO; LANES];
        for (line, &id) in lines.iter_mut().zip(ids) {
            *line = self.line(id, rays);
        }
        RaySpaceLanes::new(simd, &self.surface.frame, lines)
    }

    /// The rays that may still have hits: those of which any hit counts end with the first.
    #[inline(always)]
    fn open(&self, ids: &[u32; LANES], rays: &[CompactRay]) -> u32 {
        if !self.any {
            return first_lanes(LANES);
        }
        let is_open = |id: &u32| rays.get(*id as usize).is_some_and(CompactRay::is_open);
        ids.iter().enumerate().fold(0, |mask, (k, id)| mask | u32::from(is_open(id)) << k)
    }

    /// Projects eight leaves along their rays; queues or searches the pairs in the mask that may meet.
    #[inline(always)]
    fn examine<S: Simd>(
        &mut self,
        simd: S,
        mask: u32,
        lanes: &LeafLanes<S>,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        rays: &mut [CompactRay],
    ) {
        let projection = lanes.project(simd, &self.spaces(simd, ids, rays));
        let met = mask & projection.met & self.open(ids, rays);
        let mut hard = met & !projection.certified;
        while hard != 0 {
            let k = hard.trailing_zeros() as usize & (LANES - 1);
            hard &= hard - 1;
            if let Some(leaf) = self.surface.leaves.get(leaves[k].ordinal()) {
                self.search_one(simd, leaf, ids[k], rays);
            }
        }
        let easy = met & projection.certified;
        if easy != 0 {
            let ProjectionLanes { a, b, q, inverse_determinant: per, start, .. } = projection;
            let fields = [a[0], a[1], b[0], b[1], q, per, start[0], start[1]];
            self.enqueue(simd, easy, leaves, ids, fields, rays);
        }
    }

    /// Queues the pairs in the mask; solves groups that are full.
    #[inline(always)]
    fn enqueue<S: Simd>(
        &mut self,
        simd: S,
        mask: u32,
        leaves: &[BvhLeaf; LANES],
        ids: &[u32; LANES],
        fields: [S::Wide; FIELDS],
        rays: &mut [CompactRay],
    ) {
        let [a, b, c, d, e, f, g, h] = fields;
        let (a, b, c, d) = (simd.store8(a), simd.store8(b), simd.store8(c), simd.store8(d));
        let (e, f, g, h) = (simd.store8(e), simd.store8(f), simd.store8(g), simd.store8(h));
        let mut records = [[0.0; FIELDS]; LANES];
        for (record, row) in records.iter_mut().zip(simd.columns8(&[&a, &b, &c, &d, &e, &f, &g, &h])) {
            *record = simd.store8(row);
        }
        let mut rest = mask;
        while rest != 0 {
            let k = rest.trailing_zeros() as usize & (LANES - 1);
            rest &= rest - 1;
            let ordinal = leaves[k].ordinal();
            let mut index = MIXED_GROUP;
            if self.by_subpatch
                && let Some(leaf) = self.surface.leaves.get(ordinal)
            {
                let taken;
                (index, taken) = self.queue.index_of(leaf.subpatch);
                if taken {
                    self.release(simd, index, rays);
                }
            }
            let group = self.queue.group_mut(index);
            group.push(ids[k], ordinal as u32, &records[k]);
            if group.is_full() {
                self.solve(simd, index, rays);
            }
        }
    }

    /// Passes the pairs of a group to that of any subpatches.
    #[inline(always)]
    fn release<S: Simd>(&mut self, simd: S, index: usize, rays: &mut [CompactRay]) {
        for k in 0..self.queue.group(index).count {
            let (ray, leaf, record) = self.queue.group(index).pair(k);
            let group = self.queue.group_mut(MIXED_GROUP);
            group.push(ray, leaf, &record);
            if group.is_full() {
                self.solve(simd, MIXED_GROUP, rays);
            }
        }
        self.queue.group_mut(index).count = 0;
    }

    /// Solves the pairs of a group, and empties it.
    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S, index: usize, rays: &mut [CompactRay]) {
        simd.outlined(GroupSolver { searcher: &mut *self, rays, index });
        self.queue.group_mut(index).count = 0;
    }

    /// Searches a leaf for the roots of one ray.
    #[inline(always)]
    pub(super) fn search_one<S: Simd>(
        &mut self,
        simd: S,
        leaf: &PatchLeaf,
        id: u32,
        rays: &mut [CompactRay],
    ) {
        let surface = self.surface;
        let space = self.line(id, rays).space(&surface.frame);
        let Some(projection) = leaf.project(simd, &space) else { return };
        let search = LeafSearch {
            subpatches: &surface.subpatches,
            reduced_nets: &surface.reduced_nets,
            leaf,
            projection: &projection,
            space: &space,
            scratch: &mut *self.search,
        };
        if let Some(root) = simd.outlined(search) {
            self.add(leaf, id, space.line.t(root.s), root.at, rays);
        } else {
            while let Some(root) = self.search.roots.pop() {
                self.add(leaf, id, space.line.t(root.s), root.at, rays);
            }
        }
    }

    /// Adds a root of a ray with a leaf: its ray parameter and its place in the subpatch.
    #[inline(always)]
    pub(super) fn add(&mut self, leaf: &PatchLeaf, id: u32, t: f64, at: DVec2, rays: &mut [CompactRay]) {
        let (index, surface) = (id as usize, self.surface);
        let (Some(best), Some(bounded), Some(ray)) =
            (self.hits.get_mut(index), self.bounded.get(index), rays.get_mut(index))
        else {
            return;
        };
        let location = &surface.location(leaf.subpatch);
        let end = best.map_or(bounded.t_max, |best| best.t);
        if !(t > 0.0 && t <= end) {
            return;
        }
        let border = if leaf.crossed { surface.border(location, at) } else { Some(HitBorder::Away) };
        let Some(border) = border else { return };
        let found = hit(t, location, at, border);
        if t < end || best.is_some_and(|best| order(&found, &best).is_lt()) {
            *best = Some(found);
            ray.shorten(if self.any { f64::NEG_INFINITY } else { t });
        }
    }
}
