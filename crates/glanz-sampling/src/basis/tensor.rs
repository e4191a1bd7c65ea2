//! Products of bases, one per axis of the unit cube.

use crate::basis::{FunctionBasis, GaussLegendre, GramMatrix, ORDER, check_length};
use crate::error::DensityError;

/// The products of the functions of `D` bases, one per axis of [0, 1]^D; the bases may differ.
///
/// Function (j_0, ..., j_(D-1)) has the index that counts the last axis fastest. Indices of functions must be below
/// [`TensorBasis::len`].
#[derive(Clone, Debug, PartialEq)]
pub struct TensorBasis<const D: usize> {
    axes: [FunctionBasis; D],
    grams: [GramMatrix; D],
    len: usize,
}

impl<const D: usize> TensorBasis<D> {
    /// The product of these bases.
    ///
    /// # Errors
    /// [`DensityError::Pivot`] as [`FunctionBasis::gram`]; [`DensityError::Length`] for more than 2^32 - 1 functions.
    pub fn try_new(axes: [FunctionBasis; D]) -> Result<Self, DensityError> {
        let len = axes.iter().fold(1_usize, |product, basis| product.saturating_mul(basis.len()));
        if u32::try_from(len).is_err() {
            return Err(DensityError::Length { found: len, expected: u32::MAX as usize });
        }
        let mut grams = Vec::with_capacity(D);
        for basis in &axes {
            grams.push(basis.gram()?);
        }
        let grams = grams.try_into().map_err(|_| DensityError::Mismatch)?;
        Ok(Self { axes, grams, len })
    }

    /// The bases of the axes.
    #[must_use]
    pub fn axes(&self) -> &[FunctionBasis; D] {
        &self.axes
    }

    /// The Gram matrices of the axes, whose products are the inner products of the basis functions.
    #[must_use]
    pub fn grams(&self) -> &[GramMatrix; D] {
        &self.grams
    }

    /// Number of functions along each axis.
    #[must_use]
    pub fn shape(&self) -> [usize; D] {
        std::array::from_fn(|a| self.axes[a].len())
    }

    /// Number of functions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Always `false`: there is at least one function.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The coefficient of every function in the constant 1.
    #[must_use]
    pub fn unit_coefficient(&self) -> f64 {
        self.axes.iter().map(|b| 1.0 / b.sum()).product()
    }

    /// The integral of function `index`.
    #[must_use]
    pub fn weight(&self, index: usize) -> f64 {
        let mut rest = index;
        let mut weight = 1.0;
        for basis in self.axes.iter().rev() {
            weight *= basis.weights()[rest % basis.len()];
            rest /= basis.len();
        }
        weight
    }

    /// The integrals of all functions, in the order of their indices.
    #[must_use]
    pub fn weights(&self) -> Vec<f64> {
        let mut weights = vec![1.0];
        for basis in &self.axes {
            weights = weights.iter().flat_map(|w| basis.weights().iter().map(move |v| w * v)).collect();
        }
        weights
    }

    /// Calls `visit` with index and value of every function that does not vanish near `x`, a point of [0, 1]^D.
    #[inline]
    pub fn for_each_nonzero(&self, x: &[f64; D], mut visit: impl FnMut(usize, f64)) {
        let mut first = [0; D];
        let mut values = [[0.0; ORDER]; D];
        for a in 0..D {
            (first[a], values[a]) = self.axes[a].nonzero(x[a]);
        }
        let mut offset = [0; D];
        loop {
            let (mut index, mut value) = (0, 1.0);
            for a in 0..D {
                index = index * self.axes[a].len() + first[a] + offset[a];
                value *= values[a][offset[a]];
            }
            visit(index, value);
            // Advances, the last axis fastest.
            let Some(a) = (0..D).rev().find(|&a| offset[a] < self.axes[a].degree()) else { return };
            offset[a] += 1;
            offset[a + 1..].fill(0);
        }
    }

