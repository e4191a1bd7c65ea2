//! Knot vectors of B-splines on [0, 1].

use crate::basis::{MAX_DEGREE, ORDER};
use crate::error::DensityError;

/// Knots of B-splines on [0, 1]: 0 and 1 stand degree + 1 times at the ends.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
}

impl KnotVector {
    /// The vector of these knots: `degree` + 1 times 0, inner knots that do not decrease and none of which stands more
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
        for (index, &value) in knots.iter().enumerate() {
            let end = if index <= degree {
                Some(0.0)
            } else if index + degree + 1 >= count {
                Some(1.0)
            } else {
                None
            };
            if end.is_some_and(|end| value != end) {
                return Err(DensityError::EndKnot { index, value });
            }
            let rises = index == 0 || value >= knots[index - 1];
            let supported = index <= degree || value > knots[index - degree - 1];
            if !(rises && supported) {
                return Err(DensityError::Knot { index, value });
            }
        }
        Ok(Self { degree, knots })
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
        let mut knots = vec![0.0; degree + 1];
        knots.extend((1..segments).map(|i| i as f64 / segments as f64));
        knots.extend(std::iter::repeat_n(1.0, degree + 1));
        Self::try_new(degree, knots)
    }

    /// The degree of the pieces.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The knots, ascending.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of B-splines.
    #[must_use]
    pub fn len(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Never: there is at least one B-spline.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The index m with `knots[m]` <= x < `knots[m + 1]`; the last such segment holds 1 too, and x outside [0, 1] goes
    /// to the nearest segment.
    #[inline]
    #[must_use]
    pub fn segment(&self, x: f64) -> usize {
        let (d, n) = (self.degree, self.len());
        // Of the knots after the leading zeros, those up to x: the one before the first that is above.
        d + self.knots[d + 1..n].partition_point(|&t| t <= x)
    }

    /// The segments of positive length: index, start, end.
    pub fn segments(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        self.knots.windows(2).enumerate().filter(|(_, w)| w[0] < w[1]).map(|(m, w)| (m, w[0], w[1]))
    }

    /// The blossoms (polar forms) of the degree + 1 B-splines that do not vanish on segment `m`, at the arguments
    /// `at(1)` to `at(degree)`; the first belongs to function m - degree, the rest of the array is 0.
    ///
    /// With all arguments equal to x these are the values at x; with `degree` consecutive knots of a refined vector, a
    /// row of the refinement matrix.
    ///
    /// # Source
    /// @piegl1997 algorithm A2.2; with differing arguments the second algorithm of @cohen1980.
    #[inline]
    pub(crate) fn blossoms(&self, m: usize, at: impl Fn(usize) -> f64) -> [f64; ORDER] {
        let mut b = [0.0; ORDER];
        b[0] = 1.0;
        for r in 1..=self.degree {
            let x = at(r);
            // From the last to the first, so that each value is read before it is overwritten.
            let mut carried = 0.0;
            for (i, value) in b.iter_mut().enumerate().take(r + 1) {
                let rising = carried;
                let staying = if i < r {
                    let (left, right) = (self.knots[m + 1 - r + i], self.knots[m + 1 + i]);
                    let share = (x - left) / (right - left);
                    carried = share * *value;
                    ((right - x) / (right - left)) * *value
                } else {
                    0.0
                };
                *value = rising + staying;
            }
        }
        b
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
        let of = |degree, knots: &[f64]| KnotVector::try_new(degree, knots.to_vec());
        assert!(matches!(of(8, &[0.0; 30]), Err(DensityError::Degree { degree: 8, .. })));
        assert!(matches!(of(1, &[0.0, 1.0, 1.0]), Err(DensityError::KnotCount { found: 3, .. })));
        assert!(matches!(of(1, &[0.0, 0.1, 1.0, 1.0]), Err(DensityError::EndKnot { index: 1, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, 0.5, 1.0]), Err(DensityError::EndKnot { index: 2, .. })));
        assert!(matches!(of(0, &[0.0, 0.6, 0.5, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(0, &[0.0, 0.5, 0.5, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, f64::NAN, 1.0, 1.0]), Err(DensityError::Knot { index: 2, .. })));
        assert!(matches!(of(1, &[0.0, 0.0, 2.0, 1.0, 1.0]), Err(DensityError::Knot { index: 3, .. })));
        assert!(of(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).is_ok());
        assert!(KnotVector::uniform(2, 0).is_err());
    }

    #[test]
    fn segments_hold_their_points() {
        let knots = KnotVector::try_new(2, vec![0.0, 0.0, 0.0, 0.2, 0.5, 0.5, 0.9, 1.0, 1.0, 1.0]).unwrap();
        assert_eq!(knots.segments().map(|s| s.0).collect::<Vec<_>>(), [2, 3, 5, 6]);
        for (x, m) in
            [(0.0, 2), (0.1, 2), (0.2, 3), (0.49, 3), (0.5, 5), (0.9, 6), (1.0, 6), (-1.0, 2), (2.0, 6)]
        {
            assert_eq!(knots.segment(x), m, "{x}");
        }
    }
}
