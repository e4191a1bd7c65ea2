//! Interval arithmetic with outward rounding.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

/// A lower bound on the exact value that was rounded to `x`: at most the next number below.
///
/// |x| 2^-52 is at least the distance to the next number and the subtraction, as it is rounded, cannot come out above that
/// number; `MIN_POSITIVE` covers subnormal ones. It has no branch, unlike `next_down`, so that loops of it are fast.
fn down(x: f64) -> f64 {
    x - (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

/// An upper bound on the exact value that was rounded to `x`.
fn up(x: f64) -> f64 {
    x + (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

impl Interval {
    pub const ONE: Self = Self { low: 1.0, high: 1.0 };

    /// The one number `x`.
    pub const fn of(x: f64) -> Self {
        Self { low: x, high: x }
    }

    pub fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Bound on the distance from one end to the other.
    pub fn width(self) -> f64 {
        up(self.high - self.low)
    }

    /// Largest absolute value.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// All numbers within `radius` of one of these.
    pub fn widened(self, radius: f64) -> Self {
        Self { low: down(self.low - radius), high: up(self.high + radius) }
    }

    pub fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    pub fn overlaps(self, other: Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }

    pub fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The mean of two numbers; halving is exact.
    pub fn mean(self, other: Self) -> Self {
        Self { low: down((self.low + other.low) * 0.5), high: up((self.high + other.high) * 0.5) }
    }

    /// `self` at t = 0 and `other` at t = 1.
    pub fn blend(self, other: Self, t: Self) -> Self {
        (Self::ONE - t) * self + t * other
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { low: down(self.low + other.low), high: up(self.high + other.high) }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { low: down(self.low - other.high), high: up(self.high - other.low) }
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

impl Mul<f64> for Interval {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        let (a, b) = (self.low * factor, self.high * factor);
        Self { low: down(a.min(b)), high: up(a.max(b)) }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.low * other.low, self.low * other.high);
        let (c, d) = (self.high * other.low, self.high * other.high);
        Self { low: down(a.min(b).min(c.min(d))), high: up(a.max(b).max(c.max(d))) }
    }
}

impl Div for Interval {
    type Output = Self;
    /// All numbers if the divisor holds 0.
    fn div(self, other: Self) -> Self {
        if other.contains(0.0) {
            return Self { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let (a, b) = (self.low / other.low, self.low / other.high);
        let (c, d) = (self.high / other.low, self.high / other.high);
        Self { low: down(a.min(b).min(c.min(d))), high: up(a.max(b).max(c.max(d))) }
    }
}

#[test]
fn operations_hold_the_exact_result() {
    // Integers below 2^53 / 3 as numbers, their sums and products as i128.
    let mut random = super::rays::Random::new(1);
    for _ in 0..100_000 {
        let [a, b] = [(); 2].map(|()| random.between(-1e15, 1e15).round());
        let (x, y) = (Interval::of(a), Interval::of(b));
        let (i, j) = (a as i128, b as i128);
        // Floor and ceiling of the ends may be taken, since the results are integers.
        let holds = |z: Interval, exact: i128| {
            assert!(
                z.low.ceil() as i128 <= exact && exact <= z.high.floor() as i128,
                "{a} {b} {z:?} {exact}"
            );
        };
        holds(x + y, i + j);
        holds(x - y, i - j);
        holds(x * y, i * j);
        holds(x * b, i * j);
        holds(x.mean(y) + x.mean(y), i + j);
        // Times the divisor, a quotient must hold the dividend again.
        holds((x * y) / y, i);
        holds((-x).blend(y, Interval::of(2.0)), 2 * j + i);
        assert!((x * y).width() <= 4.0 * f64::EPSILON * (x * y).magnitude());
        assert!((x + y).width() <= 4.0 * f64::EPSILON * (x + y).magnitude());
    }
    for x in [1.0_f64, -1.0, 2.0, 1.0 - f64::EPSILON, 1e-310, -1e-310, 0.0, 1e300] {
        assert!(down(x) <= x.next_down() && up(x) >= x.next_up());
    }
}
