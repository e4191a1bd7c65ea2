//! Batches of rays through a hierarchy whose leaves the caller intersects.

use super::simd::lanes::LANES;
use super::simd::{Simd, Task};
use super::stream::{StreamScratch, StreamVisitor};
use super::{Bvh, BvhLeaf, CompactRay};
use crate::batch::BoundedRay;

/// The caller's work at the leaves that the rays of a batch may meet. A ray is known by its position in the batch.
pub trait BatchVisitor {
    /// Intersects `rays` with the primitives of `leaf`.
    ///
    /// Some of the rays may meet the box of the leaf only behind their end.
    fn leaf(&mut self, leaf: BvhLeaf, rays: &[u32]);

    /// The current end of a ray: that of the batch or the parameter of its closest hit; negative if its search is over.
    fn end(&self, ray: u32) -> f64;
}

impl Bvh {
    /// Visits the leaves that each of `rays` may meet before its end, roughly nearest first, with many rays at a time.
    ///
    /// As in [`Bvh::closest`], a hit at exactly the end of a ray is not culled.
    pub fn visit_batch(&self, rays: &[BoundedRay], visitor: &mut dyn BatchVisitor) {
        self.isa().run(BatchTraversal { bvh: self, rays, visitor });
    }
}

/// [`Bvh::visit_batch`].
struct BatchTraversal<'a> {
    bvh: &'a Bvh,
    rays: &'a [BoundedRay],
    visitor: &'a mut dyn BatchVisitor,
}

impl Task for BatchTraversal<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { bvh, rays, visitor } = self;
        let mut scratch = StreamScratch::take();
        bvh.stream(simd, rays, &mut scratch, &mut LeafLists(visitor));
        scratch.put_back();
    }
}

/// A [`BatchVisitor`] as the visitor of a stream.
struct LeafLists<'a>(&'a mut dyn BatchVisitor);

impl StreamVisitor for LeafLists<'_> {
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, _: S, _: &[u32], _: &mut [CompactRay]) {}

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, leaf: BvhLeaf, ids: &[u32], rays: &mut [CompactRay]) {
        self.0.leaf(leaf, ids);
        for &id in ids {
            if let Some(ray) = rays.get_mut(id as usize) {
                ray.shorten(self.0.end(id));
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
    fn prefetch<S: Simd>(&self, _: S, _: BvhLeaf) {}
}
