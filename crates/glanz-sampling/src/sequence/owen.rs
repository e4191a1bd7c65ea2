//! Nested uniform (Owen) scrambling by hashing.

use crate::hash::combine;
use crate::sequence::sobol;

/// 2^-32.
const STEP: f64 = 1.0 / (1_u64 << 32) as f64;

/// Scrambles a *bit-reversed* 32-bit fraction: each bit is flipped or not by a hash of `seed` and of the bits more
/// significant (before reversal) than itself. The result is still reversed.
///
/// `seed` should be the output of a good hash.
///
/// # Source
/// @laine2011 introduced the construction, @burley2020 its use for Sobol' points; the constants are those of
/// @vegdahl2021.
#[inline]
#[must_use]
pub fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    // Multiplications carry information upwards only, towards bits that were less significant.
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Nested uniform scrambling of a 32-bit fraction.
///
/// Of an index instead of a fraction, this is a shuffling that keeps every aligned block of 2^k indices together:
/// prefixes of a shuffled digital sequence are still nets.
#[inline]
#[must_use]
pub fn scramble(x: u32, seed: u32) -> u32 {
    scramble_reversed(x.reverse_bits(), seed).reverse_bits()
}

/// A scrambled and shuffled copy of the four-dimensional Sobol' sequence; the copy is named by `key`.
///
/// Copies of different keys are (practically) independent, so that any number of them side by side make a sequence of
/// any dimension: "padding".
///
/// # Source
/// @burley2020 section 3.
#[derive(Clone, Copy, Debug)]
pub struct ScrambledSobol {
    key: u64,
}

impl ScrambledSobol {
    /// The copy that `key` names.
    #[inline]
    #[must_use]
    pub const fn new(key: u64) -> Self {
        Self { key }
    }

    /// Coordinate `dimension` (0 to 3) of point `index`, in units of 2^-32.
    #[inline]
    #[must_use]
    pub fn coordinate(&self, index: u32, dimension: usize) -> u32 {
        let pair = combine(self.key, dimension as u64 / 2);
        let seed = if dimension % 2 == 0 { pair } else { pair >> 32 } as u32;
        scramble_reversed(sobol::coordinate_reversed(self.shuffled(index), dimension), seed).reverse_bits()
    }

    /// Coordinates 0 and 1 (`pair` 0) or 2 and 3 (`pair` 1) of point `index`, in units of 2^-32.
    #[inline]
    #[must_use]
    pub fn pair(&self, index: u32, pair: usize) -> [u32; 2] {
        let seeds = combine(self.key, pair as u64);
        let index = self.shuffled(index);
        let at = |d: usize, seed: u32| {
            scramble_reversed(sobol::coordinate_reversed(index, 2 * pair + d), seed).reverse_bits()
        };
        [at(0, seeds as u32), at(1, (seeds >> 32) as u32)]
    }

    #[inline]
    fn shuffled(&self, index: u32) -> u32 {
        scramble(index, (self.key >> 32) as u32)
    }
}

/// The middle of the interval of width 2^-32 that starts at `x` 2^-32; in (0, 1).
#[inline]
#[must_use]
pub fn unit(x: u32) -> f64 {
    (f64::from(x) + 0.5) * STEP
}
