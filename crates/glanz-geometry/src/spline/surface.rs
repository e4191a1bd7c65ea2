//! Rational B-spline surfaces.

use glanz_math::glam::DVec4;
use glanz_math::rounding::{UNIT_ROUNDOFF, gamma};
use glanz_math::{Bounds3, DVec3};

use super::basis::{BasisFunctions, BasisRow};
use super::homogeneous::{check, homogeneous_points, project};
use super::knots::{KnotVector, check_degree};
use super::polygon;
use crate::bezier::Derivatives;
use crate::bezier::homogeneous::derivative_index;
use crate::error::{SurfaceError, finite};

/// A NURBS surface `sum N_i(u) N_j(v) w_ij P_ij / sum N_i(u) N_j(v) w_ij`, metres; its normal points along
/// `dS/du x dS/dv`.
///
/// # Source
/// @markgraf2019 eq. 15 to 27.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    knots_u: KnotVector,
    knots_v: KnotVector,
    /// Homogeneous control points; (i, j) is at i * count_v + j.
    points: Vec<DVec4>,
    bounds: Bounds3,
}

impl NurbsSurface {
    /// The surface with homogeneous control points (w x, w y, w z, w), those of equal u next to each other: point (i, j) is
    /// at `i * count_v + j`, where `count_v = knots_v.len() - degree_v - 1`. `degrees` and `knots` are those in u and in v.
    ///
    /// At a knot inside the domain that appears `degree + 1` times the surface jumps: it consists of pieces. A knot that appears still more
    /// often has control points that act nowhere; they and the repetitions are left out.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_with_jumps`] for each direction; [`SurfaceError::CountMismatch`] for the number of points,
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a weight.
    pub fn try_new(
        degrees: [usize; 2],
        knots: [Vec<f64>; 2],
        points: Vec<DVec4>,
    ) -> Result<Self, SurfaceError> {
        let ([degree_u, degree_v], [knots_u, knots_v]) = (degrees, knots);
        let (all_u, all_v) = (ControlRows::new(degree_u, &knots_u), ControlRows::new(degree_v, &knots_v));
        let checked = |name, degree: usize, rows: &ControlRows| {
            KnotVector::checked(name, degree, rows.knots.clone(), degree.saturating_add(1))
        };
        let knots_u = checked("knot in u", degree_u, &all_u)?;
        let knots_v = checked("knot in v", degree_v, &all_v)?;
        if all_u.is_complete() && all_v.is_complete() {
            return Self::from_knots(knots_u, knots_v, points);
        }
        check(&points, all_u.count.saturating_mul(all_v.count))?;
        let rows = all_u.acting.iter().filter_map(|i| points.chunks_exact(all_v.count).nth(*i));
        let acting = rows.flat_map(|row| all_v.acting.iter().filter_map(|j| row.get(*j))).copied().collect();
        Self::from_knots(knots_u, knots_v, acting)
    }

