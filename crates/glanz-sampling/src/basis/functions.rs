//! Bases of B-splines and of Haar's box functions.

use crate::basis::distributions::SplineDistributions;
use crate::basis::{GaussLegendre, GramMatrix, ORDER, UnitKnots, check_length};
use crate::error::DensityError;

/// A basis of nonnegative functions on [0, 1]: B-splines, or Haar's orthonormal box functions.
///
/// Function j is N_j = w_j p_j with a probability density p_j and the weight w_j, its integral (@pietrek2001 equations
/// 2.12, 2.13). Functions are numbered from 0; indices of functions must be below [`FunctionBasis::len`].
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionBasis {
    knots: UnitKnots,
    /// Factor of the B-splines, which sum to 1.
    scale: f64,
    weights: Vec<f64>,
    pieces: SplineDistributions,
}

impl FunctionBasis {
    /// The B-splines of these knots; they sum to 1 everywhere.
    #[must_use]
    pub fn bspline(knots: UnitKnots) -> Self {
        Self::scaled(knots, 1.0)
    }

    /// The B-splines of `degree` on 2^`level` equal segments.
    ///
    /// # Errors
    /// [`DensityError::Degree`]; [`DensityError::Level`] for levels above 24.
    pub fn uniform_bspline(degree: usize, level: usize) -> Result<Self, DensityError> {
        Ok(Self::bspline(UnitKnots::uniform(degree, segments_of(level)?)?))
    }

    /// The orthonormal boxes of height 2^(level / 2) on 2^`level` equal segments.
    ///
    /// # Errors
    /// [`DensityError::Level`] for levels above 24.
    pub fn haar(level: usize) -> Result<Self, DensityError> {
        let segments = segments_of(level)?;
        Ok(Self::scaled(UnitKnots::uniform(0, segments)?, (segments as f64).sqrt()))
    }

    fn scaled(knots: UnitKnots, scale: f64) -> Self {
        let order = knots.degree() + 1;
        let weights =
            knots.knots().windows(order + 1).map(|t| scale * (t[order] - t[0]) / order as f64).collect();
        let pieces = SplineDistributions::new(&knots);
        Self { knots, scale, weights, pieces }
    }

    /// The knots.
    #[must_use]
    pub fn knots(&self) -> &UnitKnots {
        &self.knots
    }

