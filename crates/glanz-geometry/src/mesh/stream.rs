//! Batches of rays through a mesh.

use super::Mesh;
use super::block::{BlockRay, Coordinate, TriangleBlock, TriangleBlocks};
use super::query::BLOCKS_WITHOUT_TREE;
use crate::batch::BoundedRay;
use crate::bvh::query::HitCollector;
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::{Simd, Task};
use crate::bvh::stream::{StreamScratch, StreamVisitor};
use crate::bvh::{BvhLeaf, CompactRay};
use crate::triangle::ShearedRay;

/// The search for hits of a batch of rays, each with its collector. The hits are those of single rays: all go through
/// [`TriangleBlock::hits`], and collectors do not depend on the order of leaves.
pub(super) struct MeshBatch<'a, C> {
    pub(super) mesh: &'a Mesh,
    pub(super) rays: &'a [BoundedRay],
    pub(super) collectors: &'a mut [C],
}

impl<C: HitCollector> Task for MeshBatch<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match &self.mesh.blocks {
            TriangleBlocks::Single(blocks) => self.search(simd, blocks),
            TriangleBlocks::Double(blocks) => self.search(simd, blocks),
        }
    }
}

impl<C: HitCollector> MeshBatch<'_, C> {
    #[inline(always)]
    fn search<S: Simd, T: Coordinate>(self, simd: S, blocks: &[TriangleBlock<T>]) {
        let Self { mesh, rays, collectors } = self;
        if blocks.len() <= BLOCKS_WITHOUT_TREE {
            for (bounded, collector) in rays.iter().zip(collectors) {
                let ray = BlockRay::new(simd, &ShearedRay::without_branches(&bounded.ray));
                for block in blocks {
                    block.hits(simd, &ray, collector);
                }
            }
            return;
        }
        let (mut scratch, sheared) = (StreamScratch::take(), Vec::with_capacity(rays.len()));
        let mut searcher = BlockSearcher { blocks, rays, collectors, sheared };
        mesh.bvh.stream(simd, rays, &mut scratch, &mut searcher);
        scratch.put_back();
    }
}

/// The search in the leaves for the rays of a stream.
struct BlockSearcher<'a, T, C> {
    blocks: &'a [TriangleBlock<T>],
    rays: &'a [BoundedRay],
    collectors: &'a mut [C],
    /// Rays that have met a box, by their slots.
    sheared: Vec<ShearedRay>,
}

impl<T: Coordinate, C: HitCollector> StreamVisitor for BlockSearcher<'_, T, C> {
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, _: S, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            if let (Some(ray), Some(bounded)) = (rays.get_mut(id as usize), self.rays.get(id as usize)) {
                ray.slot = self.sheared.len() as u32;
                self.sheared.push(ShearedRay::without_branches(&bounded.ray));
            }
        }
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        let Some(block) = self.blocks.get(leaf.ordinal()) else { return };
        for &id in ids {
            if let (Some(ray), Some(collector)) =
                (rays.get_mut(id as usize), self.collectors.get_mut(id as usize))
                && ray.is_open()
                && let Some(sheared) = self.sheared.get(ray.slot as usize)
            {
                block.hits(simd, &BlockRay::new(simd, sheared), collector);
                ray.shorten(collector.end());
            }
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
        for (leaf, id) in leaves.iter().zip(ids).take(count) {
            self.leaf(simd, *leaf, std::slice::from_ref(id), rays);
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&mut self, _: S, _: &mut [CompactRay]) {}

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            block.prefetch(simd);
        }
    }
}
