//! The few vector operations that traversal, triangles and patches are written in, for every instruction set; and all
//! other unsafe code of the crate: a stack that is not cleared, and advice to the system about memory pages.
//!
//! [`Simd`] is implemented by tokens. Only [`Isa::detect`], which queries the processor, creates a token, so its holder
//! may use its instructions: that is the proof behind every vector instruction here. Code that is generic over `Simd` is
//! marked `#[inline(always)]` and run through [`Isa::run`], which compiles one copy of it per instruction set; code that
//! several such callers share is run through [`Simd::outlined`], which compiles one copy for all of them.
//!
//! All the unsafe code of the crate is here and in [`lanes`].
//!
//! All operations are the IEEE ones, lane by lane, so that every instruction set gives the same bits; the exception is
//! [`Simd::mul_sub`], which may or may not round its product.
#![allow(unsafe_code)]

pub(crate) mod lanes;

use std::mem::MaybeUninit;

use self::lanes::LaneSimd;

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

/// The instruction sets for which there is a copy of the hot code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Isa {
    /// Instructions that every processor of the target has.
    Portable(Portable),
    /// AVX2 with fused multiply-add and bit manipulation: x86 processors since 2013.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// The same with the registers of AVX-512, of which there are twice as many.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Isa {
    /// The best instruction set that this processor has.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = Avx512::detect() {
            return Self::Avx512(token);
        } else if let Some(token) = Avx2::detect() {
            return Self::Avx2(token);
        }
        Self::Portable(Portable)
    }

    /// Every instruction set that this processor has, for tests that compare them.
    #[cfg(test)]
    pub(crate) fn all() -> Vec<Self> {
        let mut all = vec![Self::Portable(Portable)];
        #[cfg(target_arch = "x86_64")]
        all.extend(Avx2::detect().map(Self::Avx2));
        #[cfg(target_arch = "x86_64")]
        all.extend(Avx512::detect().map(Self::Avx512));
        all
    }

    /// Runs `task` with these instructions.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Portable(scalar) => task.run(scalar),
            // SAFETY: the token proves that the processor has the features that `run_avx2` is compiled for.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => unsafe { run_avx2(token, task) },
            // SAFETY: the token proves that the processor has the features that `run_avx512` is compiled for.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(token) => unsafe { run_avx512(token, task) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<T: Task>(token: Avx2, task: T) -> T::Output {
    task.run(token)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn run_avx2_outlined<T: Task>(token: Avx2, task: T) -> T::Output {
    task.run(token)
}

