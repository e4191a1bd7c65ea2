//! A density with given coefficients.

use std::sync::Arc;

use crate::basis::{BELOW_ONE, Basis, TensorBasis, check_length};
use crate::density::Floor;
use crate::error::DensityError;

/// A probability density on [0, 1]^D: a sum of the functions of a tensor product basis with coefficients of at least 0.
///
/// # Source
/// @pietrek2001 sections 2.4.1 and 2.6.1.
#[derive(Clone, Debug, PartialEq)]
pub struct Density<const D: usize> {
    basis: Arc<TensorBasis<D>>,
    coefficients: Vec<f64>,
    /// For each axis and each choice of functions on the axes before it: the distribution function of the choice on it.
    cumulative: [Vec<f64>; D],
}

/// A point drawn from a density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensitySample<const D: usize> {
    /// Where it is, in [0, 1)^D.
    pub point: [f64; D],
    /// The density at it.
    pub pdf: f64,
    /// The index of the function of the basis that it was drawn from.
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
        let cumulative = choices(&basis, masses);
        Ok(Self { basis, coefficients, cumulative })
    }

    /// The constant density 1.
    #[must_use]
    pub fn uniform(basis: Arc<TensorBasis<D>>) -> Self {
        let unit = basis.unit_coefficient();
        let coefficients = vec![unit; basis.len()];
        let masses: Vec<f64> = basis.weights().iter().map(|w| w * unit).collect();
        let cumulative = choices(&basis, masses);
        Self { basis, coefficients, cumulative }
    }

    /// The constant density 1 in the basis of a single function.
    ///
    /// # Errors
    /// None that can occur; those of [`TensorBasis::try_new`].
    pub fn constant() -> Result<Self, DensityError> {
        let mut axes = Vec::with_capacity(D);
        for _ in 0..D {
            axes.push(Basis::haar(0)?);
        }
        let axes = axes.try_into().map_err(|_| DensityError::Mismatch)?;
        Ok(Self::uniform(Arc::new(TensorBasis::try_new(axes)?)))
    }

    /// The density of an approximation whose coefficients may be negative: they are raised by `floor`, with `mean` as the
    /// integral of the function that was approximated, and normalised.
    ///
    /// # Errors
    /// As [`Density::try_new`].
    pub fn from_approximation(
        basis: Arc<TensorBasis<D>>,
        mut coefficients: Vec<f64>,
        mean: f64,
        floor: Floor,
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

    /// The coefficients, normalised; the last axis fastest.
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

    /// The point that the numbers `xi` in [0, 1)^D go to.
    ///
    /// Number a chooses the function on axis a and, stretched again to [0, 1), the point in it: numbers that are well
    /// spread stay so.
    #[inline]
    #[must_use]
    pub fn sample(&self, xi: &[f64; D]) -> DensitySample<D> {
        let mut point = [0.0; D];
        let mut function = 0;
        for (a, (axis, table)) in self.basis.axes().iter().zip(&self.cumulative).enumerate() {
            let n = axis.len();
            let row = &table[function * n..(function + 1) * n];
            let xi = xi[a].clamp(0.0, BELOW_ONE);
            // The first bound above xi closes an interval of positive length that holds xi.
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

    /// The density that takes a share of 1 - `share` from this one and `share` from the constant 1.
    ///
    /// With a share above 0 no estimator f / p exceeds f / share. `share` is taken into [0, 1].
    #[must_use]
    pub fn mixed_with_uniform(&self, share: f64) -> Self {
        let share = share.clamp(0.0, 1.0);
        let unit = self.basis.unit_coefficient();
        let mixed = self.coefficients.iter().map(|c| (1.0 - share) * c + share * unit).collect();
        // The mixture of two densities is one: the constructor has nothing to refuse.
        Self::try_new(self.basis.clone(), mixed).unwrap_or_else(|_| self.clone())
    }

    /// The variance of f / p for samples from this density (@pietrek2001 equation 2.6), by quadrature with `nodes` nodes
    /// along each axis of each cell of the knots. Infinite where f is not 0 but the density is.
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

/// For each axis the distribution functions of the choice on it; `masses` are those of all functions.
fn choices<const D: usize>(basis: &TensorBasis<D>, mut masses: Vec<f64>) -> [Vec<f64>; D] {
    let mut cumulative = [const { Vec::new() }; D];
    // From the last axis on: what is left of the masses is their sums over the axes done.
    for (table, axis) in cumulative.iter_mut().zip(basis.axes()).rev() {
        let rows = masses.chunks_exact(axis.len());
        *table = rows.clone().flat_map(running_shares).collect();
        masses = rows.map(|row| row.iter().sum()).collect();
    }
    cumulative
}

/// The running sums of `masses` over their sum; the last is 1.
fn running_shares(masses: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let total: f64 = masses.iter().sum();
    let mut sum = 0.0;
    masses.iter().map(move |m| {
        sum += m;
        // A row without mass is never chosen.
        if total > 0.0 { sum / total } else { 1.0 }
    })
}
