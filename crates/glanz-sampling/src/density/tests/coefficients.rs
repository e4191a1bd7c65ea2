//! Densities by their coefficients: samples, integrals, mixtures.

use std::sync::Arc;

use super::super::Density;
use super::{hats, line, random};
use crate::basis::{FunctionBasis, GaussLegendre, MAX_DEGREE, TensorBasis, UnitKnots};
use crate::error::DensityError;
use crate::hash::{combine, unit_f64};
use crate::statistics::chi_square;

/// Bases of each degree, Haar's, and knots that repeat.
fn axes() -> Vec<FunctionBasis> {
    let mut axes: Vec<FunctionBasis> =
        (0..=MAX_DEGREE).map(|d| FunctionBasis::uniform_bspline(d, 2).unwrap()).collect();
    axes.push(FunctionBasis::haar(3).unwrap());
    let knots = vec![0.0, 0.0, 0.0, 0.01, 0.3, 0.3, 0.3, 0.8, 1.0, 1.0, 1.0];
    axes.push(FunctionBasis::bspline(UnitKnots::try_new(2, knots).unwrap()));
    axes
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
        let gauss = GaussLegendre::new(100);
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
    let gauss = GaussLegendre::new(2);
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
