//! Gauss-Legendre quadrature.

use std::f64::consts::PI;

/// The Gauss-Legendre rule on [0, 1]: exact for polynomials of degree 2 n - 1 with n nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussLegendre {
    /// Nodes and weights.
    rule: Vec<(f64, f64)>,
}

impl GaussLegendre {
    /// The rule of `nodes` nodes (0 counts as 1).
    ///
    /// # Source
    /// @press2007 section 4.6: Newton's method on the Legendre polynomial.
    #[must_use]
    pub fn new(nodes: usize) -> Self {
        let n = nodes.max(1);
        let rule = (0..n)
            .map(|i| {
                let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
                let mut slope = 1.0;
                // From this start Newton's method converges quadratically; five steps reach the precision of f64.
                for _ in 0..6 {
                    let (value, derivative) = legendre(n, x);
                    slope = derivative;
                    x -= value / slope;
                }
                (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
            })
            .collect();
        Self { rule }
    }

    /// The nodes in [0, 1], ascending, each with its weight; the weights sum to 1.
    #[must_use]
    pub fn rule(&self) -> &[(f64, f64)] {
        &self.rule
    }

    /// The integral of `f` from `a` to `b`.
    pub fn integrate(&self, a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        (b - a) * self.rule.iter().map(|&(x, w)| w * f(a + (b - a) * x)).sum::<f64>()
    }
}

/// The Legendre polynomial of degree n and its derivative at x.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_twice_the_nodes_are_exact() {
        for n in 1..=40 {
            let gauss = GaussLegendre::new(n);
            for degree in 0..2 * n {
                let integral = gauss.integrate(0.0, 1.0, |x| x.powi(degree as i32));
                assert!((integral - 1.0 / (degree as f64 + 1.0)).abs() < 1e-14, "{n} nodes, degree {degree}");
            }
        }
    }

    #[test]
    fn first_degree_beyond_is_not_exact() {
        let gauss = GaussLegendre::new(2);
        assert!((gauss.integrate(0.0, 1.0, |x| x.powi(4)) - 0.2).abs() > 1e-3);
    }
}
