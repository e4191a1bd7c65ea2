//! Rational B-spline curves in space.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::basis::{BasisFunctions, BasisRow};
use super::homogeneous::{check, deviation, homogeneous_points, project};
use super::knots::KnotVector;
use super::polygon;
use crate::bezier::homogeneous::project_derivatives;
use crate::error::SurfaceError;

/// A NURBS curve `sum N_i(u) w_i P_i / sum N_i(u) w_i`, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve {
    knots: KnotVector,
    points: Vec<DVec4>,
}

/// A piece of a curve between two neighbouring knots.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierSegment {
    /// Start and end of the piece in the parameter of the curve.
    pub u: [f64; 2],
    /// Homogeneous Bézier points (w x, w y, w z, w), degree + 1 of them.
    pub points: Vec<DVec4>,
}

impl NurbsCurve {
    /// The curve with control points in space (metres) and as many weights; without weights it is polynomial.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`]; [`SurfaceError::CountMismatch`] for the numbers of points and weights,
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a weight.
    pub fn try_from_points(
        degree: usize,
        knots: Vec<f64>,
        points: &[DVec3],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceError> {
        Self::from_knots(KnotVector::try_new(degree, knots)?, homogeneous_points(points, weights)?)
    }

    /// The curve over checked knots with homogeneous control points (w x, w y, w z, w).
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`] for the number of points, [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a
    /// weight, [`SurfaceError::KnotMultiplicity`] if the curve jumps.
    pub fn from_knots(knots: KnotVector, points: Vec<DVec4>) -> Result<Self, SurfaceError> {
        knots.check_continuous()?;
        check(&points, knots.count())?;
        Ok(Self { knots, points })
    }

    fn from_row((knots, points): (KnotVector, Vec<DVec4>)) -> Result<Self, SurfaceError> {
        Self::from_knots(knots, points)
    }

    /// Knots and degree.
    #[must_use]
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// Homogeneous control points (w x, w y, w z, w).
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.points
    }

    /// The point at `u`, metres; parameters outside the domain are clamped to it.
    #[must_use]
    pub fn point(&self, u: f64) -> DVec3 {
        let basis = BasisFunctions::at(&self.knots, u);
        project(self.homogeneous(&basis, &basis.values()))
    }

    /// The point and its derivatives by u of the orders 1 to `order`.
    ///
    /// At a knot they are those of the piece that starts there.
    #[must_use]
    pub fn derivatives(&self, u: f64, order: usize) -> Vec<DVec3> {
        let basis = BasisFunctions::at(&self.knots, u);
        let homogeneous: Vec<DVec4> =
            basis.rows_up_to(order).iter().map(|row| self.homogeneous(&basis, row)).collect();
        project_derivatives(&homogeneous)
    }

    fn homogeneous(&self, basis: &BasisFunctions<'_>, row: &BasisRow) -> DVec4 {
        let first = basis.first();
        let points = &self.points[first..=first + self.knots.degree()];
        points.iter().zip(row).map(|(p, n)| *p * *n).sum()
    }

    /// The same curve after inserting the knot `u` `times` times.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if `u` is not strictly inside the domain, [`SurfaceError::KnotMultiplicity`] if the knot would
    /// appear more than `degree` times.
    pub fn insert_knot(&self, u: f64, times: usize) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::insert(&self.knots, &self.points, u, times)?)
    }

    /// The curve after removing one of the knots `u`, and a bound on the distance by which points move, metres.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if `u` is not strictly inside the domain, [`SurfaceError::TooFew`] if it is not a knot,
    /// [`SurfaceError::KnotNeeded`] if the bound is greater than `tolerance` (metres); it is infinite if a weight would not stay
    /// positive.
    pub fn remove_knot(&self, u: f64, tolerance: f64) -> Result<(Self, f64), SurfaceError> {
        let needed =
            |deviation| SurfaceError::KnotNeeded { parameter: "knot", value: u, deviation, tolerance };
        let removed = match Self::from_row(polygon::remove(&self.knots, &self.points, u)?) {
            // The denominator would vanish somewhere.
            Err(SurfaceError::NotPositive { .. }) => return Err(needed(f64::INFINITY)),
            other => other?,
        };
        let (_, again) = polygon::insert(&removed.knots, &removed.points, u, 1)?;
        let deviation = deviation(&self.points, &again);
        if deviation <= tolerance { Ok((removed, deviation)) } else { Err(needed(deviation)) }
    }

    /// The same curve with its degree raised by one.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if the degree is already the highest possible.
    pub fn elevate(&self) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::elevate(&self.knots, &self.points)?)
    }

    /// The part between two parameters, with clamped knots.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for a parameter outside the domain, [`SurfaceError::EmptyRange`] if they do not ascend.
    pub fn restrict(&self, range: [f64; 2]) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::restrict(&self.knots, &self.points, range)?)
    }

    /// The parts before and after `u`, with clamped knots; the last control point of the first part is the first of the second.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] or [`SurfaceError::EmptyRange`] if `u` is not strictly inside the domain.
    pub fn split(&self, u: f64) -> Result<(Self, Self), SurfaceError> {
        let [start, end] = self.knots.domain();
        Ok((self.restrict([start, u])?, self.restrict([u, end])?))
    }

    /// The same curve over the same domain, reversed.
    ///
    /// # Errors
    /// Those of [`KnotVector::reversed`].
    pub fn reversed(&self) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::reverse(&self.knots, &self.points)?)
    }

    /// The pieces between knots; the control points of neighbours at their common end are equal to the last bit.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if knots are so close together that a weight underflows.
    pub fn bezier_segments(&self) -> Result<Vec<BezierSegment>, SurfaceError> {
        let (breaks, points) = polygon::bezier(&self.knots, &self.points)?;
        let p = self.knots.degree();
        let segments = breaks
            .windows(2)
            .enumerate()
            .map(|(i, u)| BezierSegment { u: [u[0], u[1]], points: points[i * p..=(i + 1) * p].to_vec() });
        Ok(segments.collect())
    }
}
