//! Lower bounds on the coefficients of a density.

use crate::basis::TensorBasis;

/// The lower bound to which the coefficients of an approximation are raised before it becomes a density.
///
/// Coefficients must not be negative (@pietrek2001 section 2.4.3.1), and a density must not vanish where the integrand was
/// underestimated (section 2.4.3.2). `mean` below is the integral of the approximated function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoefficientFloor {
    /// 0: the density may vanish where the integrand does not, which biases the integral.
    Zero,
    /// tau `mean` w_j, the rule printed in document 003 and used for its tables.
    ///
    /// In an orthonormal basis these are the coefficients of the constant tau `mean`. In a basis of B-splines that constant has the
    /// coefficients tau `mean`, and this bound is lower by w_j: it decreases on finer levels, which follows smooth integrands
    /// closer to their zeros but protects less.
    Weighted(f64),
    /// The coefficients of the constant tau `mean`, in any basis: the density is nowhere below about tau.
    Constant(f64),
    /// This number, as in the example of document 003 section 2.4.4.2.
    Absolute(f64),
}

impl Default for CoefficientFloor {
    /// The rule of document 003: [`CoefficientFloor::Weighted`] with tau = 1 / 10.
    fn default() -> Self {
        Self::Weighted(0.1)
    }
}

impl CoefficientFloor {
    /// Raises the coefficients in place; coefficients beyond the number of functions stay unchanged.
    pub fn apply<const D: usize>(self, basis: &TensorBasis<D>, coefficients: &mut [f64], mean: f64) {
        let raise = |c: &mut f64, floor: f64| *c = c.max(floor.max(0.0));
        match self {
            Self::Zero => coefficients.iter_mut().for_each(|c| raise(c, 0.0)),
            Self::Weighted(tau) => {
                let weights = basis.weights();
                coefficients.iter_mut().zip(&weights).for_each(|(c, w)| raise(c, tau * mean * w));
            }
            Self::Constant(tau) => {
                let floor = tau * mean * basis.unit_coefficient();
                coefficients.iter_mut().for_each(|c| raise(c, floor));
            }
            Self::Absolute(floor) => coefficients.iter_mut().for_each(|c| raise(c, floor)),
        }
    }
}
