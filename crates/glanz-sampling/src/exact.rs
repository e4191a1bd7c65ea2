//! Sums that do not depend on the order or grouping of their terms.
//!
//! Floating-point addition rounds, so that the last bits of a sum depend on the order of its terms. Here every term is first
//! rounded to a multiple of a fixed quantum, and the multiples are added as integers, which do not round: any order, any split
//! into partial sums and any number of threads give the same bits. The limits below exclude overflow for up to [`MAX_TERMS`]
//! terms.
//!
//! | type | quantum | largest term | bits used by [`MAX_TERMS`] terms |
//! |---|---|---|---|
//! | [`WideSum`] | 2^-60 | 2^36 | 60 + 36 + 30 = 126 of 127 |
//! | [`SquareSum`] | 2^-88 | (2^36)^2 | 88 + 72 + 30 = 190 of 192 |
//! | [`NarrowSum`] | 2^-30 | 4 | 30 + 2 + 30 = 62 of 63 |
//!
//! An `f32` of magnitude 2^-37 or more is a multiple of 2^-60 already, so that a [`WideSum`] of radiance has no visible rounding;
//! larger terms are clamped to the largest, and reported as clamped by [`fits_wide`].

/// Largest number of terms of a sum: samples of one pixel.
pub const MAX_TERMS: u32 = 1 << 30;

/// Largest magnitude of a term of a [`WideSum`], 2^36; larger ones are clamped to it.
pub const WIDE_LIMIT: f64 = (1_u64 << 36) as f64;

/// Largest magnitude of a term of a [`NarrowSum`]; larger ones are clamped to it.
pub const NARROW_LIMIT: f64 = 4.0;

const WIDE_UNITS: f64 = (1_u64 << 60) as f64;
const SQUARE_UNITS: f64 = (1_u128 << 88) as f64;
const NARROW_UNITS: f64 = (1_u64 << 30) as f64;
const TWO_64: f64 = 18_446_744_073_709_551_616.0;

/// Whether `value` is added to a [`WideSum`] without clamping.
#[must_use]
pub fn fits_wide(value: f64) -> bool {
    value.abs() <= WIDE_LIMIT
}

/// Sum of values in units of 2^-60.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WideSum(i128);

impl WideSum {
    /// The sum of `value` alone, rounded to the quantum and clamped to [`WIDE_LIMIT`]; NaN counts as zero.
    #[inline]
    #[must_use]
    pub fn of(value: f64) -> Self {
        // Scaling by a power of two is exact, so that this rounds once.
        Self(nearest_integer(value.clamp(-WIDE_LIMIT, WIDE_LIMIT) * WIDE_UNITS))
    }

    /// Adds `value`, as [`WideSum::of`].
    pub fn add(&mut self, value: f64) {
        self.merge(Self::of(value));
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }

    /// The sum, rounded once.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / WIDE_UNITS
    }

    /// The integer as two words, low word first.
    #[must_use]
    pub fn to_words(self) -> [u64; 2] {
        let bits = self.0 as u128;
        [bits as u64, (bits >> 64) as u64]
    }

    /// The inverse of [`WideSum::to_words`].
    #[must_use]
    pub fn from_words(words: [u64; 2]) -> Self {
        Self((u128::from(words[0]) | (u128::from(words[1]) << 64)) as i128)
    }
}

/// Sum of squares in units of 2^-88.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SquareSum([u64; 3]);

impl SquareSum {
    /// Adds the square of `value`, rounded to the quantum; `value` is clamped to [`WIDE_LIMIT`], NaN counts as zero.
    ///
    /// The square of an `f32` is exact in `f64`; squares above 2^-40 are not rounded.
    pub fn add_square(&mut self, value: f32) {
        self.merge(Self::of_square(value));
    }

    /// The sum of the square of `value` alone, as [`SquareSum::add_square`].
    #[must_use]
    pub fn of_square(value: f32) -> Self {
        let value = f64::from(value);
        if value.is_nan() {
            return Self::default();
        }
        let cut = value.abs().min(WIDE_LIMIT);
        Self(to_limbs(cut * cut * SQUARE_UNITS))
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Self) {
        let mut carry = false;
        for (a, b) in self.0.iter_mut().zip(other.0) {
            let (sum, c1) = a.overflowing_add(b);
            let (sum, c2) = sum.overflowing_add(u64::from(carry));
            *a = sum;
            carry = c1 || c2;
        }
    }

    /// The sum, to within three roundings.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        let [low, middle, high] = self.0.map(|limb| limb as f64);
        ((high * TWO_64 + middle) * TWO_64 + low) / SQUARE_UNITS
    }

    /// The integer, low word first.
    #[must_use]
    pub fn to_words(self) -> [u64; 3] {
        self.0
    }

    /// The inverse of [`SquareSum::to_words`].
    #[must_use]
    pub fn from_words(words: [u64; 3]) -> Self {
        Self(words)
    }
}

