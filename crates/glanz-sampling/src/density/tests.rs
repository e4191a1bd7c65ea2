//! Densities against document 003's numbers (reference.json B.*): exact projections, variances of the primary estimator.
//!
//! One file in spite of its length: the tests of densities and of their fitting share bases and helpers.

use std::f64::consts::{FRAC_2_PI, PI};
use std::sync::Arc;

use super::*;
use crate::basis::{FunctionBasis, MAX_DEGREE, TensorBasis, UnitKnots};
use crate::error::DensityError;
use crate::hash::{combine, unit_f64};
use crate::multiresolution::MultiResolution;
use crate::statistics::chi_square;

fn sine(x: f64) -> f64 {
    (0.5 * PI * x).sin()
}

fn line(basis: FunctionBasis) -> Arc<TensorBasis<1>> {
    Arc::new(TensorBasis::try_new([basis]).unwrap())
}

fn hats(level: usize) -> Arc<TensorBasis<1>> {
    line(FunctionBasis::uniform_bspline(1, level).unwrap())
}

fn haar(level: usize) -> Arc<TensorBasis<1>> {
    line(FunctionBasis::haar(level).unwrap())
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

#[test]
fn densities_of_table_2_1_have_its_variances() {
    // B.table2.1, one sample; sin(pi x / 2).
    let variance = |basis: &Arc<TensorBasis<1>>, c: Vec<f64>| {
        Density::try_new(basis.clone(), c).unwrap().primary_variance(30, |[x]| sine(*x))
    };
    close(Density::uniform(hats(0)).primary_variance(30, |[x]| sine(*x)), 0.094_715_265_430_648_91);
    let segments = [0.006_784_675_106_775_801, 0.000_266_824_849_389_444_3, 1.431_029_407_857_615_8e-5];
    for (level, expected) in segments.into_iter().enumerate() {
        let n = f64::from(1 << level);
        close(variance(&hats(level), (0..=1 << level).map(|i| sine(f64::from(i) / n)).collect()), expected);
    }
    let basis = hats(0);
    let projection = basis.project(30, |[x]| sine(*x));
    close(projection[0], 0.114_770_682_054_218_86);
    close(projection[1], 1.158_468_862_680_943_8);
    close(variance(&basis, projection.clone()), 0.006_140_480_630_940_152);
    close(variance(&basis, vec![projection[1], projection[0]]), 0.593_480_267_519_844_5);
}

#[test]
fn densities_of_the_example_of_x_squared_have_its_variances() {
    // B.x2_example; the document prints these over 40, the variance of the mean of 40 samples.
    let square = |x: &[f64; 1]| x[0] * x[0];
    let boxes = haar(2);
    close(Density::uniform(boxes.clone()).primary_variance(10, square), 4.0 / 45.0);
    let projection = boxes.project(4, square);
    for (c, e) in projection.iter().zip([1.0, 7.0, 19.0, 37.0]) {
        close(*c, e / 96.0);
    }
    let variance = |basis: &Arc<TensorBasis<1>>, c: &[f64]| {
        Density::try_new(basis.clone(), c.to_vec()).unwrap().primary_variance(40, square)
    };
    close(variance(&boxes, &projection), 0.006_519_959_809_433_49);
    close(variance(&boxes, &[0.008_25, 0.0644, 0.191, 0.39]), 0.007_294_481_720_175_16);
    close(variance(&boxes, &[0.008_25, 0.0644, 0.191, 0.39]) / 40.0, 0.000_182_362_043_004_379);

    let hats = hats(1);
    let dual = hats.inner_products(4, square);
    for (c, e) in dual.iter().zip([1.0 / 96.0, 7.0 / 48.0, 17.0 / 96.0]) {
        close(*c, e);
    }
    let projection = hats.project(4, square);
    for (c, e) in projection.iter().zip([-1.0, 5.0, 23.0]) {
        close(*c, e / 24.0);
    }
    // Negative on [0, 1/12), so that it is not a density before it is raised.
    assert!(hats.evaluate(&projection, &[1.0 / 12.0 - 1e-9]).unwrap() < 0.0);
    assert!(hats.evaluate(&projection, &[1.0 / 12.0 + 1e-9]).unwrap() > 0.0);
    let refused = Density::try_new(hats.clone(), projection.clone());
    assert!(matches!(refused, Err(DensityError::Coefficient { index: 0, .. })));
    close(variance(&hats, &[0.01, 0.111, 1.05]), 0.007_008_313_048_131_94);
    for (floor, expected) in [
        (CoefficientFloor::Weighted(0.1), 0.002_696_024_981_120_27),
        (CoefficientFloor::Constant(0.1), 0.004_303_128_028_135_59),
        (CoefficientFloor::Weighted(0.01), 0.002_227_584_838_125_36),
        (CoefficientFloor::Constant(0.01), 0.002_382_832_247_600_15),
        (CoefficientFloor::Absolute(0.01), 0.002_801_149_953_632_01),
    ] {
        let density =
            Density::from_approximation(hats.clone(), projection.clone(), 1.0 / 3.0, floor).unwrap();
        close(density.primary_variance(40, square), expected);
    }
}

#[test]
fn exact_fits_over_levels_have_the_limits_of_table_2_2() {
    let variance = |basis: Arc<TensorBasis<1>>, floor| {
        let projection = basis.project(30, |[x]| sine(*x));
        let density = Density::from_approximation(basis, projection, FRAC_2_PI, floor).unwrap();
        // The density nearly vanishes near 0, where a rule of few nodes is not exact.
        density.primary_variance(400, |[x]| sine(*x))
    };
    // B.table2.2_limits.
    for (i, e) in
        [0.039_113_712_932_027_3, 0.013_464_935_950_196_1, 0.004_274_434_733_879_67].into_iter().enumerate()
    {
        close(variance(haar(i + 1), CoefficientFloor::Zero), e);
    }
    let hat: [(CoefficientFloor, [f64; 4]); 3] = [
        (
            CoefficientFloor::Zero,
            [
                0.006_140_480_630_940_15,
                0.000_284_591_563_847_572,
                1.515_366_725_502_83e-5,
                8.768_402_698_469_18e-7,
            ],
        ),
        (
            CoefficientFloor::Weighted(0.1),
            [
                0.006_140_480_630_940_15,
                0.000_368_763_402_343_257,
                7.051_810_789_372_33e-5,
                1.684_460_126_083_92e-5,
            ],
        ),
        (
            CoefficientFloor::Constant(0.1),
            [
                0.006_140_480_630_940_15,
                0.002_125_103_433_282_54,
                0.001_693_182_529_942_56,
                0.001_171_766_525_788_69,
            ],
        ),
    ];
    for (floor, expected) in hat {
        for (level, e) in expected.into_iter().enumerate() {
            close(variance(hats(level), floor), e);
        }
    }
}

#[test]
fn fitting_must_not_divide_by_the_density() {
    // B.eq2.21_2.22_division_test: Haar levels 1 to 3, infinitely many samples. A coefficient converges to w_j times the
    // mean of f over samples from p_j, the integral of f N_j; divided by p as printed, it is that of f N_j / p.
    let expected_1d = [
        [0.039_113_712_932_027_34, 0.013_464_935_950_196_103, 0.004_274_434_733_879_665],
        [0.039_113_712_932_027_34, 0.078_125_199_505_228_89, 0.032_270_904_182_257_004],
    ];
    for (divide, expected) in [false, true].into_iter().zip(expected_1d) {
        let mut density = Density::uniform(haar(1));
        for (i, e) in expected.into_iter().enumerate() {
            let basis = haar(i + 1);
            let fitted = basis.project(20, |x| sine(x[0]) / if divide { density.pdf(x) } else { 1.0 });
            density = Density::try_new(basis, fitted).unwrap();
            close(density.primary_variance(30, |[x]| sine(*x)), e);
        }
    }
    let expected_2d = [
        [0.033_234_264_066_686_03, 0.011_095_570_485_279_965, 0.003_482_997_085_403_067],
        [0.033_234_264_066_686_03, 0.069_429_448_287_040_4, 0.027_199_220_928_378_398],
    ];
    let f = |x: &[f64; 2]| sine(1.0 - x[0]) * sine(x[1]);
    for (divide, expected) in [false, true].into_iter().zip(expected_2d) {
        let basis = |level| {
            Arc::new(TensorBasis::try_new([(); 2].map(|()| FunctionBasis::haar(level).unwrap())).unwrap())
        };
        let mut density = Density::uniform(basis(1));
        for (i, e) in expected.into_iter().enumerate() {
            let basis = basis(i + 1);
            let fitted = basis.project(12, |x| f(x) / if divide { density.pdf(x) } else { 1.0 });
            density = Density::try_new(basis, fitted).unwrap();
            close(density.primary_variance(16, f), e);
        }
    }
}

/// Bases of each degree, Haar's, and knots that repeat.
fn axes() -> Vec<FunctionBasis> {
    let mut axes: Vec<FunctionBasis> =
        (0..=MAX_DEGREE).map(|d| FunctionBasis::uniform_bspline(d, 2).unwrap()).collect();
    axes.push(FunctionBasis::haar(3).unwrap());
    let knots = vec![0.0, 0.0, 0.0, 0.01, 0.3, 0.3, 0.3, 0.8, 1.0, 1.0, 1.0];
    axes.push(FunctionBasis::bspline(UnitKnots::try_new(2, knots).unwrap()));
    axes
}

/// Coefficients of all sizes, some of them 0.
fn random<const D: usize>(basis: &Arc<TensorBasis<D>>, key: u64) -> Density<D> {
    let number = |i: usize| unit_f64(combine(key, i as u64));
    let c = (0..basis.len()).map(|i| (2.0 * number(i) - 0.5).max(0.0).powi(2)).collect();
    Density::try_new(basis.clone(), c).unwrap()
}

#[test]
fn samples_of_every_density_follow_it() {
    // Ten bases, at 1e-4 each.
    for (key, axis) in axes().into_iter().enumerate() {
        let degree = axis.degree();
        let density = random(&line(axis), key as u64);
        let mut hits = [0; 50];
        let mut functions = vec![0; density.basis().len()];
        let n = 50_000;
        for i in 0..n {
            let sample = density.sample(&[unit_f64(combine(key as u64 + 100, i))]);
            assert_eq!(sample.pdf, density.pdf(&sample.point));
            hits[(sample.point[0] * 50.0) as usize] += 1;
            functions[sample.function] += 1;
        }
        let gauss = crate::basis::GaussLegendre::new(100);
        let cell = |k: usize| gauss.integrate(0.02 * k as f64, 0.02 * (k + 1) as f64, |x| density.pdf(&[x]));
        let expected: Vec<f64> = (0..50).map(|k| n as f64 * cell(k)).collect();
        let test = chi_square(&hits, &expected);
        assert!(test.p_value > 1e-4, "degree {degree}: {test:?}");
        let shares: Vec<f64> = (0..functions.len()).map(|j| n as f64 * density.probability(j)).collect();
        let test = chi_square(&functions, &shares);
        assert!(test.p_value > 1e-4, "degree {degree}, functions: {test:?}");
    }
}

#[test]
fn samples_in_three_dimensions_follow_the_density_on_different_bases() {
    let bases =
        [FunctionBasis::haar(2), FunctionBasis::uniform_bspline(2, 1), FunctionBasis::uniform_bspline(1, 2)]
            .map(Result::unwrap);
    let basis = Arc::new(TensorBasis::try_new(bases).unwrap());
    assert_eq!((basis.shape(), basis.len()), ([4, 4, 5], 80));
    let density = random(&basis, 77);
    let n = 200_000;
    let mut hits = vec![0; 512];
    for i in 0..n {
        let key = combine(5, i);
        let sample = density.sample(&[0, 1, 2].map(|a| unit_f64(combine(key, a))));
        hits[sample.point.iter().fold(0, |c, x| c * 8 + (x * 8.0) as usize)] += 1;
    }
    // Cells of eighths do not cross knots: the quadrature is exact.
    let gauss = crate::basis::GaussLegendre::new(2);
    let expected: Vec<f64> = (0..512)
        .map(|cell| {
            let corner = [cell / 64, cell / 8 % 8, cell % 8].map(|k| f64::from(k) / 8.0);
            let mut sum = 0.0;
            for &(x, a) in gauss.rule() {
                for &(y, b) in gauss.rule() {
                    for &(z, c) in gauss.rule() {
                        let p = [corner[0] + x / 8.0, corner[1] + y / 8.0, corner[2] + z / 8.0];
                        sum += a * b * c * density.pdf(&p);
                    }
                }
            }
            n as f64 * sum / 512.0
        })
        .collect();
    assert!((expected.iter().sum::<f64>() / n as f64 - 1.0).abs() < 1e-12);
    let test = chi_square(&hits, &expected);
    assert!(test.p_value > 1e-3, "{test:?}");
}

#[test]
fn densities_integrate_to_one_and_vanish_outside() {
    for (key, axis) in axes().into_iter().enumerate() {
        let density = random(&line(axis), key as u64);
        let mut integral = 0.0;
        density.basis().for_each_node(MAX_DEGREE + 1, |x, w| integral += w * density.pdf(x));
        assert!((integral - 1.0).abs() < 1e-13);
        assert_eq!([density.pdf(&[-0.1]), density.pdf(&[1.1]), density.pdf(&[f64::NAN])], [0.0; 3]);
    }
}

#[test]
fn density_of_a_function_in_the_space_leaves_no_variance() {
    for axis in axes() {
        let basis = line(axis);
        let c: Vec<f64> = (0..basis.len()).map(|i| 1.5 + (2.0 * i as f64).sin()).collect();
        let f = |x: &[f64; 1]| basis.evaluate(&c, x).unwrap();
        let projection = basis.project(MAX_DEGREE + 1, f);
        assert!(projection.iter().zip(&c).all(|(a, b)| (a - b).abs() < 1e-11));
        let density = Density::try_new(basis.clone(), projection).unwrap();
        assert!(density.primary_variance(MAX_DEGREE + 1, f).abs() < 1e-11);
    }
}

#[test]
fn mixture_with_the_constant_is_nowhere_below_its_weight() {
    let density = random(&line(FunctionBasis::uniform_bspline(2, 3).unwrap()), 3);
    let mixed = density.mixed_with_uniform(0.25);
    for i in 0..=100 {
        let x = [f64::from(i) / 100.0];
        assert!((mixed.pdf(&x) - 0.75 * density.pdf(&x) - 0.25).abs() < 1e-14);
    }
    assert_eq!(Density::<3>::constant().unwrap().pdf(&[0.2, 0.5, 1.0]), 1.0);
}

#[test]
fn invalid_coefficients_are_refused() {
    let basis = hats(1);
    let of = |c: &[f64]| Density::try_new(basis.clone(), c.to_vec());
    assert_eq!(of(&[0.0; 3]), Err(DensityError::Integral(0.0)));
    assert_eq!(of(&[1.0; 4]), Err(DensityError::Length { found: 4, expected: 3 }));
    assert_eq!(of(&[0.0, -1.0, 2.0]), Err(DensityError::Coefficient { index: 1, value: -1.0 }));
    assert!(matches!(of(&[0.0, f64::NAN, 2.0]), Err(DensityError::Coefficient { index: 1, .. })));
}

/// Records `n` samples of f.
fn fit<const D: usize>(
    density: &Density<D>,
    method: FittingMethod,
    n: u64,
    key: u64,
    f: impl Fn(&[f64; D]) -> f64,
) -> DensityFitter<D> {
    let mut fitter = DensityFitter::new(density.basis().clone(), method);
    for i in 0..n {
        let key = combine(key, i);
        let sample = density.sample(&std::array::from_fn(|a| unit_f64(combine(key, a as u64))));
        assert!(fitter.record(&sample, f(&sample.point)));
    }
    fitter
}

#[test]
fn both_methods_find_the_inner_products() {
    // 5 x 9 coefficients, both ways: 90 normal deviates; 4 standard deviations have a chance of 6e-3 to be left.
    let axes = [FunctionBasis::uniform_bspline(2, 1).unwrap(), FunctionBasis::uniform_bspline(1, 3).unwrap()];
    let basis = Arc::new(TensorBasis::try_new(axes).unwrap());
    let f = |x: &[f64; 2]| sine(1.0 - x[0]) * sine(x[1]) + 0.1;
    let exact = basis.inner_products(12, f);
    let density = random(&basis, 9).mixed_with_uniform(0.3);
    for method in [FittingMethod::OwnSamples(MissingCoefficient::Constant), FittingMethod::AllSamples] {
        let estimate = fit(&density, method, 100_000, 8, f).estimate().unwrap();
        let within = |sigmas: f64| {
            let each = estimate.values.iter().zip(&estimate.variances).zip(&exact);
            each.filter(|((v, variance), e)| (*v - **e).abs() < sigmas * variance.sqrt()).count()
        };
        assert_eq!(within(4.0), exact.len(), "{method:?}");
        // And the variances are not too large: about 0.68 of deviates lie within one.
        assert!(within(1.0) as f64 > 0.45 * exact.len() as f64 && within(1.0) < exact.len(), "{method:?}");
        assert!((estimate.integral - (FRAC_2_PI * FRAC_2_PI + 0.1)).abs() < 0.01);
    }
}

#[test]
fn coefficients_without_samples_are_those_of_the_constant() {
    let basis = hats(4);
    let estimate = fit(
        &Density::uniform(basis.clone()),
        FittingMethod::OwnSamples(MissingCoefficient::Constant),
        3,
        1,
        |_| 2.0,
    )
    .estimate()
    .unwrap();
    for ((value, count), weight) in estimate.values.iter().zip(&estimate.counts).zip(basis.weights()) {
        assert!((value - 2.0 * weight).abs() < 1e-15, "{count}");
    }
    assert!(
        DensityFitter::new(basis, FittingMethod::OwnSamples(MissingCoefficient::Constant))
            .estimate()
            .is_none()
    );
}

#[test]
fn coefficients_without_samples_follow_their_neighbours() {
    // 3 x 3 hat functions of level 1, weights 1/4, 1/2, 1/4 along each axis; samples at the first corner (mean 8) and in the
    // middle of the last row (mean 2).
    let axes = [(); 2].map(|()| FunctionBasis::uniform_bspline(1, 1).unwrap());
    let basis = TensorBasis::try_new(axes).unwrap();
    let mut counts = vec![0; 9];
    (counts[0], counts[7]) = (5, 5);
    let mut values = vec![99.0; 9];
    (values[0], values[7]) = (8.0 / 16.0, 2.0 / 8.0);
    let mut estimate = DualEstimate { values, variances: vec![1.0; 9], counts, integral: 99.0, samples: 10 };
    estimate.fill_from_neighbours(&basis).unwrap();
    // First round: 1 and 3 next to the corner; 4, 6 and 8 next to the other. Second: 2 from 1, 5 from 4 and 8.
    let means = [8.0, 8.0, 8.0, 8.0, 2.0, 2.0, 2.0, 2.0, 2.0];
    for ((value, mean), weight) in estimate.values.iter().zip(means).zip(basis.weights()) {
        assert!((value - mean * weight).abs() < 1e-15, "{:?}", estimate.values);
    }
    // Without any samples, nothing changes and the loop ends.
    let mut empty = DualEstimate { counts: vec![0; 9], ..estimate.clone() };
    empty.fill_from_neighbours(&basis).unwrap();
    assert_eq!(empty.values, estimate.values);
    assert!(
        empty
            .fill_from_neighbours(&TensorBasis::try_new([FunctionBasis::haar(1).unwrap()]).unwrap())
            .is_err()
    );
}

#[test]
fn values_that_are_not_finite_are_rejected_and_negative_ones_count_by_magnitude() {
    let density = Density::uniform(hats(0));
    let mut fitter =
        DensityFitter::new(density.basis().clone(), FittingMethod::OwnSamples(MissingCoefficient::Constant));
    let sample = density.sample(&[0.3]);
    assert!(!fitter.record(&sample, f64::NAN) && !fitter.record(&sample, f64::INFINITY));
    assert!(fitter.record(&sample, -2.0));
    let estimate = fitter.estimate().unwrap();
    assert_eq!((fitter.samples(), estimate.integral), (1, 2.0));
}

#[test]
fn merged_fitters_equal_one() {
    let density = Density::uniform(hats(2));
    let f = |x: &[f64; 1]| sine(x[0]);
    let mut a = fit(&density, FittingMethod::OwnSamples(MissingCoefficient::Constant), 500, 1, f);
    let b = fit(&density, FittingMethod::OwnSamples(MissingCoefficient::Constant), 700, 2, f);
    let (first, second) = (a.estimate().unwrap(), b.estimate().unwrap());
    a.merge(&b).unwrap();
    let merged = a.estimate().unwrap();
    // The document's formula for further passes (section 2.4.5): old and new weighted by their samples.
    let mut accumulated = first;
    accumulated.accumulate(&second, Weighting::Samples).unwrap();
    for (x, y) in merged.values.iter().zip(&accumulated.values) {
        assert!((x - y).abs() < 1e-14);
    }
    assert_eq!((merged.samples, &merged.counts), (accumulated.samples, &accumulated.counts));
    let other = DensityFitter::new(hats(1), FittingMethod::OwnSamples(MissingCoefficient::Constant));
    assert_eq!(a.merge(&other), Err(DensityError::Mismatch));
}

#[test]
fn inverse_variances_weigh_the_better_estimate_more() {
    let mut rough = DualEstimate {
        values: vec![2.0],
        variances: vec![0.4],
        counts: vec![10],
        integral: 2.0,
        samples: 10,
    };
    let fine = DualEstimate {
        values: vec![1.0],
        variances: vec![0.1],
        counts: vec![10],
        integral: 1.0,
        samples: 10,
    };
    rough.accumulate(&fine, Weighting::InverseVariance).unwrap();
    // Weights 1/5 and 4/5; 1 / (2.5 + 10).
    assert!((rough.values[0] - 1.2).abs() < 1e-15 && (rough.variances[0] - 0.08).abs() < 1e-16);
    assert_eq!((rough.integral, rough.samples), (1.5, 20));
}

#[test]
fn refined_density_is_the_same_function() {
    let scales = Arc::new(TensorMultiResolution::new([
        MultiResolution::haar(4).unwrap(),
        MultiResolution::bspline(2, 3).unwrap(),
    ]));
    let mut adaptive =
        AdaptiveDensity::try_new(scales, [2, 0], FittingMethod::OwnSamples(MissingCoefficient::Constant))
            .unwrap();
    for i in 0..4000 {
        let key = combine(6, i);
        let sample = adaptive.sample(&[unit_f64(combine(key, 0)), unit_f64(combine(key, 1))]);
        adaptive.record(&sample, sample.point[0] * sine(sample.point[1]));
    }
    adaptive.fit(CoefficientFloor::default(), Weighting::Samples).unwrap().unwrap();
    let coarse = adaptive.density().clone();
    adaptive.refine([4, 3]).unwrap();
    assert_eq!(adaptive.density().basis().shape(), [16, 10]);
    for i in 0..400 {
        let x = [f64::from(i % 20) / 19.5, f64::from(i / 20) / 19.5];
        assert!((adaptive.pdf(&x) - coarse.pdf(&x)).abs() < 1e-13);
    }
    assert!(matches!(adaptive.refine([3, 3]), Err(DensityError::Level { level: 3, lowest: 4, .. })));
}

#[test]
fn further_passes_on_one_scale_come_closer_to_the_proximum() {
    let scales = Arc::new(TensorMultiResolution::new([MultiResolution::bspline(1, 1).unwrap()]));
    let mut adaptive =
        AdaptiveDensity::try_new(scales, [1], FittingMethod::OwnSamples(MissingCoefficient::Constant))
            .unwrap();
    let projection = hats(1).project(30, |[x]| sine(*x));
    let mut errors = Vec::new();
    for pass in 0..64 {
        for i in 0..1000 {
            let sample = adaptive.sample(&[unit_f64(combine(combine(3, pass), i))]);
            adaptive.record(&sample, sine(sample.point[0]));
        }
        let found = adaptive.fit(CoefficientFloor::default(), Weighting::Samples).unwrap().unwrap();
        errors.push(found.iter().zip(&projection).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt());
    }
    // A root of 64 is expected.
    assert!(errors[63] < errors[0] / 4.0, "{errors:?}");
}

#[test]
fn density_stays_without_samples() {
    let scales = Arc::new(TensorMultiResolution::new([MultiResolution::haar(2).unwrap()]));
    let mut adaptive =
        AdaptiveDensity::try_new(scales, [2], FittingMethod::OwnSamples(MissingCoefficient::Constant))
            .unwrap();
    assert_eq!(adaptive.fit(CoefficientFloor::default(), Weighting::Samples), Ok(None));
    let sample = adaptive.sample(&[0.4]);
    adaptive.record(&sample, 0.0);
    assert_eq!(adaptive.fit(CoefficientFloor::default(), Weighting::Samples), Ok(None));
    assert_eq!(adaptive.pdf(&[0.9]), 1.0);
}
