//! Batches of rays through a freeform surface.
//!
//! [`Bvh::stream`](crate::bvh::Bvh) brings lists of rays to the leaves. A leaf is projected along eight of them at once; pairs of a
//! ray and a leaf that it may meet in one point at most wait in a queue until eight can be solved side by side. All other
//! pairs go through the search for a single one. Each pair gives the same bits as in a query of one ray, and of all its roots a ray
//! keeps the first by [`order`], so that answers depend neither on the other rays nor on the sequence of leaves. A leaf that is
//! skipped because its box lies behind the closest hit has no root before it: every root is a point of the leaf within a few times
//! the noise from the ray, far less than boxes are padded by.

use std::sync::atomic;

use glanz_math::DVec2;

use super::Freeform;
use super::bicubic::Bicubic;
use super::bicubic_lanes::{self, PairLanes, RootLanes};
use super::leaf::PatchLeaf;
use super::query::{hit, order};
use super::ray_lanes::{CompactLine, RaySpaceLanes};
use super::root::SearchScratch;
use super::subpatches::{LeafSearch, SubpatchList};
use crate::batch::BoundedRay;
use crate::bvh::simd::lanes::{LANES, first_lanes};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::stream::{StreamScratch, StreamVisitor};
use crate::bvh::{BvhLeaf, CompactRay};
use crate::hit::Hit;

/// Number of rays that are traced together: as many as caches hold.
const PART: usize = 4096;

/// The closest hit, or any hit, of each ray of a batch.
pub(super) struct BatchQuery<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) rays: &'a [BoundedRay],
    /// Whether any hit ends the search.
    pub(super) any: bool,
    /// One entry per ray, `None` at first.
    pub(super) hits: &'a mut [Option<Hit>],
}

impl Task for BatchQuery<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { surface, rays, any, hits } = self;
        let mut scratch = StreamScratch::default();
        let mut searcher = StreamSearcher {
            surface,
            bounded: &[],
            hits: &mut [],
            any,
            lines: Vec::new(),
            queue: PairQueue::new(),
            scratch: SearchScratch::default(),
        };
        for (rays, hits) in rays.chunks(PART).zip(hits.chunks_mut(PART)) {
            searcher = StreamSearcher { bounded: rays, hits, ..searcher };
            searcher.lines.clear();
            surface.bvh.stream(simd, rays, &mut scratch, &mut searcher);
        }
        let undecided = searcher.scratch.undecided;
        if undecided > 0 {
            surface.undecided.fetch_add(undecided, atomic::Ordering::Relaxed);
        }
    }
}

/// Room of a queue: a vector that is not full, and another one.
const ROOM: usize = 2 * LANES;

/// Numbers per pair: the projection of the leaf.
const FIELDS: usize = 8;

/// Pairs of a ray and a certified leaf, by field.
struct PairQueue {
    count: usize,
    rays: [u32; ROOM],
    leaves: [u32; ROOM],
    fields: [[f64; ROOM]; FIELDS],
}

impl PairQueue {
    fn new() -> Self {
        Self { count: 0, rays: [0; ROOM], leaves: [0; ROOM], fields: [[0.0; ROOM]; FIELDS] }
    }

    /// Appends the pairs in the mask of one leaf with eight rays. There must be room for a vector.
    #[inline(always)]
    fn push<S: Simd>(
        &mut self,
        simd: S,
        mask: u32,
        ids: &[u32; LANES],
        leaf: u32,
        fields: [S::Wide; FIELDS],
    ) {
        let at = self.count;
        if let Some(slots) = self.rays.get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
            simd.compress_ids(mask, ids, slots);
        }
        if let Some(slots) = self.leaves.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<LANES>()) {
            *slots = [leaf; LANES];
        }
        for (list, field) in self.fields.iter_mut().zip(fields) {
            if let Some(slots) = list.get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
                simd.compress8(mask, field, slots);
            }
        }
        self.count = (at + mask.count_ones() as usize).min(LANES - 1 + LANES);
    }

    /// The first vector, with the spaces of its rays.
    #[inline(always)]
    fn pairs<S: Simd>(&self, simd: S, mask: u32, rays: RaySpaceLanes<S>) -> PairLanes<S> {
        let mut fields = [simd.splat8(0.0); FIELDS];
        for (field, list) in fields.iter_mut().zip(&self.fields) {
            if let Some(lanes) = list.first_chunk() {
                *field = simd.load8(lanes);
            }
        }
        let [ax, ay, bx, by, q, inverse_determinant, s, t] = fields;
        PairLanes { mask, rays, a: [ax, ay], b: [bx, by], q, inverse_determinant, start: [s, t] }
    }

    /// Removes the first vector.
    #[inline(always)]
    fn pop(&mut self) {
        self.rays.copy_within(LANES.., 0);
        self.leaves.copy_within(LANES.., 0);
        for list in &mut self.fields {
            list.copy_within(LANES.., 0);
        }
        self.count = self.count.saturating_sub(LANES);
    }
}

