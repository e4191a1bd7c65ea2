//! Nodes of eight boxes in unit coordinates of type `f32`, and the test of a ray against all eight.

use glanz_math::{Bounds3, DVec3, Ray};

use super::compact_ray::CompactRay;
use super::simd::{Lanes8, Simd};

/// Number of children of a node.
pub(crate) const WIDTH: usize = 8;

/// A child of a node: another node, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeChild(pub(crate) u32);

impl NodeChild {
    const LEAF: u32 = 1 << 31;

    pub(crate) fn node(index: u32) -> Self {
        Self(index)
    }

    pub(crate) fn leaf(ordinal: u32) -> Self {
        Self(ordinal | Self::LEAF)
    }

    /// The leaf's ordinal, if the child is one.
    #[inline(always)]
    pub(crate) fn as_leaf(self) -> Option<u32> {
        (self.0 & Self::LEAF != 0).then_some(self.0 & !Self::LEAF)
    }
}

/// Eight boxes and their children: four cache lines, the last of which is only read if a box is met.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct WideNode {
    /// Planes by axis and by side (smallest, largest coordinate), in unit coordinates (see [`UnitFrame`]).
    pub(crate) planes: [[Lanes8; 2]; 3],
    pub(crate) children: [NodeChild; WIDTH],
}

impl WideNode {
    /// Eight boxes that no ray meets: an empty interval on every axis.
    pub(crate) const EMPTY: Self = Self {
        planes: [[Lanes8([f32::INFINITY; WIDTH]), Lanes8([f32::NEG_INFINITY; WIDTH])]; 3],
        children: [NodeChild(0); WIDTH],
    };

    /// Sets the box and the child of `slot`.
    pub(crate) fn set(&mut self, slot: usize, min: [f32; 3], max: [f32; 3], child: NodeChild) {
        for axis in 0..3 {
            self.planes[axis][0].0[slot] = min[axis];
            self.planes[axis][1].0[slot] = max[axis];
        }
        self.children[slot] = child;
    }

    /// The children whose boxes the ray may meet, as bits, and the entries of the ray into them.
    #[inline(always)]
    pub(crate) fn intersect<S: Simd>(&self, simd: S, ray: &UnitRay<S>) -> (u32, S::F32) {
        self.ordered_planes(simd, ray.far_side).intersect(simd, ray)
    }

    /// The planes in the order in which rays of an octant of directions cross them; see [`far_sides`].
    #[inline(always)]
    pub(super) fn ordered_planes<S: Simd>(&self, simd: S, far_side: [usize; 3]) -> OrderedPlanes<S> {
        let [x, y, z] = &self.planes;
        let [sx, sy, sz] = far_side.map(|side| side & 1);
        OrderedPlanes {
            near: [simd.load(&x[sx ^ 1]), simd.load(&y[sy ^ 1]), simd.load(&z[sz ^ 1])],
            far: [simd.load(&x[sx]), simd.load(&y[sy]), simd.load(&z[sz])],
        }
    }

    /// Prefetches this node.
    #[inline(always)]
    pub(crate) fn prefetch<S: Simd>(&self, simd: S) {
        for planes in &self.planes {
            simd.prefetch(planes);
        }
        simd.prefetch(&self.children);
    }
}

/// Indices of the planes through which rays of an octant of directions leave a box: 1 where the direction is positive, which are
/// the bits of the octant.
#[inline(always)]
pub(super) fn far_sides(octant: usize) -> [usize; 3] {
    [octant & 1, octant >> 1 & 1, octant >> 2 & 1]
}

/// The planes of a node in registers, for rays of one octant of directions.
pub(super) struct OrderedPlanes<S: Simd> {
    near: [S::F32; 3],
    far: [S::F32; 3],
}

