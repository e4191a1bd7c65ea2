//! Pairs of a ray and a leaf that wait until a vector is full.
//!
//! Pairs wait in groups, by subpatch where the solver gains from it: eight pairs of one subpatch share its coefficients. A group that must
//! make room for another one, and all groups at the end of a stream, pass their pairs to the group of pairs of any subpatches.

use super::pair_lanes::PairLanes;
use super::ray_lanes::RaySpaceLanes;
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::{LANES, first_lanes};

/// Number of groups of pairs of one subpatch: 21 KB in all, which fits the L1 cache.
const GROUPS: usize = 32;

/// Numbers per pair: the projection of the leaf.
pub(super) const FIELDS: usize = LANES;

/// Pairs that are solved together.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct PairGroup {
    /// By pair: the tangents of the projected leaf, its q, its inverse determinant and the start of the search.
    records: [[f64; FIELDS]; LANES],
    pub(super) rays: [u32; LANES],
    /// Ordinals of the leaves.
    pub(super) leaves: [u32; LANES],
    pub(super) count: usize,
    /// The subpatch of all pairs, except in the group of any subpatches.
    subpatch: u32,
}

impl PairGroup {
    const EMPTY: Self =
        Self { records: [[0.0; FIELDS]; LANES], rays: [0; LANES], leaves: [0; LANES], count: 0, subpatch: 0 };

    /// The lanes in use.
    #[inline(always)]
    pub(super) fn mask(&self) -> u32 {
        first_lanes(self.count)
    }

    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count >= LANES
    }

    /// Appends a pair. There must be room for it.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: u32, leaf: u32, record: &[f64; FIELDS]) {
        let at = self.count & (LANES - 1);
        self.records[at] = *record;
        self.rays[at] = ray;
        self.leaves[at] = leaf;
        self.count = at + 1;
    }

    /// A pair: its ray, its leaf and its record.
    #[inline(always)]
    pub(super) fn pair(&self, k: usize) -> (u32, u32, [f64; FIELDS]) {
        let k = k & (LANES - 1);
        (self.rays[k], self.leaves[k], self.records[k])
    }

    /// The pairs, with the spaces of their rays.
    #[inline(always)]
    pub(super) fn pairs<S: Simd>(&self, simd: S, rays: RaySpaceLanes<S>) -> PairLanes<S> {
        let [a, b, c, d, e, f, g, h] = &self.records;
        let [ax, ay, bx, by, q, inverse_determinant, s, t] = simd.columns8(&[a, b, c, d, e, f, g, h]);
        PairLanes { mask: self.mask(), rays, a: [ax, ay], b: [bx, by], q, inverse_determinant, start: [s, t] }
    }
}

/// Pairs of a ray and a certified leaf.
pub(super) struct PairQueue {
    /// The last one is that of any subpatches.
    groups: [PairGroup; GROUPS + 1],
}

/// The group of pairs of any subpatches.
pub(super) const MIXED_GROUP: usize = GROUPS;

impl PairQueue {
    pub(super) fn new() -> Self {
        Self { groups: [PairGroup::EMPTY; GROUPS + 1] }
    }

    /// The groups of pairs of one subpatch.
    pub(super) fn subpatch_groups() -> std::ops::Range<usize> {
        0..GROUPS
    }

    /// The group at `index`.
    #[inline(always)]
    pub(super) fn group(&self, index: usize) -> &PairGroup {
        &self.groups[index.min(MIXED_GROUP)]
    }

    #[inline(always)]
    pub(super) fn group_mut(&mut self, index: usize) -> &mut PairGroup {
        &mut self.groups[index.min(MIXED_GROUP)]
    }

    /// The group for pairs of a subpatch, and whether pairs of another one wait there.
    #[inline(always)]
    pub(super) fn index_of(&mut self, subpatch: u32) -> (usize, bool) {
        let index = subpatch as usize % GROUPS;
        let group = self.group_mut(index);
        let taken = group.subpatch != subpatch && group.count > 0;
        group.subpatch = subpatch;
        (index, taken)
    }
}
