//! Weights of multiple importance sampling.
//!
//! All densities must have the same measure. An infinite density (a mirror, a point light) gives its strategy the weight 1; if all
//! densities are zero, the weight is 0: the result is never NaN.
//!
//! # Source
//! @veach1995.

/// The balance heuristic: own / (own + other), for a sample drawn with density `own` and the density `other` of the other
/// strategy.
#[inline]
#[must_use]
pub fn balance(own: f64, other: f64) -> f64 {
    weight(own, other, 1.0)
}

/// The power heuristic: own^2 / (own^2 + other^2), for a sample drawn with density `own` and the density `other` of the other
/// strategy.
#[inline]
#[must_use]
pub fn power(own: f64, other: f64) -> f64 {
    let ratio = other / own;
    weight(own, other, ratio)
}

/// `1 / (1 + other / own * factor)` with its limits; squares are never formed, so that nothing overflows.
#[inline]
fn weight(own: f64, other: f64, factor: f64) -> f64 {
    if own.is_nan() || own <= 0.0 {
        return 0.0;
    }
    if own == f64::INFINITY {
        return if other == f64::INFINITY { 0.5 } else { 1.0 };
    }
    1.0 / (1.0 + other / own * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_both_strategies_sum_to_one() {
        for (a, b) in [(1.0, 3.0), (1e-200, 1e200), (1e300, 1e300), (0.0, 2.0), (5e-324, 5e-324)] {
            assert!((balance(a, b) + balance(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
            assert!((power(a, b) + power(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
        }
    }

    #[test]
    fn values_are_those_of_the_definition() {
        assert_eq!(balance(1.0, 3.0), 0.25);
        assert!((power(1.0, 3.0) - 0.1).abs() < 1e-16);
    }

    #[test]
    fn zero_and_infinite_densities_never_give_nan() {
        let inf = f64::INFINITY;
        for f in [balance, power] {
            assert_eq!(f(0.0, 0.0), 0.0);
            assert_eq!(f(inf, 1.0), 1.0);
            assert_eq!(f(1.0, inf), 0.0);
            assert_eq!(f(inf, inf), 0.5);
            assert_eq!(f(f64::NAN, 1.0), 0.0);
        }
    }
}
