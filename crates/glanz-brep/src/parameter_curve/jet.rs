//! Taylor coefficients over an interval, in ball arithmetic.
//!
//! A [`Jet`] stands for a function f on [-1, 1]. Its coefficient k is a ball (a middle and a radius) that contains f^(k)(x) / k! for all
//! x in [-1, 1]; its middle is the value at 0, up to rounding. With Taylor's theorem,
//! `f(x) = sum of k < n of m_k x^k + r`, where `m_k` are the middles and `|r| <= |m_n| + r_n`. Sums and products of balls contain those of
//! their elements, so that this holds for every expression. Rounding is not contained; it is added at the end.
//!
//! A [`TaylorSeries`] has the middles alone, where nothing has to be proven.
//!
//! # Source
//! @moore2009 chapter 6 (recurrences for Taylor coefficients), in the arithmetic of middles and radii.

use std::ops::{Add, Mul, Sub};

/// Order of the last coefficient, from which the remainder is bounded.
pub(super) const ORDER: usize = 9;

/// A number for each order.
type Row = [f64; ORDER + 1];

/// Taylor coefficients at 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TaylorSeries(pub(super) Row);

/// Taylor coefficients of a function on [-1, 1]: all numbers at most a radius from a middle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jet {
    pub(super) middles: TaylorSeries,
    pub(super) radii: Row,
}

/// A function on [-1, 1] as its Taylor coefficients, with or without radii.
pub(super) trait Expansion:
    Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
    /// The polynomial with these coefficients of powers of x.
    fn polynomial(coefficients: &[f64]) -> Self;

    /// The product of two functions.
    fn times(&self, other: &Self) -> Self;

    /// `1 / f`.
    fn inverse(&self) -> Self;

    /// Whether the function is the constant 1.
    fn is_one(&self) -> bool;

    /// Adds a constant.
    fn add_constant(&mut self, value: f64);
}

fn combine(a: &Row, b: &Row, f: impl Fn(f64, f64) -> f64) -> Row {
    std::array::from_fn(|k| f(a[k], b[k]))
}

/// The number of coefficients up to the last that is not 0.
fn count(row: &Row) -> usize {
    row.iter().rposition(|value| *value != 0.0).map_or(0, |last| last + 1)
}

/// Adds the product of two series, of which `b` has `count` coefficients, to `sum`.
fn add_product(sum: &mut Row, a: &Row, b: &Row, count: usize) {
    // With constant numbers of steps, the loops are unrolled.
    for j in 0..=ORDER {
        if j == count {
            break;
        }
        for k in j..=ORDER {
            sum[k] += a[k - j] * b[j];
        }
    }
}

/// Coefficient k >= 1 of a quotient 1 / f times f(0), from those before it.
fn quotient(f: &Row, inverse: &Row, k: usize) -> f64 {
    -(1..=k).map(|j| f[j] * inverse[k - j]).sum::<f64>()
}

impl Expansion for TaylorSeries {
    fn polynomial(coefficients: &[f64]) -> Self {
        let mut series = Self::default();
        series.0.iter_mut().zip(coefficients).for_each(|(a, b)| *a = *b);
        series
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        // Arguments are often polynomials of a low degree.
        add_product(&mut product.0, &self.0, &other.0, count(&other.0));
        product
    }

    fn inverse(&self) -> Self {
        let mut inverse = Self::default();
        let first = 1.0 / self.0[0];
        inverse.0[0] = first;
        for k in 1..=ORDER {
            inverse.0[k] = first * quotient(&self.0, &inverse.0, k);
        }
        inverse
    }

    fn is_one(&self) -> bool {
        self.0[0] == 1.0 && count(&self.0) == 1
    }

    fn add_constant(&mut self, value: f64) {
        self.0[0] += value;
    }
}

impl Jet {
    /// The value at 0.
    pub(super) fn center(&self) -> f64 {
        self.middles.0[0]
    }

    /// The function less its value at 0.
    pub(super) fn centered(mut self) -> Self {
        self.middles.0[0] = 0.0;
        self
    }

    /// Bound on the distance of the values from that at 0.
    pub(super) fn spread(&self) -> f64 {
        self.radii[0]
    }

    /// Whether the function is the constant 0.
    pub(super) fn is_zero(&self) -> bool {
        count(&self.middles.0) == 0 && count(&self.radii) == 0
    }

    /// The largest absolute value of the coefficient of an order.
    pub(super) fn magnitude(&self, order: usize) -> f64 {
        self.middles.0[order].abs() + self.radii[order]
    }

    fn magnitudes(&self) -> Row {
        combine(&self.radii, &self.middles.0, |radius, middle| radius + middle.abs())
    }

