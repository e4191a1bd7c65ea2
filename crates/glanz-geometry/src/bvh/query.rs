//! Closest hit, any hit and all hits of a surface whose primitives lie in the leaves of a hierarchy.

use glanz_math::Ray;

use super::simd::Simd;
use super::{Bvh, BvhLeaf, LeafVisitor};
use crate::hit::Hit;

/// Intersects a ray with the primitives of a leaf. Methods are `#[inline(always)]`: see [`LeafVisitor`].
pub(crate) trait LeafIntersector {
    /// Prefetches a leaf that will be visited soon.
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf);

    /// Adds the hits of a leaf with `0 < t <= collector.end()`.
    fn hits<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, collector: &mut impl HitCollector);
}

/// The hits of a query, as far as it needs them. Methods are `#[inline(always)]`.
pub(crate) trait HitCollector {
    /// Whether a single hit ends the search, so that the order of leaves does not matter.
    const STOPS_AT_FIRST: bool;

    /// The end of the ray: hits farther away do not count. Less than before if the search is over.
    fn end(&self) -> f64;

    /// Adds a hit with `0 < t`.
    fn add(&mut self, hit: Hit);
}

/// The closest hit.
pub(crate) struct ClosestHit {
    best: Hit,
    found: bool,
}

impl ClosestHit {
    #[inline(always)]
    pub(crate) fn before(t_max: f64) -> Self {
        // No hit at the end of the ray comes before this one, so that only closer ones count.
        let end = Hit::new(t_max, f64::NEG_INFINITY, f64::NEG_INFINITY, 0);
        Self { best: end, found: false }
    }

    pub(crate) fn hit(self) -> Option<Hit> {
        self.found.then_some(self.best)
    }
}

impl HitCollector for ClosestHit {
    const STOPS_AT_FIRST: bool = false;

    #[inline(always)]
    fn end(&self) -> f64 {
        self.best.t
    }

    #[inline(always)]
    fn add(&mut self, hit: Hit) {
        // Of hits at the same t that of the lowest face and parameters is taken, whatever the order of leaves.
        let key = |h: &Hit| (h.t, h.face, h.u, h.v);
        if key(&hit) < key(&self.best) {
            *self = Self { best: hit, found: true };
        }
    }
}

/// Whether there is a hit.
pub(crate) struct AnyHit {
    t_max: f64,
    found: bool,
}

impl AnyHit {
    #[inline(always)]
    pub(crate) fn before(t_max: f64) -> Self {
        Self { t_max, found: false }
    }

    pub(crate) fn found(self) -> bool {
        self.found
    }
}

impl HitCollector for AnyHit {
    const STOPS_AT_FIRST: bool = true;

    #[inline(always)]
    fn end(&self) -> f64 {
        if self.found { f64::NEG_INFINITY } else { self.t_max }
    }

    #[inline(always)]
    fn add(&mut self, hit: Hit) {
        self.found |= hit.t < self.t_max;
    }
}

/// All hits before `t_max`, unordered.
pub(crate) struct AllHits<'a> {
    pub(crate) t_max: f64,
    pub(crate) hits: &'a mut Vec<Hit>,
}

impl HitCollector for AllHits<'_> {
    const STOPS_AT_FIRST: bool = false;

    #[inline(always)]
    fn end(&self) -> f64 {
        self.t_max
    }

    #[inline(always)]
    fn add(&mut self, hit: Hit) {
        if hit.t < self.t_max {
            self.hits.push(hit);
        }
    }
}

struct CollectingVisitor<I, C> {
    intersector: I,
    collector: C,
}

impl<I: LeafIntersector, C: HitCollector> LeafVisitor for &mut CollectingVisitor<I, C> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, leaf: BvhLeaf, _: f64) -> f64 {
        self.intersector.hits(simd, leaf, &mut self.collector);
        self.collector.end()
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, leaf: BvhLeaf) {
        self.intersector.prefetch(simd, leaf);
    }
}

impl Bvh {
    /// The hits of a ray, by an intersector for the leaves.
    #[inline(always)]
    pub(crate) fn collect<S: Simd, I: LeafIntersector, C: HitCollector>(
        &self,
        simd: S,
        ray: &Ray,
        intersector: I,
        collector: C,
    ) -> C {
        let t_max = collector.end();
        let mut visitor = CollectingVisitor { intersector, collector };
        if C::STOPS_AT_FIRST {
            self.any_with(simd, ray, t_max, &mut visitor);
        } else {
            self.closest_with(simd, ray, t_max, &mut visitor);
        }
        visitor.collector
    }
}
