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
    /// Writes the integers of the lanes in the mask to the front of `out`; what lies behind them is unspecified.
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]);
    /// Reads seven numbers into eight lanes, the fourth one twice: a load with a mask takes many times as long.
    fn load7(self, lanes: &[f64; 7]) -> Self::Wide;
    /// The transposed matrix: lane `i` of column `k` is lane `k` of row `i`.
    fn transpose8(self, rows: [Self::Wide; LANES]) -> [Self::Wide; LANES];
    /// The nearest `f32` of both in each lane, in memory that of `a` before that of `b`.
    fn narrow_pairs8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide;

    /// Eight rows as columns: lane `i` of column `k` is entry `k` of row `i`.
    #[inline(always)]
    fn columns8(self, [a, b, c, d, e, f, g, h]: &[&[f64; LANES]; LANES]) -> [Self::Wide; LANES] {
        self.transpose8([
            self.load8(a),
            self.load8(b),
            self.load8(c),
            self.load8(d),
            self.load8(e),
            self.load8(f),
            self.load8(g),
            self.load8(h),
        ])
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
                simd.narrow_pairs8(a, c),
                simd.load7(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
            ];
            all.extend(columns);
            let mut bits: Vec<u64> =
                all.into_iter().flat_map(|wide| simd.store8(wide).map(f64::to_bits)).collect();
            bits.extend([simd.less8(a, c), simd.at_most8(b, b), simd.less8(b, c)].map(u64::from));
            for mask in 0..256 {
                bits.extend(simd.store8(simd.select8(mask, b, c)).map(f64::to_bits));
                let count = mask.count_ones() as usize;
                let mut ids = [0; 8];
                simd.compress_ids(mask, &[10, 11, 12, 13, 14, 15, 16, 17], &mut ids);
                bits.extend(ids[..count].iter().map(|&id| u64::from(id)));
                let expected: Vec<u32> = (0..8).filter(|i| mask >> i & 1 == 1).map(|i| 10 + i).collect();
                assert_eq!(ids[..count], expected);
            }
            let pair = |a: f64, b: f64| {
                let bytes = [(a as f32).to_ne_bytes(), (b as f32).to_ne_bytes()].concat();
                u64::from_ne_bytes(bytes.try_into().unwrap())
            };
            let pairs = simd.store8(simd.narrow_pairs8(b, c));
            let (b, c) = (simd.store8(b), simd.store8(c));
            assert_eq!(pairs.map(f64::to_bits), std::array::from_fn(|i| pair(b[i], c[i])));
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