    /// The sine and the cosine of f.
    pub(super) fn sin_cos(&self) -> [Self; 2] {
        let (mut sin, mut cos) = (Self::default(), Self::default());
        let [middles, magnitudes] = [self.middles.0, self.magnitudes()];
        (sin.middles.0[0], cos.middles.0[0]) = self.center().sin_cos();
        // The slopes are at most 1, and the values between -1 and 1.
        let radius = self.radii[0].min(2.0);
        (sin.radii[0], cos.radii[0]) = (radius, radius);
        for k in 1..=ORDER {
            for j in 1..=k {
                let share = j as f64 / k as f64;
                let (middle, radius) = (share * middles[j], share * self.radii[j]);
                sin.middles.0[k] += middle * cos.middles.0[k - j];
                cos.middles.0[k] -= middle * sin.middles.0[k - j];
                sin.radii[k] +=
                    share * magnitudes[j] * cos.radii[k - j] + radius * cos.middles.0[k - j].abs();
                cos.radii[k] +=
                    share * magnitudes[j] * sin.radii[k - j] + radius * sin.middles.0[k - j].abs();
            }
        }
        [sin, cos]
    }
}

impl Expansion for Jet {
    /// The derivative of order k over k! is `sum of binomial(j, k) a_j x^(j - k)`.
    fn polynomial(coefficients: &[f64]) -> Self {
        let mut jet = Self { middles: TaylorSeries::polynomial(coefficients), radii: Row::default() };
        for (k, radius) in jet.radii.iter_mut().enumerate() {
            let mut binomial = 1.0;
            for (j, a) in coefficients.iter().enumerate().skip(k + 1) {
                binomial *= j as f64 / (j - k) as f64;
                *radius += binomial * a.abs();
            }
        }
        jet
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self { middles: self.middles.times(&other.middles), radii: Row::default() };
        let of_middles = self.middles.0.map(f64::abs);
        add_product(&mut product.radii, &of_middles, &other.radii, count(&other.radii));
        let magnitudes = other.magnitudes();
        add_product(&mut product.radii, &self.radii, &magnitudes, count(&magnitudes));
        product
    }

    /// All numbers if f may be 0.
    fn inverse(&self) -> Self {
        let mut inverse = Self { middles: self.middles.inverse(), radii: Row::default() };
        let middle = self.center().abs();
        let least = middle - self.radii[0];
        if least.is_nan() || least <= 0.0 {
            return Self { middles: TaylorSeries::default(), radii: [f64::INFINITY; ORDER + 1] };
        }
        inverse.radii[0] = self.radii[0] / (middle * least);
        let magnitudes = self.magnitudes();
        for k in 1..=ORDER {
            // The sum is -f(0) times the middle of the coefficient, and is multiplied by the ball of 1 / f.
            let sum = quotient(&self.middles.0, &inverse.middles.0, k).abs();
            let radius: f64 = (1..=k)
                .map(|j| {
                    magnitudes[j] * inverse.radii[k - j] + self.radii[j] * inverse.middles.0[k - j].abs()
                })
                .sum();
            inverse.radii[k] = (sum + radius) * inverse.radii[0] + radius / middle;
        }
        inverse
    }

    fn is_one(&self) -> bool {
        self.middles.is_one() && count(&self.radii) == 0
    }

    fn add_constant(&mut self, value: f64) {
        self.middles.add_constant(value);
    }
}

impl Add for TaylorSeries {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(combine(&self.0, &other.0, |a, b| a + b))
    }
}

impl Sub for TaylorSeries {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(combine(&self.0, &other.0, |a, b| a - b))
    }
}

impl Mul<f64> for TaylorSeries {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|a| a * factor))
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            middles: self.middles + other.middles,
            radii: combine(&self.radii, &other.radii, |a, b| a + b),
        }
    }
}

impl Sub for Jet {
    type Output = Self;

    /// Radii add up here, too.
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { middles: self.middles * factor, radii: self.radii.map(|radius| radius * factor.abs()) }
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
            sin.times(&Jet::polynomial(&[3.0 + center / 2.0, 0.5 * reach]).inverse())
        };
        let whole = at(0.0, 1.0);
        for i in -10..=10 {
            // With a reach of almost nothing the coefficients are those at one point, scaled.
            let (x, reach) = (f64::from(i) / 10.0, 1e-2);
            let point = at(x, reach);
            for k in 0..=ORDER {
                let value = point.middles.0[k] / reach.powi(k as i32);
                let (middle, radius) = (whole.middles.0[k], whole.radii[k]);
                assert!(
                    (value - middle).abs() <= radius + 1e-12,
                    "order {k} at {x}: {value} {middle} {radius}"
                );
            }
        }
        let x: f64 = 0.7;
        let taylor = |n: usize| (0..n).map(|k| whole.middles.0[k] * x.powi(k as i32)).sum::<f64>();
        let value = (2.0 + x / 4.0 + x * x / 8.0).sin() / (3.0 + x / 2.0);
        assert!((value - taylor(ORDER)).abs() <= whole.magnitude(ORDER));
    }

    #[test]
    fn quotients_by_functions_with_a_zero_are_unbounded() {
        assert_eq!(Jet::polynomial(&[1.0, 1.5]).inverse().magnitude(0), f64::INFINITY);
    }
}
