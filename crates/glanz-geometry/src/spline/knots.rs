//! Knot vectors of splines.

use std::ops::Deref;

use glanz_math::bspline::{KnotError, Knots};

use crate::bezier::bernstein;
use crate::error::SurfaceError;

/// The highest degree of a spline: rows of basis functions have a fixed size.
pub const MAX_DEGREE: usize = bernstein::ROW_DEGREE;

/// The [`Knots`] of a spline of degree 1 to [`MAX_DEGREE`], clamped or not; continuous, unless made by [`KnotVector::try_with_jumps`].
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector(Knots);

impl Deref for KnotVector {
    type Target = Knots;

    fn deref(&self) -> &Knots {
        &self.0
    }
}

impl KnotVector {
    /// The knot vector of a spline of `degree` 1 to [`MAX_DEGREE`] with `knots.len() - degree - 1` control points.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::TooFew`] with fewer than `2 degree + 2` knots,
    /// [`SurfaceError::NotFinite`], [`SurfaceError::KnotsDecrease`], [`SurfaceError::KnotMultiplicity`] if a knot appears more than
    /// `degree + 1` times, or more than `degree` times inside the domain, [`SurfaceError::EmptyRange`] if the domain is empty.
    pub fn try_new(degree: usize, knots: Vec<f64>) -> Result<Self, SurfaceError> {
        Self::checked("knot", degree, knots, degree)
    }

    /// The same for a spline that may jump: where a knot inside the domain appears `degree + 1` times, it consists of two that have no
    /// control point in common.
    ///
    /// # Errors
    /// Those of [`Self::try_new`], except that a knot inside the domain may appear once more.
    pub fn try_with_jumps(degree: usize, knots: Vec<f64>) -> Result<Self, SurfaceError> {
        Self::checked("knot", degree, knots, degree.saturating_add(1))
    }

    /// The knot vector with the name of the parameter for messages, and the largest multiplicity inside the domain.
    pub(crate) fn checked(
        parameter: &'static str,
        degree: usize,
        knots: Vec<f64>,
        inner_multiplicity: usize,
    ) -> Result<Self, SurfaceError> {
        check_degree(degree)?;
        Knots::try_new(degree, knots, inner_multiplicity)
            .map(Self)
            .map_err(|error| knot_error(parameter, error))
    }

    /// The knots inside the domain at which the spline jumps, ascending, with their multiplicities.
    #[must_use]
    pub fn jumps(&self) -> Vec<(f64, usize)> {
        let [start, end] = self.domain();
        let is_jump = |&(knot, count): &(f64, usize)| knot > start && knot < end && count > self.degree();
        self.distinct().into_iter().filter(is_jump).collect()
    }

    /// Checks that the spline does not jump.
    ///
    /// # Errors
    /// [`SurfaceError::KnotMultiplicity`] with the first knot at which it does.
    pub(crate) fn check_continuous(&self) -> Result<(), SurfaceError> {
        self.jumps().first().map_or(Ok(()), |&jump| Err(self.jump_error(jump)))
    }

    fn jump_error(&self, (value, multiplicity): (f64, usize)) -> SurfaceError {
        SurfaceError::KnotMultiplicity { parameter: "knot", value, multiplicity, max: self.degree() }
    }

    /// The clamped knot vector over [0, 1] with `count` control points and inner knots at equal distances.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::TooFew`] if `count` is not greater than the degree.
    pub fn clamped_uniform(degree: usize, count: usize) -> Result<Self, SurfaceError> {
        check_degree(degree)?;
        if count <= degree {
            return Err(SurfaceError::TooFew { parameter: "control points", count, min: degree + 1 });
        }
        Self::try_new(degree, Knots::clamped_uniform(degree, count - degree))
    }

    /// Greville abscissae: for each control point the mean of its `degree` inner knots, which is its parameter on a straight line
    /// of constant speed.
    ///
    /// # Source
    /// @farin2002 section 8.6; @pumberger2010 section 2.1.2.
    #[must_use]
    pub fn greville(&self) -> Vec<f64> {
        let p = self.degree();
        let mean = |knots: &[f64]| {
            // Around the first, so that equal knots have themselves as mean.
            let first = knots[0];
            first + knots.iter().map(|k| k - first).sum::<f64>() / p as f64
        };
        (0..self.count()).map(|i| mean(&self.knots()[i + 1..=i + p])).collect()
    }

    /// The knots of the same spline in reverse direction, with the same domain.
    ///
    /// # Errors
    /// [`SurfaceError::KnotMultiplicity`] if knots are so close together that too many of their mirror images coincide.
    pub fn reversed(&self) -> Result<Self, SurfaceError> {
        let [start, end] = self.domain();
        let mirror = |&k: &f64| {
            let image = start + (end - k);
            // The ends are exact, and rounding moves no knot across them.
            if k == start {
                end
            } else if k == end {
                start
            } else if k < start {
                image.max(end)
            } else if k > end {
                image.min(start)
            } else {
                image.clamp(start, end)
            }
        };
        let reversed = Self::try_with_jumps(self.degree(), self.knots().iter().rev().map(mirror).collect())?;
        // Images that coincide by rounding would tear the spline, and leave out the piece between them.
        let images: Vec<f64> = self.jumps().iter().map(|(knot, _)| mirror(knot)).collect();
        let new_jump = reversed.jumps().into_iter().find(|(knot, _)| !images.contains(knot));
        new_jump.map_or(Ok(()), |jump| Err(self.jump_error(jump)))?;
        Ok(reversed)
    }
}

