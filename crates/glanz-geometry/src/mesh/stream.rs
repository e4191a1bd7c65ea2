//! Batches of rays through a mesh.

use super::Mesh;
use super::block::{BlockRay, Coordinate, TriangleBlock, TriangleBlocks};
use super::query::BLOCKS_WITHOUT_TREE;
use super::ray_lanes::{ShearedLanes, ShearedRow, row, sheared};
use crate::batch::BoundedRay;
use crate::bvh::query::HitCollector;
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::{Simd, Task};
use crate::bvh::stream::{StreamScratch, StreamVisitor};
use crate::bvh::{BvhLeaf, CompactRay};
use crate::triangle::ShearedRay;

/// Number of rays from which on they are tested against one triangle after the other instead of one ray after the other against four.
const LEAST_LANES: usize = 3;

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
        let Self { mesh, rays: bounded, collectors } = self;
        if blocks.len() <= BLOCKS_WITHOUT_TREE {
            for (bounded, collector) in bounded.iter().zip(collectors) {
                let ray = BlockRay::new(simd, &ShearedRay::without_branches(&bounded.ray));
                for block in blocks {
                    block.hits(simd, &ray, collector);
                }
            }
            return;
        }
        let (mut scratch, rows) = (StreamScratch::take(), Vec::with_capacity(bounded.len()));
        let mut searcher = BlockSearcher { blocks, rays: bounded, collectors, rows };
        mesh.bvh.stream(simd, bounded, &mut scratch, &mut searcher);
        scratch.put_back();
    }
}

/// The search in the leaves for the rays of a stream.
struct BlockSearcher<'a, T, C> {
    blocks: &'a [TriangleBlock<T>],
    rays: &'a [BoundedRay],
    collectors: &'a mut [C],
    /// Rays that have met a box, by their slots.
    rows: Vec<ShearedRow>,
}

impl<T: Coordinate, C: HitCollector> BlockSearcher<'_, T, C> {
    /// Intersects a ray with a block.
    #[inline(always)]
    fn one<S: Simd>(&mut self, simd: S, block: &TriangleBlock<T>, id: u32, rays: &mut [CompactRay]) {
        if let (Some(ray), Some(collector)) =
            (rays.get_mut(id as usize), self.collectors.get_mut(id as usize))
            && ray.is_open()
            && let Some(row) = self.rows.get(ray.slot as usize)
        {
            block.hits(simd, &BlockRay::new(simd, &sheared(row)), collector);
            ray.shorten(collector.end());
        }
    }

    /// Intersects up to eight rays with a block.
    #[inline(always)]
    fn eight<S: Simd>(&mut self, simd: S, block: &TriangleBlock<T>, ids: &[u32], rays: &mut [CompactRay]) {
        let mut rows = [&[0.0; LANES]; LANES];
        let (mut ends, mut mask) = ([f64::NEG_INFINITY; LANES], 0);
        for (k, &id) in ids.iter().enumerate().take(LANES) {
            if let (Some(ray), Some(collector)) = (rays.get(id as usize), self.collectors.get(id as usize))
                && ray.is_open()
                && let Some(row) = self.rows.get(ray.slot as usize)
            {
                (rows[k], ends[k]) = (row, collector.end());
                mask |= 1 << k;
            }
        }
        let lanes = ShearedLanes::new(simd, &rows);
        let end_lanes = simd.load8(&ends);
        let mut met = 0;
        for triangle in block.triangles() {
            let Some(found) = lanes.hits(triangle.1, end_lanes, mask) else { continue };
            met |= found.mask;
            let mut hits = found.mask;
            while hits != 0 {
                let k = hits.trailing_zeros() as usize & (LANES - 1);
                hits &= hits - 1;
                if let Some(hit) = found.hit(k, triangle, rows[k], ends[k])
                    && let Some(collector) = self.collectors.get_mut(ids[k] as usize)
                {
                    collector.add(hit);
                }
            }
        }
        while met != 0 {
            let k = met.trailing_zeros() as usize & (LANES - 1);
            met &= met - 1;
            if let (Some(ray), Some(collector)) =
                (rays.get_mut(ids[k] as usize), self.collectors.get(ids[k] as usize))
            {
                ray.shorten(collector.end());
            }
        }
    }
}

impl<T: Coordinate, C: HitCollector> StreamVisitor for BlockSearcher<'_, T, C> {
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, _: S, ids: &[u32], rays: &mut [CompactRay]) {
        for &id in ids {
            if let (Some(ray), Some(bounded)) = (rays.get_mut(id as usize), self.rays.get(id as usize)) {
                ray.slot = self.rows.len() as u32;
                self.rows.push(row(&ShearedRay::without_branches(&bounded.ray)));
            }
        }
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        let Some(block) = self.blocks.get(leaf.ordinal()) else { return };
        for ids in ids.chunks(LANES) {
            if ids.len() < LEAST_LANES {
                for &id in ids {
                    self.one(simd, block, id, rays);
                }
            } else {
                self.eight(simd, block, ids, rays);
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
