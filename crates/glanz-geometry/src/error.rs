//! The error of all constructors.

use glanz_math::DVec2;

/// Invalid parameters of a surface, a spline or a trimming region. Every variant names the parameter and holds its value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A parameter is infinite or not a number.
    #[error("{parameter} is {value}; it must be finite")]
    NotFinite {
        /// The parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter that is a size is zero or negative.
    #[error("{parameter} is {value}; it must be positive")]
    NotPositive {
        /// The parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter lies outside its valid range.
    #[error("{parameter} is {value}; it must lie between {min} and {max}")]
    OutOfRange {
        /// The parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
    /// A range contains no part of the surface.
    #[error("{parameter} from {min} to {max} contains no part of the surface")]
    EmptyRange {
        /// The parameter.
        parameter: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// Each parameter is valid but together they make a curve, a point or nothing.
    #[error("the surface has no area: {reason} ({value})")]
    Degenerate {
        /// The reason.
        reason: &'static str,
        /// The measured quantity.
        value: f64,
    },
    /// The intersection of half-spaces is unbounded.
    #[error("the intersection of the half-spaces is unbounded in the direction ({}, {}, {}); add one that bounds it", direction[0], direction[1], direction[2])]
    Unbounded {
        /// A direction in which it is unbounded.
        direction: [f64; 3],
    },
    /// A list is too short.
    #[error("there are {count} {parameter}; at least {min} are needed")]
    TooFew {
        /// The list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries needed.
        min: usize,
    },
    /// A list has the wrong length.
    #[error("there are {count} {parameter}; {expected} are needed")]
    CountMismatch {
        /// The list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries needed.
        expected: usize,
    },
    /// An index points past the end of its list.
    #[error("{parameter} {position} refers to entry {index}; there are only {count}")]
    BadIndex {
        /// The list that contains the index.
        parameter: &'static str,
        /// Position in that list.
        position: usize,
        /// The index.
        index: u64,
        /// Length of the list that it refers to.
        count: usize,
    },
    /// A polynomial has a term of too high a degree.
    #[error("a term of {parameter} has degree {degree}; the largest possible degree is {max}")]
    DegreeTooHigh {
        /// The polynomial.
        parameter: &'static str,
        /// Degree given.
        degree: u32,
        /// Largest degree possible.
        max: u32,
    },
    /// A knot is less than the one before it.
    #[error("{parameter} {position} is {value}, less than {previous} before it; sort the knots")]
    KnotsDecrease {
        /// The knot vector.
        parameter: &'static str,
        /// Position in that vector.
        position: usize,
        /// The knot.
        value: f64,
        /// The knot before it.
        previous: f64,
    },
    /// A knot is repeated too often.
    #[error("{parameter} {value} appears {multiplicity} times; at most {max} are possible")]
    KnotMultiplicity {
        /// The knot vector.
        parameter: &'static str,
        /// The knot.
        value: f64,
        /// Number of repetitions.
        multiplicity: usize,
        /// Largest number possible.
        max: usize,
    },
    /// A knot cannot be removed without changing the shape.
    #[error(
        "removing {parameter} {value} would move the shape by up to {deviation}; the tolerance is {tolerance}"
    )]
    KnotNeeded {
        /// The knot vector.
        parameter: &'static str,
        /// The knot.
        value: f64,
        /// Bound on the distance that a point would move, metres.
        deviation: f64,
        /// Distance allowed, metres.
        tolerance: f64,
    },
    /// A tolerance is negative.
    #[error("{parameter} is {value}; it must not be negative")]
    Negative {
        /// The parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A list is longer than its indices can count.
    #[error("there are {count} {parameter}; at most {max} are possible")]
    TooMany {
        /// The list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries possible.
        max: usize,
    },
    /// Triangles around a vertex do not make a surface that can be subdivided.
    #[error(
        "the triangles around vertex {vertex} make no surface: {reason}; give each sheet vertices of its own"
    )]
    NotManifold {
        /// The vertex, from 0.
        vertex: u32,
        /// The reason.
        reason: &'static str,
    },
    /// Two consecutive curves of a trimming loop do not meet.
    #[error(
        "curve {curve} of the trimming loop ends at ({}, {}) and curve {next} starts at ({}, {}), {gap} away; \
         the tolerance is {tolerance}",
        end.x, end.y, start.x, start.y
    )]
    OpenLoop {
        /// Number of the curve that ends, from 0.
        curve: usize,
        /// Number of the next curve, from 0.
        next: usize,
        /// End of the former.
        end: DVec2,
        /// Start of the latter.
        start: DVec2,
        /// Their distance, parameter units.
        gap: f64,
        /// The distance allowed.
        tolerance: f64,
    },
    /// All curves of a trimming loop are one point.
    #[error("the trimming loop is the single point ({}, {}); it must have an extent", point.x, point.y)]
    CollapsedLoop {
        /// The point.
        point: DVec2,
    },
}

/// `value`, if it is finite.
pub(crate) fn finite(parameter: &'static str, value: f64) -> Result<f64, SurfaceError> {
    if value.is_finite() { Ok(value) } else { Err(SurfaceError::NotFinite { parameter, value }) }
}

/// `value`, if it is finite and greater than zero.
pub(crate) fn positive(parameter: &'static str, value: f64) -> Result<f64, SurfaceError> {
    let value = finite(parameter, value)?;
    if value > 0.0 { Ok(value) } else { Err(SurfaceError::NotPositive { parameter, value }) }
}

/// `value`, if it is finite and not negative.
pub(crate) fn not_negative(parameter: &'static str, value: f64) -> Result<f64, SurfaceError> {
    let value = finite(parameter, value)?;
    if value >= 0.0 { Ok(value) } else { Err(SurfaceError::Negative { parameter, value }) }
}

/// `point`, if its coordinates are finite.
pub(crate) fn finite_point(parameter: &'static str, point: DVec2) -> Result<DVec2, SurfaceError> {
    Ok(DVec2::new(finite(parameter, point.x)?, finite(parameter, point.y)?))
}

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
        assert_eq!(error.to_string(), "radius is -1.5; it must be positive");
    }
}
