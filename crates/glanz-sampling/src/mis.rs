//! Weights of multiple importance sampling.
//!
//! Densities must share a measure. Where a density is infinite (a mirror, a point light), its strategy takes all;
//! where all vanish, the weight is 0: never NaN.
//!
//! # Source
//! @veach1995.

/// Weight of a sample drawn with density `own` where the other strategy has density `other`: own / (own + other).
#[inline]
#[must_use]
pub fn balance(own: f64, other: f64) -> f64 {
    weight(own, other, 1.0)
}

/// Weight of a sample drawn with density `own` where the other strategy has density `other`:
/// own^2 / (own^2 + other^2).
#[inline]
#[must_use]
pub fn power(own: f64, other: f64) -> f64 {
    let ratio = other / own;
    weight(own, other, ratio)
}

/// `1 / (1 + ratio * factor)` with the limits; squares are never formed, so nothing overflows.
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

/// Balance heuristic among many strategies: `own` over the sum of `own` and all `others`.
///
/// Densities are to be multiplied by their numbers of samples where these differ.
#[must_use]
pub fn balance_of(own: f64, others: &[f64]) -> f64 {
    among(own, others, |ratio| ratio)
}

/// Power heuristic (exponent 2) among many strategies.
#[must_use]
pub fn power_of(own: f64, others: &[f64]) -> f64 {
    among(own, others, |ratio| ratio * ratio)
}

fn among(own: f64, others: &[f64], shape: impl Fn(f64) -> f64) -> f64 {
    if own.is_nan() || own <= 0.0 {
        return 0.0;
    }
    if own == f64::INFINITY {
        let rivals = others.iter().filter(|&&p| p == f64::INFINITY).count();
        return 1.0 / (1.0 + rivals as f64);
    }
    1.0 / (1.0 + others.iter().map(|&p| shape(p / own)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_all_strategies_sum_to_one() {
        for (a, b) in [(1.0, 3.0), (1e-200, 1e200), (1e300, 1e300), (0.0, 2.0), (5e-324, 5e-324)] {
            assert!((balance(a, b) + balance(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
            assert!((power(a, b) + power(b, a) - 1.0).abs() < 1e-15, "{a} {b}");
        }
        let p = [0.2, 3.0, 1.0];
        let rest = [[3.0, 1.0], [0.2, 1.0], [0.2, 3.0]];
        assert!((p.iter().zip(&rest).map(|(&o, r)| balance_of(o, r)).sum::<f64>() - 1.0).abs() < 1e-15);
        assert!((p.iter().zip(&rest).map(|(&o, r)| power_of(o, r)).sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn values_are_those_of_the_definition() {
        assert_eq!(balance(1.0, 3.0), 0.25);
        assert!((power(1.0, 3.0) - 0.1).abs() < 1e-16);
        assert_eq!(balance_of(2.0, &[1.0, 1.0]), 0.5);
        assert!((power_of(2.0, &[1.0, 1.0]) - 4.0 / 6.0).abs() < 1e-15);
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
        assert_eq!(power_of(1.0, &[inf, 0.0]), 0.0);
        assert_eq!(power_of(inf, &[inf, 3.0]), 0.5);
        assert_eq!(balance_of(1.0, &[]), 1.0);
    }
}
