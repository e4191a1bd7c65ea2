//! Rational B-spline curves of the plane and of space.

use glanz_geometry::SurfaceError;
use glanz_geometry::spline::KnotVector;

use super::vector::CurveVector;

/// A rational B-spline curve.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineCurve<P: CurveVector> {
    knots: KnotVector,
    points: Vec<P::Homogeneous>,
}

impl<P: CurveVector> SplineCurve<P> {
    /// The curve of `degree` with these knots, clamped or not, and homogeneous control points (the point times its weight, with the
    /// weight), of which there are `knots.len() - degree - 1`.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`] and of [`Self::from_knots`].
    pub fn try_new(
        degree: usize,
        knots: Vec<f64>,
        points: Vec<P::Homogeneous>,
    ) -> Result<Self, SurfaceError> {
        Self::from_knots(KnotVector::try_new(degree, knots)?, points)
    }

    /// The curve over checked knots.
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`] for the number of points, [`SurfaceError::NotPositive`] for a weight,
    /// [`SurfaceError::NotFinite`].
    pub fn from_knots(knots: KnotVector, points: Vec<P::Homogeneous>) -> Result<Self, SurfaceError> {
        let (count, expected) = (points.len(), knots.count());
        if count != expected {
            return Err(SurfaceError::CountMismatch { parameter: "control points", count, expected });
        }
        for &point in &points {
            let (numerator, weight) = P::split(point);
            if weight.is_nan() || weight <= 0.0 {
                return Err(SurfaceError::NotPositive { parameter: "weight", value: weight });
            }
            if !weight.is_finite() || !P::project(point).is_finite() || !numerator.is_finite() {
                return Err(SurfaceError::NotFinite { parameter: "control point", value: numerator.norm() });
            }
        }
        Ok(Self { knots, points })
    }

    /// Knots and degree.
    #[must_use]
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// Degree, from 1.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Homogeneous control points.
    #[must_use]
    pub fn control_points(&self) -> &[P::Homogeneous] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::{DVec2, DVec3};

    use super::*;

    #[test]
    fn points_without_positive_weight_are_refused() {
        let line = |weight: f64| {
            let points = vec![DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 0.0, weight)];
            SplineCurve::<DVec2>::try_new(1, vec![0.0, 0.0, 1.0, 1.0], points)
        };
        assert!(line(2.0).is_ok());
        assert!(matches!(line(0.0), Err(SurfaceError::NotPositive { value: 0.0, .. })));
        assert!(matches!(line(f64::NAN), Err(SurfaceError::NotPositive { .. })));
        assert!(matches!(line(f64::INFINITY), Err(SurfaceError::NotFinite { .. })));
        let short = SplineCurve::<DVec2>::try_new(1, vec![0.0, 0.0, 1.0, 1.0], vec![DVec3::ONE]);
        assert!(matches!(short, Err(SurfaceError::CountMismatch { count: 1, expected: 2, .. })));
    }
}
