//! Sums of radial functions.

use faer::Mat;
use faer::linalg::solvers::Solve;
use glanz_math::{DVec2, DVec3};

use super::{Interpolant, ReconstructError, Sample};

/// Largest residual of a solution that is taken for one, relative to the largest value.
const RESIDUAL: f64 = 1e-6;

/// A radial function for each sample, of a radius that is the distance to the next one.
///
/// # Source
/// @hardy1971; @pietrek2001 section 4.5.2.
pub(super) struct Multiquadrics {
    functions: Vec<Function>,
    exponent: f64,
}

struct Function {
    point: DVec2,
    /// Square of the radius.
    radius: f64,
    factor: DVec3,
}

impl Multiquadrics {
    /// # Errors
    /// [`ReconstructError`] for an exponent of 0, samples at one point, and equations that cannot be solved.
    pub(super) fn try_new(samples: &[Sample], exponent: f64) -> Result<Self, ReconstructError> {
        if exponent == 0.0 || !exponent.is_finite() {
            return Err(ReconstructError::Exponent("multiquadrics", exponent));
        }
        let n = samples.len();
        let mut functions = Vec::with_capacity(n);
        for (i, sample) in samples.iter().enumerate() {
            let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
            let nearest =
                others.map(|(_, s)| s.point.distance_squared(sample.point)).fold(f64::INFINITY, f64::min);
            if nearest == 0.0 {
                return Err(ReconstructError::Points);
            }
            // A single sample has no next one; any radius makes it a constant at its place.
            let radius = if nearest.is_finite() { nearest } else { 1.0 };
            functions.push(Function { point: sample.point, radius, factor: DVec3::ZERO });
        }
        let system = Mat::from_fn(n, n, |row, column| {
            let function = &functions[column];
            power(samples[row].point.distance_squared(function.point) + function.radius, exponent)
        });
        let values = Mat::from_fn(n, 3, |row, band| samples[row].value[band]);
        let factors = system.partial_piv_lu().solve(&values);
        let rest = &system * &factors - &values;
        let largest =
            |m: &Mat<f64>| (0..n).flat_map(|i| (0..3).map(move |j| m[(i, j)].abs())).fold(0.0, nan_max);
        // Not so for what is no number.
        let solved = largest(&rest) <= RESIDUAL * largest(&values);
        if !solved {
            return Err(ReconstructError::Singular(n));
        }
        for (i, function) in functions.iter_mut().enumerate() {
            function.factor = DVec3::new(factors[(i, 0)], factors[(i, 1)], factors[(i, 2)]);
        }
        Ok(Self { functions, exponent })
    }
}

/// The larger one, or what is no number.
fn nan_max(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
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
        let term = |f: &Function| power(f.point.distance_squared(point) + f.radius, self.exponent) * f.factor;
        self.functions.iter().map(term).sum()
    }
}
