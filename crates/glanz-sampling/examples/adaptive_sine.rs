//! The integral of sin(pi x / 2) in four passes, with Haar's box functions, hat functions and quadratic B-splines.
//!
//! Each pass samples the density fitted by the previous one, on the next finer level; the variance of a sample decreases from pass
//! to pass. Run with `cargo run --release -p glanz-sampling --example adaptive_sine`.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use std::sync::Arc;

use glanz_sampling::DensityError;
use glanz_sampling::density::{TensorMultiResolution, Weighting};
use glanz_sampling::integrate::{AdaptivePlan, Estimate, IntegrationPass, integrate_adaptively};
use glanz_sampling::multiresolution::MultiResolution;

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), DensityError> {
    let bases = [
        ("Haar", MultiResolution::haar(3)?, [1, 2, 3, 3]),
        ("hat functions", MultiResolution::bspline(1, 2)?, [0, 1, 2, 2]),
        ("quadratic B-splines", MultiResolution::bspline(2, 2)?, [0, 1, 2, 2]),
    ];
    println!("integral of sin(pi x / 2), 100000 samples per pass; exact {FRAC_2_PI:.7}\n");
    println!(
        "{:<20} {:>4} {:>6} {:>11} {:>14} {:>12}",
        "basis", "pass", "level", "integral", "standard error", "variance"
    );
    for (name, analysis, levels) in bases {
        let analyses = Arc::new(TensorMultiResolution::new([analysis]));
        let passes = levels.map(|level| IntegrationPass { levels: [level], samples: 100_000 });
        let plan = AdaptivePlan::new(passes.to_vec(), 2001);
        let result = integrate_adaptively(&analyses, &plan, |x| (FRAC_PI_2 * x[0]).sin())?;
        for (index, pass) in result.passes.iter().enumerate() {
            let estimate = pass.estimate;
            println!(
                "{name:<20} {:>4} {:>6} {:>11.7} {:>14.7} {:>12.3e}",
                index + 1,
                pass.levels[0],
                estimate.mean,
                estimate.standard_error(),
                estimate.primary_variance
            );
        }
        // Early passes are noisy; weights inverse to the variances limit their influence.
        let estimates: Vec<Estimate> = result.passes.iter().map(|pass| pass.estimate).collect();
        for (label, weighting) in
            [("by samples", Weighting::Samples), ("by variance", Weighting::InverseVariance)]
        {
            if let Some(all) = Estimate::combine(&estimates, weighting) {
                println!("{name:<20} {label:>11} {:>11.7} {:>14.7}", all.mean, all.standard_error());
            }
        }
        println!();
    }
    Ok(())
}
