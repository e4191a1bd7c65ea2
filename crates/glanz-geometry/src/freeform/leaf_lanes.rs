//! Leaves projected along eight rays at once: [`PatchLeaf::project`] lane by lane, with the same bits.

use super::bicubic::POWERS;
use super::leaf::{CERTIFIED, PatchLeaf};
use super::ray_lanes::{RaySpaceLanes, cross, dot2, negated};
use crate::bvh::simd::Simd;

/// [`LeafProjection`](super::leaf::LeafProjection)s of eight rays with one leaf.
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

impl PatchLeaf {
    /// The projections along eight rays.
    #[inline(always)]
    pub(super) fn project_lanes<S: Simd>(&self, simd: S, rays: &RaySpaceLanes<S>) -> ProjectionLanes<S> {
        let [p, q] = rays.axes;
        let (p, q) = (self.columns_along(simd, p), self.columns_along(simd, q));
        let c = [simd.add8(p[0], rays.center[0]), simd.add8(q[0], rays.center[1])];
        let (a, b) = ([p[1], q[1]], [p[2], q[2]]);
        let det = cross(simd, a, b);
        let (s, t) = (negated(simd, cross(simd, c, b)), negated(simd, cross(simd, a, c)));
        let (a2, b2) = (dot2(simd, a, a), dot2(simd, b, b));
        let noise = simd.mul8(simd.splat8(POWERS), rays.noise);
        let [[.., thickness], [.., deviation], _] = self.rows;
        let thickness = simd.add8(simd.splat8(thickness.into()), noise);
        let size = simd.abs8(det);
        let thickness2 = simd.mul8(thickness, thickness);
        let outside = outside(simd, s, size, simd.mul8(thickness2, b2))
            | outside(simd, t, size, simd.mul8(thickness2, a2));
        let unsure = simd.mul8(simd.splat8(16.0), noise);
        let q2 =
            simd.mul8(simd.add8(simd.splat8(deviation.into()), simd.mul8(unsure, unsure)), simd.add8(a2, b2));
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
    fn columns_along<S: Simd>(&self, simd: S, [x, y, z]: [S::Wide; 3]) -> [S::Wide; 3] {
        let [rx, ry, rz] = &self.rows;
        let mut columns = [x; 3];
        for (k, column) in columns.iter_mut().enumerate() {
            let sum = simd.mul8(simd.splat8(rx[k].into()), x);
            let sum = simd.mul_add8(simd.splat8(ry[k].into()), y, sum);
            *column = simd.mul_add8(simd.splat8(rz[k].into()), z, sum);
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
