//! The tokens of AVX2 and AVX-512, functions compiled for them, and the operations that both do with registers of 256 bits.

use std::arch::x86_64::*;

use super::lanes::LaneSimd;
use super::{Lanes8, Simd, Task};

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

// SAFETY, for every block below: `self` is a token, so the processor has AVX2, FMA and BMI2. Loads and stores go through
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
            unsafe { run_avx512_outlined(Avx(()), task) }
        } else {
            // SAFETY: every token is a proof of AVX2.
            unsafe { run_avx2_outlined(Avx(()), task) }
        }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn run_avx2<T: Task>(token: Avx2, task: T) -> T::Output {
    task.run(token)
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
pub(super) fn run_avx2_outlined<T: Task>(token: Avx2, task: T) -> T::Output {
    task.run(token)
}

// Vectors of [`Simd`] are those of AVX2; the compiler knows that they reach 32 registers here, and spills fewer. Those of
// [`LaneSimd`] have 512 bits.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
pub(super) fn run_avx512<T: Task>(token: Avx512, task: T) -> T::Output {
    task.run(token)
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
#[inline(never)]
pub(super) fn run_avx512_outlined<T: Task>(token: Avx512, task: T) -> T::Output {
    task.run(token)
}
