//! The error of bases, densities and integrators.

/// Invalid arguments of bases, multiresolution analyses, densities and integrators.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DensityError {
    /// The degree of a B-spline is above [`crate::basis::MAX_DEGREE`].
    #[error("the degree is {degree}; the largest possible degree is {max}")]
    Degree {
        /// Degree given.
        degree: usize,
        /// Highest degree possible.
        max: usize,
    },
    /// Too few knots, no segments, or too many segments.
    #[error("{found} knots are too few or too many for a knot vector of degree {degree}")]
    KnotCount {
        /// Knots given.
        found: usize,
        /// Degree given.
        degree: usize,
    },
    /// A knot is NaN, less than the one before it, or repeated so often that a function has no support.
    #[error("knot {index} is {value}; knots must not decrease nor repeat more often than the order")]
    Knot {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// One of the first degree + 1 knots is not 0, or one of the last is not 1.
    #[error("the end knot {index} is {value}; the first degree + 1 knots must be 0, the last must be 1")]
    EndKnot {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A coarse space is not a subspace of a finer one.
    #[error(
        "the finer knots do not contain the coarser ones, or the degrees differ; refine by inserting knots"
    )]
    NotNested,
    /// The number of coefficients differs from the dimension of the space.
    #[error("there are {found} coefficients; the dimension of the space is {expected}")]
    Length {
        /// Coefficients given.
        found: usize,
        /// Dimension of the space.
        expected: usize,
    },
    /// A coefficient of a density is negative, infinite or NaN.
    #[error("coefficient {index} is {value}; it must be finite and not negative")]
    Coefficient {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// An integral is not positive or not finite.
    #[error("the integral is {0}; it must be positive and finite for a density")]
    Integral(f64),
    /// A level that the multiresolution analysis does not have, or a step from a finer to a coarser level.
    #[error("the level is {level}; it must lie between {lowest} and {highest}")]
    Level {
        /// Level given.
        level: usize,
        /// Coarsest level possible.
        lowest: usize,
        /// Finest level possible.
        highest: usize,
    },
    /// A matrix of inner products is not positive definite up to rounding.
    #[error(
        "the inner products are not positive definite: pivot {pivot} is {value}; use fewer or longer segments"
    )]
    Pivot {
        /// Row of the pivot.
        pivot: usize,
        /// Its value.
        value: f64,
    },
    /// No samples, no repetitions or no passes.
    #[error("there are no samples, repetitions or passes; at least 1 of each is needed")]
    Samples,
    /// Two operands belong to different bases.
    #[error("the operands belong to different bases; they must share one basis")]
    Mismatch,
}
