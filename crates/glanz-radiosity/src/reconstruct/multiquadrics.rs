//! Interpolation by sums of radial functions.

use glanz_math::{DVec2, DVec3};

use super::dense::solve;
use super::{Interpolant, ReconstructError, Sample};

/// Largest residual of a valid solution, relative to the largest value.
const MAX_RESIDUAL: f64 = 1e-6;

/// A radial function for each sample, whose radius is the distance to the nearest other sample.
///
/// # Source
/// @hardy1971; @pietrek2001 section 4.5.2.
pub(super) struct Multiquadrics {
    functions: Vec<RadialFunction>,
    exponent: f64,
}

struct RadialFunction {
    point: DVec2,
    /// Square of the radius.
    radius: f64,
    factor: DVec3,
}

impl Multiquadrics {
    /// `exponent`: finite and not 0.
    ///
    /// # Errors
    /// [`ReconstructError::Points`] for samples at one point, [`ReconstructError::Singular`] for equations without a unique solution.
    pub(super) fn try_new(samples: &[Sample], exponent: f64) -> Result<Self, ReconstructError> {
        let n = samples.len();
        let mut functions = Vec::with_capacity(n);
        for (i, sample) in samples.iter().enumerate() {
            let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
            let nearest =
                others.map(|(_, s)| s.point.distance_squared(sample.point)).fold(f64::INFINITY, f64::min);
            if nearest == 0.0 {
                return Err(ReconstructError::Points);
            }
            // A single sample has no neighbour; any radius reproduces its value at its point.
            let radius = if nearest.is_finite() { nearest } else { 1.0 };
            functions.push(RadialFunction { point: sample.point, radius, factor: DVec3::ZERO });
        }
        let entry = |row: &Sample, column: &RadialFunction| {
            power(row.point.distance_squared(column.point) + column.radius, exponent)
        };
        let system: Vec<f64> =
            samples.iter().flat_map(|row| functions.iter().map(move |column| entry(row, column))).collect();
        let values: Vec<DVec3> = samples.iter().map(|sample| sample.value).collect();
        let factors = solve(system.clone(), &values).ok_or(ReconstructError::Singular(n))?;
        let rest = system.chunks_exact(n.max(1)).zip(&values).map(|(row, value)| {
            row.iter().zip(&factors).map(|(entry, factor)| *entry * *factor).sum::<DVec3>() - *value
        });
        let largest = values.iter().map(|value| value.abs().max_element()).fold(0.0, f64::max);
        // False for values that are not numbers.
        let is_solution = |rest: DVec3| rest.abs().cmple(DVec3::splat(MAX_RESIDUAL * largest)).all();
        if !rest.into_iter().all(is_solution) {
            return Err(ReconstructError::Singular(n));
        }
        for (function, factor) in functions.iter_mut().zip(factors) {
            function.factor = factor;
        }
        Ok(Self { functions, exponent })
    }
}

fn power(x: f64, exponent: f64) -> f64 {
    match exponent {
        0.5 => x.sqrt(),
        -0.5 => 1.0 / x.sqrt(),
        other => x.powf(other),
    }
}

impl Interpolant for Multiquadrics {
    fn value(&self, point: DVec2) -> DVec3 {
        let term =
            |f: &RadialFunction| power(f.point.distance_squared(point) + f.radius, self.exponent) * f.factor;
        self.functions.iter().map(term).sum()
    }
}
