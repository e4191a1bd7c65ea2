//! Why a surface cannot be built.

/// What is wrong with the parameters of a surface. Every variant names the parameter and carries its value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A parameter is infinite or not a number.
    #[error("{parameter} is {value}, it must be finite")]
    NotFinite {
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter that is a size is zero or negative.
    #[error("{parameter} is {value}, it must be greater than zero")]
    NotPositive {
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter lies outside the range in which it makes sense.
    #[error("{parameter} is {value}, it must lie between {min} and {max}")]
    OutOfRange {
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
    /// A range keeps nothing of the surface.
    #[error("{parameter} from {min} to {max} keeps nothing of the surface")]
    EmptyRange {
        /// Which parameter.
        parameter: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// The parameters are legal one by one but the surface collapses to a curve, a point or nothing.
    #[error("the surface has no area: {reason} ({value})")]
    Degenerate {
        /// What coincides, in words.
        reason: &'static str,
        /// The quantity that should be larger, or smaller.
        value: f64,
    },
    /// Half-spaces leave a way out.
    #[error("the half-spaces have no end in the direction ({}, {}, {})", direction[0], direction[1], direction[2])]
    Unbounded {
        /// A direction in which one can go on for ever.
        direction: [f64; 3],
    },
    /// A list is too short for the surface.
    #[error("{count} {parameter}, at least {min} are needed")]
    TooFew {
        /// Which list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries needed.
        min: usize,
    },
    /// Two lists that belong together differ in length.
    #[error("{count} {parameter}, there must be {expected}")]
    CountMismatch {
        /// Which list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries needed.
        expected: usize,
    },
    /// An index points past the end of its list.
    #[error("{parameter} {position} refers to entry {index}, there are only {count}")]
    BadIndex {
        /// Which list holds the index.
        parameter: &'static str,
        /// Where in that list.
        position: usize,
        /// The index.
        index: u64,
        /// Length of the list that it points into.
        count: usize,
    },
    /// A polynomial has a term of too high a degree.
    #[error("a term of {parameter} has degree {degree}, at most {max} is possible")]
    DegreeTooHigh {
        /// Which polynomial.
        parameter: &'static str,
        /// Degree given.
        degree: u32,
        /// Largest degree possible.
        max: u32,
    },
    /// A knot is less than the one before it.
    #[error("{parameter} {position} is {value}, less than {previous} before it")]
    KnotsDecrease {
        /// Which knot vector.
        parameter: &'static str,
        /// Where in that vector.
        position: usize,
        /// The knot.
        value: f64,
        /// The knot before it.
        previous: f64,
    },
    /// A knot stands in its vector too often.
    #[error("{parameter} {value} would stand there {multiplicity} times, at most {max} are possible")]
    KnotMultiplicity {
        /// Which knot vector.
        parameter: &'static str,
        /// The knot.
        value: f64,
        /// How often it stands there.
        multiplicity: usize,
        /// How often it may.
        max: usize,
    },
    /// A knot cannot be left out: the shape would change.
    #[error("without {parameter} {value} the shape would move by up to {deviation}, {tolerance} is allowed")]
    KnotNeeded {
        /// Which knot vector.
        parameter: &'static str,
        /// The knot.
        value: f64,
        /// Bound on the distance that a point would move, metres.
        deviation: f64,
        /// Distance allowed, metres.
        tolerance: f64,
    },
}

/// The checks of single numbers for an error that has the variants `NotFinite` and `NotPositive`.
///
/// A macro, as with a type parameter for the error `?` could not tell which one is meant.
macro_rules! number_checks {
    ($error:ident) => {
        /// `value`, if it is finite.
        pub(crate) fn finite(parameter: &'static str, value: f64) -> Result<f64, $error> {
            if value.is_finite() { Ok(value) } else { Err($error::NotFinite { parameter, value }) }
        }

        /// `value`, if it is finite and greater than zero.
        pub(crate) fn positive(parameter: &'static str, value: f64) -> Result<f64, $error> {
            let value = finite(parameter, value)?;
            if value > 0.0 { Ok(value) } else { Err($error::NotPositive { parameter, value }) }
        }
    };
}
pub(crate) use number_checks;

number_checks!(SurfaceError);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_return_the_offending_value() {
        assert_eq!(positive("radius", 2.0), Ok(2.0));
        assert_eq!(
            positive("radius", 0.0),
            Err(SurfaceError::NotPositive { parameter: "radius", value: 0.0 })
        );
        assert!(
            matches!(positive("radius", f64::NAN), Err(SurfaceError::NotFinite { value, .. }) if value.is_nan())
        );
    }

    #[test]
    fn messages_name_parameter_and_value() {
        let error = SurfaceError::NotPositive { parameter: "radius", value: -1.5 };
        assert_eq!(error.to_string(), "radius is -1.5, it must be greater than zero");
    }
}
