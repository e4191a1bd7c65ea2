//! Pairs of a ray and a leaf that wait until a vector is full.

use super::pair_lanes::PairLanes;
use super::ray_lanes::RaySpaceLanes;
use crate::bvh::BvhLeaf;
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// Capacity of a queue: a vector that is not full, and another one.
const QUEUE_CAPACITY: usize = 2 * LANES;

/// Numbers per pair: the projection of the leaf.
const FIELDS: usize = 8;

/// Pairs of a ray and a certified leaf, by field.
pub(super) struct PairQueue {
    pub(super) count: usize,
    pub(super) rays: [u32; QUEUE_CAPACITY],
    pub(super) leaves: [u32; QUEUE_CAPACITY],
    fields: [[f64; QUEUE_CAPACITY]; FIELDS],
}

impl PairQueue {
    pub(super) fn new() -> Self {
        Self {
            count: 0,
            rays: [0; QUEUE_CAPACITY],
            leaves: [0; QUEUE_CAPACITY],
            fields: [[0.0; QUEUE_CAPACITY]; FIELDS],
        }
    }

    /// Appends the pairs in the mask. There must be room for a vector.
    #[inline(always)]
    pub(super) fn push<S: Simd>(
        &mut self,
        simd: S,
        mask: u32,
        ids: &[u32; LANES],
        leaves: &[BvhLeaf; LANES],
        fields: [S::Wide; FIELDS],
    ) {
        let at = self.count;
        let ordinals = leaves.map(|leaf| leaf.ordinal() as u32);
        for (list, lanes) in [(&mut self.rays, ids), (&mut self.leaves, &ordinals)] {
            if let Some(slots) = list.get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
                simd.compress_ids(mask, lanes, slots);
            }
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
    pub(super) fn pairs<S: Simd>(&self, simd: S, mask: u32, rays: RaySpaceLanes<S>) -> PairLanes<S> {
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
    pub(super) fn pop(&mut self) {
        self.rays.copy_within(LANES.., 0);
        self.leaves.copy_within(LANES.., 0);
        for list in &mut self.fields {
            list.copy_within(LANES.., 0);
        }
        self.count = self.count.saturating_sub(LANES);
    }
}
