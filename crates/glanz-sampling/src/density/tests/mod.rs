//! Densities against document 003's figures (`published`) and against their own samples; the bases and helpers of these tests.

mod adaptive;
mod coefficients;
mod fitter;
mod published;

use std::f64::consts::PI;
use std::sync::Arc;

use super::Density;
use crate::basis::{FunctionBasis, TensorBasis};
use crate::hash::{combine, unit_f64};

fn sine(x: f64) -> f64 {
    (0.5 * PI * x).sin()
}

fn line(basis: FunctionBasis) -> Arc<TensorBasis<1>> {
    Arc::new(TensorBasis::try_new([basis]).unwrap())
}

fn hats(level: usize) -> Arc<TensorBasis<1>> {
    line(FunctionBasis::uniform_bspline(1, level).unwrap())
}

/// Coefficients of all sizes, some of them 0.
fn random<const D: usize>(basis: &Arc<TensorBasis<D>>, key: u64) -> Density<D> {
    let number = |i: usize| unit_f64(combine(key, i as u64));
    let c = (0..basis.len()).map(|i| (2.0 * number(i) - 0.5).max(0.0).powi(2)).collect();
    Density::try_new(basis.clone(), c).unwrap()
}
