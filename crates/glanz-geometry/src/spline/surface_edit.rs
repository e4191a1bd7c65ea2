//! Changes of a surface that leave its shape alone, and curves on it.

use glanz_math::glam::DVec4;

use super::basis::Basis;
use super::curve::RationalCurve;
use super::homogeneous::deviation;
use super::knots::KnotVector;
use super::polygon;
use super::surface::NurbsSurface;
use crate::error::SurfaceError;

/// One of the two directions of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// That of the first parameter.
    U,
    /// That of the second parameter.
    V,
}

impl NurbsSurface {
    /// Knots and degree in one direction.
    #[must_use]
    pub fn knots(&self, direction: Direction) -> &KnotVector {
        match direction {
            Direction::U => self.knots_u(),
            Direction::V => self.knots_v(),
        }
    }

    fn along(
        &self,
        direction: Direction,
        change: impl Fn(&KnotVector, &[DVec4]) -> Result<(KnotVector, Vec<DVec4>), SurfaceError>,
    ) -> Result<Self, SurfaceError> {
        match direction {
            Direction::U => Ok(self.swapped().along_v(change)?.swapped()),
            Direction::V => self.along_v(change),
        }
    }

    /// The same surface with the knot `value` `times` times more.
    ///
    /// # Errors
    /// A value not strictly inside the domain, or there more than `degree` times then.
    pub fn insert_knot(&self, direction: Direction, value: f64, times: usize) -> Result<Self, SurfaceError> {
        self.along(direction, |t, row| polygon::insert(t, row, value, times))
    }

    /// The surface without one of the knots `value`, and a bound on the distance by which points move, metres.
    ///
    /// # Errors
    /// A value not strictly inside the domain or no knot; [`SurfaceError::KnotNeeded`] if the bound is greater than
    /// `tolerance` (metres), infinite where a weight would not stay positive.
    pub fn remove_knot(
        &self,
        direction: Direction,
        value: f64,
        tolerance: f64,
    ) -> Result<(Self, f64), SurfaceError> {
        let parameter = match direction {
            Direction::U => "knot in u",
            Direction::V => "knot in v",
        };
        let needed = |deviation| SurfaceError::KnotNeeded { parameter, value, deviation, tolerance };
        let removed = match self.along(direction, |t, row| polygon::remove(t, row, value)) {
            // A denominator that vanishes somewhere.
            Err(SurfaceError::NotPositive { .. }) => return Err(needed(f64::INFINITY)),
            other => other?,
        };
        let again = removed.insert_knot(direction, value, 1)?;
        let deviation = deviation(self.control_points(), again.control_points());
        if deviation <= tolerance { Ok((removed, deviation)) } else { Err(needed(deviation)) }
    }

    /// The same surface one degree higher in one direction.
    ///
    /// # Errors
    /// A degree that is the highest already.
    pub fn elevate(&self, direction: Direction) -> Result<Self, SurfaceError> {
        self.along(direction, polygon::elevate)
    }

    /// The parts before and after a parameter, clamped there and at the ends of that direction; at the cut their
    /// control points are equal to the last bit.
    ///
    /// # Errors
    /// A value not strictly inside the domain.
    pub fn split(&self, direction: Direction, value: f64) -> Result<(Self, Self), SurfaceError> {
        let [start, end] = self.knots(direction).domain();
        let part = |range| self.along(direction, |t, row| polygon::restrict(t, row, range));
        Ok((part([start, value])?, part([value, end])?))
    }

    /// The same surface run through backwards in one direction over the same domain; its normal points to the other
    /// side.
    ///
    /// # Errors
    /// Those of [`KnotVector::reversed`].
    pub fn reversed(&self, direction: Direction) -> Result<Self, SurfaceError> {
        self.along(direction, polygon::reverse)
    }

    /// The curve on which the parameter of `fixed` has this value and the other one runs; values outside of the domain
    /// count as its nearer end.
    ///
    /// # Errors
    /// None but for weights that underflow.
    pub fn isocurve(&self, fixed: Direction, value: f64) -> Result<RationalCurve, SurfaceError> {
        let turned = match fixed {
            Direction::U => self.clone(),
            Direction::V => self.swapped(),
        };
        let basis = Basis::at(turned.knots_u(), value);
        let (row, first) = (basis.values(), basis.first());
        let (count, degree) = (turned.knots_v().count(), turned.knots_u().degree());
        let points = (0..count).map(|j| {
            let along_u = (first..=first + degree).zip(row);
            along_u.map(|(i, n)| turned.control_points()[i * count + j] * n).sum()
        });
        RationalCurve::from_knots(turned.knots_v().clone(), points.collect())
    }
}
