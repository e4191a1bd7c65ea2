//! Why a trimming curve, loop or region cannot be built.

use glanz_math::DVec2;

use crate::error::number_checks;

/// What is wrong with the curves that trim a parameter domain. Every variant carries the values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrimError {
    /// A number is infinite or not a number.
    #[error("{parameter} is {value}, it must be finite")]
    NotFinite {
        /// Which number.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number that must be greater than zero is not.
    #[error("{parameter} is {value}, it must be greater than zero")]
    NotPositive {
        /// Which number.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A tolerance is below zero.
    #[error("{parameter} is {value}, it must not be negative")]
    Negative {
        /// Which number.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// A list is too short.
    #[error("{count} {parameter}, at least {min} are needed")]
    TooFew {
        /// Which list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries needed.
        min: usize,
    },
    /// A list is longer than can be numbered.
    #[error("{count} {parameter}, at most {max} are possible")]
    TooMany {
        /// Which list.
        parameter: &'static str,
        /// Entries given.
        count: usize,
        /// Entries possible.
        max: usize,
    },
    /// The degree of a curve is zero or too high.
    #[error("the degree of a trimming curve is {degree}, it must lie between 1 and {max}")]
    Degree {
        /// Degree given.
        degree: usize,
        /// Largest degree possible.
        max: usize,
    },
    /// The number of knots does not fit the number of control points.
    #[error("{count} knots, {points} control points of degree {degree} need {expected}")]
    KnotCount {
        /// Knots given.
        count: usize,
        /// Control points given.
        points: usize,
        /// Degree of the curve.
        degree: usize,
        /// Knots needed.
        expected: usize,
    },
    /// A knot is less than the one before it.
    #[error("knot {position} is {after}, less than the one before it, {before}")]
    KnotsDecrease {
        /// Position of the later knot in the list.
        position: usize,
        /// The knot before.
        before: f64,
        /// The knot there.
        after: f64,
    },
    /// A knot inside the range is repeated so often that the curve falls apart there.
    #[error("knot {value} is repeated {count} times inside the curve, at most {max} times keep it together")]
    KnotRepeated {
        /// The knot.
        value: f64,
        /// How often it is there.
        count: usize,
        /// The degree of the curve.
        max: usize,
    },
    /// A range has no interior.
    #[error("{parameter} from {min} to {max} is empty")]
    EmptyRange {
        /// Which range.
        parameter: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// Two curves that follow each other in a loop do not meet.
    #[error(
        "curve {curve} of the loop ends at ({}, {}) and curve {next} starts at ({}, {}): \
         {gap} apart, the tolerance is {tolerance}",
        end.x, end.y, start.x, start.y
    )]
    Open {
        /// Number of the curve that ends, from 0.
        curve: usize,
        /// Number of the curve that should go on, from 0.
        next: usize,
        /// Where the one ends.
        end: DVec2,
        /// Where the other starts.
        start: DVec2,
        /// Their distance, parameter units.
        gap: f64,
        /// The distance allowed.
        tolerance: f64,
    },
    /// All curves of a loop are one point.
    #[error("the loop is nothing but the point ({}, {})", point.x, point.y)]
    Collapsed {
        /// The point.
        point: DVec2,
    },
}

number_checks!(TrimError);

/// `point`, if its coordinates are finite.
pub(super) fn finite_point(parameter: &'static str, point: DVec2) -> Result<DVec2, TrimError> {
    Ok(DVec2::new(finite(parameter, point.x)?, finite(parameter, point.y)?))
}

/// `value`, if it is finite and not below zero.
pub(super) fn not_negative(parameter: &'static str, value: f64) -> Result<f64, TrimError> {
    let value = finite(parameter, value)?;
    if value >= 0.0 { Ok(value) } else { Err(TrimError::Negative { parameter, value }) }
}