    /// The surface with control points in space (metres) and as many weights, in the order of [`Self::try_new`]; without
    /// weights it is polynomial.
    ///
    /// # Errors
    /// Those of [`Self::try_new`], and [`SurfaceError::CountMismatch`] for the number of weights.
    pub fn try_from_points(
        degrees: [usize; 2],
        knots: [Vec<f64>; 2],
        points: &[DVec3],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceError> {
        Self::try_new(degrees, knots, homogeneous_points(points, weights)?)
    }

    /// The surface over checked knots, with homogeneous control points in the order of [`Self::try_new`].
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`] for the number of points, [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a
    /// weight.
    pub fn from_knots(
        knots_u: KnotVector,
        knots_v: KnotVector,
        points: Vec<DVec4>,
    ) -> Result<Self, SurfaceError> {
        check(&points, knots_u.count().saturating_mul(knots_v.count()))?;
        let bounds = Bounds3::from_points(points.iter().map(|p| project(*p)));
        Ok(Self { knots_u, knots_v, points, bounds })
    }

    /// Knots and degree in u.
    #[must_use]
    pub fn knots_u(&self) -> &KnotVector {
        &self.knots_u
    }

    /// Knots and degree in v.
    #[must_use]
    pub fn knots_v(&self) -> &KnotVector {
        &self.knots_v
    }

    /// Numbers of control points in u and v.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        (self.knots_u.count(), self.knots_v.count())
    }

    /// Homogeneous control points; point (i, j) is at `i * count_v + j`.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.points
    }

    /// Whether all weights are 1.
    #[must_use]
    pub fn is_polynomial(&self) -> bool {
        self.points.iter().all(|p| p.w == 1.0)
    }

    /// A box around all control points, which also contains the surface.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// The point at (u, v), metres; parameters outside the domain are clamped to it.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        project(self.homogeneous_point(u, v))
    }

    /// The homogeneous point (w x, w y, w z, w) at (u, v), coordinates in metres; parameters outside the domain are clamped to it.
    #[must_use]
    pub fn homogeneous_point(&self, u: f64, v: f64) -> DVec4 {
        let bases = self.bases(u, v);
        let mut value = [DVec4::ZERO];
        self.homogeneous(&bases, [&[bases[0].values()], &[bases[1].values()]], &mut value);
        value[0]
    }

    /// The point and its first derivatives by u and v.
    ///
    /// # Source
    /// @markgraf2019 eq. 20.
    #[must_use]
    pub fn tangents(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let bases = self.bases(u, v);
        let mut all = [DVec4::ZERO; 3];
        self.homogeneous(&bases, [&bases[0].rows::<2>(), &bases[1].rows::<2>()], &mut all);
        let [value, by_u, by_v] = all;
        let point = project(value);
        let tangent = |a: DVec4| (a.truncate() - a.w * point) / value.w;
        (point, tangent(by_u), tangent(by_v))
    }

    /// All partial derivatives up to a total `order`.
    ///
    /// At a knot they are those of the piece that starts there.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64, order: usize) -> Derivatives {
        let bases = self.bases(u, v);
        let mut homogeneous = vec![DVec4::ZERO; derivative_index(0, order) + 1];
        if order <= 2 {
            self.homogeneous(&bases, [&bases[0].rows::<3>(), &bases[1].rows::<3>()], &mut homogeneous);
        } else {
            let [rows_u, rows_v] = [0, 1].map(|axis| bases[axis].rows_up_to(order));
            self.homogeneous(&bases, [&rows_u, &rows_v], &mut homogeneous);
        }
        Derivatives::project(order, &homogeneous)
    }

    /// The unit normal along `dS/du x dS/dv`.
    ///
    /// Where the derivatives vanish or are parallel, as at the pole of a sphere, it is the limit along the line to the
    /// middle of the domain. `None` where the limit does not exist up to second order nor after a small step.
    ///
    /// # Source
    /// @markgraf2019 eq. 27, corrected: first derivatives, u before v.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> Option<DVec3> {
        let (u, v) = (self.knots_u.clamp(u), self.knots_v.clamp(v));
        let (_, du, dv) = self.tangents(u, v);
        let ([u0, u1], [v0, v1]) = (self.knots_u.domain(), self.knots_v.domain());
        // The area element of a surface of this size at constant speed; the derivatives carry a few roundings per step of
        // the recursion.
        let usual = self.bounds.min.distance_squared(self.bounds.max) / ((u1 - u0) * (v1 - v0));
        let steps = 8 * (self.knots_u.degree() + self.knots_v.degree()) as u32;
        let negligible = gamma(steps) * usual;
        let normal = du.cross(dv);
        if normal.length() > negligible {
            return normal.try_normalize();
        }
        let (to_u, to_v) = (0.5 * (u0 + u1) - u, 0.5 * (v0 + v1) - v);
        let d = self.derivatives(u, v, 2);
        let by_u = d.at(2, 0).cross(dv) + du.cross(d.at(1, 1));
        let by_v = d.at(1, 1).cross(dv) + du.cross(d.at(0, 2));
        let limit = by_u * to_u + by_v * to_v;
        if limit.length() > negligible {
            return limit.try_normalize();
        }
        // At a zero of higher order, a step of the root of the roundoff leaves half of the digits.
        let step = UNIT_ROUNDOFF.sqrt();
        let (_, du, dv) = self.tangents(u + to_u * step, v + to_v * step);
        du.cross(dv).try_normalize()
    }

    fn bases(&self, u: f64, v: f64) -> [BasisFunctions<'_>; 2] {
        [BasisFunctions::at(&self.knots_u, u), BasisFunctions::at(&self.knots_v, v)]
    }

    /// Adds the derivatives of the homogeneous form, by [`derivative_index`], to `sums`: as many of them as it has.
    fn homogeneous(
        &self,
        [in_u, in_v]: &[BasisFunctions<'_>; 2],
        [rows_u, rows_v]: [&[BasisRow]; 2],
        sums: &mut [DVec4],
    ) {
        for i in 0..=self.knots_u.degree() {
            let first = (in_u.first() + i) * self.knots_v.count() + in_v.first();
            let points = &self.points[first..=first + self.knots_v.degree()];
            for (l, row_v) in rows_v.iter().enumerate() {
                let along_v = points.iter().zip(row_v).map(|(point, m)| *point * *m).sum::<DVec4>();
                for (k, row_u) in rows_u.iter().enumerate() {
                    if let Some(sum) = sums.get_mut(derivative_index(k, l)) {
                        *sum += along_v * row_u[i];
                    }
                }
            }
        }
    }

    /// A surface that is closed in u, in v, or in both, from control points that are not repeated.
    ///
    /// In a periodic direction with `n` control points there are `n + 1` knots: one period, whose first and last knot
    /// coincide. Point i acts between the knots `i - degree` and `i + 1`, modulo the period. In the other direction, knots
    /// are as in [`KnotVector::try_new`], without jumps. The result is clamped; its control points on both sides of the seam are equal to the
    /// last bit.
    ///
    /// # Errors
    /// Those of [`KnotVector::try_new`] for each direction, [`SurfaceError::CountMismatch`] for the number of points,
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a weight, and [`SurfaceError::TooFew`] with fewer than 2 knots in a
    /// periodic direction.
    pub fn try_new_periodic(
        degrees: [usize; 2],
        knots: [Vec<f64>; 2],
        points: Vec<DVec4>,
        periodic: [bool; 2],
    ) -> Result<Self, SurfaceError> {
        let [degree_u, degree_v] = degrees;
        let [mut knots_u, mut knots_v] = knots;
        let mut count_v = knots_v.len().saturating_sub(degree_v.saturating_add(1));
        if periodic[1] {
            count_v = knots_v.len().saturating_sub(1);
            knots_v = unroll("knot in v", degree_v, &knots_v)?;
        }
        let mut count_u = knots_u.len().saturating_sub(degree_u.saturating_add(1));
        if periodic[0] {
            count_u = knots_u.len().saturating_sub(1);
            knots_u = unroll("knot in u", degree_u, &knots_u)?;
        }
        let knots_u = KnotVector::checked("knot in u", degree_u, knots_u, degree_u)?;
        let knots_v = KnotVector::checked("knot in v", degree_v, knots_v, degree_v)?;
        check(&points, count_u.saturating_mul(count_v))?;
        let unrolled = (0..knots_u.count()).flat_map(|i| {
            let points = &points;
            (0..knots_v.count()).map(move |j| points[i % count_u * count_v + j % count_v])
        });
        let open = Self::from_knots(knots_u.clone(), knots_v.clone(), unrolled.collect())?;
        let mut closed = open.restrict([knots_u.domain(), knots_v.domain()])?;
        let (rows, columns) = closed.counts();
        if periodic[0] {
            closed.points.copy_within(0..columns, (rows - 1) * columns);
        }
        if periodic[1] {
            for row in closed.points.chunks_exact_mut(columns) {
                row[columns - 1] = row[0];
            }
        }
        Ok(closed)
    }

    /// Applies `change` to every row of control points along v.
    pub(super) fn map_rows_v(
        &self,
        change: impl Fn(&KnotVector, &[DVec4]) -> Result<(KnotVector, Vec<DVec4>), SurfaceError>,
    ) -> Result<Self, SurfaceError> {
        let mut knots = self.knots_v.clone();
        let mut points = Vec::with_capacity(self.points.len());
        for row in self.points.chunks_exact(self.knots_v.count()) {
            let (new_knots, new_row) = change(&self.knots_v, row)?;
            knots = new_knots;
            points.extend(new_row);
        }
        Self::from_knots(self.knots_u.clone(), knots, points)
    }

    /// The surface with u and v exchanged; its normal points to the other side.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let (count_u, count_v) = self.counts();
        let points = (0..count_v).flat_map(|j| (0..count_u).map(move |i| self.points[i * count_v + j]));
        Self {
            knots_u: self.knots_v.clone(),
            knots_v: self.knots_u.clone(),
            points: points.collect(),
            bounds: self.bounds,
        }
    }

    /// The part over the rectangle [u, v] of the domain, with clamped knots.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for a parameter outside the domain, [`SurfaceError::EmptyRange`] if they do not ascend.
    pub fn restrict(&self, [range_u, range_v]: [[f64; 2]; 2]) -> Result<Self, SurfaceError> {
        let strip = self.map_rows_v(|t, row| polygon::restrict(t, row, range_v))?;
        Ok(strip.transposed().map_rows_v(|t, row| polygon::restrict(t, row, range_u))?.transposed())
    }
}

/// The rows of control points along one direction that act somewhere, and their knots.
struct ControlRows {
    knots: Vec<f64>,
    /// Number of all rows.
    count: usize,
    /// Those whose basis function is not zero everywhere.
    acting: Vec<usize>,
}

impl ControlRows {
    fn new(degree: usize, knots: &[f64]) -> Self {
        let order = degree.saturating_add(1);
        let count = knots.len().saturating_sub(order);
        let is_idle = |i: &usize| knots.get(*i) == knots.get(i.saturating_add(order));
        let acting: Vec<usize> = (0..count).filter(|i| !is_idle(i)).collect();
        // Invalid knots are left for their errors.
        if acting.len() < order || !knots.is_sorted() {
            return Self { knots: knots.to_vec(), count, acting: (0..count).collect() };
        }
        let kept = acting.iter().filter_map(|&i| knots.get(i)).chain(knots.get(count..).unwrap_or(&[]));
        Self { knots: kept.copied().collect(), count, acting }
    }

    fn is_complete(&self) -> bool {
        self.acting.len() == self.count
    }
}

/// The knots of one period, continued by `degree` knots on each side.
fn unroll(parameter: &'static str, degree: usize, period: &[f64]) -> Result<Vec<f64>, SurfaceError> {
    let (count, min) = (period.len(), 2);
    if count < min {
        return Err(SurfaceError::TooFew { parameter: "knots", count, min });
    }
    check_degree(degree)?;
    let (n, length) = (count - 1, finite(parameter, period[count - 1] - period[0])?);
    let shifted = |i: usize, turns: f64| period[i] + turns * length;
    let before = (1..=degree).rev().map(|k| shifted((n - k % n) % n, -(k.div_ceil(n) as f64)));
    let after = (1..=degree).map(|k| shifted(k % n, (k / n) as f64 + 1.0));
    Ok(before.chain(period.iter().copied()).chain(after).collect())
}