    /// The degree of the pieces.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Number of functions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Always `false`: there is at least one function.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The sum of all functions, which is constant.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.scale
    }

    /// The integrals w_j of all functions.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Start and end of the support of function `j`.
    #[must_use]
    pub fn support(&self, j: usize) -> [f64; 2] {
        let t = self.knots.knots();
        [t[j], t[j + self.degree() + 1]]
    }

    /// The first function that does not vanish on the segment of `x`, and the values there of this and the following
    /// [`FunctionBasis::degree`] functions; the rest of the array is 0.
    #[inline]
    #[must_use]
    pub fn nonzero(&self, x: f64) -> (usize, [f64; ORDER]) {
        let m = self.knots.find_span(x);
        let mut values = self.knots.blossoms(m, |_| x);
        if self.scale != 1.0 {
            values = values.map(|v| v * self.scale);
        }
        (m - self.degree(), values)
    }

    /// The value of function `j` at `x`; 0 outside [0, 1].
    #[must_use]
    pub fn value(&self, j: usize, x: f64) -> f64 {
        if !(0.0..=1.0).contains(&x) {
            return 0.0;
        }
        let (first, values) = self.nonzero(x);
        j.checked_sub(first).and_then(|k| values.get(k)).copied().unwrap_or(0.0)
    }

    /// The density p_j at `x`; 0 outside [0, 1].
    #[must_use]
    pub fn pdf(&self, j: usize, x: f64) -> f64 {
        self.value(j, x) / self.weights[j]
    }

    /// A point with the density p_j from the uniform number `xi` in [0, 1), increasing with `xi`, in the support of the function. It
    /// inverts the distribution function to about 1e-15.
    #[inline]
    #[must_use]
    pub fn sample(&self, j: usize, xi: f64) -> f64 {
        self.pieces.invert(self.knots.knots(), j, xi)
    }

    /// The distribution function of p_j, in [0, 1]: the inverse of [`FunctionBasis::sample`].
    #[must_use]
    pub fn cumulative(&self, j: usize, x: f64) -> f64 {
        self.pieces.cumulative(self.knots.knots(), j, x)
    }

    /// The value at `x` of the function with these coefficients; 0 outside [0, 1].
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn evaluate(&self, coefficients: &[f64], x: f64) -> Result<f64, DensityError> {
        check_length(coefficients, self.len())?;
        if !(0.0..=1.0).contains(&x) {
            return Ok(0.0);
        }
        let (first, values) = self.nonzero(x);
        Ok(coefficients[first..].iter().zip(values).take(self.degree() + 1).map(|(c, v)| c * v).sum())
    }

    /// The inner products of all functions, exact up to rounding.
    ///
    /// # Errors
    /// [`DensityError::Pivot`] if segments are so short that the functions are linearly dependent up to rounding.
    pub fn gram(&self) -> Result<GramMatrix, DensityError> {
        let d = self.degree();
        let gauss = GaussLegendre::new(d + 1);
        let width = d + 1;
        let mut entries = vec![0.0; self.len() * width];
        for (_, a, b) in self.knots.spans() {
            for &(node, weight) in gauss.rule() {
                let (first, values) = self.nonzero(a + (b - a) * node);
                for i in 0..=d {
                    for k in 0..=i {
                        entries[(first + i) * width + k] += (b - a) * weight * values[i] * values[i - k];
                    }
                }
            }
        }
        GramMatrix::try_new(self.len(), d, entries)
    }

    /// The inner products of `f` with all functions, by a rule of `nodes` nodes on each segment: exact up to rounding
    /// if f is a polynomial of degree 2 `nodes` - 1 - [`FunctionBasis::degree`] on each segment.
    #[must_use]
    pub fn inner_products(&self, nodes: usize, mut f: impl FnMut(f64) -> f64) -> Vec<f64> {
        let gauss = GaussLegendre::new(nodes);
        let mut products = vec![0.0; self.len()];
        for (_, a, b) in self.knots.spans() {
            for &(node, weight) in gauss.rule() {
                let x = a + (b - a) * node;
                let term = (b - a) * weight * f(x);
                let (first, values) = self.nonzero(x);
                for (p, v) in products[first..].iter_mut().zip(values) {
                    *p += term * v;
                }
            }
        }
        products
    }

    /// The coefficients of the orthogonal projection of `f` in L2 (@pietrek2001 equation B.2); `nodes` as in
    /// [`FunctionBasis::inner_products`].
    ///
    /// # Errors
    /// [`DensityError::Pivot`] as [`FunctionBasis::gram`].
    pub fn project(&self, nodes: usize, f: impl FnMut(f64) -> f64) -> Result<Vec<f64>, DensityError> {
        let mut coefficients = self.inner_products(nodes, f);
        self.gram()?.solve(&mut coefficients);
        Ok(coefficients)
    }
}

/// The finest level, with 2^24 segments.
const FINEST: usize = 24;

