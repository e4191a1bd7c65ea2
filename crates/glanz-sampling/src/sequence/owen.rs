//! Nested uniform (Owen) scrambling by hashing.

use crate::hash::mix64;
use crate::sequence::sobol;

/// 2^-32.
const STEP: f64 = 1.0 / (1_u64 << 32) as f64;

/// Scrambles a *bit-reversed* 32-bit fraction: each bit is flipped depending on a hash of `seed` and of the more significant bits
/// (before reversal). The result is reversed too.
///
/// `seed` should be the output of a good hash.
///
/// # Source
/// @laine2011 introduced the construction, @burley2020 its use for Sobol' points; the constants are those of
/// @vegdahl2021.
#[inline]
#[must_use]
pub fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    // Multiplication carries information only upwards, towards bits that were less significant.
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Nested uniform scrambling of a 32-bit fraction.
///
/// Applied to an index, it is a shuffle that keeps every aligned block of 2^k indices together: prefixes of a shuffled digital
/// sequence are still nets.
#[inline]
#[must_use]
pub fn scramble(x: u32, seed: u32) -> u32 {
    scramble_reversed(x.reverse_bits(), seed).reverse_bits()
}

/// A scrambled and shuffled copy of the four-dimensional Sobol' sequence, identified by a key.
///
/// Copies with different keys are practically independent, so that several of them make a sequence of any dimension ("padding").
///
/// # Source
/// @burley2020 section 3.
#[derive(Clone, Copy, Debug)]
pub struct ScrambledSobol {
    key: u64,
}

impl ScrambledSobol {
    /// The copy with the given key.
    #[inline]
    #[must_use]
    pub const fn new(key: u64) -> Self {
        Self { key }
    }

    /// Coordinate `dimension` (0 to 3) of a point, in units of 2^-32; `reversed_index` is its index with reversed bits
    /// ([`u32::reverse_bits`]).
    #[inline]
    #[must_use]
    pub fn coordinate(&self, reversed_index: u32, dimension: usize) -> u32 {
        let seeds = self.seeds(dimension / 2);
        let seed = if dimension & 1 == 0 { seeds } else { seeds >> 32 } as u32;
        self.scrambled(self.shuffled(reversed_index), dimension, seed)
    }

    /// Coordinates 0 and 1 (`pair` 0) or 2 and 3 (any other `pair`) of a point, in units of 2^-32; `reversed_index` as in
    /// [`ScrambledSobol::coordinate`].
    ///
    /// Pair 0 is a scrambled (0, 2)-sequence. Pair 1 alone is worse (errors of smooth integrands are up to 60 %, of discontinuous
    /// ones a third larger). But pairs of different copies are independent, while the four coordinates of one copy are jointly
    /// well distributed: with 64 points the error of a product of discontinuous functions of both pairs is half of that with
    /// two copies.
    #[inline]
    #[must_use]
    pub fn pair(&self, reversed_index: u32, pair: usize) -> [u32; 2] {
        let [a, b, c, d] = sobol::point_reversed(self.shuffled(reversed_index));
        if pair == 0 { scrambled_pair([a, b], self.seeds(0)) } else { scrambled_pair([c, d], self.seeds(1)) }
    }

    /// All coordinates of a point, in units of 2^-32; `reversed_index` as in [`ScrambledSobol::coordinate`].
    #[inline]
    #[must_use]
    pub fn point(&self, reversed_index: u32) -> [u32; 4] {
        let [a, b, c, d] = sobol::point_reversed(self.shuffled(reversed_index));
        let [first, second] = [self.seeds(0), self.seeds(1)];
        let [a, b] = scrambled_pair([a, b], first);
        let [c, d] = scrambled_pair([c, d], second);
        [a, b, c, d]
    }

    /// The seeds of both coordinates of a pair.
    #[inline]
    fn seeds(&self, pair: usize) -> u64 {
        // A difference of one bit is enough for a good hash.
        mix64(self.key ^ (1 + pair as u64))
    }

    #[inline]
    fn shuffled(&self, reversed_index: u32) -> u32 {
        scramble_reversed(reversed_index, (self.key >> 32) as u32)
    }

    #[inline]
    fn scrambled(&self, reversed_index: u32, dimension: usize, seed: u32) -> u32 {
        scramble_reversed(sobol::coordinate_reversed(reversed_index, dimension), seed).reverse_bits()
    }
}

/// Two bit-reversed coordinates, scrambled by the halves of `seeds`, in their usual order of bits.
#[inline]
fn scrambled_pair([x, y]: [u32; 2], seeds: u64) -> [u32; 2] {
    let x = scramble_reversed(x, seeds as u32);
    let y = scramble_reversed(y, (seeds >> 32) as u32);
    // At once: to reverse 64 bits costs no more than 32.
    let both = (u64::from(x) << 32 | u64::from(y)).reverse_bits();
    [both as u32, (both >> 32) as u32]
}

/// The middle of the interval of width 2^-32 that starts at `x` 2^-32; in (0, 1).
#[inline]
#[must_use]
pub fn unit(x: u32) -> f64 {
    (f64::from(x) + 0.5) * STEP
}
