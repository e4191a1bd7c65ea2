//! Why a basis, a density or an integration cannot be.

/// What bases, multiresolution analyses, densities and integrators refuse.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DensityError {
    /// The degree of a B-spline is above [`crate::basis::MAX_DEGREE`].
    #[error("degree {degree} is above {max}")]
    Degree {
        /// Degree asked for.
        degree: usize,
        /// Highest possible degree.
        max: usize,
    },
    /// Too few knots, or none, or too many segments.
    #[error("{found} knots are no knot vector of degree {degree}")]
    KnotCount {
        /// Knots given.
        found: usize,
        /// Degree asked for.
        degree: usize,
    },
    /// A knot is not a number, decreases, or repeats so often that a function has no support.
    #[error("knot {index} is {value}, which does not go with its neighbours")]
    Knot {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The first degree + 1 knots have to be 0, the last ones 1.
    #[error("the end knot {index} is {value}")]
    EndKnot {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A coarse space does not lie in a finer one.
    #[error("the finer knots do not contain the coarser ones, or the degrees differ")]
    NotNested,
    /// The number of coefficients is not the dimension of the space.
    #[error("{found} coefficients for a space of dimension {expected}")]
    Length {
        /// Coefficients given.
        found: usize,
        /// Dimension of the space.
        expected: usize,
    },
    /// A coefficient of a density is negative, infinite or not a number.
    #[error("coefficient {index} is {value}, it has to be a number of at least 0")]
    Coefficient {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// An integral that has to be positive and finite is not.
    #[error("the integral is {0}, no density can be made of it")]
    Integral(f64),
    /// A scale that the multiresolution analysis does not have, or a step from a finer to a coarser one.
    #[error("scale {level} is not between {lowest} and {highest}")]
    Level {
        /// Scale asked for.
        level: usize,
        /// Coarsest possible.
        lowest: usize,
        /// Finest possible.
        highest: usize,
    },
    /// A matrix of inner products is not positive definite within rounding.
    #[error("inner products are not positive definite: pivot {pivot} is {value}")]
    Pivot {
        /// Row of the pivot.
        pivot: usize,
        /// Its value.
        value: f64,
    },
    /// No samples, no repetitions or no passes, or more than 2^32 - 1 samples in one of them.
    #[error("nothing to integrate with: samples, repetitions and passes have to be at least 1")]
    Samples,
    /// Two things that should be of one basis are not.
    #[error("the parts belong to different bases")]
    Mismatch,
}