fn segments_of(level: usize) -> Result<usize, DensityError> {
    if level > FINEST {
        return Err(DensityError::Level { level, lowest: 0, highest: FINEST });
    }
    Ok(1 << level)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;
    use crate::hash::{combine, unit_f64};
    use crate::reference::{GRAMS, matrix};
    use crate::statistics::chi_square;

    /// Bases of all kinds: every degree, Haar, and knots that repeat and crowd.
    fn zoo() -> Vec<FunctionBasis> {
        let mut zoo = vec![FunctionBasis::haar(0).unwrap(), FunctionBasis::haar(3).unwrap()];
        for degree in 0..=crate::basis::MAX_DEGREE {
            zoo.push(FunctionBasis::uniform_bspline(degree, 0).unwrap());
            zoo.push(FunctionBasis::uniform_bspline(degree, 3).unwrap());
            let mut knots = vec![0.0; degree + 1];
            knots.extend([0.01, 0.02, 0.4]);
            // As often as possible: the functions are discontinuous there.
            knots.extend(vec![0.7; degree + 1]);
            knots.push(0.999);
            knots.extend(vec![1.0; degree + 1]);
            zoo.push(FunctionBasis::bspline(UnitKnots::try_new(degree, knots).unwrap()));
        }
        zoo
    }

    #[test]
    fn functions_sum_to_one_number_and_none_is_negative() {
        for basis in zoo() {
            for i in 0..=1000 {
                let (_, values) = basis.nonzero(f64::from(i) / 1000.0);
                assert!(values.iter().all(|v| *v >= 0.0));
                assert!((values.iter().sum::<f64>() / basis.sum() - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn bernstein_polynomials_are_the_splines_of_one_segment() {
        // C(3, k) x^k (1 - x)^(3 - k).
        let basis = FunctionBasis::uniform_bspline(3, 0).unwrap();
        for i in 0..=20 {
            let x = f64::from(i) / 20.0;
            let y = 1.0 - x;
            let expected = [y * y * y, 3.0 * x * y * y, 3.0 * x * x * y, x * x * x];
            for (j, e) in expected.iter().enumerate() {
                assert!((basis.value(j, x) - e).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn weights_inner_products_and_their_inverses_are_the_exact_fractions() {
        for case in GRAMS {
            let basis = FunctionBasis::uniform_bspline(case.degree, case.level).unwrap();
            let name = format!("degree {}, level {}", case.degree, case.level);
            for (found, expected) in basis.weights().iter().zip(&matrix(case.weights)[0]) {
                assert!((found - expected).abs() < 1e-15, "{name}");
            }
            let gram = basis.gram().unwrap();
            let inverse = gram.inverse();
            let (expected, expected_inverse) = (matrix(case.gram), matrix(case.inverse));
            assert_eq!(expected.len(), basis.len(), "{name}");
            for i in 0..basis.len() {
                for j in 0..basis.len() {
                    assert!((gram.entry(i, j) - expected[i][j]).abs() < 1e-15, "{name}: {i} {j}");
                    let e = expected_inverse[i][j];
                    assert!((inverse[i][j] - e).abs() < 1e-12 * e.abs().max(1.0), "{name}: {i} {j}");
                }
            }
        }
    }

    #[test]
    fn haar_boxes_are_orthonormal_with_weights_of_two_to_minus_half_the_level() {
        // B.haar: w = 1, 1/sqrt 2, 1/2, 1/sqrt 8.
        for (level, w) in [1.0, FRAC_1_SQRT_2, 0.5, 0.353_553_390_593_273_8].into_iter().enumerate() {
            let basis = FunctionBasis::haar(level).unwrap();
            assert!(basis.weights().iter().all(|v| (v - w).abs() < 1e-15));
            let gram = basis.gram().unwrap();
            for i in 0..basis.len() {
                for j in 0..basis.len() {
                    let delta = if i == j { 1.0 } else { 0.0 };
                    assert!((gram.entry(i, j) - delta).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn dual_functions_are_biorthogonal() {
        for basis in zoo() {
            let gram = basis.gram().unwrap();
            let inverse = gram.inverse();
            for (i, dual) in inverse.iter().enumerate() {
                // Dual function i in the primary basis; its inner product with N_j by a quadrature of its own.
                let products = basis.inner_products(basis.degree() + 1, |x| basis.evaluate(dual, x).unwrap());
                // The size of the terms that cancel.
                let size = dual.iter().zip(basis.weights()).fold(1.0, |s: f64, (d, w)| s.max((d * w).abs()));
                for (j, p) in products.iter().enumerate() {
                    let delta = if i == j { 1.0 } else { 0.0 };
                    assert!((p - delta).abs() < 1e-12 * size, "degree {}: {p} {i} {j}", basis.degree());
                }
            }
        }
    }

    #[test]
    fn appendix_b_examples_come_out() {
        // B.18: x^2 in Haar's boxes of level 1 is (sqrt 2 / 24, 7 sqrt 2 / 24).
        let haar = FunctionBasis::haar(1).unwrap().project(4, |x| x * x).unwrap();
        let root = 2.0_f64.sqrt();
        assert!((haar[0] - root / 24.0).abs() < 1e-15 && (haar[1] - 7.0 * root / 24.0).abs() < 1e-15);
        // B.19: the duals of 1 - x and x are 4 - 6 x = 4 (1 - x) - 2 x and 6 x - 2 = -2 (1 - x) + 4 x.
        let lines = FunctionBasis::uniform_bspline(1, 0).unwrap();
        for (i, row) in lines.gram().unwrap().inverse().iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - if i == j { 4.0 } else { -2.0 }).abs() < 1e-14);
            }
        }
        // B.20 (its functions are numbered the other way round): 5/6 x - 1/6 (1 - x).
        let projection = lines.project(4, |x| x * x).unwrap();
        assert!((projection[0] + 1.0 / 6.0).abs() < 1e-15 && (projection[1] - 5.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn dual_and_primary_coefficients_of_sine_are_the_computed_ones() {
        // Computed independently: inner products and projections of sin(pi x / 2) with hat functions.
        let dual: [&[f64]; 4] = [
            &[0.231_335_037_798_230_25, 0.405_284_734_569_351_1],
            &[0.063_460_604_116_825_08, 0.335_748_867_362_810_34, 0.237_410_300_887_945_9],
            &[
                0.016_236_759_126_886_838,
                0.094_447_689_979_876_49,
                0.174_516_575_330_758_46,
                0.228_016_894_084_227_3,
                0.123_401_853_845_832_62,
            ],
            &[
                0.004_082_737_364_735_14,
                0.024_308_043_524_303_394,
                0.047_681_942_568_075_67,
                0.069_223_451_299_298_26,
                0.088_104_741_618_047_54,
                0.103_600_216_126_123_59,
                0.115_114_392_428_143_28,
                0.122_204_787_186_044_43,
                0.062_299_460_252_810_05,
            ],
        ];
        let primary: [&[f64]; 4] = [
            &[0.114_770_682_054_218_86, 1.158_468_862_680_943_8],
            &[0.010_136_794_980_100_762, 0.741_253_659_441_699_4, 1.053_834_975_606_825_7],
            &[
                0.001_187_112_689_131_620_4,
                0.387_307_993_667_020_84,
                0.716_325_472_159_820_8,
                0.935_787_925_631_899_2,
                1.012_928_283_334_037_6,
            ],
            &[
                0.000_146_352_772_248_600_8,
                0.195_678_687_962_789_5,
                0.383_924_984_543_156_2,
                0.557_354_617_132_217_7,
                0.709_382_209_294_289_4,
                0.834_144_143_356_906_9,
                0.926_851_591_332_015_8,
                0.983_940_327_865_907_3,
                1.003_216_882_134_487_6,
            ],
        ];
        let sine = |x: f64| (FRAC_PI_2 * x).sin();
        for level in 0..4 {
            let basis = FunctionBasis::uniform_bspline(1, level).unwrap();
            for (found, expected) in basis.inner_products(20, sine).iter().zip(dual[level]) {
                assert!((found - expected).abs() < 1e-14, "{level}: {found} {expected}");
            }
            for (found, expected) in basis.project(20, sine).unwrap().iter().zip(primary[level]) {
                assert!((found - expected).abs() < 1e-14);
            }
        }
        // Haar: means of the cells.
        let means: [&[f64]; 2] = [
            &[0.372_923_228_578_056_6, 0.900_316_316_157_106_1],
            &[
                0.193_839_178_740_714_02,
                0.552_007_278_415_399_2,
                0.826_137_273_909_779_5,
                0.974_495_358_404_432_7,
            ],
        ];
        for (level, expected) in [1, 2].into_iter().zip(means) {
            let basis = FunctionBasis::haar(level).unwrap();
            for (c, mean) in basis.project(20, sine).unwrap().iter().zip(expected) {
                assert!((c * basis.sum() - mean).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn projection_reproduces_functions_of_the_space() {
        for basis in zoo() {
            let coefficients: Vec<f64> = (0..basis.len()).map(|i| (1.7 * i as f64).cos()).collect();
            let projected =
                basis.project(basis.degree() + 1, |x| basis.evaluate(&coefficients, x).unwrap()).unwrap();
            for i in 0..=200 {
                let x = f64::from(i) / 200.0;
                let error =
                    basis.evaluate(&projected, x).unwrap() - basis.evaluate(&coefficients, x).unwrap();
                assert!(error.abs() < 1e-12, "degree {}: {error}", basis.degree());
            }
        }
    }

    #[test]
    fn sampling_and_the_distribution_function_are_inverse_and_rise() {
        for basis in zoo() {
            for j in 0..basis.len() {
                let [a, b] = basis.support(j);
                let mut before = a;
                for i in 0..=2000 {
                    let xi = f64::from(i) / 2000.0;
                    let x = basis.sample(j, xi);
                    assert!(
                        x >= before && x < b,
                        "degree {} function {j}: {xi} to {x} after {before}",
                        basis.degree()
                    );
                    before = x;
                    assert!(
                        (basis.cumulative(j, x) - xi).abs() < 1e-12,
                        "degree {} function {j}",
                        basis.degree()
                    );
                }
                assert_eq!([basis.cumulative(j, a), basis.cumulative(j, b)], [0.0, 1.0]);
            }
        }
    }

    #[test]
    fn numbers_near_zero_find_their_point_to_relative_precision() {
        // The first cubic: F(x) = 1 - (1 - x)^4; the last: F(x) = x^4.
        let basis = FunctionBasis::uniform_bspline(3, 0).unwrap();
        for e in 1..60 {
            let xi = 10.0_f64.powi(-e);
            let last = xi.powf(0.25);
            assert!((basis.sample(3, xi) / last - 1.0).abs() < 1e-14, "{e}");
            let first = -(0.25 * (-xi).ln_1p()).exp_m1();
            assert!((basis.sample(0, xi) / first - 1.0).abs() < 1e-13, "{e}");
        }
    }

    #[test]
    fn distribution_functions_are_integrals_of_the_densities() {
        let gauss = GaussLegendre::new(8);
        for basis in zoo() {
            for j in 0..basis.len() {
                let mut sum = 0.0;
                for (_, a, b) in basis.knots().spans() {
                    sum += gauss.integrate(a, b, |x| basis.pdf(j, x));
                    let error = basis.cumulative(j, b) - sum;
                    assert!(error.abs() < 1e-12, "degree {} function {j} at {b}: {error:e}", basis.degree());
                }
                assert!((sum - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn samples_of_every_function_follow_its_density() {
        // 22 functions at 1e-4 each.
        for basis in [FunctionBasis::haar(1).unwrap(), FunctionBasis::uniform_bspline(1, 2).unwrap()]
            .into_iter()
            .chain([2, 3].map(|d| FunctionBasis::uniform_bspline(d, 1).unwrap()))
            .chain([zoo().swap_remove(13)])
        {
            for j in 0..basis.len() {
                let [a, b] = basis.support(j);
                let mut hits = [0; 32];
                for i in 0..20_000 {
                    let x = basis.sample(j, unit_f64(combine(j as u64 + 40, i)));
                    hits[((x - a) / (b - a) * 32.0) as usize] += 1;
                }
                let gauss = GaussLegendre::new(64);
                let width = (b - a) / 32.0;
                let expected: Vec<f64> = (0..32)
                    .map(|k| {
                        20_000.0
                            * gauss.integrate(a + width * f64::from(k), a + width * f64::from(k + 1), |x| {
                                basis.pdf(j, x)
                            })
                    })
                    .collect();
                let test = chi_square(&hits, &expected);
                assert!(test.p_value > 1e-4, "degree {} function {j}: {test:?}", basis.degree());
            }
        }
    }
}