    /// The value at `x` of the function with these coefficients; 0 outside [0, 1]^D.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn evaluate(&self, coefficients: &[f64], x: &[f64; D]) -> Result<f64, DensityError> {
        check_length(coefficients, self.len)?;
        Ok(self.sum(coefficients, x))
    }

    /// As [`TensorBasis::evaluate`], without the check of the length.
    #[inline]
    pub(crate) fn sum(&self, coefficients: &[f64], x: &[f64; D]) -> f64 {
        if !x.iter().all(|x| (0.0..=1.0).contains(x)) {
            return 0.0;
        }
        let mut sum = 0.0;
        self.for_each_nonzero(x, |index, value| sum += coefficients[index] * value);
        sum
    }

    /// Converts dual to primary coefficients in place, axis by axis.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn to_primary(&self, coefficients: &mut Vec<f64>) -> Result<(), DensityError> {
        check_length(coefficients, self.len)?;
        self.solve(coefficients);
        Ok(())
    }

    /// Converts primary to dual coefficients, axis by axis.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn to_dual(&self, coefficients: &[f64]) -> Result<Vec<f64>, DensityError> {
        check_length(coefficients, self.len)?;
        let mut dual = coefficients.to_vec();
        for (a, gram) in self.grams.iter().enumerate() {
            dual = map_axis(&dual, &self.shape(), a, |line| gram.multiply(line));
        }
        Ok(dual)
    }

    /// Calls `visit` with the nodes and weights of a quadrature with `nodes` nodes along each axis of each cell between knots.
    pub fn for_each_node(&self, nodes: usize, mut visit: impl FnMut(&[f64; D], f64)) {
        let gauss = GaussLegendre::new(nodes);
        let lines: [Vec<(f64, f64)>; D] = std::array::from_fn(|a| {
            let segments = self.axes[a].knots().spans();
            let nodes_on = |(_, a, b): (usize, f64, f64)| {
                gauss.rule().iter().map(move |&(x, w)| (a + (b - a) * x, (b - a) * w))
            };
            segments.flat_map(nodes_on).collect()
        });
        let mut at = [0; D];
        loop {
            let x = std::array::from_fn(|a| lines[a][at[a]].0);
            visit(&x, (0..D).map(|a| lines[a][at[a]].1).product());
            let Some(a) = (0..D).rev().find(|&a| at[a] + 1 < lines[a].len()) else { return };
            at[a] += 1;
            at[a + 1..].fill(0);
        }
    }

    /// The inner products of `f` with all functions, by the quadrature of [`TensorBasis::for_each_node`].
    #[must_use]
    pub fn inner_products(&self, nodes: usize, mut f: impl FnMut(&[f64; D]) -> f64) -> Vec<f64> {
        let mut products = vec![0.0; self.len];
        self.for_each_node(nodes, |x, weight| {
            let term = weight * f(x);
            self.for_each_nonzero(x, |index, value| products[index] += term * value);
        });
        products
    }

    /// The coefficients of the orthogonal projection of `f` in L2, by the quadrature of [`TensorBasis::for_each_node`].
    #[must_use]
    pub fn project(&self, nodes: usize, f: impl FnMut(&[f64; D]) -> f64) -> Vec<f64> {
        let mut coefficients = self.inner_products(nodes, f);
        self.solve(&mut coefficients);
        coefficients
    }

    fn solve(&self, dual: &mut Vec<f64>) {
        for (a, gram) in self.grams.iter().enumerate() {
            *dual = map_axis(dual, &self.shape(), a, |line| {
                let mut solved = line.to_vec();
                gram.solve(&mut solved);
                solved
            });
        }
    }
}

/// Applies `map`, whose results have equal lengths, to every line along `axis` of an array of this shape, last axis fastest.
pub(crate) fn map_axis(
    values: &[f64],
    shape: &[usize],
    axis: usize,
    mut map: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let length = shape[axis];
    let inner: usize = shape[axis + 1..].iter().product();
    let mut mapped = Vec::with_capacity(values.len());
    for block in values.chunks_exact(length * inner) {
        let lines: Vec<Vec<f64>> = (0..inner)
            .map(|i| {
                let line: Vec<f64> = block[i..].iter().step_by(inner).copied().collect();
                map(&line)
            })
            .collect();
        let new_length = lines.first().map_or(0, Vec::len);
        for k in 0..new_length {
            mapped.extend(lines.iter().map(|line| line[k]));
        }
    }
    mapped
}
