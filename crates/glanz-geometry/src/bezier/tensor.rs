//! Rational Bézier patches over the unit square.

use std::ops::Range;
use std::sync::Arc;

use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec3};

use super::bernstein::{BernsteinSum, curve_derivatives, elevate, part, split};
use super::homogeneous::{
    self, Derivatives, check_points, checked_degree, derivative_index, homogeneous_points, keep_weight,
    project,
};
use crate::error::{SurfaceError, finite};

/// A Bézier patch over (u, v) in the unit square.
///
/// Control points are homogeneous, (w x, w y, w z, w) with w > 0; all w are 1 if the patch is polynomial. Evaluation outside
/// the unit square extrapolates the same rational functions.
///
/// # Source
/// @farin2002 chapters 14 and 16.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorPatch {
    degree_u: usize,
    degree_v: usize,
    points: Arc<[DVec4]>,
}

/// The four borders of a [`TensorPatch`], each in the direction that has the patch on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TensorEdge {
    /// v = 0, from u = 0 to u = 1.
    VZero,
    /// u = 1, from v = 0 to v = 1.
    UOne,
    /// v = 1, from u = 1 to u = 0.
    VOne,
    /// u = 0, from v = 1 to v = 0.
    UZero,
}

impl TensorPatch {
    /// A patch from (degree_u + 1) (degree_v + 1) homogeneous control points, those of equal u next to each other.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] for a degree of 0 or a weight, [`SurfaceError::OutOfRange`] for a degree above
    /// [`super::MAX_DEGREE`], [`SurfaceError::CountMismatch`] for the number of points, [`SurfaceError::NotFinite`].
    pub fn try_new(degree_u: usize, degree_v: usize, points: Vec<DVec4>) -> Result<Self, SurfaceError> {
        checked_degree("degree in u", degree_u)?;
        checked_degree("degree in v", degree_v)?;
        check_points(&points, (degree_u + 1) * (degree_v + 1))?;
        Ok(Self { degree_u, degree_v, points: points.into() })
    }

    /// A patch from points (metres) in the same order, and as many weights; without weights it is polynomial.
    ///
    /// # Errors
    /// Those of [`TensorPatch::try_new`], and [`SurfaceError::CountMismatch`] of the weights.
    pub fn try_from_points(
        degree_u: usize,
        degree_v: usize,
        points: &[DVec3],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceError> {
        Self::try_new(degree_u, degree_v, homogeneous_points(points, weights)?)
    }

    /// A patch from means of checked points.
    pub(super) fn from_means(degree_u: usize, degree_v: usize, source: &[DVec4], points: Vec<DVec4>) -> Self {
        Self { degree_u, degree_v, points: keep_weight(source, points).into() }
    }

    /// Degrees in u and v.
    #[must_use]
    pub fn degrees(&self) -> (usize, usize) {
        (self.degree_u, self.degree_v)
    }

    /// Homogeneous control points; point (i, j) is at i (degree in v + 1) + j.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.points
    }

    /// The control points, shared with the patch and its clones.
    pub(crate) fn shared_control_points(&self) -> Arc<[DVec4]> {
        self.points.clone()
    }

    /// Whether any two weights differ.
    #[must_use]
    pub fn is_rational(&self) -> bool {
        homogeneous::is_rational(&self.points)
    }

