//! Bernstein coefficients in two parameters.

use std::ops::{Add, Mul, Sub};

/// Coefficients of a tensor product polynomial, index `i * (degree_v + 1) + j`.
#[derive(Clone, Debug)]
pub(super) struct Net<T> {
    degrees: (usize, usize),
    values: Vec<T>,
}

/// A type of coefficients.
pub(super) trait Coefficient:
    Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
}

impl<T> Coefficient for T where T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T> {}

impl<T: Coefficient> Net<T> {
    pub(super) fn new(degrees: (usize, usize), values: Vec<T>) -> Self {
        Self { degrees, values }
    }

    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    fn get(&self, i: usize, j: usize) -> T {
        self.values.get(i * (self.degrees.1 + 1) + j).copied().unwrap_or_default()
    }

    fn from_fn(degrees: (usize, usize), value: impl Fn(usize, usize) -> T) -> Self {
        let values = (0..=degrees.0).flat_map(|i| (0..=degrees.1).map(move |j| (i, j)));
        Self { degrees, values: values.map(|(i, j)| value(i, j)).collect() }
    }

    pub(super) fn map<U: Coefficient>(&self, f: impl Fn(T) -> U) -> Net<U> {
        Net { degrees: self.degrees, values: self.values.iter().map(|&value| f(value)).collect() }
    }

    /// The derivative by the first or the second parameter; 0 for degree 0.
    pub(super) fn derivative(&self, first: bool) -> Self {
        let (p, q) = self.degrees;
        if first {
            Self::from_fn((p.saturating_sub(1), q), |i, j| {
                if p == 0 { T::default() } else { (self.get(i + 1, j) - self.get(i, j)) * p as f64 }
            })
        } else {
            Self::from_fn((p, q.saturating_sub(1)), |i, j| {
                if q == 0 { T::default() } else { (self.get(i, j + 1) - self.get(i, j)) * q as f64 }
            })
        }
    }

    /// The largest derivative by a parameter, measured by `size`.
    pub(super) fn steepest(&self, first: bool, size: impl Fn(T) -> f64) -> f64 {
        self.derivative(first).values.iter().fold(0.0, |most, &value| most.max(size(value)))
    }

    /// The product with another polynomial.
    ///
    /// # Source
    /// @farin2002: B_i^m B_k^n = binomial(m, i) binomial(n, k) / binomial(m + n, i + k) B_(i + k)^(m + n).
    pub(super) fn product<U: Coefficient, V: Coefficient>(
        &self,
        other: &Net<U>,
        times: impl Fn(T, U) -> V,
    ) -> Net<V> {
        let ((p, q), (r, s)) = (self.degrees, other.degrees);
        let share =
            |m: usize, i: usize, n: usize, k: usize| binomial(m, i) * binomial(n, k) / binomial(m + n, i + k);
        Net::from_fn((p + r, q + s), |i, j| {
            let mut sum = V::default();
            for a in i.saturating_sub(r)..=i.min(p) {
                for b in j.saturating_sub(s)..=j.min(q) {
                    let factor = share(p, a, r, i - a) * share(q, b, s, j - b);
                    sum = sum + times(self.get(a, b), other.get(i - a, j - b)) * factor;
                }
            }
            sum
        })
    }

    /// The difference from a polynomial of the same degrees.
    pub(super) fn minus(&self, other: &Self) -> Self {
        Self::from_fn(self.degrees, |i, j| self.get(i, j) - other.get(i, j))
    }

    /// The coefficients over the quarters of the unit square: low and high first parameter in turn, low second before high.
    pub(super) fn quarters(&self) -> [Self; 4] {
        let [low, high] = self.halves(true);
        let ([a, c], [b, d]) = (low.halves(false), high.halves(false));
        [a, b, c, d]
    }

    /// De Casteljau's subdivision in the middle.
    fn halves(&self, first: bool) -> [Self; 2] {
        let (p, q) = self.degrees;
        let (degree, lines) = if first { (p, q) } else { (q, p) };
        let (mut low, mut high) = (self.clone(), self.clone());
        let stride = q + 1;
        let index = |k: usize, line: usize| if first { k * stride + line } else { line * stride + k };
        for line in 0..=lines {
            let mut row: Vec<T> =
                (0..=degree).map(|k| if first { self.get(k, line) } else { self.get(line, k) }).collect();
            for step in 0..=degree {
                let ends = (row.first().copied(), row.last().copied());
                if let (Some(slot), Some(value)) = (low.values.get_mut(index(step, line)), ends.0) {
                    *slot = value;
                }
                if let (Some(slot), Some(value)) = (high.values.get_mut(index(degree - step, line)), ends.1) {
                    *slot = value;
                }
                row = row.windows(2).map(|pair| (pair[0] + pair[1]) * 0.5).collect();
            }
        }
        [low, high]
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k.min(n - k)).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eval(net: &Net<f64>, u: f64, v: f64) -> f64 {
        let (p, q) = net.degrees;
        let basis =
            |n: usize, i: usize, t: f64| binomial(n, i) * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32);
        (0..=p)
            .flat_map(|i| (0..=q).map(move |j| (i, j)))
            .map(|(i, j)| net.get(i, j) * basis(p, i, u) * basis(q, j, v))
            .sum()
    }

    #[test]
    fn operations_are_those_of_the_polynomials() {
        let a = Net::from_fn((2, 1), |i, j| 1.0 + i as f64 - 3.0 * (j * i) as f64);
        let b = Net::from_fn((1, 3), |i, j| 0.5 * j as f64 - 2.0 * i as f64 + (i * j) as f64);
        let (product, quarters) = (a.product(&b, |x, y| x * y), b.quarters());
        let slope = b.derivative(false);
        let difference = product.minus(&product.map(|x| 0.25 * x));
        for (u, v) in [(0.0, 1.0), (0.3, 0.8), (0.9, 0.1)] {
            let expected = eval(&a, u, v) * eval(&b, u, v);
            assert!((eval(&product, u, v) - expected).abs() < 1e-13);
            assert!((eval(&difference, u, v) - 0.75 * expected).abs() < 1e-13);
            assert!((eval(&quarters[1], u, v) - eval(&b, 0.5 + 0.5 * u, 0.5 * v)).abs() < 1e-13);
            assert!((eval(&quarters[2], u, v) - eval(&b, 0.5 * u, 0.5 + 0.5 * v)).abs() < 1e-13);
            let h = 1e-6;
            let by_v = (eval(&b, u, v + h) - eval(&b, u, v - h)) / (2.0 * h);
            assert!((eval(&slope, u, v) - by_v).abs() < 1e-8);
        }
    }
}