// Vectors of [`Simd`] are those of AVX2; the compiler knows that they reach 32 registers here, and spills fewer. Those of
// [`LaneSimd`] have 512 bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
fn run_avx512<T: Task>(token: Avx512, task: T) -> T::Output {
    task.run(token)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
#[inline(never)]
fn run_avx512_outlined<T: Task>(token: Avx512, task: T) -> T::Output {
    task.run(token)
}

/// Plain arithmetic on arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Portable;

#[inline(always)]
fn mask<const N: usize>(bits: [bool; N]) -> u32 {
    bits.iter().enumerate().fold(0, |m, (i, &b)| m | (u32::from(b) << i))
}

impl Simd for Portable {
    type F32 = [f32; 8];
    type F64 = [f64; 4];

    #[inline(always)]
    fn splat(self, value: f32) -> [f32; 8] {
        [value; 8]
    }
    #[inline(always)]
    fn load(self, lanes: &Lanes8) -> [f32; 8] {
        lanes.0
    }
    #[inline(always)]
    fn store(self, value: [f32; 8]) -> Lanes8 {
        Lanes8(value)
    }
    #[inline(always)]
    fn mul_sub(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| a[i] * b[i] - c[i])
    }
    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn at_most(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        mask::<8>(std::array::from_fn(|i| a[i] <= b[i]))
    }

    #[inline(always)]
    fn splat64(self, value: f64) -> [f64; 4] {
        [value; 4]
    }
    #[inline(always)]
    fn load64(self, lanes: &[f64; 4]) -> [f64; 4] {
        *lanes
    }
    #[inline(always)]
    fn widen(self, lanes: &[f32; 4]) -> [f64; 4] {
        lanes.map(f64::from)
    }
    #[inline(always)]
    fn store64(self, value: [f64; 4]) -> [f64; 4] {
        value
    }
    #[inline(always)]
    fn add64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn mul_add64(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        // Slow where the processor cannot do it in one step, but the same bits everywhere.
        std::array::from_fn(|i| a[i].mul_add(b[i], c[i]))
    }
    #[inline(always)]
    fn transpose64(self, rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i]))
    }
    #[inline(always)]
    fn abs64(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn copysign64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i].copysign(b[i]))
    }
    #[inline(always)]
    fn narrow(self, a: [f64; 4]) -> [f32; 4] {
        a.map(|x| x as f32)
    }
    #[inline(always)]
    fn min64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn less64(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        mask::<4>(std::array::from_fn(|i| a[i] < b[i]))
    }
    #[inline(always)]
    fn at_most64(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        mask::<4>(std::array::from_fn(|i| a[i] <= b[i]))
    }

    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}
    #[inline(never)]
    fn outlined<T: Task>(self, task: T) -> T::Output {
        task.run(self)
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::lanes::LaneSimd;
    use super::{Lanes8, Simd, Task};
    use std::arch::x86_64::*;

    /// Proof that the processor has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT; with 32 registers also AVX-512 F, VL, DQ
    /// and BW.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct Avx<const REGISTERS: usize>(());

    /// The proof of AVX2 alone.
    pub(crate) type Avx2 = Avx<16>;

    /// The proof of AVX-512 as well.
    pub(crate) type Avx512 = Avx<32>;

    impl Avx2 {
        /// The token, if the processor has these instructions.
        pub(super) fn detect() -> Option<Self> {
            (is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt"))
            .then_some(Self(()))
        }
    }

    impl Avx512 {
        /// The token, if the processor has these instructions.
        pub(super) fn detect() -> Option<Self> {
            Avx2::detect()?;
            (is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw"))
            .then_some(Self(()))
        }
    }

    // SAFETY, for every block below: `self` is a token, so the processor has AVX2 and FMA. Loads and stores go through
    // references to exactly as many lanes as the instruction touches; the aligned ones to `Lanes8`, which is
    // 32-byte aligned by its type.
    impl<const REGISTERS: usize> Simd for Avx<REGISTERS>
    where
        Self: LaneSimd,
    {
        type F32 = __m256;
        type F64 = __m256d;

        #[inline(always)]
        fn splat(self, value: f32) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_set1_ps(value) }
        }
        #[inline(always)]
        fn load(self, lanes: &Lanes8) -> __m256 {
            // SAFETY: as above, 8 aligned lanes.
            unsafe { _mm256_load_ps(lanes.0.as_ptr()) }
        }
        #[inline(always)]
        fn store(self, value: __m256) -> Lanes8 {
            let mut lanes = Lanes8([0.0; 8]);
            // SAFETY: as above, 8 aligned lanes.
            unsafe { _mm256_store_ps(lanes.0.as_mut_ptr(), value) };
            lanes
        }
        #[inline(always)]
        fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_fmsub_ps(a, b, c) }
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_min_ps(a, b) }
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_max_ps(a, b) }
        }
        #[inline(always)]
        fn at_most(self, a: __m256, b: __m256) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
        }

        #[inline(always)]
        fn splat64(self, value: f64) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_set1_pd(value) }
        }
        #[inline(always)]
        fn load64(self, lanes: &[f64; 4]) -> __m256d {
            // SAFETY: as above, 4 lanes, unaligned.
            unsafe { _mm256_loadu_pd(lanes.as_ptr()) }
        }
        #[inline(always)]
        fn widen(self, lanes: &[f32; 4]) -> __m256d {
            // SAFETY: as above, 4 lanes, unaligned.
            unsafe { _mm256_cvtps_pd(_mm_loadu_ps(lanes.as_ptr())) }
        }
        #[inline(always)]
        fn store64(self, value: __m256d) -> [f64; 4] {
            let mut lanes = [0.0; 4];
            // SAFETY: as above, 4 lanes, unaligned.
            unsafe { _mm256_storeu_pd(lanes.as_mut_ptr(), value) };
            lanes
        }
        #[inline(always)]
        fn add64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_add_pd(a, b) }
        }
        #[inline(always)]
        fn sub64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_sub_pd(a, b) }
        }
        #[inline(always)]
        fn mul64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_mul_pd(a, b) }
        }
        #[inline(always)]
        fn div64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_div_pd(a, b) }
        }
        #[inline(always)]
        fn mul_add64(self, a: __m256d, b: __m256d, c: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_fmadd_pd(a, b, c) }
        }
        #[inline(always)]
        fn transpose64(self, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
            // SAFETY: as above.
            unsafe {
                let (ab, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
                let (cd, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
                [
                    _mm256_permute2f128_pd::<0x20>(ab, cd),
                    _mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd),
                    _mm256_permute2f128_pd::<0x31>(ab, cd),
                    _mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd),
                ]
            }
        }
        #[inline(always)]
        fn abs64(self, a: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), a) }
        }
        #[inline(always)]
        fn copysign64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_or_pd(self.abs64(a), _mm256_and_pd(_mm256_set1_pd(-0.0), b)) }
        }
        #[inline(always)]
        fn narrow(self, a: __m256d) -> [f32; 4] {
            let mut lanes = [0.0; 4];
            // SAFETY: as above, 4 lanes, unaligned.
            unsafe { _mm_storeu_ps(lanes.as_mut_ptr(), _mm256_cvtpd_ps(a)) };
            lanes
        }
        #[inline(always)]
        fn min64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_min_pd(a, b) }
        }
        #[inline(always)]
        fn max64(self, a: __m256d, b: __m256d) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_max_pd(a, b) }
        }
        #[inline(always)]
        fn less64(self, a: __m256d, b: __m256d) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) as u32 }
        }
        #[inline(always)]
        fn at_most64(self, a: __m256d, b: __m256d) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)) as u32 }
        }

        #[inline(always)]
        fn prefetch<T>(self, place: &T) {
            // SAFETY: a prefetch never faults, and `place` is valid anyway.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(place).cast()) }
        }

        #[inline(always)]
        fn outlined<T: Task>(self, task: T) -> T::Output {
            if REGISTERS == 32 {
                // SAFETY: a token with 32 registers is the proof of AVX-512.
                unsafe { super::run_avx512_outlined(Avx(()), task) }
            } else {
                // SAFETY: every token is a proof of AVX2.
                unsafe { super::run_avx2_outlined(Avx(()), task) }
            }
        }
    }
}