/// The error of a surface for the knot vector called `parameter`.
fn knot_error(parameter: &'static str, error: KnotError) -> SurfaceError {
    match error {
        KnotError::TooFew { count, min } => SurfaceError::TooFew { parameter: "knots", count, min },
        KnotError::NotFinite { value, .. } => SurfaceError::NotFinite { parameter, value },
        KnotError::Decrease { position, value, previous } => {
            SurfaceError::KnotsDecrease { parameter, position, value, previous }
        }
        KnotError::EmptyDomain { start, end } => {
            SurfaceError::EmptyRange { parameter: "the domain", min: start, max: end }
        }
        KnotError::Multiplicity { value, multiplicity, max, .. } => {
            SurfaceError::KnotMultiplicity { parameter, value, multiplicity, max }
        }
        KnotError::Range(value) => SurfaceError::NotFinite { parameter: "range of the knots", value },
    }
}

/// Checks that `degree` is from 1 to [`MAX_DEGREE`].
///
/// # Errors
/// [`SurfaceError::OutOfRange`].
pub(crate) fn check_degree(degree: usize) -> Result<(), SurfaceError> {
    if degree == 0 || degree > MAX_DEGREE {
        let (value, max) = (degree as f64, MAX_DEGREE as f64);
        return Err(SurfaceError::OutOfRange { parameter: "degree", value, min: 1.0, max });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_knots_are_refused_with_their_value() {
        let refused = |degree, knots: &[f64]| KnotVector::try_new(degree, knots.to_vec()).unwrap_err();
        assert!(matches!(refused(0, &[0.0, 1.0]), SurfaceError::OutOfRange { value: 0.0, .. }));
        assert!(matches!(refused(26, &[0.0; 60]), SurfaceError::OutOfRange { value: 26.0, .. }));
        assert!(matches!(refused(2, &[0.0, 0.0, 0.0, 1.0, 1.0]), SurfaceError::TooFew { min: 6, .. }));
        assert_eq!(
            refused(1, &[0.0, 0.0, 0.7, 0.5, 1.0, 1.0]),
            SurfaceError::KnotsDecrease { parameter: "knot", position: 3, value: 0.5, previous: 0.7 }
        );
        assert!(matches!(
            refused(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]),
            SurfaceError::KnotMultiplicity { multiplicity: 2, max: 1, .. }
        ));
        assert!(matches!(
            refused(1, &[0.0, 0.0, 0.0, 1.0, 1.0]),
            SurfaceError::KnotMultiplicity { multiplicity: 3, max: 2, .. }
        ));
        assert!(matches!(refused(1, &[0.0, 1.0, 1.0, 2.0]), SurfaceError::EmptyRange { .. }));
        assert!(matches!(refused(1, &[0.0, 0.0, f64::NAN, 1.0]), SurfaceError::NotFinite { .. }));
        assert!(matches!(refused(1, &[-1e308, 0.0, 1.0, 1e308]), SurfaceError::NotFinite { .. }));
    }

    #[test]
    fn spans_are_half_open_and_the_last_is_closed() {
        let knots = KnotVector::try_new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 3.0, 4.0, 4.0, 4.0]).unwrap();
        let spans = [-1.0, 0.0, 0.5, 1.0, 2.9, 3.0, 4.0, 9.0, f64::NAN].map(|u| knots.find_span(u));
        assert_eq!(spans, [2, 2, 2, 4, 4, 5, 5, 5, 2]);
        assert_eq!(knots.domain(), [0.0, 4.0]);
        assert_eq!((knots.count(), knots.multiplicity(1.0), knots.is_clamped()), (6, 2, true));
        assert_eq!(knots.breaks(), [0.0, 1.0, 3.0, 4.0]);
        assert_eq!(knots.greville(), [0.0, 0.5, 1.0, 2.0, 3.5, 4.0]);
        assert_eq!(knots.reversed().unwrap().knots(), [0.0, 0.0, 0.0, 1.0, 3.0, 3.0, 4.0, 4.0, 4.0]);
    }

    #[test]
    fn domain_of_unclamped_knots_lies_between_the_inner_ones() {
        let knots = KnotVector::try_new(2, (0..8).map(f64::from).collect()).unwrap();
        assert_eq!(knots.domain(), [2.0, 5.0]);
        assert!(!knots.is_clamped());
        assert_eq!([2.0, 4.5, 5.0, 7.0].map(|u| knots.find_span(u)), [2, 4, 4, 4]);
        assert_eq!(knots.inner(), [3.0, 4.0]);
    }

    #[test]
    fn clamped_uniform_knots_divide_the_unit_interval_evenly() {
        let knots = KnotVector::clamped_uniform(3, 6).unwrap();
        assert_eq!(knots.knots(), [0.0, 0.0, 0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 1.0, 1.0, 1.0]);
        assert!(matches!(KnotVector::clamped_uniform(3, 3), Err(SurfaceError::TooFew { min: 4, .. })));
    }
}