/// The search in the leaves for the rays of a stream.
struct StreamSearcher<'a> {
    surface: &'a Freeform,
    bounded: &'a [BoundedRay],
    hits: &'a mut [Option<Hit>],
    any: bool,
    /// Rays that have met a box, by their slots.
    lines: Vec<CompactLine>,
    queue: PairQueue,
    scratch: SearchScratch,
}

impl StreamVisitor for StreamSearcher<'_> {
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, _: S, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            if let (Some(ray), Some(bounded)) = (rays.get_mut(id as usize), self.bounded.get(id as usize)) {
                ray.slot = self.lines.len() as u32;
                self.lines.push(CompactLine::new(&self.surface.frame, &bounded.ray));
            }
        }
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        let ordinal = leaf.ordinal() as u32;
        let Some(leaf) = self.surface.leaves.get(leaf.ordinal()) else { return };
        for chunk in ids.chunks(LANES) {
            let mut eight = [chunk[0]; LANES];
            eight[..chunk.len()].copy_from_slice(chunk);
            let projection = leaf.project_lanes(simd, &self.spaces(simd, &eight, rays));
            let met = projection.met & first_lanes(chunk.len());
            let (a, b, start) = (projection.a, projection.b, projection.start);
            let mut hard = met & !projection.certified;
            while hard != 0 {
                let k = hard.trailing_zeros() as usize;
                hard &= hard - 1;
                self.search(simd, leaf, eight[k & (LANES - 1)], rays);
            }
            let easy = met & projection.certified;
            if easy != 0 {
                let (q, per) = (projection.q, projection.inverse_determinant);
                let fields = [a[0], a[1], b[0], b[1], q, per, start[0], start[1]];
                self.queue.push(simd, easy, &eight, ordinal, fields);
                if self.queue.count >= LANES {
                    simd.outlined(Solve { searcher: &mut *self, rays: &mut *rays, mask: first_lanes(LANES) });
                    self.queue.pop();
                }
            }
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&mut self, simd: S, rays: &mut [CompactRay]) {
        let count = self.queue.count;
        if count > 0 {
            simd.outlined(Solve { searcher: &mut *self, rays, mask: first_lanes(count) });
            self.queue.count = 0;
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
    fn spaces<S: Simd>(&self, simd: S, ids: &[u32; LANES], rays: &[CompactRay]) -> RaySpaceLanes<S> {
        let mut lines = [&CompactLine::ZERO; LANES];
        for (line, &id) in lines.iter_mut().zip(ids) {
            *line = self.line(id, rays);
        }
        RaySpaceLanes::new(simd, &self.surface.frame, lines)
    }

    /// Searches a leaf for the roots of one ray.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, leaf: &PatchLeaf, id: u32, rays: &mut [CompactRay]) {
        let surface = self.surface;
        let space = self.line(id, rays).space(&surface.frame);
        let Some(projection) = leaf.project(simd, &space) else { return };
        let search = LeafSearch {
            subpatches: &surface.subpatches,
            leaf,
            projection: &projection,
            space: &space,
            scratch: &mut self.scratch,
        };
        if let Some(root) = simd.outlined(search) {
            self.add(leaf, id, space.line.t(root.s), root.at, rays);
        } else {
            while let Some(root) = self.scratch.roots.pop() {
                self.add(leaf, id, space.line.t(root.s), root.at, rays);
            }
        }
    }

    /// Adds a root of a ray with a leaf: its ray parameter and its place in the subpatch.
    #[inline(always)]
    fn add(&mut self, leaf: &PatchLeaf, id: u32, t: f64, at: DVec2, rays: &mut [CompactRay]) {
        let (index, surface) = (id as usize, self.surface);
        let (Some(best), Some(bounded), Some(ray)) =
            (self.hits.get_mut(index), self.bounded.get(index), rays.get_mut(index))
        else {
            return;
        };
        let Some(location) = surface.locations.get(leaf.subpatch as usize) else { return };
        let end = best.map_or(bounded.t_max, |best| best.t);
        if !(t > 0.0 && t <= end) || (leaf.crossed && !surface.keeps(location, at)) {
            return;
        }
        let found = hit(t, location, at);
        if t < end || best.is_some_and(|best| order(&found, &best).is_lt()) {
            *best = Some(found);
            ray.shorten(if self.any { f64::NEG_INFINITY } else { t });
        }
    }
}

