//! Ray queries of a mesh.

use glanz_math::Ray;

use super::Mesh;
use super::block::{BlockRay, Coordinate, TriangleBlock, TriangleBlocks};
use crate::bvh::BvhLeaf;
use crate::bvh::query::{HitCollector, LeafIntersector};
use crate::bvh::simd::{Simd, Task};
use crate::triangle::ShearedRay;

/// Largest number of blocks that are tested one after the other: a tree would cost more than it saves.
pub(super) const BLOCKS_WITHOUT_TREE: usize = 2;

/// The search for hits of a ray.
pub(super) struct MeshQuery<'a, C> {
    pub(super) mesh: &'a Mesh,
    pub(super) ray: &'a Ray,
    pub(super) collector: C,
}

impl<C: HitCollector> Task for MeshQuery<'_, C> {
    type Output = C;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> C {
        match &self.mesh.blocks {
            TriangleBlocks::Single(blocks) => self.search(simd, blocks),
            TriangleBlocks::Double(blocks) => self.search(simd, blocks),
        }
    }
}

impl<C: HitCollector> MeshQuery<'_, C> {
    #[inline(always)]
    fn search<S: Simd, T: Coordinate>(self, simd: S, blocks: &[TriangleBlock<T>]) -> C {
        let Self { mesh, ray, mut collector } = self;
        let block_ray = BlockRay::new(simd, &ShearedRay::without_branches(ray));
        if blocks.len() <= BLOCKS_WITHOUT_TREE {
            for block in blocks {
                block.hits(simd, &block_ray, &mut collector);
            }
            return collector;
        }
        mesh.bvh.collect(simd, ray, BlockIntersector { blocks, ray: block_ray }, collector)
    }
}

struct BlockIntersector<'a, S: Simd, T> {
    blocks: &'a [TriangleBlock<T>],
    ray: BlockRay<S>,
}

impl<R: Simd, T: Coordinate> LeafIntersector for BlockIntersector<'_, R, T> {
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            block.prefetch(simd);
        }
    }

    #[inline(always)]
    fn hits<S: Simd>(&mut self, _: S, leaf: BvhLeaf, collector: &mut impl HitCollector) {
        if let Some(block) = self.blocks.get(leaf.ordinal()) {
            block.hits(self.ray.simd, &self.ray, collector);
        }
    }
}