/// Advises the system to back the capacity of `list` by large pages, so that random access misses fewer address
/// translations. To be called before the list is filled; a system without support ignores it.
pub(crate) fn prefer_large_pages<T>(list: &mut Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        use std::ffi::{c_int, c_void};
        unsafe extern "C" {
            fn madvise(address: *mut c_void, length: usize, advice: c_int) -> c_int;
        }
        const MADV_HUGEPAGE: c_int = 14;
        const LARGE: usize = 1 << 21;
        let room = list.spare_capacity_mut();
        let bytes = size_of_val(room);
        let start = room.as_mut_ptr().cast::<u8>();
        let skip = start.align_offset(LARGE);
        let length = bytes.saturating_sub(skip) / LARGE * LARGE;
        if length > 0 {
            // SAFETY: whole large pages inside an allocation that `list` owns, by their alignment whole pages of any
            // smaller size too. The advice changes neither contents nor access, only which pages back them.
            unsafe { madvise(start.add(skip).cast(), length, MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = list;
}

/// A stack of fixed capacity that is not cleared when it is created: clearing would cost a tenth of a short ray.
pub(crate) struct Stack<const ROOM: usize> {
    entries: [MaybeUninit<u64>; ROOM],
    // Invariant: the first `len` entries are initialised, and `len <= ROOM`.
    len: usize,
}

impl<const ROOM: usize> Stack<ROOM> {
    /// An empty stack.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; ROOM], len: 0 }
    }

    /// Pushes `entry`. If there is no room, it is lost: `ROOM` needs a proof.
    #[inline(always)]
    pub(crate) fn push(&mut self, entry: u64) {
        if let Some(slot) = self.entries.get_mut(self.len) {
            slot.write(entry);
            self.len += 1;
        }
    }

    /// Removes and returns the top entry.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<u64> {
        self.len = self.len.checked_sub(1)?;
        let slot = self.entries.get(self.len)?;
        // SAFETY: the entry lay below `len`, so it was written by `push`.
        Some(unsafe { slot.assume_init() })
    }

    /// Sorts the `count` topmost entries descending, so that the smallest is popped first.
    #[inline(always)]
    pub(crate) fn sort_top(&mut self, count: usize) {
        let start = self.len.saturating_sub(count);
        let Some(slots) = self.entries.get_mut(start..self.len) else { return };
        // SAFETY: the entries below `len` were written by `push`, and `MaybeUninit<u64>` has the layout of `u64`.
        let top = unsafe { &mut *(std::ptr::from_mut(slots) as *mut [u64]) };
        for i in 1..top.len() {
            let entry = top[i];
            let mut j = i;
            while j > 0 && top[j - 1] < entry {
                top[j] = top[j - 1];
                j -= 1;
            }
            top[j] = entry;
        }
    }
}
