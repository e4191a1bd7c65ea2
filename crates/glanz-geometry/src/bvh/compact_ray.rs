//! Rays of a stream in memory, prepared for boxes eight at a time.

use super::node::{CARRY, FLATTEST, NEAR, ParameterScale, U32, UnitFrame, UnitRay};
use super::simd::Simd;
use super::simd::lanes::{LANES, first_lanes};
use crate::batch::BoundedRay;

/// A ray of a stream, prepared for boxes: the numbers of its [`UnitRay`] once each instead of once per lane, in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct CompactRay {
    pub(super) inverse: [f32; 3],
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    pub(super) end: f32,
    /// The position at which the visitor of the leaves keeps its own data of the ray; see
    /// [`StreamVisitor::prepare`](super::stream::StreamVisitor::prepare).
    pub(crate) slot: u32,
    pub(super) scale: ParameterScale,
}

impl CompactRay {
    /// A ray that meets nothing.
    pub(super) const NONE: Self = Self {
        inverse: [1.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        end: f32::NEG_INFINITY,
        slot: 0,
        scale: ParameterScale { rate: 0.0, offset: 0.0 },
    };

    /// Sets the end of the ray to `t_max`, rounded up.
    #[inline(always)]
    pub(crate) fn shorten(&mut self, t_max: f64) {
        self.end = self.scale.end(t_max);
    }

    /// Whether anything may still lie before its end.
    #[inline(always)]
    pub(crate) fn is_open(&self) -> bool {
        self.end >= 0.0
    }

    /// The signs of the direction, as bits: 1 where it is positive.
    #[inline(always)]
    pub(super) fn octant(&self) -> usize {
        let [x, y, z] = self.inverse.map(|i| usize::from(i > 0.0));
        x | y << 1 | z << 2
    }
}

/// Prepares up to eight rays as [`UnitRay::new`] does, by the same bounds; a ray that cannot meet the unit cube becomes
/// [`CompactRay::NONE`].
#[inline(always)]
pub(super) fn prepare<S: Simd>(
    simd: S,
    frame: &UnitFrame,
    rays: &[BoundedRay],
    out: &mut [CompactRay; LANES],
) {
    let mut rows = [[0.0; LANES]; LANES];
    for (row, BoundedRay { ray, t_max }) in rows.iter_mut().zip(rays) {
        let (o, d) = (ray.origin, ray.direction);
        *row = [o.x, o.y, o.z, d.x, d.y, d.z, *t_max, 0.0];
    }
    let [a, b, c, d, e, f, g, h] = &rows;
    let [ox, oy, oz, dx, dy, dz, t_max, _] = simd.columns8(&[a, b, c, d, e, f, g, h]);
    let scale = simd.splat8(frame.scale);
    let center = frame.center;
    let ox = simd.mul8(simd.sub8(ox, simd.splat8(center.x)), scale);
    let oy = simd.mul8(simd.sub8(oy, simd.splat8(center.y)), scale);
    let oz = simd.mul8(simd.sub8(oz, simd.splat8(center.z)), scale);
    let (ax, ay, az) = (simd.abs8(dx), simd.abs8(dy), simd.abs8(dz));
    let length = simd.max8(simd.max8(ax, ay), az);
    let (px, py, pz) = (simd.abs8(ox), simd.abs8(oy), simd.abs8(oz));
    let distance = simd.max8(simd.max8(px, py), pz);
    // Written so that NaN, in any coordinate, is not near.
    let sum = simd.add8(simd.add8(simd.add8(ax, ay), az), simd.add8(simd.add8(px, py), pz));
    let near = simd.at_most8(distance, simd.splat8(NEAR))
        & simd.less8(simd.splat8(0.0), length)
        & simd.less8(sum, simd.splat8(f64::INFINITY));
    let carried = simd.mul8(distance, simd.splat8(CARRY));
    let one = simd.splat8(1.0);
    let flattest = simd.mul8(length, simd.splat8(FLATTEST));
    let mut lanes = [[0.0; LANES]; 9];
    let axes = [(ox, px, dx, ax), (oy, py, dy, ay), (oz, pz, dz, az)];
    for (axis, (o, size, d, d_size)) in axes.into_iter().enumerate() {
        let inverse = simd.div8(length, simd.copysign8(simd.max8(d_size, flattest), d));
        let relative = simd.mul8(simd.add8(one, size), simd.splat8(4.0 * U32));
        let pad = simd.mul8(simd.abs8(inverse), simd.add8(relative, carried));
        let product = simd.mul8(o, inverse);
        lanes[axis] = simd.narrow8(inverse);
        lanes[3 + axis] = simd.narrow8(simd.add8(product, pad));
        lanes[6 + axis] = simd.narrow8(simd.sub8(product, pad));
    }
    let rates = simd.store8(simd.mul8(length, scale));
    let (offsets, t_max) = (simd.store8(carried), simd.store8(t_max));
    for (k, ray) in out.iter_mut().enumerate() {
        let scale = ParameterScale { rate: rates[k], offset: offsets[k] };
        *ray = CompactRay {
            inverse: [lanes[0][k], lanes[1][k], lanes[2][k]],
            near: [lanes[3][k], lanes[4][k], lanes[5][k]],
            far: [lanes[6][k], lanes[7][k], lanes[8][k]],
            end: scale.end(t_max[k]),
            slot: 0,
            scale,
        };
    }
    let mut rest = first_lanes(rays.len()) & !near;
    while rest != 0 {
        let k = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        if let (Some(BoundedRay { ray, t_max }), Some(out)) = (rays.get(k), out.get_mut(k)) {
            let unit = UnitRay::new(simd, frame, ray, *t_max);
            *out = match unit {
                Some(unit) => unit.compact(simd),
                None => CompactRay::NONE,
            };
        }
    }
}