/// The roots of the pairs at the front of the queue.
struct Solve<'a, 'b> {
    searcher: &'a mut StreamSearcher<'b>,
    rays: &'a mut [CompactRay],
    mask: u32,
}

impl Task for Solve<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { searcher, rays, mask } = self;
        let surface = searcher.surface;
        let queue = &searcher.queue;
        let (Some(ids), Some(ordinals)) =
            (queue.rays.first_chunk::<LANES>().copied(), queue.leaves.first_chunk::<LANES>().copied())
        else {
            return;
        };
        let Some(first) = surface.leaves.get(ordinals[0] as usize) else { return };
        // Lanes that are not in use repeat the first one.
        let mut leaves = [first; LANES];
        let mut pairs = ids;
        for (k, (leaf, ordinal)) in leaves.iter_mut().zip(ordinals).enumerate() {
            if mask >> k & 1 == 0 {
                pairs[k] = ids[0];
            } else if let Some(found) = surface.leaves.get(ordinal as usize) {
                *leaf = found;
            }
        }
        let pairs = queue.pairs(simd, mask, searcher.spaces(simd, &pairs, rays));
        let roots = match &surface.subpatches {
            SubpatchList::Polynomial(list) => solve_bicubic(simd, list, &leaves, &pairs),
            SubpatchList::Rational(list) => solve_bicubic(simd, list, &leaves, &pairs),
            SubpatchList::General(_) => None,
        };
        let mut hard = mask;
        if let Some(RootLanes { converged, excluded, s, at }) = roots {
            let t = simd.store8(pairs.rays.t(simd, s));
            let (u, v) = (simd.store8(at[0]), simd.store8(at[1]));
            hard &= !(converged | excluded);
            let mut found = converged;
            while found != 0 {
                let k = found.trailing_zeros() as usize & (LANES - 1);
                found &= found - 1;
                searcher.add(leaves[k], ids[k], t[k], DVec2::new(u[k], v[k]), rays);
            }
        }
        while hard != 0 {
            let k = hard.trailing_zeros() as usize & (LANES - 1);
            hard &= hard - 1;
            searcher.search(simd, leaves[k], ids[k], rays);
        }
    }
}

/// The roots of eight pairs with bicubic patches.
#[inline(always)]
fn solve_bicubic<S: Simd, const COORDINATES: usize>(
    simd: S,
    list: &[Bicubic<COORDINATES>],
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> Option<RootLanes<S>> {
    let first = list.get(leaves[0].subpatch as usize)?;
    let mut patches = [first; LANES];
    let mut same = true;
    for (patch, leaf) in patches.iter_mut().zip(leaves) {
        if leaf.subpatch != leaves[0].subpatch {
            *patch = list.get(leaf.subpatch as usize)?;
            same = false;
        }
    }
    Some(if same {
        bicubic_lanes::roots(simd, &first, leaves, pairs)
    } else {
        bicubic_lanes::roots(simd, &patches, leaves, pairs)
    })
}
