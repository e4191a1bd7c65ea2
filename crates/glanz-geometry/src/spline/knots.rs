//! Knot vectors: where the pieces of a spline meet, and how smoothly.

use crate::bezier::bernstein;
use crate::error::{SurfaceError, finite};

/// The highest degree of a spline: one row of basis functions has its place on the stack.
pub const MAX_DEGREE: usize = bernstein::ROW_DEGREE;

/// The knots of a spline of some degree, which never decrease; the curve lives between the knots number `degree` and
/// number `count`, counted from 0, where `count` is the number of control points.
///
/// Clamped or not: what stands outside of the domain only shapes the basis functions at its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
}

impl KnotVector {
    /// The knot vector of a spline of `degree` 1 to [`MAX_DEGREE`] with `knots.len() - degree - 1` control points.
    ///
    /// # Errors
    /// A degree out of range, fewer than `2 degree + 2` knots, knots that are not finite or decrease, a knot that
    /// stands there more than `degree + 1` times, or more than `degree` times inside the domain, an empty domain.
    pub fn try_new(degree: usize, knots: Vec<f64>) -> Result<Self, SurfaceError> {
        Self::checked("knot", degree, knots)
    }

    /// The same with the name of the vector for messages.
    pub(crate) fn checked(
        parameter: &'static str,
        degree: usize,
        knots: Vec<f64>,
    ) -> Result<Self, SurfaceError> {
        check_degree(degree)?;
        let (count, min) = (knots.len(), 2 * degree + 2);
        if count < min {
            return Err(SurfaceError::TooFew { parameter: "knots", count, min });
        }
        for &knot in &knots {
            finite(parameter, knot)?;
        }
        for (i, pair) in knots.windows(2).enumerate() {
            if pair[1] < pair[0] {
                let (value, previous) = (pair[1], pair[0]);
                return Err(SurfaceError::KnotsDecrease { parameter, position: i + 1, value, previous });
            }
        }
        finite("range of the knots", knots[count - 1] - knots[0])?;
        let checked = Self { degree, knots };
        let [start, end] = checked.domain();
        if start >= end {
            return Err(SurfaceError::EmptyRange { parameter: "the domain", min: start, max: end });
        }
        for (value, multiplicity) in checked.distinct() {
            let max = if value > start && value < end { degree } else { degree + 1 };
            if multiplicity > max {
                return Err(SurfaceError::KnotMultiplicity { parameter, value, multiplicity, max });
            }
        }
        Ok(checked)
    }

    /// The clamped knot vector over [0, 1] with `count` control points and inner knots at equal distances.
    ///
    /// # Errors
    /// A degree out of range, or a count that is not greater than the degree.
    pub fn clamped_uniform(degree: usize, count: usize) -> Result<Self, SurfaceError> {
        check_degree(degree)?;
        if count <= degree {
            return Err(SurfaceError::TooFew { parameter: "control points", count, min: degree + 1 });
        }
        let spans = count - degree;
        let inner = (1..spans).map(|i| i as f64 / spans as f64).collect();
        Self::try_new(degree, clamped(degree, [0.0, 1.0], inner))
    }

    /// Degree, from 1 to [`MAX_DEGREE`].
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots, ascending.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of control points.
    #[must_use]
    pub fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Smallest and largest parameter.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.count()]]
    }

    /// `u`, moved to the nearer end of the domain if it lies outside.
    #[must_use]
    pub fn clamp(&self, u: f64) -> f64 {
        let [start, end] = self.domain();
        u.clamp(start, end)
    }

    /// Whether the first and the last knot of the domain stand there `degree + 1` times, so that the spline starts
    /// and ends in control points.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let [start, end] = self.domain();
        self.knots[0] == start && self.knots[self.knots.len() - 1] == end
    }

    /// The index i of the span, not empty, with `knots[i] <= u < knots[i + 1]`.
    ///
    /// The last span is closed. Parameters outside of the domain get the first or the last span.
    #[must_use]
    pub fn find_span(&self, u: f64) -> usize {
        let [start, end] = self.domain();
        if u >= end {
            return self.knots.partition_point(|&k| k < end) - 1;
        }
        // Written so that what is no number counts as the start.
        let u = if u > start { u } else { start };
        self.knots.partition_point(|&k| k <= u) - 1
    }

    /// How often `u` stands in the vector.
    #[must_use]
    pub fn multiplicity(&self, u: f64) -> usize {
        self.knots.iter().filter(|&&k| k == u).count()
    }

    /// The values of the knots, each once, and how often they stand there.
    #[must_use]
    pub fn distinct(&self) -> Vec<(f64, usize)> {
        self.knots.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len())).collect()
    }

    /// The ends of the pieces, ascending: the values of the knots inside the domain and at its ends.
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.count()].to_vec();
        breaks.dedup();
        breaks
    }

    /// The knots strictly inside the domain with their repetitions, ascending.
    #[must_use]
    pub fn inner(&self) -> &[f64] {
        let [start, end] = self.domain();
        let from = self.knots.partition_point(|&k| k <= start);
        let to = self.knots.partition_point(|&k| k < end);
        &self.knots[from..to]
    }

    /// For each control point the mean of its `degree` inner knots: where it stands if the spline is a straight line
    /// run through at constant speed.
    ///
    /// # Source
    /// @farin2002 section 8.6; @pumberger2010 section 2.1.2.
    #[must_use]
    pub fn greville(&self) -> Vec<f64> {
        let p = self.degree;
        let mean = |knots: &[f64]| {
            // Around the first, so that equal knots have themselves as mean.
            let first = knots[0];
            first + knots.iter().map(|k| k - first).sum::<f64>() / p as f64
        };
        (0..self.count()).map(|i| mean(&self.knots[i + 1..=i + p])).collect()
    }

    /// The knots of the same spline run through backwards, with the same domain.
    ///
    /// # Errors
    /// Knots so close together that their mirror images fall onto each other too often.
    pub fn reversed(&self) -> Result<Self, SurfaceError> {
        let [start, end] = self.domain();
        let mirror = |&k: &f64| {
            let image = start + (end - k);
            // The ends are exact, and rounding changes no side.
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
        Self::try_new(self.degree, self.knots.iter().rev().map(mirror).collect())
    }
}

/// The clamped knots of `degree` over a domain with these inner knots.
pub(crate) fn clamped(degree: usize, [start, end]: [f64; 2], inner: Vec<f64>) -> Vec<f64> {
    let mut knots = vec![start; degree + 1];
    knots.extend(inner);
    knots.extend(std::iter::repeat_n(end, degree + 1));
    knots
}

/// # Errors
/// A degree of 0 or above [`MAX_DEGREE`].
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
    fn unusable_knots_are_refused_with_their_value() {
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
    fn unclamped_knots_live_between_the_inner_ones() {
        let knots = KnotVector::try_new(2, (0..8).map(f64::from).collect()).unwrap();
        assert_eq!(knots.domain(), [2.0, 5.0]);
        assert!(!knots.is_clamped());
        assert_eq!([2.0, 4.5, 5.0, 7.0].map(|u| knots.find_span(u)), [2, 4, 4, 4]);
        assert_eq!(knots.inner(), [3.0, 4.0]);
    }

    #[test]
    fn clamped_uniform_knots_part_the_unit_interval_evenly() {
        let knots = KnotVector::clamped_uniform(3, 6).unwrap();
        assert_eq!(knots.knots(), [0.0, 0.0, 0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 1.0, 1.0, 1.0]);
        assert!(matches!(KnotVector::clamped_uniform(3, 3), Err(SurfaceError::TooFew { min: 4, .. })));
    }
}
