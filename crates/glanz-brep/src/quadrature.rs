//! Integrals over ranges of a parameter, by rules that are halved until they hold.

use std::ops::{Add, Mul};

/// Nodes in [-1, 1] and weights of the Gauss-Legendre rule of eight points; symmetric.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Deepest halving of a range.
pub(crate) const MAX_DEPTH: u32 = 14;

/// A value that is integrated.
pub(crate) trait Integral: Copy + Default + Add<Output = Self> + Mul<f64, Output = Self> {
    /// The number by which it is judged whether an integral holds.
    fn magnitude(self) -> f64;
}

impl Integral for f64 {
    fn magnitude(self) -> f64 {
        self
    }
}

/// The integral of `f` by one rule of eight points, exact for polynomials up to degree 15.
pub(crate) fn gauss<T: Integral>([a, b]: [f64; 2], f: impl Fn(f64) -> T) -> T {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    GAUSS.iter().fold(T::default(), |sum, &(node, weight)| {
        sum + (f(middle - half * node) + f(middle + half * node)) * (weight * half)
    })
}

/// The integral by `rule`, of which `whole` is that over the range, halved at most `depth` times until it changes by at most `tolerance`.
pub(crate) fn refined<T: Integral>(
    rule: &impl Fn([f64; 2]) -> T,
    [a, b]: [f64; 2],
    whole: T,
    tolerance: f64,
    depth: u32,
) -> T {
    let middle = 0.5 * (a + b);
    let halves = [[a, middle], [middle, b]];
    let [low, high] = halves.map(rule);
    let better = low + high;
    let change = (better.magnitude() - whole.magnitude()).abs();
    if depth == 0 || change <= tolerance || change.is_nan() {
        return better;
    }
    refined(rule, halves[0], low, 0.5 * tolerance, depth - 1)
        + refined(rule, halves[1], high, 0.5 * tolerance, depth - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_is_exact_up_to_degree_15_and_halved_beyond() {
        let power = |n: i32| move |x: f64| x.powi(n);
        assert!((gauss([0.0, 2.0], power(15)) - 4096.0).abs() < 1e-9);
        assert!((gauss([0.0, 2.0], power(30)) * 31.0 / 2f64.powi(31) - 1.0).abs() > 1e-9);
        let rule = |range: [f64; 2]| gauss(range, f64::sqrt);
        let found = refined(&rule, [0.0, 1.0], rule([0.0, 1.0]), 1e-9, MAX_DEPTH);
        assert!((found - 2.0 / 3.0).abs() < 1e-8 && (rule([0.0, 1.0]) - 2.0 / 3.0).abs() > 1e-5);
    }
}
