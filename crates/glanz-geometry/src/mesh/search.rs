//! What rays ask a mesh.

use glanz_math::Ray;

use super::Mesh;
use super::block::{Block, BlockRay, Blocks, Coordinate, Found, Report, hits_in_block};
use crate::bvh::simd::{Simd, Task};
use crate::bvh::{Leaf, Visit};
use crate::hit::Hit;

/// Up to this many blocks are tested one after the other: a tree would cost more than it saves.
const BLOCKS_WITHOUT_TREE: usize = 2;

/// The closest hit.
pub(super) struct Closest<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for Closest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Hit> {
        match &self.mesh.blocks {
            Blocks::Single(blocks) => self.search(simd, blocks),
            Blocks::Double(blocks) => self.search(simd, blocks),
        }
    }
}

impl Closest<'_> {
    #[inline(always)]
    fn search<S: Simd, T: Coordinate>(self, simd: S, blocks: &[Block<T>]) -> Option<Hit> {
        let Self { mesh, ray, t_max } = self;
        // Face 0 at the end of the ray: no hit there comes before it, so that only closer ones count.
        let best = Best { found: Found { t: t_max, u: 0.0, v: 0.0, face: 0 }, any: false };
        let mut visit = ClosestVisit { blocks, ray: BlockRay::new(simd, ray), best };
        if blocks.len() <= BLOCKS_WITHOUT_TREE {
            for block in blocks {
                hits_in_block(simd, block, &visit.ray, visit.best.found.t, &mut visit.best);
            }
        } else {
            mesh.bvh.closest_with(simd, ray, t_max, &mut visit);
        }
        let Best { found: Found { t, u, v, face }, any } = visit.best;
        any.then_some(Hit { t, u, v, face })
    }
}

/// The closest hit so far.
struct Best {
    found: Found,
    any: bool,
}

impl Report for Best {
    #[inline(always)]
    fn hit(&mut self, found: Found) -> bool {
        // Of hits at the same place that of the lowest face wins, in whatever order they are met.
        if (found.t, found.face) < (self.found.t, self.found.face) {
            *self = Self { found, any: true };
        }
        false
    }
}

struct ClosestVisit<'a, S: Simd, T> {
    blocks: &'a [Block<T>],
    ray: BlockRay<S>,
    best: Best,
}

impl<R: Simd, T: Coordinate> Visit for &mut ClosestVisit<'_, R, T> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            hits_in_block(self.ray.simd, block, &self.ray, t_max, &mut self.best);
        }
        self.best.found.t
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: Leaf) {
        prefetch(simd, self.blocks, leaf);
    }
}

/// Asks the memory for the block of `leaf`.
#[inline(always)]
fn prefetch<S: Simd, T: Coordinate>(simd: S, blocks: &[Block<T>], leaf: Leaf) {
    if let Some(block) = blocks.get(leaf.ordinal()) {
        block.prefetch(simd);
    }
}

/// Whether there is a hit.
pub(super) struct Occluded<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
}

impl Task for Occluded<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        match &self.mesh.blocks {
            Blocks::Single(blocks) => self.search(simd, blocks),
            Blocks::Double(blocks) => self.search(simd, blocks),
        }
    }
}

impl Occluded<'_> {
    #[inline(always)]
    fn search<S: Simd, T: Coordinate>(self, simd: S, blocks: &[Block<T>]) -> bool {
        let Self { mesh, ray, t_max } = self;
        let mut visit =
            AnyVisit { blocks, ray: BlockRay::new(simd, ray), before: Before { t_max, met: false } };
        if blocks.len() <= BLOCKS_WITHOUT_TREE {
            for block in blocks {
                hits_in_block(simd, block, &visit.ray, t_max, &mut visit.before);
            }
        } else {
            mesh.bvh.any_with(simd, ray, t_max, &mut visit);
        }
        visit.before.met
    }
}

struct AnyVisit<'a, S: Simd, T> {
    blocks: &'a [Block<T>],
    ray: BlockRay<S>,
    before: Before,
}

impl<R: Simd, T: Coordinate> Visit for &mut AnyVisit<'_, R, T> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            hits_in_block(self.ray.simd, block, &self.ray, t_max, &mut self.before);
        }
        if self.before.met { f64::NEG_INFINITY } else { t_max }
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: Leaf) {
        prefetch(simd, self.blocks, leaf);
    }
}

/// Whether there was a hit before the end.
struct Before {
    t_max: f64,
    met: bool,
}

impl Report for Before {
    #[inline(always)]
    fn hit(&mut self, found: Found) -> bool {
        self.met |= found.t < self.t_max;
        self.met
    }
}

/// All hits, in no order.
pub(super) struct Every<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    pub(super) hits: &'a mut Vec<Hit>,
}

impl Task for Every<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match &self.mesh.blocks {
            Blocks::Single(blocks) => self.search(simd, blocks),
            Blocks::Double(blocks) => self.search(simd, blocks),
        }
    }
}

impl Every<'_> {
    #[inline(always)]
    fn search<S: Simd, T: Coordinate>(self, simd: S, blocks: &[Block<T>]) {
        let Self { mesh, ray, t_max, hits } = self;
        let mut visit = EveryVisit { blocks, ray: BlockRay::new(simd, ray), all: All { t_max, hits } };
        mesh.bvh.closest_with(simd, ray, t_max, &mut visit);
    }
}

struct All<'a> {
    t_max: f64,
    hits: &'a mut Vec<Hit>,
}

impl Report for All<'_> {
    #[inline(always)]
    fn hit(&mut self, Found { t, u, v, face }: Found) -> bool {
        if t < self.t_max {
            self.hits.push(Hit { t, u, v, face });
        }
        false
    }
}

struct EveryVisit<'a, S: Simd, T> {
    blocks: &'a [Block<T>],
    ray: BlockRay<S>,
    all: All<'a>,
}

impl<R: Simd, T: Coordinate> Visit for &mut EveryVisit<'_, R, T> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: Leaf, t_max: f64) -> f64 {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            hits_in_block(self.ray.simd, block, &self.ray, t_max, &mut self.all);
        }
        t_max
    }
}
