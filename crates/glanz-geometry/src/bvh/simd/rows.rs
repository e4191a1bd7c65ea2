//! Rays in memory as rows of numbers, for loads and stores of whole vectors.

use std::mem::{align_of, size_of};

use super::super::CompactRay;
use super::lanes::LANES;
use crate::batch::BoundedRay;

// The proof that follows needs that both types consist of numbers without gaps.
const _: () = assert!(size_of::<BoundedRay>() == size_of::<[f64; 7]>());
const _: () = assert!(size_of::<CompactRay>() == size_of::<[f64; LANES]>());
const _: () = assert!(align_of::<CompactRay>() >= align_of::<f64>());

/// Origin, direction and end.
#[inline(always)]
pub(crate) fn numbers(ray: &BoundedRay) -> &[f64; 7] {
    // SAFETY: by `repr(C)` and its size, a ray is 7 numbers of type `f64` without gaps.
    unsafe { &*std::ptr::from_ref(ray).cast() }
}

/// Overwrites a ray by 64 bytes: the fields of [`CompactRay`] in order.
#[inline(always)]
pub(crate) fn write(ray: &mut CompactRay, row: [f64; LANES]) {
    // SAFETY: the fields are numbers of types `f32`, `u32` and `f64`, of which all bits are values, and the size is that of the row.
    unsafe { std::ptr::from_mut(ray).cast::<[f64; LANES]>().write(row) }
}
