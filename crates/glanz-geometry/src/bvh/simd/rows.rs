//! Rays in memory as rows of numbers, for loads and stores of whole vectors.

use std::mem::{align_of, offset_of, size_of};

use super::super::CompactRay;
use super::Simd;
use super::lanes::LANES;
use crate::batch::BoundedRay;

// The proofs below need that both types consist of numbers without gaps, in the order of `columns` and of `compact_ray::prepare`.
const _: () = assert!(size_of::<BoundedRay>() == size_of::<[f64; 7]>());
const _: () = assert!(offset_of!(BoundedRay, ray.origin) == 0 && offset_of!(BoundedRay, ray.direction) == 24);
const _: () = assert!(offset_of!(BoundedRay, t_max) == 48);
const _: () = assert!(size_of::<CompactRay>() == size_of::<[f64; LANES]>());
const _: () = assert!(align_of::<CompactRay>() >= align_of::<f64>());
const _: () = assert!(offset_of!(CompactRay, end) == 36 && offset_of!(CompactRay, slot) == 40);
const _: () = assert!(offset_of!(CompactRay, scale) == 48);

/// Origin, direction and end.
#[inline(always)]
fn numbers(ray: &BoundedRay) -> &[f64; 7] {
    // SAFETY: by `repr(C)` and its size, a ray is 7 numbers of type `f64` without gaps.
    unsafe { &*std::ptr::from_ref(ray).cast() }
}

/// Origins, directions and ends of eight rays: `[ox, oy, oz, dx, dx, dy, dz, t_max]`, the fourth column twice.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, [a, b, c, d, e, f, g, h]: [&BoundedRay; LANES]) -> [S::Wide; LANES] {
    simd.transpose8([
        simd.load7(numbers(a)),
        simd.load7(numbers(b)),
        simd.load7(numbers(c)),
        simd.load7(numbers(d)),
        simd.load7(numbers(e)),
        simd.load7(numbers(f)),
        simd.load7(numbers(g)),
        simd.load7(numbers(h)),
    ])
}

/// Writes the fields of a ray as eight numbers, in the order of memory.
#[inline(always)]
pub(crate) fn write(ray: &mut CompactRay, row: [f64; LANES]) {
    // SAFETY: the fields are numbers of types `f32`, `u32` and `f64`, of which all bits are values, and the size is that of the row.
    unsafe { std::ptr::from_mut(ray).cast::<[f64; LANES]>().write(row) }
}
