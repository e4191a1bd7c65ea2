//! Densities compared with document 003's numbers, computed again independently: exact projections, variances of the primary estimator.

use std::f64::consts::FRAC_2_PI;
use std::sync::Arc;

use super::super::{CoefficientFloor, Density};
use super::{hats, line, sine};
use crate::basis::{FunctionBasis, TensorBasis};
use crate::error::DensityError;

fn haar(level: usize) -> Arc<TensorBasis<1>> {
    line(FunctionBasis::haar(level).unwrap())
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

#[test]
fn densities_of_table_2_1_have_its_variances() {
    // Table 2.1, one sample; sin(pi x / 2).
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
    // The document prints these over 40, the variance of the mean of 40 samples.
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
    // The limits of table 2.2 for infinitely many samples.
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
    // Equations (2.21) and (2.22), Haar levels 1 to 3, infinitely many samples. A coefficient converges to w_j times the
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
