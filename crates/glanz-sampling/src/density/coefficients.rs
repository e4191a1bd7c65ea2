//! Densities from coefficients.

use std::sync::Arc;

use crate::basis::{BELOW_ONE, FunctionBasis, TensorBasis, check_length};
use crate::density::CoefficientFloor;
use crate::error::DensityError;

/// A probability density on [0, 1]^D: a linear combination of the functions of a tensor product basis with nonnegative
/// coefficients.
///
/// # Source
/// @pietrek2001 sections 2.4.1 and 2.6.1.
#[derive(Clone, Debug, PartialEq)]
pub struct Density<const D: usize> {
    basis: Arc<TensorBasis<D>>,
    coefficients: Vec<f64>,
    /// For each axis, and each choice of functions on the axes before it, the cumulative probabilities of the functions on it.
    cumulative: [Vec<f64>; D],
}

/// A point drawn from a density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensitySample<const D: usize> {
    /// Position, in [0, 1)^D.
    pub point: [f64; D],
    /// Density at the point.
    pub pdf: f64,
    /// Index of the basis function that it was drawn from.
    pub function: usize,
}

impl<const D: usize> Density<D> {
    /// The density proportional to the function with these coefficients (@pietrek2001 equation 2.20).
    ///
    /// # Errors
    /// [`DensityError::Length`], [`DensityError::Coefficient`] if one is negative or not finite, and
    /// [`DensityError::Integral`] if all are 0.
    pub fn try_new(basis: Arc<TensorBasis<D>>, mut coefficients: Vec<f64>) -> Result<Self, DensityError> {
        check_length(&coefficients, basis.len())?;
        let wrong = coefficients.iter().position(|c| !(c.is_finite() && *c >= 0.0));
        if let Some(index) = wrong {
            return Err(DensityError::Coefficient { index, value: coefficients[index] });
        }
        let masses: Vec<f64> = basis.weights().iter().zip(&coefficients).map(|(w, c)| w * c).collect();
        let total: f64 = masses.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(DensityError::Integral(total));
        }
        coefficients.iter_mut().for_each(|c| *c /= total);
        let cumulative = cumulative_probabilities(&basis, masses);
        Ok(Self { basis, coefficients, cumulative })
    }

    /// The constant density 1.
    #[must_use]
    pub fn uniform(basis: Arc<TensorBasis<D>>) -> Self {
        let unit = basis.unit_coefficient();
        let coefficients = vec![unit; basis.len()];
        let masses: Vec<f64> = basis.weights().iter().map(|w| w * unit).collect();
        let cumulative = cumulative_probabilities(&basis, masses);
        Self { basis, coefficients, cumulative }
    }

    /// The constant density 1 in the basis of a single function.
    ///
    /// # Errors
    /// Those of [`TensorBasis::try_new`], which do not occur.
    pub fn constant() -> Result<Self, DensityError> {
        let mut axes = Vec::with_capacity(D);
        for _ in 0..D {
            axes.push(FunctionBasis::haar(0)?);
        }
        let axes = axes.try_into().map_err(|_| DensityError::Mismatch)?;
        Ok(Self::uniform(Arc::new(TensorBasis::try_new(axes)?)))
    }

    /// The density from the coefficients of an approximation, which may be negative: they are raised to `floor`, with `mean` the
    /// integral of the approximated function, and normalized.
    ///
    /// # Errors
    /// As [`Density::try_new`].
    pub fn from_approximation(
        basis: Arc<TensorBasis<D>>,
        mut coefficients: Vec<f64>,
        mean: f64,
        floor: CoefficientFloor,
    ) -> Result<Self, DensityError> {
        check_length(&coefficients, basis.len())?;
        floor.apply(&basis, &mut coefficients, mean);
        Self::try_new(basis, coefficients)
    }

    /// The basis.
    #[must_use]
    pub fn basis(&self) -> &Arc<TensorBasis<D>> {
        &self.basis
    }

    /// The normalized coefficients, the last axis fastest.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The density at `x`; 0 outside [0, 1]^D.
    #[inline]
    #[must_use]
    pub fn pdf(&self, x: &[f64; D]) -> f64 {
        self.basis.sum(&self.coefficients, x)
    }

    /// A point from the uniform numbers `xi` in [0, 1)^D.
    ///
    /// Number a chooses the function on axis a and, rescaled to [0, 1), the coordinate from it, which preserves stratification.
    #[inline]
    #[must_use]
    pub fn sample(&self, xi: &[f64; D]) -> DensitySample<D> {
        let mut point = [0.0; D];
        let mut function = 0;
        for (a, (axis, table)) in self.basis.axes().iter().zip(&self.cumulative).enumerate() {
            let n = axis.len();
            let row = &table[function * n..(function + 1) * n];
            let xi = xi[a].clamp(0.0, BELOW_ONE);
            // The first bound above xi is the end of an interval of positive length that contains xi.
            let j = row.partition_point(|&c| c <= xi).min(n - 1);
            let low = if j == 0 { 0.0 } else { row[j - 1] };
            point[a] = axis.sample(j, (xi - low) / (row[j] - low));
            function = function * n + j;
        }
        DensitySample { point, pdf: self.pdf(&point), function }
    }

    /// The probability that a sample is drawn from function `index` (@pietrek2001 equation 2.14).
    #[must_use]
    pub fn probability(&self, index: usize) -> f64 {
        self.coefficients.get(index).map_or(0.0, |c| c * self.basis.weight(index))
    }

    /// The mixture of this density, with the weight 1 - `uniform_weight`, and the constant 1, with `uniform_weight`.
    ///
    /// With a positive weight, no estimator f / p exceeds f / `uniform_weight`. The weight is clamped to [0, 1].
    #[must_use]
    pub fn mixed_with_uniform(&self, uniform_weight: f64) -> Self {
        let weight = uniform_weight.clamp(0.0, 1.0);
        let unit = self.basis.unit_coefficient();
        let mixed = self.coefficients.iter().map(|c| (1.0 - weight) * c + weight * unit).collect();
        // A mixture of two densities is a density, so that the constructor succeeds.
        Self::try_new(self.basis.clone(), mixed).unwrap_or_else(|_| self.clone())
    }

    /// The variance of f / p for samples from this density (@pietrek2001 equation 2.6), by quadrature with `nodes` nodes along each
    /// axis of each cell between knots. It is infinite if the density is 0 where f is not.
    #[must_use]
    pub fn primary_variance(&self, nodes: usize, mut f: impl FnMut(&[f64; D]) -> f64) -> f64 {
        let (mut integral, mut square) = (0.0, 0.0);
        self.basis.for_each_node(nodes, |x, weight| {
            let value = f(x);
            integral += weight * value;
            if value != 0.0 {
                square += weight * value * value / self.pdf(x);
            }
        });
        square - integral * integral
    }
}

/// The cumulative probabilities for each axis, from the masses of all functions.
fn cumulative_probabilities<const D: usize>(basis: &TensorBasis<D>, mut masses: Vec<f64>) -> [Vec<f64>; D] {
    let mut cumulative = [const { Vec::new() }; D];
    // From the last axis to the first; the masses are summed over the axes that are done.
    for (table, axis) in cumulative.iter_mut().zip(basis.axes()).rev() {
        let rows = masses.chunks_exact(axis.len());
        *table = rows.clone().flat_map(cumulative_fractions).collect();
        masses = rows.map(|row| row.iter().sum()).collect();
    }
    cumulative
}

/// The running sums of `masses` divided by their total; the last is 1.
fn cumulative_fractions(masses: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let total: f64 = masses.iter().sum();
    let mut sum = 0.0;
    masses.iter().map(move |m| {
        sum += m;
        // A row of mass 0 is never chosen.
        if total > 0.0 { sum / total } else { 1.0 }
    })
}
