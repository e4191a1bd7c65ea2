//! Leaves projected along eight rays at once: [`PatchLeaf::project`] lane by lane, with the same bits.

use super::bicubic::POWERS;
use super::leaf::{CERTIFIED, PatchLeaf};
use super::ray_lanes::{RaySpaceLanes, cross, dot2, negated};
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// [`LeafProjection`](super::leaf::LeafProjection)s of eight pairs of a ray and a leaf.
pub(super) struct ProjectionLanes<S: Simd> {
    pub(super) a: [S::Wide; 2],
    pub(super) b: [S::Wide; 2],
    pub(super) q: S::Wide,
    pub(super) inverse_determinant: S::Wide,
    pub(super) start: [S::Wide; 2],
    /// Rays that may meet the leaf.
    pub(super) met: u32,
    /// Rays that have one root at most with it.
    pub(super) certified: u32,
}

/// The numbers of eight leaves, as [`PatchLeaf`] has them.
pub(super) struct LeafLanes<S: Simd> {
    rows: [[S::Wide; 4]; 3],
}

impl<S: Simd> LeafLanes<S> {
    /// The same leaf eight times.
    #[inline(always)]
    pub(super) fn splat(simd: S, leaf: &PatchLeaf) -> Self {
        let mut rows = [[simd.splat8(0.0); 4]; 3];
        for (row, numbers) in rows.iter_mut().zip(&leaf.rows) {
            for (lanes, &number) in row.iter_mut().zip(numbers) {
                *lanes = simd.splat8(number.into());
            }
        }
        Self { rows }
    }

    /// Eight leaves.
    #[inline(always)]
    pub(super) fn new(simd: S, leaves: &[&PatchLeaf; LANES]) -> Self {
        let (mut upper, mut last) = ([[0.0; LANES]; LANES], [[0.0; LANES]; LANES]);
        for ((upper, last), leaf) in upper.iter_mut().zip(&mut last).zip(leaves) {
            let [[a, b, c, d], [e, f, g, h], z] = leaf.rows;
            *upper = [a, b, c, d, e, f, g, h].map(f64::from);
            let [a, b, c, d] = z.map(f64::from);
            *last = [a, b, c, d, 0.0, 0.0, 0.0, 0.0];
        }
        let [a, b, c, d, e, f, g, h] = &upper;
        let [x0, x1, x2, x3, y0, y1, y2, y3] = simd.columns8(&[a, b, c, d, e, f, g, h]);
        let [a, b, c, d, e, f, g, h] = &last;
        let [z0, z1, z2, z3, ..] = simd.columns8(&[a, b, c, d, e, f, g, h]);
        Self { rows: [[x0, x1, x2, x3], [y0, y1, y2, y3], [z0, z1, z2, z3]] }
    }

    /// The projections of the leaves along the rays.
    #[inline(always)]
    pub(super) fn project(&self, simd: S, rays: &RaySpaceLanes<S>) -> ProjectionLanes<S> {
        let [p, q] = rays.axes;
        let (p, q) = (self.columns_along(simd, p), self.columns_along(simd, q));
        let c = [simd.add8(p[0], rays.center[0]), simd.add8(q[0], rays.center[1])];
        let (a, b) = ([p[1], q[1]], [p[2], q[2]]);
        let det = cross(simd, a, b);
        let (s, t) = (negated(simd, cross(simd, c, b)), negated(simd, cross(simd, a, c)));
        let (a2, b2) = (dot2(simd, a, a), dot2(simd, b, b));
        let noise = simd.mul8(simd.splat8(POWERS), rays.noise);
        let [[.., thickness], [.., deviation], _] = self.rows;
        let thickness = simd.add8(thickness, noise);
        let size = simd.abs8(det);
        let thickness2 = simd.mul8(thickness, thickness);
        let outside = outside(simd, s, size, simd.mul8(thickness2, b2))
            | outside(simd, t, size, simd.mul8(thickness2, a2));
        let unsure = simd.mul8(simd.splat8(16.0), noise);
        let q2 = simd.mul8(simd.add8(deviation, simd.mul8(unsure, unsure)), simd.add8(a2, b2));
        let inverse_determinant = simd.div8(simd.splat8(1.0), det);
        let limit = simd.mul8(simd.mul8(simd.splat8(CERTIFIED * CERTIFIED), det), det);
        ProjectionLanes {
            a,
            b,
            q: simd.mul8(simd.sqrt8(q2), simd.abs8(inverse_determinant)),
            inverse_determinant,
            start: [simd.mul8(s, inverse_determinant), simd.mul8(t, inverse_determinant)],
            met: !outside,
            certified: simd.less8(q2, limit),
        }
    }

    /// Centre and half tangents along eight directions.
    #[inline(always)]
    fn columns_along(&self, simd: S, [x, y, z]: [S::Wide; 3]) -> [S::Wide; 3] {
        let [rx, ry, rz] = &self.rows;
        let mut columns = [x; 3];
        for (k, column) in columns.iter_mut().enumerate() {
            let sum = simd.mul8(rx[k], x);
            let sum = simd.mul_add8(ry[k], y, sum);
            *column = simd.mul_add8(rz[k], z, sum);
        }
        columns
    }
}

/// Lanes where `|s|` exceeds `size` by more than the root of `room`.
#[inline(always)]
fn outside<S: Simd>(simd: S, s: S::Wide, size: S::Wide, room: S::Wide) -> u32 {
    let beyond = simd.sub8(simd.abs8(s), size);
    simd.less8(simd.splat8(0.0), beyond) & simd.less8(room, simd.mul8(beyond, beyond))
}
