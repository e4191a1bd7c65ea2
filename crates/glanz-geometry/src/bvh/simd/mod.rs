//! The few vector operations that traversal, triangles and patches are written in, for every instruction set; and all
//! other unsafe code of the crate: a stack that is not cleared, and advice to the system about memory pages.
//!
//! [`Simd`] is implemented by tokens. Only [`Isa::detect`], which queries the processor, creates a token, so its holder
//! may use its instructions: that is the proof behind every vector instruction here. Code that is generic over `Simd` is
//! marked `#[inline(always)]` and run through [`Isa::run`], which compiles one copy of it per instruction set; code that
//! several such callers share is run through [`Simd::outlined`], which compiles one copy for all of them.
//!
//! Files: `lanes` (operations on eight `f64`), `isa` (the choice of instructions), `portable` (arrays), `avx`, `avx2_lanes` and
//! `avx512_lanes` (tokens and vector instructions), `rows` (rays as rows of numbers), `stack`, `large_pages`. All the unsafe code of the crate is in them.
//!
//! All operations are the IEEE ones, lane by lane, so that every instruction set gives the same bits; the exception is
//! [`Simd::mul_sub`], which may or may not round its product.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod avx;
#[cfg(target_arch = "x86_64")]
mod avx2_lanes;
#[cfg(target_arch = "x86_64")]
mod avx512_lanes;
mod isa;
pub(crate) mod lanes;
mod large_pages;
mod portable;
pub(crate) mod rows;
mod stack;

#[cfg(target_arch = "x86_64")]
use self::avx::{Avx2, Avx512};
pub(crate) use self::isa::Isa;
use self::lanes::LaneSimd;
pub(crate) use self::large_pages::prefer_large_pages;
use self::portable::Portable;
pub(crate) use self::stack::Stack;

/// Eight `f32` lanes of one kind of box plane, aligned for vector loads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Lanes8(pub(crate) [f32; 8]);

/// Vector operations. `F32` has eight lanes, `F64` four; those of [`LaneSimd`] have eight `f64`.
pub(crate) trait Simd: LaneSimd {
    /// Eight `f32`.
    type F32: Copy;
    /// Four `f64`.
    type F64: Copy;

    /// The same value in every lane.
    fn splat(self, value: f32) -> Self::F32;
    /// Reads eight lanes.
    fn load(self, lanes: &Lanes8) -> Self::F32;
    /// Writes eight lanes.
    fn store(self, value: Self::F32) -> Lanes8;
    /// `a * b - c`, with one rounding or two.
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    /// `if a < b { a } else { b }`.
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `if a > b { a } else { b }`.
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// Bit `i` is set if lane `i` of `a` is at most that of `b`.
    fn at_most(self, a: Self::F32, b: Self::F32) -> u32;

    /// The same value in every lane.
    fn splat64(self, value: f64) -> Self::F64;
    /// Reads four lanes.
    fn load64(self, lanes: &[f64; 4]) -> Self::F64;
    /// Reads four `f32` lanes and widens them, which is exact.
    fn widen(self, lanes: &[f32; 4]) -> Self::F64;
    /// Writes four lanes.
    fn store64(self, value: Self::F64) -> [f64; 4];
    /// `a + b`.
    fn add64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a - b`.
    fn sub64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a * b`.
    fn mul64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a / b`.
    fn div64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a * b + c` with one rounding.
    fn mul_add64(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64;
    /// The transposed matrix.
    fn transpose64(self, rows: [Self::F64; 4]) -> [Self::F64; 4];
    /// `|a|`.
    fn abs64(self, a: Self::F64) -> Self::F64;
    /// The size of `a` with the sign of `b`.
    fn copysign64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// The nearest `f32`.
    fn narrow(self, a: Self::F64) -> [f32; 4];
    /// `if a < b { a } else { b }`.
    fn min64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `if a > b { a } else { b }`.
    fn max64(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// Bit `i` is set if lane `i` of `a` is less than that of `b`.
    fn less64(self, a: Self::F64, b: Self::F64) -> u32;
    /// Bit `i` is set if lane `i` of `a` is at most that of `b`.
    fn at_most64(self, a: Self::F64, b: Self::F64) -> u32;

    /// Prefetches the cache line at `place`.
    fn prefetch<T>(self, place: &T);
    /// Runs work in a function of its own, compiled for the same instructions: rare work, and work that several callers
    /// share and that would take long to compile for each.
    fn outlined<T: Task>(self, task: T) -> T::Output;
}

/// Work that is compiled once per instruction set.
pub(crate) trait Task {
    /// The result.
    type Output;
    /// Does the work; must be `#[inline(always)]` to be compiled for `simd`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}