/// The integer nearest to `units` (magnitude below 2^126), the even one of two; 0 for NaN. Faster than rounding and a cast, which are calls
/// without the instructions of newer processors.
fn nearest_integer(units: f64) -> i128 {
    const MANTISSA_BITS: u32 = 52;
    const WHOLE: f64 = (1_u64 << MANTISSA_BITS) as f64;
    if units.is_nan() || units.abs() < WHOLE {
        // The sum has no room for a fraction.
        let whole = WHOLE.copysign(units);
        return i128::from((units + whole - whole) as i64);
    }
    let bits = units.to_bits();
    let mantissa = i128::from((bits & ((1 << MANTISSA_BITS) - 1)) | (1 << MANTISSA_BITS));
    let shift = ((bits >> MANTISSA_BITS) as u32 & 0x7ff).saturating_sub(1023 + MANTISSA_BITS);
    let magnitude = mantissa << shift;
    if units < 0.0 { -magnitude } else { magnitude }
}

/// The integer nearest to `units` (>= 0, below 2^191) in base 2^64.
fn to_limbs(units: f64) -> [u64; 3] {
    const MANTISSA_BITS: u32 = 52;
    const WHOLE: f64 = (1_u64 << MANTISSA_BITS) as f64;
    if units < WHOLE {
        // The sum has no room for a fraction, as in `nearest_integer`.
        return [(units + WHOLE - WHOLE) as u64, 0, 0];
    }
    // From 2^52 on every f64 is an integer: its shifted mantissa.
    let bits = units.to_bits();
    let mantissa = u128::from((bits & ((1 << MANTISSA_BITS) - 1)) | (1 << MANTISSA_BITS));
    let shift = ((bits >> MANTISSA_BITS) as u32 & 0x7ff).saturating_sub(1023 + MANTISSA_BITS);
    let (limb, rest) = ((shift / 64) as usize, shift % 64);
    let shifted = mantissa << rest;
    let mut limbs = [0; 3];
    for (i, word) in [shifted as u64, (shifted >> 64) as u64].into_iter().enumerate() {
        if let Some(slot) = limbs.get_mut(limb + i) {
            *slot = word;
        }
    }
    limbs
}

/// Sum of values in [-4, 4] in units of 2^-30.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NarrowSum(i64);

impl NarrowSum {
    /// Adds `value`, rounded to the quantum and clamped to [`NARROW_LIMIT`]; NaN counts as zero.
    pub fn add(&mut self, value: f64) {
        let units = nearest_integer(value.clamp(-NARROW_LIMIT, NARROW_LIMIT) * NARROW_UNITS) as i64;
        self.0 = self.0.wrapping_add(units);
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }

