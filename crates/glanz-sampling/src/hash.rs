//! Counter-based random numbers: hashes of seed, pixel, sample and dimension.
//!
//! There is no generator with a state. The same arguments give the same number on any thread and in any order, so that
//! pictures are reproducible.

/// 2^-53, the spacing of the values of [`unit_f64`].
const F64_STEP: f64 = 1.0 / (1_u64 << 53) as f64;
/// 2^64 divided by the golden ratio, whose multiples are spread over all 64 bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 64 bits whose output bits each depend on every input bit.
///
/// # Source
/// The finaliser of SplitMix64 (@steele2014) with the constants "Mix13" of @stafford2011.
#[inline]
#[must_use]
pub const fn mix64(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A key that depends on `key` and `word`; for one key, different words always give different keys.
///
/// Chain it to hash several words: `combine(combine(seed, a), b)`.
#[inline]
#[must_use]
pub const fn combine(key: u64, word: u64) -> u64 {
    // Adding a constant keeps (0, 0) from being a fixed point; the multiplication spreads small counters.
    mix64(key.wrapping_add(GOLDEN) ^ word.wrapping_mul(GOLDEN))
}

/// The 53 leading bits as a number in [0, 1).
#[inline]
#[must_use]
pub fn unit_f64(bits: u64) -> f64 {
    (bits >> 11) as f64 * F64_STEP
}

/// The image of `position` (below `length`) under the permutation of `0..length` with the given key.
///
/// A keyed bijection on the next power of two is repeated until the result is below `length`, less than twice on average. Over
/// all keys, a pair of positions is mapped to all pairs equally often, up to the quality of the hash. A `position` beyond is
/// taken modulo `length`; a `length` of 0 gives 0.
///
/// # Source
/// The idea of cycle walking: @kensler2013 section 4; departure: other mixing steps.
#[must_use]
pub fn permute(position: u32, length: u32, key: u64) -> u32 {
    if length <= 1 {
        return 0;
    }
    let mask = u32::MAX >> (length - 1).leading_zeros();
    let half = (32 - mask.leading_zeros()).div_ceil(2);
    let (k1, k2, k3) = (combine(key, 1), combine(key, 2), combine(key, 3));
    let keys = [key, key >> 32, k1, k1 >> 32, k2, k2 >> 32, k3, k3 >> 32].map(|k| k as u32);
    let mut x = position % length;
    loop {
        for k in keys {
            // Each step is a bijection of the masked bits.
            x = x.wrapping_add(k) & mask;
            x ^= x >> half;
            x = x.wrapping_mul((k >> 7) | 1) & mask;
            x ^= x >> half & (k >> 20);
        }
        if x < length {
            return x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::chi_square;

    #[test]
    fn largest_bits_stay_below_one() {
        assert_eq!(unit_f64(u64::MAX), 1.0 - 2.0_f64.powi(-53));
        assert_eq!(unit_f64(0), 0.0);
    }

    #[test]
    fn flipping_any_input_bit_flips_each_output_bit_half_the_time() {
        // 64 x 64 pairs of bits, 2000 inputs each: the fraction of flips has standard deviation 0.0112; 5.5 of them
        // leave 4096 pairs a chance of 2e-4 to fail.
        let inputs: Vec<u64> = (0..2000).map(|i| combine(7, i)).collect();
        for bit in 0..64 {
            let mut flips = [0_u32; 64];
            for &x in &inputs {
                let change = mix64(x) ^ mix64(x ^ (1 << bit));
                for (j, f) in flips.iter_mut().enumerate() {
                    *f += (change >> j & 1) as u32;
                }
            }
            for f in flips {
                assert!((f64::from(f) / 2000.0 - 0.5).abs() < 5.5 * 0.0112, "bit {bit}: {f} of 2000");
            }
        }
    }

    #[test]
    fn neighbouring_pixels_samples_and_dimensions_are_uncorrelated() {
        // Pairs of neighbours fall on an 8 x 8 grid uniformly; four kinds of neighbours at 0.001 each.
        let at = |x: u32, s: u32, d: u32, seed: u64| {
            let pixel = combine(seed, 3 << 32 | u64::from(x));
            unit_f64(combine(pixel, u64::from(d) << 32 | u64::from(s)))
        };
        for kind in 0..4 {
            let mut counts = [0_u64; 64];
            for i in 0..64_000 {
                let (x, s) = (i % 200, i / 200);
                let a = at(x, s, 0, 5);
                let b = match kind {
                    0 => at(x + 1, s, 0, 5),
                    1 => at(x, s + 1, 0, 5),
                    2 => at(x, s, 1, 5),
                    _ => at(x, s, 0, 6),
                };
                counts[(a * 8.0) as usize * 8 + (b * 8.0) as usize] += 1;
            }
            let test = chi_square(&counts, &[1000.0; 64]);
            assert!(test.p_value > 0.001, "kind {kind}: {test:?}");
        }
    }

    #[test]
    fn permute_is_a_permutation_for_every_length() {
        for length in 1..70 {
            for key in 0..20 {
                let mut seen = vec![false; length as usize];
                for i in 0..length {
                    seen[permute(i, length, combine(key, 0)) as usize] = true;
                }
                assert!(seen.iter().all(|&s| s), "length {length}");
            }
        }
        assert_eq!(permute(5, 0, 1), 0);
    }

    #[test]
    fn permuted_neighbours_are_mapped_to_all_pairs_equally_often() {
        for length in [4_u32, 9, 16] {
            let n = length as usize;
            let mut counts = vec![0_u64; n * n];
            let trials = 40_000;
            for key in 0..trials {
                let key = combine(11, key);
                counts[permute(0, length, key) as usize * n + permute(1, length, key) as usize] += 1;
            }
            let share = trials as f64 / (n * (n - 1)) as f64;
            let expected: Vec<f64> = (0..n * n).map(|i| if i / n == i % n { 0.0 } else { share }).collect();
            let test = chi_square(&counts, &expected);
            assert!(test.p_value > 0.001, "length {length}: {test:?}");
        }
    }
}
