//! Rational B-spline curves in space.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::basis::Basis;
use super::homogeneous::{binomial, check, deviation, lift_all, project};
use super::knots::KnotVector;
use super::polygon;
use crate::error::SurfaceError;

/// A NURBS curve `sum N_i(u) w_i P_i / sum N_i(u) w_i`, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalCurve {
    knots: KnotVector,
    points: Vec<DVec4>,
}

/// A piece of a curve without inner knots.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierArc {
    /// Where the piece begins and ends in the parameter of the curve.
    pub u: [f64; 2],
    /// Homogeneous Bézier points (w x, w y, w z, w), degree + 1 of them.
    pub points: Vec<DVec4>,
}

impl RationalCurve {
    /// The curve with control points in space (metres) and as many weights; without weights it is polynomial.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`]; lists of lengths that do not match, coordinates that are not finite, weights
    /// that are not positive.
    pub fn try_from_points(
        degree: usize,
        knots: Vec<f64>,
        points: &[DVec3],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceError> {
        Self::from_knots(KnotVector::try_new(degree, knots)?, lift_all(points, weights)?)
    }

    /// The curve over checked knots with homogeneous control points (w x, w y, w z, w).
    ///
    /// # Errors
    /// The wrong number of points, coordinates that are not finite, weights that are not positive.
    pub fn from_knots(knots: KnotVector, points: Vec<DVec4>) -> Result<Self, SurfaceError> {
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

    /// The point at `u`, metres; parameters outside of the domain count as its ends.
    #[must_use]
    pub fn point(&self, u: f64) -> DVec3 {
        project(self.homogeneous(&Basis::at(&self.knots, u), 0))
    }

    /// The point and its derivatives by u of the orders 1 to `order`.
    ///
    /// At a knot they are those of the piece that starts there.
    ///
    /// # Source
    /// @markgraf2019 eq. 14.
    #[must_use]
    pub fn derivatives(&self, u: f64, order: usize) -> Vec<DVec3> {
        let basis = Basis::at(&self.knots, u);
        let mut found: Vec<DVec3> = Vec::with_capacity(order + 1);
        let numerators: Vec<DVec4> = (0..=order).map(|k| self.homogeneous(&basis, k)).collect();
        let weight = numerators[0].w;
        for (k, a) in numerators.iter().enumerate() {
            let known = (1..=k).map(|i| binomial(k, i) * numerators[i].w * found[k - i]).sum::<DVec3>();
            found.push((a.truncate() - known) / weight);
        }
        found
    }

    fn homogeneous(&self, basis: &Basis<'_>, order: usize) -> DVec4 {
        let (row, first) = (basis.derivatives(order), basis.first());
        let points = &self.points[first..=first + self.knots.degree()];
        points.iter().zip(row).map(|(p, n)| *p * n).sum()
    }

    /// The same curve with the knot `u` `times` times more.
    ///
    /// # Errors
    /// `u` not strictly inside the domain, or there more than `degree` times then.
    pub fn insert_knot(&self, u: f64, times: usize) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::insert(&self.knots, &self.points, u, times)?)
    }

    /// The curve without one of the knots `u`, and a bound on the distance by which points move, metres.
    ///
    /// # Errors
    /// `u` not strictly inside the domain or no knot; [`SurfaceError::KnotNeeded`] if the bound is greater than
    /// `tolerance` (metres), infinite where a weight would not stay positive.
    pub fn remove_knot(&self, u: f64, tolerance: f64) -> Result<(Self, f64), SurfaceError> {
        let needed =
            |deviation| SurfaceError::KnotNeeded { parameter: "knot", value: u, deviation, tolerance };
        let removed = match Self::from_row(polygon::remove(&self.knots, &self.points, u)?) {
            // A denominator that vanishes somewhere.
            Err(SurfaceError::NotPositive { .. }) => return Err(needed(f64::INFINITY)),
            other => other?,
        };
        let (_, again) = polygon::insert(&removed.knots, &removed.points, u, 1)?;
        let deviation = deviation(&self.points, &again);
        if deviation <= tolerance { Ok((removed, deviation)) } else { Err(needed(deviation)) }
    }

    /// The same curve one degree higher.
    ///
    /// # Errors
    /// A degree that is the highest already.
    pub fn elevate(&self) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::elevate(&self.knots, &self.points)?)
    }

    /// The part between two parameters, clamped.
    ///
    /// # Errors
    /// Parameters outside of the domain or not ascending.
    pub fn restrict(&self, range: [f64; 2]) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::restrict(&self.knots, &self.points, range)?)
    }

    /// The parts before and after `u`, clamped; the last control point of one is the first of the other.
    ///
    /// # Errors
    /// `u` not strictly inside the domain.
    pub fn split(&self, u: f64) -> Result<(Self, Self), SurfaceError> {
        let [start, end] = self.knots.domain();
        Ok((self.restrict([start, u])?, self.restrict([u, end])?))
    }

    /// The same curve run through backwards over the same domain.
    ///
    /// # Errors
    /// Those of [`KnotVector::reversed`].
    pub fn reversed(&self) -> Result<Self, SurfaceError> {
        Self::from_row(polygon::reverse(&self.knots, &self.points)?)
    }

    /// The pieces between knots; where two meet, their control points are equal to the last bit.
    ///
    /// # Errors
    /// Knots so close together that a weight underflows.
    pub fn bezier_arcs(&self) -> Result<Vec<BezierArc>, SurfaceError> {
        let (breaks, points) = polygon::bezier(&self.knots, &self.points)?;
        let p = self.knots.degree();
        let arcs = breaks
            .windows(2)
            .enumerate()
            .map(|(i, u)| BezierArc { u: [u[0], u[1]], points: points[i * p..=(i + 1) * p].to_vec() });
        Ok(arcs.collect())
    }
}
