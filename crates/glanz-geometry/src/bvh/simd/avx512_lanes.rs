//! Eight `f64` lanes in one register of AVX-512.

use std::arch::x86_64::*;

use super::Avx512;
use super::lanes::{LANES, LaneSimd};

// SAFETY, for every block below: `self` is a token, so the processor has AVX-512 F, VL, DQ and BW, and all that AVX2's
// token proves. Loads and stores are unaligned and go through references to exactly as many lanes as they touch.
impl LaneSimd for Avx512 {
    type Wide = __m512d;

    #[inline(always)]
    fn splat8(self, value: f64) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_set1_pd(value) }
    }
    #[inline(always)]
    fn load8(self, lanes: &[f64; LANES]) -> __m512d {
        // SAFETY: as above, 8 lanes.
        unsafe { _mm512_loadu_pd(lanes.as_ptr()) }
    }
    #[inline(always)]
    fn store8(self, value: __m512d) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        // SAFETY: as above, 8 lanes.
        unsafe { _mm512_storeu_pd(lanes.as_mut_ptr(), value) };
        lanes
    }
    #[inline(always)]
    fn add8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_add_pd(a, b) }
    }
    #[inline(always)]
    fn sub8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_sub_pd(a, b) }
    }
    #[inline(always)]
    fn mul8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_mul_pd(a, b) }
    }
    #[inline(always)]
    fn div8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_div_pd(a, b) }
    }
    #[inline(always)]
    fn mul_add8(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_fmadd_pd(a, b, c) }
    }
    #[inline(always)]
    fn sqrt8(self, a: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_sqrt_pd(a) }
    }
    #[inline(always)]
    fn abs8(self, a: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_abs_pd(a) }
    }
    #[inline(always)]
    fn copysign8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_or_pd(_mm512_abs_pd(a), _mm512_and_pd(_mm512_set1_pd(-0.0), b)) }
    }
    #[inline(always)]
    fn min8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_min_pd(a, b) }
    }
    #[inline(always)]
    fn max8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_max_pd(a, b) }
    }
    #[inline(always)]
    fn less8(self, a: __m512d, b: __m512d) -> u32 {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b).into() }
    }
    #[inline(always)]
    fn at_most8(self, a: __m512d, b: __m512d) -> u32 {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b).into() }
    }
    #[inline(always)]
    fn select8(self, mask: u32, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe { _mm512_mask_blend_pd(mask as u8, b, a) }
    }
    #[inline(always)]
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]) {
        // SAFETY: as above, 8 lanes of 4 bytes.
        unsafe {
            let packed = _mm256_maskz_compress_epi32(mask as u8, _mm256_loadu_si256(ids.as_ptr().cast()));
            _mm256_storeu_si256(out.as_mut_ptr().cast(), packed);
        }
    }
    #[inline(always)]
    fn load7(self, lanes: &[f64; 7]) -> __m512d {
        // SAFETY: as above, the first 4 and the last 4 of the 7 numbers.
        unsafe {
            let (first, last) = (_mm256_loadu_pd(lanes.as_ptr()), _mm256_loadu_pd(lanes.as_ptr().add(3)));
            _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(first), last)
        }
    }
    #[inline(always)]
    fn narrow_pairs8(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: as above.
        unsafe {
            let low = _mm512_cvtepu32_epi64(_mm256_castps_si256(_mm512_cvtpd_ps(a)));
            let high = _mm512_cvtepu32_epi64(_mm256_castps_si256(_mm512_cvtpd_ps(b)));
            _mm512_castsi512_pd(_mm512_or_si512(low, _mm512_slli_epi64::<32>(high)))
        }
    }
    #[inline(always)]
    fn transpose8(self, rows: [__m512d; LANES]) -> [__m512d; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: as above.
        unsafe {
            // Pairs of rows: even entries, odd entries.
            let (ab, ab_odd) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
            let (cd, cd_odd) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
            let (ef, ef_odd) = (_mm512_unpacklo_pd(e, f), _mm512_unpackhi_pd(e, f));
            let (gh, gh_odd) = (_mm512_unpacklo_pd(g, h), _mm512_unpackhi_pd(g, h));
            // Quarters 0 and 2, and quarters 1 and 3, of two pairs; then the same of the four quarters.
            let (p, p_odd) =
                (_mm512_shuffle_f64x2::<0x88>(ab, cd), _mm512_shuffle_f64x2::<0x88>(ab_odd, cd_odd));
            let (q, q_odd) =
                (_mm512_shuffle_f64x2::<0xdd>(ab, cd), _mm512_shuffle_f64x2::<0xdd>(ab_odd, cd_odd));
            let (r, r_odd) =
                (_mm512_shuffle_f64x2::<0x88>(ef, gh), _mm512_shuffle_f64x2::<0x88>(ef_odd, gh_odd));
            let (s, s_odd) =
                (_mm512_shuffle_f64x2::<0xdd>(ef, gh), _mm512_shuffle_f64x2::<0xdd>(ef_odd, gh_odd));
            [
                _mm512_shuffle_f64x2::<0x88>(p, r),
                _mm512_shuffle_f64x2::<0x88>(p_odd, r_odd),
                _mm512_shuffle_f64x2::<0x88>(q, s),
                _mm512_shuffle_f64x2::<0x88>(q_odd, s_odd),
                _mm512_shuffle_f64x2::<0xdd>(p, r),
                _mm512_shuffle_f64x2::<0xdd>(p_odd, r_odd),
                _mm512_shuffle_f64x2::<0xdd>(q, s),
                _mm512_shuffle_f64x2::<0xdd>(q_odd, s_odd),
            ]
        }
    }
}
