//! Statistical tests of samplers against densities.

/// Result of a chi-square test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Sum of (observed - expected)^2 / expected over the pooled cells; infinite if a cell of probability 0 was hit.
    pub statistic: f64,
    /// Number of pooled cells minus one.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least as large under the expectation.
    pub p_value: f64,
}

/// Smallest expected number of hits of a cell that is not pooled; the usual rule for the limit distribution.
const FEWEST_EXPECTED: f64 = 5.0;

/// Pearson's chi-square test of hit counts against expected numbers.
///
/// `observed` and `expected` have the same order (additional entries of the longer one are ignored); their sums should agree.
/// Cells with less than five expected hits are pooled, smallest first (the order does not depend on `observed`).
///
/// # Source
/// @pearson1900; the pooling is that of @jakob2010mitsuba's test suite.
#[must_use]
pub fn chi_square(observed: &[u64], expected: &[f64]) -> ChiSquare {
    let mut cells: Vec<(f64, u64)> = expected.iter().copied().zip(observed.iter().copied()).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut statistic, mut used) = (0.0, 0_usize);
    let mut pool = (0.0, 0_u64);
    for (e, o) in cells {
        if e <= 0.0 && o > 0 {
            return ChiSquare { statistic: f64::INFINITY, degrees_of_freedom: used, p_value: 0.0 };
        }
        pool = (pool.0 + e, pool.1 + o);
        if pool.0 >= FEWEST_EXPECTED {
            statistic += (pool.1 as f64 - pool.0).powi(2) / pool.0;
            used += 1;
            pool = (0.0, 0);
        }
    }
    let degrees = used.saturating_sub(1);
    let p_value = if degrees == 0 { 1.0 } else { gamma_q(0.5 * degrees as f64, 0.5 * statistic) };
    ChiSquare { statistic, degrees_of_freedom: degrees, p_value }
}

/// The regularised upper incomplete gamma function Q(a, x) for a > 0, x >= 0.
///
/// Series for x < a + 1, else Lentz's continued fraction; relative accuracy about 1e-12 for a up to 1e5.
///
/// # Source
/// @press2007 section 6.2.
#[must_use]
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    if x == f64::INFINITY {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        // Terms decrease geometrically once n > x; stop when they are below rounding.
        while term > sum * f64::EPSILON {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - front * sum).clamp(0.0, 1.0);
    }
    let tiny = f64::MIN_POSITIVE / f64::EPSILON;
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / tiny, 1.0 / b);
    let mut h = d;
    // About sqrt(a) steps near x = a, few elsewhere.
    for i in 1..100_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = numerator * d + b;
        c = b + numerator / c;
        d = 1.0 / if d.abs() < tiny { tiny } else { d };
        c = if c.abs() < tiny { tiny } else { c };
        h *= d * c;
        if (d * c - 1.0).abs() < 2.0 * f64::EPSILON {
            break;
        }
    }
    (front * h).clamp(0.0, 1.0)
}

/// Natural logarithm of the gamma function for x > 0, relative accuracy about 1e-14.
///
/// # Source
/// @lanczos1964 with g = 7 and nine coefficients.
#[must_use]
pub fn ln_gamma(x: f64) -> f64 {
    #[allow(clippy::excessive_precision)]
    const COEFFICIENTS: [f64; 9] = [
        0.999_999_999_999_809_93,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_13,
        -176.615_029_162_140_59,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_571_6e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        // Reflection: gamma(x) gamma(1 - x) = pi / sin(pi x).
        return (std::f64::consts::PI / (std::f64::consts::PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let [first, rest @ ..] = COEFFICIENTS;
    let sum = rest.iter().enumerate().fold(first, |sum, (i, c)| sum + c / (x + i as f64 + 1.0));
    let t = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn incomplete_gamma_agrees_with_closed_forms() {
        for x in [0.01, 0.5, 1.0, 3.0, 20.0, 100.0] {
            // Q(1, x) = exp(-x); Q(3, x) = exp(-x) (1 + x + x^2 / 2).
            let e = f64::exp(-x);
            assert!((gamma_q(1.0, x) - e).abs() <= 1e-12 * e.max(1e-3));
            let q3 = e * (1.0 + x + 0.5 * x * x);
            assert!((gamma_q(3.0, x) - q3).abs() <= 1e-12);
        }
        // The median of chi-square with k degrees of freedom is close to k (1 - 2 / (9 k))^3.
        let k = 100.0_f64;
        let median = k * (1.0 - 2.0 / (9.0 * k)).powi(3);
        assert!((gamma_q(0.5 * k, 0.5 * median) - 0.5).abs() < 1e-4);
    }

    #[test]
    fn ln_gamma_is_that_of_factorials_and_of_one_half() {
        assert!((ln_gamma(11.0) - 3_628_800_f64.ln()).abs() < 1e-13);
        assert!((ln_gamma(0.5) - 0.5 * std::f64::consts::PI.ln()).abs() < 1e-14);
        assert!((ln_gamma(0.25) - 3.625_609_908_221_908_f64.ln()).abs() < 1e-13);
    }

    #[test]
    fn wrong_expectations_are_rejected_and_right_ones_kept() {
        assert!(chi_square(&[100, 100, 100, 100], &[100.0; 4]).p_value > 0.999);
        // Statistic 4 * 900 / 100 = 36 with 3 degrees of freedom: p about 7.5e-8.
        let off = chi_square(&[130, 70, 130, 70], &[100.0; 4]);
        assert_eq!(off.statistic, 36.0);
        assert!(off.p_value < 1e-7 && off.p_value > 1e-8);
        assert_eq!(chi_square(&[1, 99], &[0.0, 100.0]).p_value, 0.0);
    }

    #[test]
    fn small_cells_are_pooled() {
        let test = chi_square(&[1, 1, 1, 1, 1, 95], &[1.0, 1.0, 1.0, 1.0, 1.0, 95.0]);
        assert_eq!(test.degrees_of_freedom, 1);
        assert_eq!(test.statistic, 0.0);
    }
}
