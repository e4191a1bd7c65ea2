//! A ridge over the unit square: box functions across its steep side, quadratic B-splines along its smooth side.
//!
//! The integrand is 1 / (1 + 400 (u - 1/3)^2) times 1 + v^2, whose integral is known. The levels increase mainly along the first axis. Run with `cargo run --release -p glanz-sampling --example adaptive_plane`.

use std::sync::Arc;

use glanz_sampling::DensityError;
use glanz_sampling::density::{CoefficientFloor, Density, TensorMultiResolution, Weighting};
use glanz_sampling::integrate::{
    AdaptivePlan, IntegrationPass, IntegrationPlan, SamplingPattern, integrate, integrate_adaptively,
};
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

    for sampling in [SamplingPattern::Independent, SamplingPattern::Sobol] {
        let plan = IntegrationPlan { samples: 4096, repetitions: 16, sampling, seed: 1 };
        row(&format!("uniform, {sampling:?}"), &integrate(&Density::<2>::constant()?, &plan, ridge)?);
    }

    let analyses =
        Arc::new(TensorMultiResolution::new([MultiResolution::haar(5)?, MultiResolution::bspline(2, 1)?]));
    let passes = [([2, 0], 256), ([3, 0], 512), ([4, 1], 1024), ([5, 1], 2304)]
        .map(|(levels, samples)| IntegrationPass { levels, samples });
    for sampling in [SamplingPattern::Independent, SamplingPattern::Sobol] {
        let plan = AdaptivePlan {
            repetitions: 16,
            sampling,
            floor: CoefficientFloor::Constant(0.05),
            weighting: Weighting::InverseVariance,
            ..AdaptivePlan::new(passes.to_vec(), 1)
        };
        let result = integrate_adaptively(&analyses, &plan, ridge)?;
        println!();
        for pass in &result.passes {
            row(&format!("adaptive, {sampling:?}, levels {:?}", pass.levels), &pass.estimate);
        }
        row(&format!("adaptive, {sampling:?}, all"), &result.estimate);
    }
    Ok(())
}
