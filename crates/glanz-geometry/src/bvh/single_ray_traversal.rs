//! Traversal by one ray of a stream, which stops at every leaf.

use super::compact_ray::CompactRay;
use super::node::{NodeChild, UnitRay};
use super::simd::{Simd, Stack};
use super::stream::StreamVisitor;
use super::traversal::{STACK_CAPACITY, child, descend, near};
use super::{Bvh, BvhLeaf, LeafVisitor};

/// The traversal of a subtree by one ray of a stream, nearest boxes first, leaf by leaf.
pub(super) struct SingleRayTraversal {
    /// The position of the ray in its stream.
    pub(super) id: u32,
    stack: Stack<STACK_CAPACITY>,
}

impl SingleRayTraversal {
    pub(super) fn new() -> Self {
        Self { id: 0, stack: Stack::new() }
    }

    /// Goes to the next leaf of the ray, or else of the ray of the next of `tasks`.
    #[inline(always)]
    pub(super) fn advance<S: Simd, V: StreamVisitor>(
        &mut self,
        simd: S,
        bvh: &Bvh,
        rays: &[CompactRay],
        tasks: &mut impl Iterator<Item = (NodeChild, u32)>,
        visit: &V,
    ) -> Option<BvhLeaf> {
        let mut unit = UnitRay::load(simd, rays.get(self.id as usize)?);
        let mut current = self.pop(&unit);
        loop {
            let child = match current {
                Some(child) => child,
                None => {
                    let Some((child, id)) = tasks.next() else {
                        // The next batch may have fewer rays.
                        self.id = 0;
                        return None;
                    };
                    self.id = id;
                    unit = UnitRay::load(simd, rays.get(id as usize)?);
                    child
                }
            };
            if let Some(leaf) = child.as_leaf() {
                return Some(BvhLeaf(leaf));
            }
            let visit = Prefetcher(visit);
            current = descend::<S, _, true>(simd, bvh, child, &unit, &mut self.stack, &visit);
            if current.is_none() {
                current = self.pop(&unit);
            }
        }
    }

    /// The nearest box on the stack that lies before the end of the ray.
    #[inline(always)]
    fn pop<S: Simd>(&mut self, unit: &UnitRay<S>) -> Option<NodeChild> {
        loop {
            let next = self.stack.pop()?;
            if unit.reaches(near(next)) {
                return Some(child(next));
            }
        }
    }
}

/// The visitor of a stream, as far as the descent of a single ray needs it.
struct Prefetcher<'a, V>(&'a V);

impl<V: StreamVisitor> LeafVisitor for Prefetcher<'_, V> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, _: BvhLeaf, t_max: f64) -> f64 {
        t_max
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        self.0.prefetch(simd, leaf);
    }
}
