//! Taylor coefficients over an interval, in ball arithmetic.
//!
//! A [`Jet`] stands for a function f on [-1, 1]. Its coefficient k is a ball (a middle and a radius) that contains f^(k)(x) / k! for all
//! x in [-1, 1]; its middle is the value at 0, up to rounding. With Taylor's theorem,
//! `f(x) = sum of k < n of m_k x^k + r`, where `m_k` are the middles and `|r| <= |m_n| + r_n`. Sums and products of balls contain those of
//! their elements, so that this holds for every expression. Rounding is not contained; it is added at the end.
//!
//! # Source
//! @moore2009 chapter 6 (recurrences for Taylor coefficients), in the arithmetic of middles and radii.

use std::ops::{Add, Mul, Sub};

/// Order of the last coefficient, from which the remainder is bounded.
pub(super) const ORDER: usize = 9;

/// All numbers at most `radius` from `middle`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ball {
    pub(super) middle: f64,
    pub(super) radius: f64,
}

impl Ball {
    fn exact(middle: f64) -> Self {
        Self { middle, radius: 0.0 }
    }

    /// The largest absolute value.
    pub(super) fn magnitude(self) -> f64 {
        self.middle.abs() + self.radius
    }

    /// The inverses; all numbers if 0 is among these.
    fn inverse(self) -> Self {
        let least = self.middle.abs() - self.radius;
        if least.is_nan() || least <= 0.0 {
            return Self { middle: 0.0, radius: f64::INFINITY };
        }
        Self { middle: 1.0 / self.middle, radius: self.radius / (self.middle.abs() * least) }
    }

    /// Sines and cosines, whose slopes are at most 1.
    fn sin_cos(self) -> [Self; 2] {
        let (sin, cos) = self.middle.sin_cos();
        let radius = self.radius.min(2.0);
        [Self { middle: sin, radius }, Self { middle: cos, radius }]
    }
}

impl Add for Ball {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { middle: self.middle + other.middle, radius: self.radius + other.radius }
    }
}

impl Sub for Ball {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { middle: self.middle - other.middle, radius: self.radius + other.radius }
    }
}

impl Mul for Ball {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let radius = self.middle.abs() * other.radius + self.radius * other.magnitude();
        Self { middle: self.middle * other.middle, radius }
    }
}

impl Mul<f64> for Ball {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { middle: self.middle * factor, radius: self.radius * factor.abs() }
    }
}

/// Taylor coefficients of a function on [-1, 1].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jet(pub(super) [Ball; ORDER + 1]);

impl Jet {
    /// A constant.
    pub(super) fn constant(value: f64) -> Self {
        let mut jet = Self::default();
        jet.0[0] = Ball::exact(value);
        jet
    }

    /// The polynomial with these coefficients of powers of x. The derivative of order k over k! is
    /// `sum of binomial(j, k) a_j x^(j - k)`.
    pub(super) fn polynomial(coefficients: &[f64]) -> Self {
        let mut jet = Self::default();
        for (k, ball) in jet.0.iter_mut().enumerate() {
            let mut binomial = 1.0;
            for (j, a) in coefficients.iter().enumerate().skip(k) {
                if j == k {
                    ball.middle = *a;
                } else {
                    binomial *= j as f64 / (j - k) as f64;
                    ball.radius += binomial * a.abs();
                }
            }
        }
        jet
    }

    /// The value at 0.
    pub(super) fn center(&self) -> f64 {
        self.0[0].middle
    }

    /// The function less its value at 0.
    pub(super) fn centered(mut self) -> Self {
        self.0[0].middle = 0.0;
        self
    }

    /// Bound on the distance of the values from that at 0.
    pub(super) fn spread(&self) -> f64 {
        self.0[0].radius
    }

    /// `1 / f`.
    pub(super) fn inverse(&self) -> Self {
        let mut jet = Self::default();
        let first = self.0[0].inverse();
        jet.0[0] = first;
        for k in 1..=ORDER {
            let sum = (1..=k).fold(Ball::default(), |sum, j| sum + self.0[j] * jet.0[k - j]);
            jet.0[k] = first * sum * -1.0;
        }
        jet
    }

    /// The sine and the cosine of f.
    pub(super) fn sin_cos(&self) -> [Self; 2] {
        let (mut sin, mut cos) = (Self::default(), Self::default());
        [sin.0[0], cos.0[0]] = self.0[0].sin_cos();
        for k in 1..=ORDER {
            let (mut s, mut c) = (Ball::default(), Ball::default());
            for j in 1..=k {
                let slope = self.0[j] * (j as f64 / k as f64);
                s = s + slope * cos.0[k - j];
                c = c - slope * sin.0[k - j];
            }
            (sin.0[k], cos.0[k]) = (s, c);
        }
        [sin, cos]
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = *a + b);
        self
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = *a - b);
        self
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(mut self, factor: f64) -> Self {
        self.0.iter_mut().for_each(|a| *a = *a * factor);
        self
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let mut jet = Self::default();
        // Arguments are often polynomials of a low degree.
        let last = other.0.iter().rposition(|ball| *ball != Ball::default()).unwrap_or(0);
        for k in 0..=ORDER {
            let from = k.saturating_sub(last);
            jet.0[k] = (from..=k).fold(Ball::default(), |sum, j| sum + self.0[j] * other.0[k - j]);
        }
        jet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of which all derivatives are known: `e^x = e^(-1) e^(x + 1)` has none here, so sines and quotients.
    #[test]
    fn coefficients_contain_the_derivatives() {
        // sin(2 + x / 4 + x^2 / 8) / (3 + x / 2), differentiated by differences of the recurrence at other centres.
        let at = |center: f64, reach: f64| {
            let shifted = [
                2.0 + center / 4.0 + center * center / 8.0,
                (0.25 + center / 4.0) * reach,
                reach * reach / 8.0,
            ];
            let [sin, _] = Jet::polynomial(&shifted).sin_cos();
            sin * Jet::polynomial(&[3.0 + center / 2.0, 0.5 * reach]).inverse()
        };
        let whole = at(0.0, 1.0);
        for i in -10..=10 {
            // With a reach of almost nothing the coefficients are those at one point, scaled.
            let (x, reach) = (f64::from(i) / 10.0, 1e-2);
            let point = at(x, reach);
            for k in 0..=ORDER {
                let value = point.0[k].middle / reach.powi(k as i32);
                let ball = whole.0[k];
                assert!(
                    (value - ball.middle).abs() <= ball.radius + 1e-12,
                    "order {k} at {x}: {value} {ball:?}"
                );
            }
        }
        let x: f64 = 0.7;
        let taylor = |n: usize| (0..n).map(|k| whole.0[k].middle * x.powi(k as i32)).sum::<f64>();
        let value = (2.0 + x / 4.0 + x * x / 8.0).sin() / (3.0 + x / 2.0);
        assert!((value - taylor(ORDER)).abs() <= whole.0[ORDER].magnitude());
    }

    #[test]
    fn quotients_by_functions_with_a_zero_are_unbounded() {
        assert_eq!(Jet::polynomial(&[1.0, 1.5]).inverse().0[0].magnitude(), f64::INFINITY);
    }
}
