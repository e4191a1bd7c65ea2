//! Coefficients from samples.

use std::f64::consts::FRAC_2_PI;
use std::sync::Arc;

use super::super::{Density, DensityFitter, DualEstimate, FittingMethod, MissingCoefficient, Weighting};
use super::{hats, random, sine};
use crate::basis::{FunctionBasis, TensorBasis};
use crate::error::DensityError;
use crate::hash::{combine, unit_f64};

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
