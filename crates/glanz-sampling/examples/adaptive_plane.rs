//! A ridge over the unit square: boxes across its steep side, quadratic B-splines along its smooth one.
//!
//! The integrand is 1 / (1 + 400 (u - 1/3)^2) times 1 + v^2; its integral is known. The scales rise along the first axis
//! only where that pays. Run with `cargo run --release -p glanz-sampling --example adaptive_plane`.

use std::sync::Arc;

use glanz_sampling::DensityError;
use glanz_sampling::density::{Density, Floor, Scales, Weighting};
use glanz_sampling::integrate::{AdaptivePlan, Pass, Plan, Sampling, integrate, integrate_adaptively};
use glanz_sampling::multiresolution::MultiResolution;

fn ridge(x: &[f64]) -> f64 {
    let [u, v] = x else { return 0.0 };
    (1.0 + v * v) / (1.0 + 400.0 * (u - 1.0 / 3.0).powi(2))
}

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), DensityError> {
    let exact = 4.0 / 3.0 * ((40.0_f64 / 3.0).atan() + (20.0_f64 / 3.0).atan()) / 20.0;
    println!("integral of a ridge over the unit square; exact {exact:.8}\n");
    println!("{:<34} {:>8} {:>12} {:>14} {:>12}", "", "samples", "integral", "standard error", "variance");
    let row = |name: &str, e: &glanz_sampling::integrate::Estimate| {
        println!(
            "{name:<34} {:>8} {:>12.8} {:>14.8} {:>12.3e}",
            e.samples,
            e.mean,
            e.standard_error(),
            e.primary_variance
        );
    };

    for sampling in [Sampling::Independent, Sampling::Sobol] {
        let plan = Plan { samples: 4096, repetitions: 16, sampling, seed: 1 };
        row(&format!("uniform, {sampling:?}"), &integrate(&Density::<2>::constant()?, &plan, ridge)?);
    }

    let scales = Arc::new(Scales::new([MultiResolution::haar(5)?, MultiResolution::bspline(2, 1)?]));
    let passes = [([2, 0], 256), ([3, 0], 512), ([4, 1], 1024), ([5, 1], 2304)]
        .map(|(levels, samples)| Pass { levels, samples });
    for sampling in [Sampling::Independent, Sampling::Sobol] {
        let plan = AdaptivePlan {
            repetitions: 16,
            sampling,
            floor: Floor::Constant(0.05),
            weighting: Weighting::InverseVariance,
            ..AdaptivePlan::new(passes.to_vec(), 1)
        };
        let result = integrate_adaptively(&scales, &plan, ridge)?;
        println!();
        for pass in &result.passes {
            row(&format!("adaptive, {sampling:?}, scales {:?}", pass.levels), &pass.estimate);
        }
        row(&format!("adaptive, {sampling:?}, all"), &result.estimate);
    }
    Ok(())
}