    /// A box around the control points, metres, which also contains the patch.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        homogeneous::bounds(&self.points)
    }

    /// The homogeneous point at (u, v).
    #[must_use]
    pub fn homogeneous_point(&self, u: f64, v: f64) -> DVec4 {
        let mut sum_u = BernsteinSum::new(self.degree_u, 1.0 - u, u);
        for row in self.rows() {
            let mut sum_v = BernsteinSum::new(self.degree_v, 1.0 - v, v);
            row.iter().for_each(|p| sum_v.push(*p));
            sum_u.push(sum_v.sum);
        }
        sum_u.sum
    }

    /// The point at (u, v), metres.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        project(self.homogeneous_point(u, v))
    }

    /// The point at (u, v) and its first derivatives by u and by v, metres.
    #[must_use]
    pub fn point_and_tangents(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let mut value = BernsteinSum::new(self.degree_u, 1.0 - u, u);
        let mut by_v = BernsteinSum::new(self.degree_u, 1.0 - u, u);
        let mut by_u = BernsteinSum::new(self.degree_u - 1, 1.0 - u, u);
        let mut previous: Option<DVec4> = None;
        for row in self.rows() {
            let mut point = BernsteinSum::new(self.degree_v, 1.0 - v, v);
            let mut slope = BernsteinSum::new(self.degree_v - 1, 1.0 - v, v);
            row.iter().for_each(|p| point.push(*p));
            row.windows(2).for_each(|p| slope.push(p[1] - p[0]));
            value.push(point.sum);
            by_v.push(slope.sum);
            if let Some(last) = previous.replace(point.sum) {
                by_u.push(point.sum - last);
            }
        }
        let (point, weight) = (project(value.sum), value.sum.w);
        let tangent = |d: DVec4| (d.truncate() - point * d.w) / weight;
        (point, tangent(by_u.sum * self.degree_u as f64), tangent(by_v.sum * self.degree_v as f64))
    }

    /// All partial derivatives at (u, v) up to the total order `order`.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64, order: usize) -> Derivatives {
        let rows: Vec<_> = self.rows().map(|row| curve_derivatives(row, v, order)).collect();
        let mut homogeneous = vec![DVec4::ZERO; derivative_index(0, order) + 1];
        for l in 0..=order {
            let curve: Vec<_> = rows.iter().map(|row| row[l]).collect();
            for (k, value) in curve_derivatives(&curve, u, order - l).into_iter().enumerate() {
                homogeneous[derivative_index(k, l)] = value;
            }
        }
        Derivatives::project(order, &homogeneous)
    }

    /// The unit normal along dp/du x dp/dv.
    ///
    /// Where the tangents vanish or are parallel, as at a collapsed border, it is the normal of a nearby point towards the
    /// middle, with half of the digits; `None` if that point has no normal either.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> Option<DVec3> {
        let net = (self.control_points(), self.degree_u.max(self.degree_v));
        let inner = [(0.5, 0.5), (0.25, 0.75)];
        homogeneous::normal(net, (u, v), inner, |u, v| self.point_and_tangents(u, v))
    }

    /// The parts below and above u = `t`, each over the unit square again.
    ///
    /// Their common border has the same bits in both. Two patches with a common edge that are both split there, in either
    /// direction, keep the same bits if `1 - t` is exact (as for 1/2).
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if `t` is not in [0, 1], [`SurfaceError::NotFinite`].
    pub fn split_u(&self, t: f64) -> Result<(Self, Self), SurfaceError> {
        let (before, after) = self.transposed().split_v(t)?;
        Ok((before.transposed(), after.transposed()))
    }

    /// The parts below and above v = `t`; otherwise as [`TensorPatch::split_u`].
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if `t` is not in [0, 1], [`SurfaceError::NotFinite`].
    pub fn split_v(&self, t: f64) -> Result<(Self, Self), SurfaceError> {
        check_unit("split parameter", t)?;
        Ok(self.cut_v(t))
    }

    /// The halves in u.
    #[must_use]
    pub fn halves_u(&self) -> (Self, Self) {
        let (before, after) = self.transposed().cut_v(0.5);
        (before.transposed(), after.transposed())
    }

    /// The halves in v.
    #[must_use]
    pub fn halves_v(&self) -> (Self, Self) {
        self.cut_v(0.5)
    }

    /// The part over a rectangle of the unit square, over the unit square again.
    ///
    /// Neighbouring rectangles of the same extent along their common border have the same bits there.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] if an end is not in [0, 1], [`SurfaceError::NotFinite`], [`SurfaceError::EmptyRange`] if a
    /// range has no extent.
    pub fn sub_rectangle(&self, u: Range<f64>, v: Range<f64>) -> Result<Self, SurfaceError> {
        for (parameter, range) in [("u", &u), ("v", &v)] {
            check_unit(parameter, range.start)?;
            check_unit(parameter, range.end)?;
            if range.is_empty() {
                return Err(SurfaceError::EmptyRange { parameter, min: range.start, max: range.end });
            }
        }
        let strip = self.mapped_v(self.degree_v, |row| part(row, &v));
        Ok(strip.transposed().mapped_v(self.degree_u, |row| part(row, &u)).transposed())
    }

    /// The same patch with its degree in u raised by one.
    #[must_use]
    pub fn elevated_u(&self) -> Self {
        self.transposed().elevated_v().transposed()
    }

    /// The same patch with its degree in v raised by one.
    #[must_use]
    pub fn elevated_v(&self) -> Self {
        self.mapped_v(self.degree_v + 1, elevate)
    }

    /// The patch with u replaced by 1 - u; its normal points to the other side.
    #[must_use]
    pub fn reversed_u(&self) -> Self {
        let points = self.rows().rev().flatten().copied().collect();
        Self { points, ..*self }
    }

    /// The patch with v replaced by 1 - v; its normal points to the other side.
    #[must_use]
    pub fn reversed_v(&self) -> Self {
        let points = self.rows().flat_map(|row| row.iter().rev()).copied().collect();
        Self { points, ..*self }
    }

    /// The patch with u and v exchanged; its normal points to the other side.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let columns = 0..=self.degree_v;
        let points = columns.flat_map(|j| self.rows().filter_map(move |row| row.get(j))).copied().collect();
        Self { degree_u: self.degree_v, degree_v: self.degree_u, points }
    }

    /// Homogeneous control points of a border, in its direction.
    #[must_use]
    pub fn edge(&self, edge: TensorEdge) -> Vec<DVec4> {
        let (p, q) = (self.degree_u, self.degree_v);
        let at = |i: usize, j: usize| self.points[i * (q + 1) + j];
        match edge {
            TensorEdge::VZero => (0..=p).map(|i| at(i, 0)).collect(),
            TensorEdge::UOne => (0..=q).map(|j| at(p, j)).collect(),
            TensorEdge::VOne => (0..=p).rev().map(|i| at(i, q)).collect(),
            TensorEdge::UZero => (0..=q).rev().map(|j| at(0, j)).collect(),
        }
    }

    /// Control points by rows of equal u.
    fn rows(&self) -> std::slice::ChunksExact<'_, DVec4> {
        self.points.chunks_exact(self.degree_v + 1)
    }

    fn cut_v(&self, t: f64) -> (Self, Self) {
        let cut: Vec<_> = self.rows().map(|row| split(row, t)).collect();
        let before = cut.iter().flat_map(|(row, _)| row).copied().collect();
        let after = cut.iter().flat_map(|(_, row)| row).copied().collect();
        (self.with_degree_v(self.degree_v, before), self.with_degree_v(self.degree_v, after))
    }

    fn mapped_v(&self, degree_v: usize, map: impl Fn(&[DVec4]) -> Vec<DVec4>) -> Self {
        self.with_degree_v(degree_v, self.rows().flat_map(map).collect())
    }

    fn with_degree_v(&self, degree_v: usize, points: Vec<DVec4>) -> Self {
        Self::from_means(self.degree_u, degree_v, &self.points, points)
    }
}

/// Checks that `value` is in [0, 1].
fn check_unit(parameter: &'static str, value: f64) -> Result<(), SurfaceError> {
    finite(parameter, value)?;
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(SurfaceError::OutOfRange { parameter, value, min: 0.0, max: 1.0 })
    }
}