impl<S: Simd> OrderedPlanes<S> {
    /// As [`WideNode::intersect`], for a ray of that octant.
    #[inline(always)]
    pub(super) fn intersect(&self, simd: S, ray: &UnitRay<S>) -> (u32, S::F32) {
        let [x, y, z] = [self.slab(simd, ray, 0), self.slab(simd, ray, 1), self.slab(simd, ray, 2)];
        // The second operand of `max` wins a tie, so that zero is never a negative one: its bits are sorted.
        let entry = simd.max(simd.max(x.0, y.0), simd.max(z.0, simd.splat(0.0)));
        let exit = simd.min(simd.min(x.1, y.1), simd.min(z.1, ray.end));
        (simd.at_most(entry, exit), entry)
    }

    /// Entries and exits of the ray for the slabs between the planes across `axis`.
    #[inline(always)]
    fn slab(&self, simd: S, ray: &UnitRay<S>, axis: usize) -> (S::F32, S::F32) {
        (
            simd.mul_sub(self.near[axis], ray.inverse[axis], ray.near[axis]),
            simd.mul_sub(self.far[axis], ray.inverse[axis], ray.far[axis]),
        )
    }
}

/// The map from the world to the coordinates of the boxes, which fill at most [-1, 1]^3.
///
/// For models of any position and size, the boxes use the whole precision of `f32` and never overflow.
/// `unit = (world - center) * scale`, where `scale` is a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UnitFrame {
    pub(super) center: DVec3,
    pub(super) scale: f64,
}

impl UnitFrame {
    /// The frame of everything in `bounds`, which must be finite; any frame if it is empty.
    pub(crate) fn around(bounds: &Bounds3) -> Self {
        if bounds.is_empty() {
            return Self { center: DVec3::ZERO, scale: 1.0 };
        }
        let center = bounds.center();
        // From the centre, since the difference of the corners may overflow.
        let extent = (bounds.max - center).max(center - bounds.min).max_element();
        // Beyond these exponents 1 / scale is not finite. A model smaller than 1e-290 m counts as a point.
        let exponent = extent.max(f64::MIN_POSITIVE).log2().ceil().clamp(-960.0, 1020.0);
        // From its bits, since no library guarantees that 2^n is exact.
        Self { center, scale: f64::from_bits(((1023.0 - exponent) as u64) << (f64::MANTISSA_DIGITS - 1)) }
    }

    /// The box of `bounds` in unit coordinates, rounded outward.
    pub(crate) fn bounds(&self, bounds: &Bounds3) -> ([f32; 3], [f32; 3]) {
        // The subtraction rounds once, by at most half an ulp; the product with a power of two is exact unless it
        // underflows, which the step of `next_down` covers as well.
        let min = ((bounds.min - self.center) * self.scale).to_array().map(|x| round_down(x.next_down()));
        let max = ((bounds.max - self.center) * self.scale).to_array().map(|x| -round_down((-x).next_down()));
        (min, max)
    }

    /// The length in metres of one unit.
    #[cfg(test)]
    pub(crate) fn unit(&self) -> f64 {
        1.0 / self.scale
    }
}

/// The largest `f32` that is not above `x`.
fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// Unit roundoff of `f32`.
pub(super) const U32: f64 = f32::EPSILON as f64 * 0.5;

/// A bound on the relative error of the few `f64` operations that carry a ray into the unit frame.
pub(super) const CARRY: f64 = 64.0 * f64::EPSILON;

/// The smallest component of a direction, relative to its largest, that is not rounded away from zero.
pub(super) const FLATTEST: f64 = 1.0 / (1u64 << 40) as f64;

/// Rays from farther away, in units, are moved to their entry into the unit cube: boxes grow by `4 u NEAR` at most, which
/// is negligible compared to the size of a leaf.
pub(super) const NEAR: f64 = 8.0;

/// Origins more units away than this meet nothing. `f64` places them to no better than 2^27 units, and up to here no
/// product exceeds the range of `f32`.
const FARTHEST: f64 = (1u128 << 80) as f64;

