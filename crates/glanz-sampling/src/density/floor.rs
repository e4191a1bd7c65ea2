//! How small coefficients are raised.

use crate::basis::TensorBasis;

/// How the coefficients of an approximation are raised before it is made a density.
///
/// Negative coefficients have to go (@pietrek2001 section 2.4.3.1), and a density must not vanish where the integrand was
/// only estimated too low (section 2.4.3.2). `mean` below is the integral of the approximated function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Floor {
    /// To 0: the density may vanish where the integrand does not, and then the integral is wrong.
    Zero,
    /// To tau `mean` w_j, the rule as document 003 prints it, and the one that its tables were made with.
    ///
    /// In an orthonormal basis the function tau `mean` has these coefficients. In a basis of B-splines it has tau `mean`, and
    /// this floor is lower by w_j: it sinks with the scale, to where smooth integrands that vanish somewhere are followed
    /// further down, but protects less.
    Weighted(f64),
    /// To the coefficients of the constant tau `mean`, in any basis: the density is nowhere below about tau.
    Constant(f64),
    /// To this number, as the example of document 003 section 2.4.4.2 does it.
    Absolute(f64),
}

impl Default for Floor {
    /// The document's: [`Floor::Weighted`] with tau = 1 / 10.
    fn default() -> Self {
        Self::Weighted(0.1)
    }
}

impl Floor {
    /// Raises the coefficients in place; further coefficients than the basis has functions stay.
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
