//! Evaluation and edits of rational splines.

use std::f64::consts::TAU;

use glanz_geometry::SurfaceError;
use glanz_geometry::spline::basis::{BasisFunctions, BasisRow};
use glanz_geometry::spline::{KnotVector, polygon};

use crate::model::{CurveVector, SplineCurve};

/// The point and the derivatives of orders 1 and up from those of numerator and weight.
///
/// # Source
/// @piegl1997 eq. 4.8.
fn project_derivatives<P: CurveVector>(homogeneous: &[P::Homogeneous]) -> Vec<P> {
    let mut projected: Vec<P> = Vec::with_capacity(homogeneous.len());
    let weights: Vec<f64> = homogeneous.iter().map(|h| P::split(*h).1).collect();
    for (k, h) in homogeneous.iter().enumerate() {
        let mut numerator = P::split(*h).0;
        let mut binomial = 1.0;
        for i in 1..=k {
            binomial *= (k + 1 - i) as f64 / i as f64;
            numerator = numerator - projected[k - i] * (binomial * weights[i]);
        }
        projected.push(numerator.divided(weights[0]));
    }
    projected
}

impl<P: CurveVector> SplineCurve<P> {
    /// Smallest and largest parameter.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        self.knots().domain()
    }

    /// The point at `t`; parameters outside the domain are clamped to it.
    #[must_use]
    pub fn point(&self, t: f64) -> P {
        let basis = BasisFunctions::at(self.knots(), t);
        P::project(self.homogeneous(&basis, &basis.values()))
    }

    /// The point and its derivatives of the orders 1 to `order`; at a knot those of the piece that starts there.
    #[must_use]
    pub fn derivatives(&self, t: f64, order: usize) -> Vec<P> {
        project_derivatives(&self.homogeneous_derivatives(t, order))
    }

    /// Derivatives of numerator and weight of the orders 0 to `order`; at a knot those of the piece that starts there.
    #[must_use]
    pub fn homogeneous_derivatives(&self, t: f64, order: usize) -> Vec<P::Homogeneous> {
        let basis = BasisFunctions::at(self.knots(), t);
        basis.rows_up_to(order).iter().map(|row| self.homogeneous(&basis, row)).collect()
    }

    fn homogeneous(&self, basis: &BasisFunctions<'_>, row: &BasisRow) -> P::Homogeneous {
        let first = basis.first();
        let points = &self.control_points()[first..=first + self.degree()];
        let weighted = points.iter().zip(row).map(|(p, n)| *p * *n);
        weighted.reduce(|sum, p| sum + p).unwrap_or(P::ZERO.with_weight(0.0))
    }

    /// The straight line from `start` to `end` over `domain`.
    ///
    /// # Errors
    /// [`SurfaceError::EmptyRange`], [`SurfaceError::NotFinite`].
    pub fn line(start: P, end: P, domain: [f64; 2]) -> Result<Self, SurfaceError> {
        let [a, b] = domain;
        Self::try_new(1, vec![a, a, b, b], [start, end].map(|p| p.with_weight(1.0)).to_vec())
    }

    /// The part between two parameters of the domain, with clamped knots.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`], [`SurfaceError::EmptyRange`] if they do not ascend.
    pub fn restrict(&self, range: [f64; 2]) -> Result<Self, SurfaceError> {
        let (knots, points) = polygon::restrict(self.knots(), self.control_points(), range)?;
        Self::from_knots(knots, points)
    }

    /// The part between two parameters, with clamped knots. The first lies in the domain; the second may lie up to a length of the
    /// domain behind its end, if the curve is closed.
    pub(crate) fn restrict_over_seam(&self, [from, to]: [f64; 2]) -> Result<Self, SurfaceError> {
        let [start, end] = self.domain();
        // A multiple of the rounding of a shift by the period.
        let negligible = 8.0 * f64::EPSILON * (start.abs() + end.abs());
        let from = if from < start + negligible { start } else { from };
        if to <= end + negligible {
            return self.restrict([from, to.min(end)]);
        }
        if from >= end - negligible {
            return self.restrict([start, (start + (to - end)).min(end)])?.shifted(end - start);
        }
        let rest = (start + (to - end)).min(from);
        Self::joined(&[self.restrict([from, end])?, self.restrict([start, rest])?])
    }

    /// The same curve over a domain that is moved by `offset`.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`], where rounding makes knots coincide.
    pub fn shifted(&self, offset: f64) -> Result<Self, SurfaceError> {
        self.with_knots(self.knots().knots().iter().map(|k| k + offset).collect())
    }

    /// The same curve over [`start`, `end`].
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`].
    pub fn over(&self, [start, end]: [f64; 2]) -> Result<Self, SurfaceError> {
        let [a, b] = self.domain();
        let scale = (end - start) / (b - a);
        // Exact at the ends.
        let map = |k: &f64| if *k == b { end } else { start + (k - a) * scale };
        self.with_knots(self.knots().knots().iter().map(map).collect())
    }

    fn with_knots(&self, knots: Vec<f64>) -> Result<Self, SurfaceError> {
        Self::try_new(self.degree(), knots, self.control_points().to_vec())
    }

    /// The curve in the opposite direction; its parameters are the negatives.
    ///
    /// # Errors
    /// None for a valid curve.
    pub fn reversed(&self) -> Result<Self, SurfaceError> {
        let knots = self.knots().knots().iter().rev().map(|k| -k).collect();
        let points = self.control_points().iter().rev().copied().collect();
        Self::try_new(self.degree(), knots, points)
    }

    /// The curve with its degree raised to `degree`, unless it is that high.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if the degree is higher than possible.
    pub fn elevated(&self, degree: usize) -> Result<Self, SurfaceError> {
        let mut raised = self.clone();
        while raised.degree() < degree {
            let (knots, points) = polygon::elevate(raised.knots(), raised.control_points())?;
            raised = Self::from_knots(knots, points)?;
        }
        Ok(raised)
    }

    /// The clamped curves one after the other, over a domain that starts with that of the first. Where the next does not start at
    /// the end of the one before, its first control point is moved there.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without a curve; those of [`KnotVector::try_new`].
    pub fn joined(parts: &[Self]) -> Result<Self, SurfaceError> {
        let degree = parts.iter().map(Self::degree).max().unwrap_or(1);
        let mut whole: Option<(Vec<f64>, Vec<P::Homogeneous>)> = None;
        for part in parts {
            let part = part.elevated(degree)?;
            let [start, end] = part.domain();
            let Some((knots, points)) = &mut whole else {
                whole = Some((part.knots().knots().to_vec(), part.control_points().to_vec()));
                continue;
            };
            let (Some(&seam), Some(&last)) = (knots.last(), points.last()) else { continue };
            let first = part.control_points().first().map_or(1.0, |p| P::split(*p).1);
            let scale = P::split(last).1 / first;
            knots.pop();
            knots.extend(part.knots().inner().iter().map(|k| seam + (k - start)));
            knots.extend(std::iter::repeat_n(seam + (end - start), degree + 1));
            points.extend(part.control_points().iter().skip(1).map(|p| *p * scale));
        }
        let Some((knots, points)) = whole else {
            return Err(SurfaceError::TooFew { parameter: "curves to join", count: 0, min: 1 });
        };
        Self::try_new(degree, knots, points)
    }

    /// The arc of `center + cos t a + sin t b` over an ascending range of at most a turn, of quarters at most.
    ///
    /// # Source
    /// @farin2002 chapter 12.
    pub(crate) fn elliptic_arc([center, a, b]: [P; 3], [from, to]: [f64; 2]) -> Result<Self, SurfaceError> {
        // Removes the effect of rounding pi at quarter turns.
        let exact = |x: f64| if x.abs() < 2.0 * f64::EPSILON { 0.0 } else { x };
        let radius = |t: f64| {
            let (sin, cos) = t.sin_cos();
            a * exact(cos) + b * exact(sin)
        };
        let count = ((to - from) / (0.25 * TAU) - f64::EPSILON * 8.0).ceil().max(1.0);
        quadratic_pieces(
            [from, to],
            count,
            |middle, half| {
                let c = half.cos();
                (center * c + radius(middle)).with_weight(c)
            },
            |t| center + radius(t),
        )
    }

    /// The arc of `center + cosh t a + sinh t b` over an ascending range, of pieces whose weights differ little.
    pub(crate) fn hyperbolic_arc([center, a, b]: [P; 3], [from, to]: [f64; 2]) -> Result<Self, SurfaceError> {
        /// Largest hyperbolic angle of a piece: its weights then differ by a factor of at most 1.3.
        const LONGEST: f64 = 1.5;
        /// Limit of the number of pieces; cosh overflows at 710.
        const MOST: f64 = 1024.0;
        let radius = |t: f64| a * t.cosh() + b * t.sinh();
        let count = ((to - from) / LONGEST).ceil().clamp(1.0, MOST);
        quadratic_pieces(
            [from, to],
            count,
            |middle, half| {
                let c = half.cosh();
                (center * c + radius(middle)).with_weight(c)
            },
            |t| center + radius(t),
        )
    }
}

/// The quadratic spline of `count` equal pieces between points of weight 1 with `corner(middle, half length)` in each.
fn quadratic_pieces<P: CurveVector>(
    [from, to]: [f64; 2],
    count: f64,
    corner: impl Fn(f64, f64) -> P::Homogeneous,
    point: impl Fn(f64) -> P,
) -> Result<SplineCurve<P>, SurfaceError> {
    let at = |k: f64| if k >= count { to } else { from + (to - from) * (k / count) };
    let half = 0.5 * (to - from) / count;
    let mut knots = vec![from; 3];
    let mut points = vec![point(from).with_weight(1.0)];
    for i in 0..count as u32 {
        let (k, end) = (f64::from(i), at(f64::from(i) + 1.0));
        knots.extend([end, end]);
        points.extend([corner(at(k + 0.5), half), point(end).with_weight(1.0)]);
    }
    knots.push(to);
    SplineCurve::from_knots(KnotVector::try_new(2, knots)?, points)
}