/// A ray prepared for boxes in unit coordinates: its box test never misses a box that the `f64` ray meets.
///
/// The ray is `o + s d` with `|d| = 1` in the maximum norm and `s >= 0`, measured from its origin, or, if that is not
/// near, from its entry into the unit cube. A plane at `b`, `|b| <= 1`, is crossed at `s = b i - o i` with `i = 1 / d`. Evaluated in
/// `f32`, by a product, a rounded `o i` and a difference, that is wrong by at most `3 u |i| (1 + |o|)` and terms of
/// second order, with or without fusing (`u`: unit roundoff of `f32`). The ray itself is carried into the frame with
/// an error below `CARRY` times the distance of its origin. Therefore `near = o i + pad` and `far = o i - pad` with
/// `pad = |i| (4 u (1 + |o|) + CARRY |o_before|)` give entries that are never late and exits that are never early.
///
/// A component of `d` below `FLATTEST = 2^-40` is replaced by that. Inside a slab the true exit may then be later than
/// the one computed, but `pad >= 4 u 2^40 (1 + |o|) = 2^18 (1 + |o|)` lies far beyond the exit from the unit cube along
/// the largest component, which is at most `1 + |o|`; entries only become earlier or stay negative. With `|o| <= 2^82` and
/// `|i| <= 2^40` every number is finite in `f32`, so no comparison sees NaN; empty slots (planes at infinity) are never
/// met because `i` is not 0.
pub(crate) struct UnitRay<S: Simd> {
    /// `1 / d` per axis.
    inverse: [S::F32; 3],
    /// Subtracted for the plane of the entry.
    near: [S::F32; 3],
    /// Subtracted for the plane of the exit.
    far: [S::F32; 3],
    /// Indices of the planes of the exit.
    far_side: [usize; 3],
    /// The end of the ray.
    end: S::F32,
    /// The same as one number.
    last: f32,
    scale: ParameterScale,
}

/// The conversion of ray parameters to those of a [`UnitRay`], `s = t rate + offset`, never too small.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct ParameterScale {
    pub(super) rate: f64,
    /// The distance from the origin to the point from which `s` is measured, negated, and the absolute error of `s`.
    pub(super) offset: f64,
}

impl ParameterScale {
    /// The end of a ray at `t_max`, rounded up.
    #[inline(always)]
    pub(super) fn end(&self, t_max: f64) -> f32 {
        // Rounding to nearest moves by at most u.
        ((t_max * self.rate * (1.0 + CARRY) + self.offset) * (1.0 + 2.0 * U32)) as f32
    }
}

impl<S: Simd> UnitRay<S> {
    /// `None` if the ray cannot meet the unit cube before `t_max`.
    #[inline(always)]
    pub(crate) fn new(simd: S, frame: &UnitFrame, ray: &Ray, t_max: f64) -> Option<Self> {
        let four = |v: DVec3| [v.x, v.y, v.z, 0.0];
        let direction = simd.load64(&four(ray.direction));
        let mut origin = simd.mul64(
            simd.sub64(simd.load64(&four(ray.origin)), simd.load64(&four(frame.center))),
            simd.splat64(frame.scale),
        );
        let finite = simd.less64(simd.abs64(direction), simd.splat64(f64::INFINITY))
            & simd.less64(simd.abs64(origin), simd.splat64(FARTHEST));
        let length = ray.direction.abs().max_element();
        if finite != 0b1111 || length == 0.0 {
            return None;
        }
        let flat = simd.max64(simd.abs64(direction), simd.splat64(FLATTEST * length));
        let inverse = simd.div64(simd.splat64(length), simd.copysign64(flat, direction));
        let [x, y, z, _] = simd.store64(simd.abs64(origin));
        let distance = x.max(y).max(z);
        let carried = CARRY * distance;
        let mut start = 0.0;
        if distance > NEAR {
            start = entry(simd.store64(origin), simd.store64(inverse), carried);
            // Where the largest component, which is 1, has left the cube, there is nothing to enter.
            if start > 2.0 * (distance + 1.0 + carried) {
                return None;
            }
            origin = simd.add64(origin, simd.mul64(direction, simd.splat64(start / length)));
        }
        let one = simd.splat64(1.0);
        let relative = simd.mul64(simd.add64(one, simd.abs64(origin)), simd.splat64(4.0 * U32));
        let pad = simd.mul64(simd.abs64(inverse), simd.add64(relative, simd.splat64(carried)));
        let product = simd.mul64(origin, inverse);
        let positive = simd.less64(simd.splat64(0.0), inverse) as usize;
        let mut unit = Self {
            inverse: splat(simd, inverse),
            near: splat(simd, simd.add64(product, pad)),
            far: splat(simd, simd.sub64(product, pad)),
            far_side: far_sides(positive),
            end: simd.splat(0.0),
            last: 0.0,
            scale: ParameterScale { rate: length * frame.scale, offset: carried + start * CARRY - start },
        };
        unit.shorten(simd, t_max);
        // Written so that NaN is a miss.
        (unit.last >= 0.0).then_some(unit)
    }

