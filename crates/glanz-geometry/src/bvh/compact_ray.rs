//! Rays of a stream in memory, prepared for boxes eight at a time.

use super::node::{CARRY, FLATTEST, NEAR, ParameterScale, U32, UnitFrame, UnitRay};
use super::simd::Simd;
use super::simd::lanes::{LANES, first_lanes};
use super::simd::rows::{columns, write};
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
    /// Padding.
    pub(super) unused: u32,
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
        unused: 0,
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

/// Octants of eight rays.
pub(super) struct RayMasks {
    /// Rays that may meet something.
    pub(super) open: u32,
    /// Rays whose direction is positive, by axis.
    positive: [u32; 3],
}

impl RayMasks {
    /// Replaces the ray of a lane.
    #[inline(always)]
    fn replace(&mut self, lane: usize, ray: &CompactRay) {
        let set = |mask: &mut u32, bit: bool| *mask = *mask & !(1 << lane) | u32::from(bit) << lane;
        set(&mut self.open, ray.is_open());
        for (positive, inverse) in self.positive.iter_mut().zip(ray.inverse) {
            set(positive, inverse > 0.0);
        }
    }

    /// The octant of the rays in the mask, if all of them are open and in one.
    #[inline(always)]
    pub(super) fn common_octant(&self, mask: u32) -> Option<usize> {
        let [x, y, z] = self.positive.map(|positive| positive & mask);
        let same = |positive: u32| positive == 0 || positive == mask;
        (self.open & mask == mask && same(x) && same(y) && same(z))
            .then(|| usize::from(x != 0) | usize::from(y != 0) << 1 | usize::from(z != 0) << 2)
    }
}

/// The inverse direction, and the numbers that are subtracted for planes of entries and exits, of one axis; see [`UnitRay`].
#[inline(always)]
fn slab<S: Simd>(simd: S, [o, d]: [S::Wide; 2], length: S::Wide, carried: S::Wide) -> [S::Wide; 3] {
    let flattest = simd.mul8(length, simd.splat8(FLATTEST));
    let inverse = simd.div8(length, simd.copysign8(simd.max8(simd.abs8(d), flattest), d));
    let relative = simd.mul8(simd.add8(simd.splat8(1.0), simd.abs8(o)), simd.splat8(4.0 * U32));
    let pad = simd.mul8(simd.abs8(inverse), simd.add8(relative, carried));
    let product = simd.mul8(o, inverse);
    [inverse, simd.add8(product, pad), simd.sub8(product, pad)]
}

/// Prepares eight rays, the first `count` of which are in use, as [`UnitRay::new`] does, by the same bounds; a ray that cannot
/// meet the unit cube becomes [`CompactRay::NONE`].
#[inline(always)]
pub(super) fn prepare<S: Simd>(
    simd: S,
    frame: &UnitFrame,
    rays: &[BoundedRay; LANES],
    count: usize,
    out: &mut [CompactRay; LANES],
) -> RayMasks {
    let [ox, oy, oz, dx, _, dy, dz, t_max] = columns(simd, rays.each_ref());
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
    let zero = simd.splat8(0.0);
    let x = slab(simd, [ox, dx], length, carried);
    let y = slab(simd, [oy, dy], length, carried);
    let z = slab(simd, [oz, dz], length, carried);
    let rate = simd.mul8(length, scale);
    // As `ParameterScale::end`.
    let end = simd.mul8(simd.mul8(t_max, rate), simd.splat8(1.0 + CARRY));
    let end = simd.mul8(simd.add8(end, carried), simd.splat8(1.0 + 2.0 * U32));
    let columns = [
        simd.narrow_pairs8(x[0], y[0]),
        simd.narrow_pairs8(z[0], x[1]),
        simd.narrow_pairs8(y[1], z[1]),
        simd.narrow_pairs8(x[2], y[2]),
        simd.narrow_pairs8(z[2], end),
        zero,
        rate,
        carried,
    ];
    for (ray, row) in out.iter_mut().zip(simd.transpose8(columns)) {
        write(ray, simd.store8(row));
    }
    let mut masks = RayMasks {
        open: simd.at_most8(zero, end),
        positive: [simd.less8(zero, x[0]), simd.less8(zero, y[0]), simd.less8(zero, z[0])],
    };
    let mut rest = first_lanes(count) & !near;
    while rest != 0 {
        let k = rest.trailing_zeros() as usize & (LANES - 1);
        rest &= rest - 1;
        prepare_one(simd, frame, &rays[k], &mut out[k]);
        masks.replace(k, &out[k]);
    }
    masks
}

/// The same for a ray that is not near, or not finite.
#[inline(always)]
fn prepare_one<S: Simd>(
    simd: S,
    frame: &UnitFrame,
    BoundedRay { ray, t_max }: &BoundedRay,
    out: &mut CompactRay,
) {
    *out = match UnitRay::new(simd, frame, ray, *t_max) {
        Some(unit) => unit.compact(simd),
        None => CompactRay::NONE,
    };
}
