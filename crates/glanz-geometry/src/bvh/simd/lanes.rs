//! Eight `f64` lanes: eight rays, or eight pairs of a ray and a leaf, side by side.
//!
//! One register of AVX-512, two of AVX2. All operations are the IEEE ones, lane by lane, so that every instruction set gives the
//! same bits, and the same as scalar code.

/// Number of lanes.
pub(crate) const LANES: usize = 8;

/// All lanes, as a mask.
pub(crate) const ALL: u32 = (1 << LANES) - 1;

/// The mask of the first `count` lanes.
#[inline(always)]
pub(crate) fn first_lanes(count: usize) -> u32 {
    if count >= LANES { ALL } else { (1 << count) - 1 }
}

/// Operations on eight `f64` lanes. Masks have a bit per lane.
pub(crate) trait LaneSimd: Copy {
    /// Eight `f64`.
    type Wide: Copy;

    /// The same value in every lane.
    fn splat8(self, value: f64) -> Self::Wide;
    /// Reads eight lanes.
    fn load8(self, lanes: &[f64; LANES]) -> Self::Wide;
    /// Writes eight lanes.
    fn store8(self, value: Self::Wide) -> [f64; LANES];
    /// Writes eight lanes as the nearest `f32`.
    fn narrow8(self, value: Self::Wide) -> [f32; LANES];
    /// `a + b`.
    fn add8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `a - b`.
    fn sub8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `a * b`.
    fn mul8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `a / b`.
    fn div8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `a * b + c` with one rounding.
    fn mul_add8(self, a: Self::Wide, b: Self::Wide, c: Self::Wide) -> Self::Wide;
    /// The square root.
    fn sqrt8(self, a: Self::Wide) -> Self::Wide;
    /// `|a|`.
    fn abs8(self, a: Self::Wide) -> Self::Wide;
    /// The size of `a` with the sign of `b`.
    fn copysign8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `if a < b { a } else { b }`.
    fn min8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// `if a > b { a } else { b }`.
    fn max8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// Lanes in which `a` is less than `b`.
    fn less8(self, a: Self::Wide, b: Self::Wide) -> u32;
    /// Lanes in which `a` is at most `b`.
    fn at_most8(self, a: Self::Wide, b: Self::Wide) -> u32;
    /// The lanes of `a` where the mask is set, those of `b` elsewhere.
    fn select8(self, mask: u32, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// Writes the lanes in the mask to the front of `out`; what lies behind them is unspecified.
    fn compress8(self, mask: u32, value: Self::Wide, out: &mut [f64; LANES]);
    /// The same for integers.
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]);
    /// Eight rows as columns: lane `i` of column `k` is entry `k` of row `i`.
    fn columns8(self, rows: &[&[f64; LANES]; LANES]) -> [Self::Wide; LANES];
}

#[inline(always)]
fn mask(bits: [bool; LANES]) -> u32 {
    bits.iter().enumerate().fold(0, |m, (i, &b)| m | (u32::from(b) << i))
}

/// Lane by lane.
#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; LANES] {
    std::array::from_fn(f)
}

/// Moves the lanes in the mask to the front.
#[inline(always)]
fn pack<T: Copy>(mask: u32, lanes: &[T; LANES], out: &mut [T; LANES]) {
    let mut count = 0;
    for (i, &lane) in lanes.iter().enumerate() {
        if let Some(slot) = out.get_mut(count) {
            *slot = lane;
        }
        count += (mask >> i & 1) as usize;
    }
}

impl LaneSimd for super::Portable {
    type Wide = [f64; LANES];