    /// Sets the end of the ray to `t_max`, rounded up.
    #[inline(always)]
    pub(crate) fn shorten(&mut self, simd: S, t_max: f64) {
        self.set_end(simd, self.scale.end(t_max));
    }

    /// Sets the end of the ray in unit coordinates.
    #[inline(always)]
    pub(super) fn set_end(&mut self, simd: S, end: f32) {
        self.last = end;
        self.end = simd.splat(end);
    }

    /// Whether a box entered at `near` lies before the end.
    #[inline(always)]
    pub(crate) fn reaches(&self, near: f32) -> bool {
        near <= self.last
    }
}

impl<S: Simd> UnitRay<S> {
    /// The ray in memory.
    #[inline(always)]
    pub(super) fn compact(&self, simd: S) -> CompactRay {
        let Self { inverse, near, far, last, scale, .. } = *self;
        let first = |[x, y, z]: [Lanes8; 3]| [x.0[0], y.0[0], z.0[0]];
        CompactRay {
            inverse: first([simd.store(inverse[0]), simd.store(inverse[1]), simd.store(inverse[2])]),
            near: first([simd.store(near[0]), simd.store(near[1]), simd.store(near[2])]),
            far: first([simd.store(far[0]), simd.store(far[1]), simd.store(far[2])]),
            end: last,
            slot: 0,
            unused: 0,
            scale,
        }
    }

    /// The ray from memory.
    #[inline(always)]
    pub(super) fn load(simd: S, ray: &CompactRay) -> Self {
        let [x, y, z] = ray.inverse;
        let [near_x, near_y, near_z] = ray.near;
        let [far_x, far_y, far_z] = ray.far;
        Self {
            inverse: [simd.splat(x), simd.splat(y), simd.splat(z)],
            near: [simd.splat(near_x), simd.splat(near_y), simd.splat(near_z)],
            far: [simd.splat(far_x), simd.splat(far_y), simd.splat(far_z)],
            far_side: far_sides(ray.octant()),
            end: simd.splat(ray.end),
            last: ray.end,
            scale: ray.scale,
        }
    }
}

/// The first three lanes, rounded, each in all lanes of a vector.
#[inline(always)]
fn splat<S: Simd>(simd: S, v: S::F64) -> [S::F32; 3] {
    let [x, y, z, _] = simd.narrow(v);
    [simd.splat(x), simd.splat(y), simd.splat(z)]
}

/// Entry of a ray into the unit cube, widened by `carried`; never late, since a flattened component only makes it earlier.
#[cold]
fn entry(origin: [f64; 4], inverse: [f64; 4], carried: f64) -> f64 {
    let axis = |i: usize| (-1.0f64.copysign(inverse[i]) * (1.0 + carried) - origin[i]) * inverse[i];
    axis(0).max(axis(1)).max(axis(2)).max(0.0) * (1.0 - CARRY)
}
