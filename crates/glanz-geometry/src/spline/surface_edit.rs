//! Edits of a surface that keep its shape, and curves on it.

use glanz_math::glam::DVec4;

use super::basis::BasisFunctions;
use super::curve::NurbsCurve;
use super::homogeneous::deviation;
use super::knots::KnotVector;
use super::polygon;
use super::surface::NurbsSurface;
use crate::error::SurfaceError;

/// One of the two parameter directions of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterDirection {
    /// Along the first parameter.
    U,
    /// Along the second parameter.
    V,
}

impl NurbsSurface {
    /// Knots and degree in one direction.
    #[must_use]
    pub fn knots(&self, direction: ParameterDirection) -> &KnotVector {
        match direction {
            ParameterDirection::U => self.knots_u(),
            ParameterDirection::V => self.knots_v(),
        }
    }

    fn map_rows(
        &self,
        direction: ParameterDirection,
        change: impl Fn(&KnotVector, &[DVec4]) -> Result<(KnotVector, Vec<DVec4>), SurfaceError>,
    ) -> Result<Self, SurfaceError> {
        match direction {
            ParameterDirection::U => Ok(self.transposed().map_rows_v(change)?.transposed()),
            ParameterDirection::V => self.map_rows_v(change),
        }
    }

    /// The same surface after inserting the knot `value` `times` times.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if the value is not strictly inside the domain, [`SurfaceError::KnotMultiplicity`] if the knot
    /// would appear more than `degree` times.
    pub fn insert_knot(
        &self,
        direction: ParameterDirection,
        value: f64,
        times: usize,
    ) -> Result<Self, SurfaceError> {
        self.map_rows(direction, |t, row| polygon::insert(t, row, value, times))
    }

    /// The surface after removing one of the knots `value`, and a bound on the distance by which points move, metres.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if the value is not strictly inside the domain, [`SurfaceError::TooFew`] if it is not a knot,
    /// [`SurfaceError::KnotNeeded`] if the bound is greater than `tolerance` (metres); it is infinite if a weight would not stay
    /// positive, or if the surface jumps there.
    pub fn remove_knot(
        &self,
        direction: ParameterDirection,
        value: f64,
        tolerance: f64,
    ) -> Result<(Self, f64), SurfaceError> {
        let parameter = match direction {
            ParameterDirection::U => "knot in u",
            ParameterDirection::V => "knot in v",
        };
        let needed = |deviation| SurfaceError::KnotNeeded { parameter, value, deviation, tolerance };
        if self.knots(direction).multiplicity(value) > self.knots(direction).degree() {
            return Err(needed(f64::INFINITY));
        }
        let removed = match self.map_rows(direction, |t, row| polygon::remove(t, row, value)) {
            // The denominator would vanish somewhere.
            Err(SurfaceError::NotPositive { .. }) => return Err(needed(f64::INFINITY)),
            other => other?,
        };
        let again = removed.insert_knot(direction, value, 1)?;
        let deviation = deviation(self.control_points(), again.control_points());
        if deviation <= tolerance { Ok((removed, deviation)) } else { Err(needed(deviation)) }
    }

    /// The same surface with its degree raised by one in one direction.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if the degree is already the highest possible.
    pub fn elevate(&self, direction: ParameterDirection) -> Result<Self, SurfaceError> {
        self.map_rows(direction, polygon::elevate)
    }

    /// The parts before and after a parameter, both with clamped knots in that direction; their control points at the cut
    /// are equal to the last bit.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] or [`SurfaceError::EmptyRange`] if the value is not strictly inside the domain.
    pub fn split(&self, direction: ParameterDirection, value: f64) -> Result<(Self, Self), SurfaceError> {
        let [start, end] = self.knots(direction).domain();
        let part = |range| self.map_rows(direction, |t, row| polygon::restrict(t, row, range));
        Ok((part([start, value])?, part([value, end])?))
    }

    /// The pieces of the surface between its jumps, those of equal u next to each other, with clamped knots; a copy of the surface if it does
    /// not jump.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if knots are so close together that a weight underflows.
    pub fn continuous_pieces(&self) -> Result<Vec<Self>, SurfaceError> {
        let [ranges_u, ranges_v] = [self.knots_u(), self.knots_v()].map(|knots| {
            let [start, end] = knots.domain();
            let jumps: Vec<f64> = knots.jumps().into_iter().map(|(knot, _)| knot).collect();
            let starts = std::iter::once(start).chain(jumps.iter().copied());
            let ends = jumps.iter().copied().chain([end]);
            starts.zip(ends).map(|(from, to)| [from, to]).collect::<Vec<_>>()
        });
        if ranges_u.len() == 1 && ranges_v.len() == 1 {
            return Ok(vec![self.clone()]);
        }
        let rectangles = ranges_u.iter().flat_map(|&u| ranges_v.iter().map(move |&v| [u, v]));
        rectangles.map(|rectangle| self.restrict(rectangle)).collect()
    }

    /// The same surface over the same domain, reversed in one direction; its normal points to the other side.
    ///
    /// # Errors
    /// Those of [`KnotVector::reversed`].
    pub fn reversed(&self, direction: ParameterDirection) -> Result<Self, SurfaceError> {
        self.map_rows(direction, polygon::reverse)
    }

    /// The isoparametric curve on which the parameter of `fixed` has this value; values outside the domain are clamped to
    /// it.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if a weight underflows, [`SurfaceError::KnotMultiplicity`] if the curve jumps: where the surface does
    /// in the other parameter.
    pub fn isocurve(&self, fixed: ParameterDirection, value: f64) -> Result<NurbsCurve, SurfaceError> {
        let oriented = match fixed {
            ParameterDirection::U => self.clone(),
            ParameterDirection::V => self.transposed(),
        };
        let basis = BasisFunctions::at(oriented.knots_u(), value);
        let (row, first) = (basis.values(), basis.first());
        let (count, degree) = (oriented.knots_v().count(), oriented.knots_u().degree());
        let points = (0..count).map(|j| {
            (first..=first + degree).zip(row).map(|(i, n)| oriented.control_points()[i * count + j] * n).sum()
        });
        NurbsCurve::from_knots(oriented.knots_v().clone(), points.collect())
    }
}
