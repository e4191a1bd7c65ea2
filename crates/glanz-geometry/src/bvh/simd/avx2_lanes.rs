//! Eight `f64` lanes in two registers of AVX2.

use std::arch::x86_64::*;

use super::lanes::{LANES, LaneSimd};
use super::{Avx2, Simd};

/// The bits of a mask of four lanes in vector form.
static SELECTED: [[i64; 4]; 16] = {
    let mut table = [[0; 4]; 16];
    let mut mask = 0;
    while mask < 16 {
        let mut lane = 0;
        while lane < 4 {
            table[mask][lane] = -((mask >> lane & 1) as i64);
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// `$op` of both halves.
macro_rules! halves {
    ($($name:ident($($a:ident),*) => $op:ident;)*) => {
        $(#[inline(always)]
        fn $name(self, $($a: Self::Wide),*) -> Self::Wide {
            [Simd::$op(self, $($a[0]),*), Simd::$op(self, $($a[1]),*)]
        })*
    };
}

// SAFETY, for every block below: `self` is a token, so the processor has AVX2, FMA and BMI2. Loads and stores are unaligned and
// go through references to at least as many lanes as they touch.
impl LaneSimd for Avx2 {
    type Wide = [__m256d; 2];

    halves! {
        add8(a, b) => add64;
        sub8(a, b) => sub64;
        mul8(a, b) => mul64;
        div8(a, b) => div64;
        mul_add8(a, b, c) => mul_add64;
        abs8(a) => abs64;
        copysign8(a, b) => copysign64;
        min8(a, b) => min64;
        max8(a, b) => max64;
    }

    #[inline(always)]
    fn splat8(self, value: f64) -> Self::Wide {
        [self.splat64(value); 2]
    }
    #[inline(always)]
    fn load8(self, lanes: &[f64; LANES]) -> Self::Wide {
        // SAFETY: as above, two times 4 of the 8 lanes.
        unsafe { [_mm256_loadu_pd(lanes.as_ptr()), _mm256_loadu_pd(lanes.as_ptr().add(4))] }
    }
    #[inline(always)]
    fn store8(self, value: Self::Wide) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        // SAFETY: as above, two times 4 of the 8 lanes.
        unsafe {
            _mm256_storeu_pd(lanes.as_mut_ptr(), value[0]);
            _mm256_storeu_pd(lanes.as_mut_ptr().add(4), value[1]);
        }
        lanes
    }
    #[inline(always)]
    fn sqrt8(self, a: Self::Wide) -> Self::Wide {
        // SAFETY: as above.
        unsafe { [_mm256_sqrt_pd(a[0]), _mm256_sqrt_pd(a[1])] }
    }
    #[inline(always)]
    fn less8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        self.less64(a[0], b[0]) | self.less64(a[1], b[1]) << 4
    }
    #[inline(always)]
    fn at_most8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        self.at_most64(a[0], b[0]) | self.at_most64(a[1], b[1]) << 4
    }
    #[inline(always)]
    fn select8(self, mask: u32, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        let (low, high) = (&SELECTED[(mask & 15) as usize], &SELECTED[(mask >> 4 & 15) as usize]);
        // SAFETY: as above, 4 lanes of 8 bytes each.
        unsafe {
            let low = _mm256_castsi256_pd(_mm256_loadu_si256(low.as_ptr().cast()));
            let high = _mm256_castsi256_pd(_mm256_loadu_si256(high.as_ptr().cast()));
            [_mm256_blendv_pd(b[0], a[0], low), _mm256_blendv_pd(b[1], a[1], high)]
        }
    }
    #[inline(always)]
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]) {
        // SAFETY: as above, 8 lanes of 4 bytes.
        unsafe {
            // A byte of ones per lane in the mask, then the numbers of those lanes moved to the front.
            let bytes = _pdep_u64(mask.into(), 0x0101_0101_0101_0101).wrapping_mul(0xff);
            let order = _pext_u64(0x0706_0504_0302_0100, bytes);
            let order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(order as i64));
            let packed = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(ids.as_ptr().cast()), order);
            _mm256_storeu_si256(out.as_mut_ptr().cast(), packed);
        }
    }
    #[inline(always)]
    fn load7(self, lanes: &[f64; 7]) -> Self::Wide {
        // SAFETY: as above, the first 4 and the last 4 of the 7 numbers.
        unsafe { [_mm256_loadu_pd(lanes.as_ptr()), _mm256_loadu_pd(lanes.as_ptr().add(3))] }
    }
    #[inline(always)]
    fn narrow_pairs8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        // SAFETY: as above.
        unsafe {
            let (low, high) = (_mm256_cvtpd_ps(a[0]), _mm256_cvtpd_ps(b[0]));
            let first = _mm256_set_m128(_mm_unpackhi_ps(low, high), _mm_unpacklo_ps(low, high));
            let (low, high) = (_mm256_cvtpd_ps(a[1]), _mm256_cvtpd_ps(b[1]));
            let second = _mm256_set_m128(_mm_unpackhi_ps(low, high), _mm_unpacklo_ps(low, high));
            [_mm256_castps_pd(first), _mm256_castps_pd(second)]
        }
    }
    #[inline(always)]
    fn transpose8(self, rows: [Self::Wide; LANES]) -> [Self::Wide; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        let [p0, p1, p2, p3] = self.transpose64([a[0], b[0], c[0], d[0]]);
        let [p4, p5, p6, p7] = self.transpose64([a[1], b[1], c[1], d[1]]);
        let [q0, q1, q2, q3] = self.transpose64([e[0], f[0], g[0], h[0]]);
        let [q4, q5, q6, q7] = self.transpose64([e[1], f[1], g[1], h[1]]);
        [[p0, q0], [p1, q1], [p2, q2], [p3, q3], [p4, q4], [p5, q5], [p6, q6], [p7, q7]]
    }
}
