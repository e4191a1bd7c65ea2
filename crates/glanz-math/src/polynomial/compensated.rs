//! Values of polynomials with error bounds, in working precision and in twice the working precision.

use crate::rounding::{UNIT_ROUNDOFF, gamma};

/// A number together with a bound on its distance from the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The computed number.
    pub value: f64,
    /// Bound on |value - exact|, >= 0.
    pub error: f64,
}

impl Bounded {
    /// 1 or -1 if the sign of the exact number is certain, otherwise 0.
    #[must_use]
    pub fn sign(self) -> i8 {
        if self.value > self.error {
            1
        } else if self.value < -self.error {
            -1
        } else {
            0
        }
    }
}

/// `a + b` as a rounded sum and the exact remainder.
///
/// # Source
/// @knuth1997 section 4.2.2, theorem B.
#[must_use]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// `a b` as a rounded product and the exact remainder, for magnitudes between about 1e-140 and 1e150.
///
/// # Source
/// @dekker1971; with a fused product on machines that have one.
#[must_use]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    #[cfg(target_feature = "fma")]
    {
        (product, a.mul_add(b, -product))
    }
    #[cfg(not(target_feature = "fma"))]
    {
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        (product, a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2))
    }
}

/// Splits `a` into the upper and the lower half of its digits.
#[cfg(not(target_feature = "fma"))]
fn split(a: f64) -> (f64, f64) {
    // 2^27 + 1: half of the 53 digits, rounded up.
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

/// The value of `sum c_i t^i` (`coefficients` in ascending order).
#[must_use]
pub fn value(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |y, &c| y * t + c)
}

/// The value of `sum c_i t^i` by Horner's rule with a running bound on its rounding error.
///
/// # Source
/// @higham2002 algorithm 5.1.
#[must_use]
pub fn horner(coefficients: &[f64], t: f64) -> Bounded {
    let size = t.abs();
    let (mut y, mut bound) = (0.0_f64, 0.0_f64);
    for &c in coefficients.iter().rev() {
        y = y * t + c;
        bound = bound * size + y.abs();
    }
    // Instead of 2 bound - |y| as in the source, with the 2 rounded up for the roundings of the bound.
    Bounded { value: y, error: UNIT_ROUNDOFF * (2.0 + 64.0 * f64::EPSILON) * bound }
}

/// Value (with bound, as [`horner`]) and derivative of `sum c_i t^i`.
#[must_use]
pub fn horner_with_slope(coefficients: &[f64], t: f64) -> (Bounded, f64) {
    let size = t.abs();
    let (mut y, mut slope, mut bound) = (0.0_f64, 0.0_f64, 0.0_f64);
    for &c in coefficients.iter().rev() {
        slope = slope * t + y;
        y = y * t + c;
        bound = bound * size + y.abs();
    }
    (Bounded { value: y, error: UNIT_ROUNDOFF * (2.0 + 64.0 * f64::EPSILON) * bound }, slope)
}

/// The value of `sum c_i t^i` as if computed with twice the digits and rounded once.
///
/// The bound includes the rounding errors of the correction term: the sum of the moduli of all remainders times `gamma(4 n + 8)`
/// for the degree n, which is theorem 4 of the source with a margin for the roundings of the bound.
///
/// # Source
/// @graillat2009 algorithm 7.
#[must_use]
pub fn compensated_horner(coefficients: &[f64], t: f64) -> Bounded {
    let size = t.abs();
    let (mut y, mut correction, mut remainders) = (0.0_f64, 0.0_f64, 0.0_f64);
    for &c in coefficients.iter().rev() {
        let (product, e) = two_product(y, t);
        let (sum, f) = two_sum(product, c);
        y = sum;
        correction = correction * t + (e + f);
        remainders = remainders * size + (e.abs() + f.abs());
    }
    let value = y + correction;
    let steps = u32::try_from(coefficients.len()).unwrap_or(u32::MAX / 8);
    Bounded { value, error: UNIT_ROUNDOFF * value.abs() + gamma(4 * steps + 4) * remainders }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_with_their_remainders_are_exact() {
        // 1 + 2^-60 and (1 + 2^-30)^2 = 1 + 2^-29 + 2^-60 need more digits than one number has.
        assert_eq!(two_sum(1.0, 2.0_f64.powi(-60)), (1.0, 2.0_f64.powi(-60)));
        let a = 1.0 + 2.0_f64.powi(-30);
        assert_eq!(two_product(a, a), (1.0 + 2.0_f64.powi(-29), 2.0_f64.powi(-60)));
    }

    #[test]
    fn value_next_to_a_triple_root_keeps_its_digits_when_compensated() {
        // (t - 1)^3 at 1 + d is d^3; d = 2^-20 makes everything representable.
        let (c, d) = ([-1.0, 3.0, -3.0, 1.0], 2.0_f64.powi(-20));
        let exact = d.powi(3);
        let plain = horner(&c, 1.0 + d);
        let fine = compensated_horner(&c, 1.0 + d);
        assert!((plain.value - exact).abs() <= plain.error);
        assert_eq!(plain.sign(), 0);
        assert!((fine.value - exact).abs() <= fine.error);
        assert!((fine.value - exact).abs() <= 1e-15 * exact);
        assert_eq!(fine.sign(), 1);
        assert_eq!(compensated_horner(&c, 1.0 - d).sign(), -1);
    }

    #[test]
    fn slope_is_that_of_the_polynomial() {
        // t^4 - 2 t at 3: 75, slope 4 27 - 2 = 106.
        let (y, slope) = horner_with_slope(&[0.0, -2.0, 0.0, 0.0, 1.0], 3.0);
        assert_eq!((y.value, slope), (75.0, 106.0));
    }
}
