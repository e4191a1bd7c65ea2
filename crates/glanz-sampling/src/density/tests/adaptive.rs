//! Densities that are refined and fitted in passes.

use std::sync::Arc;

use super::super::{
    AdaptiveDensity, CoefficientFloor, FittingMethod, MissingCoefficient, TensorMultiResolution, Weighting,
};
use super::{hats, sine};
use crate::error::DensityError;
use crate::hash::{combine, unit_f64};
use crate::multiresolution::MultiResolution;

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
