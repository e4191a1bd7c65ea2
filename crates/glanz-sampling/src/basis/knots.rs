//! Knot vectors of B-splines on [0, 1].

use std::ops::Deref;

use glanz_math::bspline::{KnotError, Knots};

use crate::basis::{MAX_DEGREE, ORDER};
use crate::error::DensityError;

/// The [`Knots`] of B-splines on [0, 1]: 0 and 1 appear degree + 1 times at the ends.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitKnots(Knots);

impl Deref for UnitKnots {
    type Target = Knots;

    fn deref(&self) -> &Knots {
        &self.0
    }
}

impl UnitKnots {
    /// The vector of these knots: `degree` + 1 times 0, inner knots that do not decrease and none of which appears more
    /// than `degree` + 1 times, `degree` + 1 times 1.
    ///
    /// # Errors
    /// [`DensityError::Degree`], [`DensityError::KnotCount`], [`DensityError::EndKnot`], [`DensityError::Knot`].
    pub fn try_new(degree: usize, knots: Vec<f64>) -> Result<Self, DensityError> {
        check_degree(degree)?;
        let count = knots.len();
        if count < 2 * (degree + 1) || u32::try_from(count).is_err() {
            return Err(DensityError::KnotCount { found: count, degree });
        }
        let ends = (0..=degree).map(|i| (i, 0.0)).chain((count - degree - 1..count).map(|i| (i, 1.0)));
        for (index, end) in ends {
            if knots[index] != end {
                return Err(DensityError::EndKnot { index, value: knots[index] });
            }
        }
        Knots::try_new(degree, knots, degree + 1).map(Self).map_err(|error| match error {
            KnotError::NotFinite { position, value }
            | KnotError::Decrease { position, value, .. }
            | KnotError::Multiplicity { position, value, .. } => {
                DensityError::Knot { index: position, value }
            }
            KnotError::TooFew { .. } | KnotError::Range(_) | KnotError::EmptyDomain { .. } => {
                DensityError::KnotCount { found: count, degree }
            }
        })
    }

    /// The vector with `segments` equal segments.
    ///
    /// # Errors
    /// [`DensityError::Degree`]; [`DensityError::KnotCount`] for no segments.
    pub fn uniform(degree: usize, segments: usize) -> Result<Self, DensityError> {
        check_degree(degree)?;
        if segments == 0 {
            return Err(DensityError::KnotCount { found: 0, degree });
        }
        Self::try_new(degree, Knots::clamped_uniform(degree, segments))
    }

    /// The blossoms (polar forms) of the degree + 1 B-splines that do not vanish on the span `m`, at the arguments `at(1)`
    /// to `at(degree)`; the first belongs to function m - degree, the rest of the array is 0.
    ///
    /// With all arguments equal to x these are the values at x; with `degree` consecutive knots of a refined vector, a
    /// row of the refinement matrix.
    #[inline]
    pub(crate) fn blossoms(&self, m: usize, at: impl Fn(usize) -> f64) -> [f64; ORDER] {
        self.recursion(m, self.degree(), |step, value, left, right| {
            let x = at(step);
            [(right - x) / (right - left) * value, (x - left) / (right - left) * value]
        })
    }
}

fn check_degree(degree: usize) -> Result<(), DensityError> {
    if degree > MAX_DEGREE {
        return Err(DensityError::Degree { degree, max: MAX_DEGREE });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_knots_are_refused_with_their_place() {
        let of = |degree, knots: &[f64]| UnitKnots::try_new(degree, knots.to_vec());
        assert!(matches!(of(8, &[0.0; 30]), Err(DensityError::Degree { degree: 8, .. })));
        assert!(matches!(of(1, &[0.0, 1.0, 1.0]), Err(DensityError::KnotCount { found: 3, .. })));
        assert!(matches!(of(1, &[0.0, 0.1, 1.0, 1.0]), Err(DensityError::EndKnot { index: 1, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, 0.5, 1.0]), Err(DensityError::EndKnot { index: 2, .. })));
        assert!(matches!(of(0, &[0.0, 0.6, 0.5, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(0, &[0.0, 0.5, 0.5, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, f64::NAN, 1.0, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, 2.0, 1.0, 1.0]), Err(DensityError::Knot { index: 3, .. })));
        assert!(of(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).is_ok());
        assert!(UnitKnots::uniform(2, 0).is_err());
    }

    #[test]
    fn segments_hold_their_points() {
        let knots = UnitKnots::try_new(2, vec![0.0, 0.0, 0.0, 0.2, 0.5, 0.5, 0.9, 1.0, 1.0, 1.0]).unwrap();
        assert_eq!(knots.spans().map(|s| s.0).collect::<Vec<_>>(), [2, 3, 5, 6]);
        for (x, m) in
            [(0.0, 2), (0.1, 2), (0.2, 3), (0.49, 3), (0.5, 5), (0.9, 6), (1.0, 6), (-1.0, 2), (2.0, 6)]
        {
            assert_eq!(knots.find_span(x), m, "{x}");
        }
    }
}