    /// The sum, rounded once.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / NARROW_UNITS
    }

    /// The integer as a word.
    #[must_use]
    pub fn to_word(self) -> u64 {
        self.0 as u64
    }

    /// The inverse of [`NarrowSum::to_word`].
    #[must_use]
    pub fn from_word(word: u64) -> Self {
        Self(word as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nearest_integer_is_that_of_rounding_and_cast() {
        let edges = [0.0, 0.5, 1.5, 2.5, 0.499_999_999_999_999_94, 4_503_599_627_370_495.5, f64::NAN];
        let bits = (0..100_000).map(|i| crate::hash::combine(3, i));
        let random = bits.map(|bits| f64::from_bits(bits >> 12 | (1023 - 60 + bits % 180) << 52));
        for value in edges.into_iter().chain(random) {
            for units in [value, -value] {
                assert_eq!(nearest_integer(units), units.round_ties_even() as i128, "{units:e}");
            }
            let magnitude = value.abs().round_ties_even() as u128;
            if value.is_finite() {
                let limbs = [magnitude as u64, (magnitude >> 64) as u64, 0];
                assert_eq!(to_limbs(value.abs()), limbs, "{value:e}");
            }
        }
    }

    /// Decomposes `value` into mantissa and exponent: value = mantissa * 2^exponent.
    fn decompose(value: f32) -> (i128, i32) {
        let bits = value.to_bits();
        let exponent = (bits >> 23 & 0xff) as i32;
        let fraction = i128::from(bits & 0x7f_ffff);
        let (mantissa, exponent) =
            if exponent == 0 { (fraction, -149) } else { (fraction | 1 << 23, exponent - 150) };
        (if value < 0.0 { -mantissa } else { mantissa }, exponent)
    }

    /// Rounds mantissa * 2^exponent to an integer, ties to even, in integers only.
    fn rounded(mantissa: i128, exponent: i32) -> i128 {
        if exponent >= 0 {
            return mantissa << exponent;
        }
        let shift = (-exponent).min(126) as u32;
        let floor = mantissa >> shift;
        let rest = mantissa - (floor << shift);
        let half = 1_i128 << (shift - 1);
        if rest > half || (rest == half && floor & 1 == 1) { floor + 1 } else { floor }
    }

    fn any_term() -> impl Strategy<Value = f32> {
        // All binary magnitudes from far below the quantum to the limit, both signs.
        (-80.0_f32..35.9, any::<bool>()).prop_map(|(e, negative)| if negative { -e.exp2() } else { e.exp2() })
    }

    proptest! {
        #[test]
        fn wide_sum_is_the_integer_sum_of_rounded_terms(terms in prop::collection::vec(any_term(), 0..200)) {
            let expected: i128 = terms.iter().map(|&t| { let (m, e) = decompose(t); rounded(m, e + 60) }).sum();
            let mut sum = WideSum::default();
            terms.iter().for_each(|&t| sum.add(f64::from(t)));
            prop_assert_eq!(sum.0, expected);
            prop_assert_eq!(WideSum::from_words(sum.to_words()), sum);
        }

        #[test]
        fn sums_do_not_depend_on_grouping(
            terms in prop::collection::vec(any_term(), 1..200),
            cuts in prop::collection::vec(0_usize..200, 0..6),
            rotate in 0_usize..200,
        ) {
            let mut whole = (WideSum::default(), SquareSum::default(), NarrowSum::default());
            for &t in &terms {
                whole.0.add(f64::from(t));
                whole.1.add_square(t);
                whole.2.add(f64::from(t));
            }
            let mut shuffled = terms.clone();
            shuffled.rotate_left(rotate % terms.len());
            let mut cuts: Vec<_> = cuts.into_iter().map(|c| c % terms.len()).collect();
            cuts.push(terms.len());
            cuts.sort_unstable();
            let (mut merged, mut start) = ((WideSum::default(), SquareSum::default(), NarrowSum::default()), 0);
            for end in cuts {
                let mut part = (WideSum::default(), SquareSum::default(), NarrowSum::default());
                for &t in &shuffled[start..end] {
                    part.0.add(f64::from(t));
                    part.1.add_square(t);
                    part.2.add(f64::from(t));
                }
                start = end;
                merged.0.merge(part.0);
                merged.1.merge(part.1);
                merged.2.merge(part.2);
            }
            prop_assert_eq!(merged, whole);
        }

        #[test]
        fn square_sum_is_the_integer_sum_of_rounded_squares(terms in prop::collection::vec(-14.0_f32..14.0, 0..100)) {
            // Up to 2^14 and 88 fraction bits a sum of 100 squares stays below 2^124: i128 can check it.
            let terms: Vec<f32> = terms.iter().map(|e| if *e < 0.0 { -e.exp2() } else { e.exp2() }).collect();
            let expected: i128 = terms.iter().map(|&t| {
                let (m, e) = decompose(t);
                rounded(m * m, 2 * e + 88)
            }).sum();
            let mut sum = SquareSum::default();
            terms.iter().for_each(|&t| sum.add_square(t));
            let words = sum.to_words();
            prop_assert_eq!(words[2], 0);
            prop_assert_eq!((u128::from(words[0]) | u128::from(words[1]) << 64) as i128, expected);
        }
    }

    #[test]
    fn the_largest_number_of_largest_terms_does_not_overflow() {
        let mut wide = WideSum::default();
        wide.add(-1e300);
        let mut square = SquareSum::default();
        square.add_square(f32::MAX);
        let mut narrow = NarrowSum::default();
        narrow.add(f64::INFINITY);
        for _ in 0..30 {
            wide.merge(wide);
            square.merge(square);
            narrow.merge(narrow);
        }
        assert_eq!(wide.to_f64(), -(66.0_f64.exp2()));
        assert_eq!(square.to_f64(), 102.0_f64.exp2());
        assert_eq!(narrow.to_f64(), 32.0_f64.exp2());
    }

    #[test]
    fn tiny_terms_survive_beside_huge_ones() {
        let mut sum = WideSum::default();
        sum.add(WIDE_LIMIT);
        sum.add(f64::from(f32::powi(2.0, -60)));
        sum.add(-WIDE_LIMIT);
        assert_eq!(sum.to_f64(), (-60.0_f64).exp2());
    }

    #[test]
    fn nan_counts_as_zero() {
        let (mut wide, mut square, mut narrow) =
            (WideSum::default(), SquareSum::default(), NarrowSum::default());
        wide.add(f64::NAN);
        square.add_square(f32::NAN);
        narrow.add(f64::NAN);
        assert_eq!((wide.to_f64(), square.to_f64(), narrow.to_f64()), (0.0, 0.0, 0.0));
    }
}