    #[inline(always)]
    fn splat8(self, value: f64) -> Self::Wide {
        [value; LANES]
    }
    #[inline(always)]
    fn load8(self, lanes: &[f64; LANES]) -> Self::Wide {
        *lanes
    }
    #[inline(always)]
    fn store8(self, value: Self::Wide) -> [f64; LANES] {
        value
    }
    #[inline(always)]
    fn narrow8(self, value: Self::Wide) -> [f32; LANES] {
        value.map(|x| x as f32)
    }
    #[inline(always)]
    fn add8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn mul_add8(self, a: Self::Wide, b: Self::Wide, c: Self::Wide) -> Self::Wide {
        each(|i| a[i].mul_add(b[i], c[i]))
    }
    #[inline(always)]
    fn sqrt8(self, a: Self::Wide) -> Self::Wide {
        a.map(f64::sqrt)
    }
    #[inline(always)]
    fn abs8(self, a: Self::Wide) -> Self::Wide {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn copysign8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i].copysign(b[i]))
    }
    #[inline(always)]
    fn min8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn less8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        mask(std::array::from_fn(|i| a[i] < b[i]))
    }
    #[inline(always)]
    fn at_most8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        mask(std::array::from_fn(|i| a[i] <= b[i]))
    }
    #[inline(always)]
    fn select8(self, mask: u32, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if mask >> i & 1 == 1 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn compress8(self, mask: u32, value: Self::Wide, out: &mut [f64; LANES]) {
        pack(mask, &value, out);
    }
    #[inline(always)]
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]) {
        pack(mask, ids, out);
    }
    #[inline(always)]
    fn columns8(self, rows: &[&[f64; LANES]; LANES]) -> [Self::Wide; LANES] {
        std::array::from_fn(|k| each(|i| rows[i][k]))
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::super::{Avx2, Avx512, Simd};
    use super::{LANES, LaneSimd};

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
        fn narrow8(self, value: __m512d) -> [f32; LANES] {
            let mut lanes = [0.0; LANES];
            // SAFETY: as above, 8 lanes.
            unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), _mm512_cvtpd_ps(value)) };
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
        fn compress8(self, mask: u32, value: __m512d, out: &mut [f64; LANES]) {
            // SAFETY: as above, 8 lanes. In a register: a compressing store takes many times as long.
            unsafe { _mm512_storeu_pd(out.as_mut_ptr(), _mm512_maskz_compress_pd(mask as u8, value)) };
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
        fn columns8(self, rows: &[&[f64; LANES]; LANES]) -> [__m512d; LANES] {
            let [a, b, c, d, e, f, g, h] = *rows;
            // SAFETY: as above.
            unsafe {
                let (a, b, c, d) = (self.load8(a), self.load8(b), self.load8(c), self.load8(d));
                let (e, f, g, h) = (self.load8(e), self.load8(f), self.load8(g), self.load8(h));
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

    /// For each mask of four lanes, the 32-bit halves of those in it, in order.
    static PACKED: [[i32; 8]; 16] = {
        let mut table = [[0; 8]; 16];
        let mut mask = 0;
        while mask < 16 {
            let (mut lane, mut count) = (0, 0);
            while lane < 4 {
                if mask >> lane & 1 == 1 {
                    table[mask][count] = 2 * lane;
                    table[mask][count + 1] = 2 * lane + 1;
                    count += 2;
                }
                lane += 1;
            }
            mask += 1;
        }
        table
    };

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
        fn narrow8(self, value: Self::Wide) -> [f32; LANES] {
            let ([a, b, c, d], [e, f, g, h]) = (self.narrow(value[0]), self.narrow(value[1]));
            [a, b, c, d, e, f, g, h]
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
        fn compress8(self, mask: u32, value: Self::Wide, out: &mut [f64; LANES]) {
            let (low, high) = ((mask & 15) as usize, (mask >> 4 & 15) as usize);
            // SAFETY: as above. The upper half is written from at most the fourth lane on.
            unsafe {
                let (first, second) = (&PACKED[low], &PACKED[high]);
                let first = _mm256_loadu_si256(first.as_ptr().cast());
                let second = _mm256_loadu_si256(second.as_ptr().cast());
                let first = _mm256_permutevar8x32_epi32(_mm256_castpd_si256(value[0]), first);
                let second = _mm256_permutevar8x32_epi32(_mm256_castpd_si256(value[1]), second);
                _mm256_storeu_pd(out.as_mut_ptr(), _mm256_castsi256_pd(first));
                let behind = out.as_mut_ptr().add(low.count_ones() as usize);
                _mm256_storeu_pd(behind, _mm256_castsi256_pd(second));
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
        fn columns8(self, rows: &[&[f64; LANES]; LANES]) -> [Self::Wide; LANES] {
            let [a, b, c, d, e, f, g, h] = *rows;
            let (a, b, c, d) = (self.load8(a), self.load8(b), self.load8(c), self.load8(d));
            let (e, f, g, h) = (self.load8(e), self.load8(f), self.load8(g), self.load8(h));
            let [p0, p1, p2, p3] = self.transpose64([a[0], b[0], c[0], d[0]]);
            let [p4, p5, p6, p7] = self.transpose64([a[1], b[1], c[1], d[1]]);
            let [q0, q1, q2, q3] = self.transpose64([e[0], f[0], g[0], h[0]]);
            let [q4, q5, q6, q7] = self.transpose64([e[1], f[1], g[1], h[1]]);
            [[p0, q0], [p1, q1], [p2, q2], [p3, q3], [p4, q4], [p5, q5], [p6, q6], [p7, q7]]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, Portable, Simd, Task};

    /// Every operation on lanes that look random, as bits.
    struct Operations;

    impl Task for Operations {
        type Output = Vec<u64>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Vec<u64> {
            let number = |i: usize, k: usize| ((i * 8 + k) as f64 * 0.618_034).fract() * 8.0 - 4.0;
            let rows: [[f64; 8]; 8] = std::array::from_fn(|i| std::array::from_fn(|k| number(i, k)));
            let mut rows_with_specials = rows;
            rows_with_specials[0][3] = f64::NAN;
            rows_with_specials[1][3] = -0.0;
            let columns = simd.columns8(&std::array::from_fn(|i| &rows[i]));
            let (a, b, c) = (simd.load8(&rows_with_specials[0]), simd.load8(&rows[1]), columns[2]);
            let mut all = vec![
                simd.add8(a, b),
                simd.sub8(a, b),
                simd.mul8(a, b),
                simd.div8(a, b),
                simd.mul_add8(a, b, c),
                simd.sqrt8(simd.abs8(b)),
                simd.copysign8(b, c),
                simd.min8(a, b),
                simd.max8(a, b),
                simd.splat8(0.3),
            ];
            all.extend(columns);
            let mut bits: Vec<u64> =
                all.into_iter().flat_map(|wide| simd.store8(wide).map(f64::to_bits)).collect();
            bits.extend(simd.narrow8(c).map(|x| u64::from(x.to_bits())));
            bits.extend([simd.less8(a, c), simd.at_most8(b, b), simd.less8(b, c)].map(u64::from));
            for mask in 0..256 {
                bits.extend(simd.store8(simd.select8(mask, b, c)).map(f64::to_bits));
                let count = mask.count_ones() as usize;
                let (mut lanes, mut ids) = ([0.0; 8], [0; 8]);
                simd.compress8(mask, c, &mut lanes);
                simd.compress_ids(mask, &[10, 11, 12, 13, 14, 15, 16, 17], &mut ids);
                bits.extend(lanes[..count].iter().map(|x| x.to_bits()));
                bits.extend(ids[..count].iter().map(|&id| u64::from(id)));
                let expected: Vec<u32> = (0..8).filter(|i| mask >> i & 1 == 1).map(|i| 10 + i).collect();
                assert_eq!(ids[..count], expected);
            }
            for (k, column) in columns.into_iter().enumerate() {
                assert_eq!(simd.store8(column), std::array::from_fn(|i| rows[i][k]));
            }
            bits
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_lanes() {
        let portable = Isa::Portable(Portable).run(Operations);
        for isa in Isa::all() {
            assert_eq!(isa.run(Operations), portable, "{isa:?}");
        }
    }
}
