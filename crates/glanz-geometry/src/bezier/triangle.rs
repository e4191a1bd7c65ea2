//! Rational Bézier patches over triangles.

use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec2, DVec3};

use super::bernstein::{BernsteinSum, binomials, falling};
use super::homogeneous::{
    self, Derivatives, check_points, checked_degree, derivative_index, homogeneous_points, keep_weight,
    project, project_derivatives,
};
use super::net::{BlossomArgument, advance, differences, net_index};
use crate::error::SurfaceError;

/// Barycentric coordinates of a triangle, r + s + t = 1; each is 1 at its corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barycentric {
    /// Weight of the first corner.
    pub r: f64,
    /// Weight of the second corner.
    pub s: f64,
    /// Weight of the third corner.
    pub t: f64,
}

impl Barycentric {
    /// Coordinates of the corners, in their order.
    pub const CORNERS: [Self; 3] =
        [Self { r: 1.0, s: 0.0, t: 0.0 }, Self { r: 0.0, s: 1.0, t: 0.0 }, Self { r: 0.0, s: 0.0, t: 1.0 }];

    /// Coordinates from surface parameters: s = u, t = v, r = 1 - u - v.
    #[must_use]
    pub fn from_parameters(parameters: DVec2) -> Self {
        Self { r: 1.0 - parameters.x - parameters.y, s: parameters.x, t: parameters.y }
    }

    /// The surface parameters u = s and v = t.
    #[must_use]
    pub fn parameters(self) -> DVec2 {
        DVec2::new(self.s, self.t)
    }
}

/// The three borders of a [`TrianglePatch`], each in the direction that has the patch on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleEdge {
    /// t = 0, from the first to the second corner.
    TZero,
    /// r = 0, from the second to the third corner.
    RZero,
    /// s = 0, from the third to the first corner.
    SZero,
}

/// A Bézier patch of degree n over the triangle r + s + t = 1: `sum n! / (i! j! k!) r^i s^j t^k p_ijk`.
///
/// Surface parameters are u = s and v = t, r = 1 - u - v. Control points are homogeneous, (w x, w y, w z, w) with
/// w > 0; all w are 1 if the patch is polynomial. Their order is i descending, then j descending: (n, 0, 0),
/// (n - 1, 1, 0), (n - 1, 0, 1), (n - 2, 2, 0), ..., (0, 0, n).
///
/// # Source
/// @pumberger2010 sections 2.2.3 to 2.2.5 (whose program omits the factors n! / (i! j! k!)); @farin2002 chapter 17.
#[derive(Clone, Debug, PartialEq)]
pub struct TrianglePatch {
    pub(super) degree: usize,
    pub(super) points: Vec<DVec4>,
}

impl TrianglePatch {
    /// A patch from (degree + 1) (degree + 2) / 2 homogeneous control points.
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] for a degree of 0 or a weight, [`SurfaceError::OutOfRange`] for a degree above
    /// [`super::MAX_DEGREE`], [`SurfaceError::CountMismatch`] for the number of points, [`SurfaceError::NotFinite`].
    pub fn try_new(degree: usize, points: Vec<DVec4>) -> Result<Self, SurfaceError> {
        checked_degree("degree", degree)?;
        check_points(&points, (degree + 1) * (degree + 2) / 2)?;
        Ok(Self { degree, points })
    }

    /// A patch from points (metres) in the same order, and as many weights; without weights it is polynomial.
    ///
    /// # Errors
    /// Those of [`TrianglePatch::try_new`], and [`SurfaceError::CountMismatch`] of the weights.
    pub fn try_from_points(
        degree: usize,
        points: &[DVec3],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceError> {
        Self::try_new(degree, homogeneous_points(points, weights)?)
    }

    /// A patch from means of checked points.
    pub(super) fn from_means(degree: usize, source: &[DVec4], points: Vec<DVec4>) -> Self {
        Self { degree, points: keep_weight(source, points) }
    }

    /// The degree n.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Homogeneous control points, in the order of [`TrianglePatch`].
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.points
    }

    /// Index of the control point (i, j, k); `None` unless i + j + k is the degree.
    #[must_use]
    pub fn index(&self, i: usize, j: usize, k: usize) -> Option<usize> {
        let sum = i.checked_add(j)?.checked_add(k)?;
        (sum == self.degree).then(|| net_index(j, k))
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

    /// The homogeneous point at barycentric coordinates.
    #[must_use]
    pub fn homogeneous_point(&self, at: Barycentric) -> DVec4 {
        bernstein_sum(self.degree, at, |e, _| self.points[e])
    }

    /// The point at (u, v), metres.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        self.point_at(Barycentric::from_parameters(DVec2::new(u, v)))
    }

    /// The point at barycentric coordinates, metres.
    #[must_use]
    pub fn point_at(&self, at: Barycentric) -> DVec3 {
        project(self.homogeneous_point(at))
    }

    /// The point at (u, v) by de Casteljau's algorithm: slower than [`TrianglePatch::point`], with convex combinations only.
    ///
    /// # Source
    /// @pumberger2010 algorithm 2.2.4.1.
    #[must_use]
    pub fn de_casteljau(&self, u: f64, v: f64) -> DVec3 {
        let argument = BlossomArgument::At(Barycentric::from_parameters(DVec2::new(u, v)));
        project(self.blossom_value((0..self.degree).map(|_| argument)))
    }

    /// The blossom: the symmetric function of n = degree arguments, affine in each, that equals the homogeneous point if all
    /// arguments are the same.
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`] unless there are n arguments.
    ///
    /// # Source
    /// @farin2002 section 17.4.
    pub fn blossom(&self, arguments: &[Barycentric]) -> Result<DVec4, SurfaceError> {
        if arguments.len() != self.degree {
            let (count, expected) = (arguments.len(), self.degree);
            return Err(SurfaceError::CountMismatch { parameter: "blossom arguments", count, expected });
        }
        Ok(self.blossom_value(arguments.iter().map(|at| BlossomArgument::At(*at))))
    }

    /// The point at (u, v) and its first derivatives by u and by v, metres.
    #[must_use]
    pub fn point_and_tangents(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let at = Barycentric::from_parameters(DVec2::new(u, v));
        let (n, p) = (self.degree, &self.points);
        let value = self.homogeneous_point(at);
        let by_u = bernstein_sum(n - 1, at, |e, d| p[e + d + 1] - p[e]);
        let by_v = bernstein_sum(n - 1, at, |e, d| p[e + d + 2] - p[e]);
        let (point, weight) = (project(value), value.w);
        let tangent = |d: DVec4| (d.truncate() - point * d.w) * (n as f64 / weight);
        (point, tangent(by_u), tangent(by_v))
    }

    /// All partial derivatives by u and v up to the total order `order`.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64, order: usize) -> Derivatives {
        let at = Barycentric::from_parameters(DVec2::new(u, v));
        let n = self.degree;
        let mut homogeneous = vec![DVec4::ZERO; derivative_index(0, order) + 1];
        // Beyond the degree, the homogeneous derivatives vanish.
        let mut by_v = self.points.clone();
        for l in 0..=order.min(n) {
            let mut net = by_v.clone();
            for k in 0..=(order - l).min(n - l) {
                homogeneous[derivative_index(k, l)] =
                    bernstein_sum(n - k - l, at, |e, _| net[e]) * falling(n, k + l);
                differences(&mut net, n - k - l, 1);
            }
            differences(&mut by_v, n - l, 2);
        }
        Derivatives::project(order, &homogeneous)
    }

    /// Derivatives of orders 0 to `order` of the point at (u, v) + e `direction` by e, at e = 0; metres.
    ///
    /// # Source
    /// @pumberger2010 proposition 2.2.5.1, applied repeatedly.
    #[must_use]
    pub fn directional_derivatives(&self, u: f64, v: f64, direction: DVec2, order: usize) -> Vec<DVec3> {
        let at = Barycentric::from_parameters(DVec2::new(u, v));
        let direction = BlossomArgument::At(Barycentric {
            r: -direction.x - direction.y,
            s: direction.x,
            t: direction.y,
        });
        let mut net = self.points.clone();
        let mut homogeneous = vec![DVec4::ZERO; order + 1];
        for (m, value) in homogeneous.iter_mut().enumerate().take(self.degree + 1) {
            *value = bernstein_sum(self.degree - m, at, |e, _| net[e]) * falling(self.degree, m);
            advance(&mut net, self.degree - m, direction);
        }
        project_derivatives(&homogeneous)
    }

    /// The unit normal along dp/du x dp/dv.
    ///
    /// Where the tangents vanish or are parallel, it is the normal of a nearby point towards the middle, with half of the
    /// digits; `None` if that point has no normal either.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> Option<DVec3> {
        let net = (self.control_points(), self.degree);
        let inner = [(0.34, 0.33), (0.2, 0.5)];
        homogeneous::normal(net, (u, v), inner, |u, v| self.point_and_tangents(u, v))
    }

    /// The same patch with its degree raised by one.
    ///
    /// # Source
    /// @pumberger2010 section 2.2.3.
    #[must_use]
    pub fn elevated(&self) -> Self {
        let n = self.degree + 1;
        let mut points = Vec::with_capacity((n + 1) * (n + 2) / 2);
        for (i, j, k) in indices(n) {
            // On the border one term is missing, so that the order of the sum does not matter.
            let mut sum = DVec4::ZERO;
            if i > 0 {
                sum += self.points[net_index(j, k)] * i as f64;
            }
            if j > 0 {
                sum += self.points[net_index(j - 1, k)] * j as f64;
            }
            if k > 0 {
                sum += self.points[net_index(j, k - 1)] * k as f64;
            }
            points.push(sum / n as f64);
        }
        Self::from_means(n, &self.points, points)
    }

    /// The patch with its second and third corners exchanged; its normal points to the other side.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        self.renumbered(|_, j, k| net_index(k, j))
    }

    /// The patch with its corners renumbered: the second becomes the first, the third the second, the first the third.
    #[must_use]
    pub fn rotated(&self) -> Self {
        // The new (i, j, k) belongs to the old second, third and first corner.
        self.renumbered(|second, third, _| net_index(second, third))
    }

    /// Homogeneous control points of the row `row` steps away from an edge, in the direction of the edge; empty beyond the
    /// opposite corner.
    #[must_use]
    pub fn edge_row(&self, edge: TriangleEdge, row: usize) -> Vec<DVec4> {
        edge_row_indices(self.degree, edge, row).map(|e| self.points[e]).collect()
    }

    /// Homogeneous control points of an edge, in its direction.
    #[must_use]
    pub fn edge(&self, edge: TriangleEdge) -> Vec<DVec4> {
        self.edge_row(edge, 0)
    }

    fn renumbered(&self, old: impl Fn(usize, usize, usize) -> usize) -> Self {
        let points = indices(self.degree).map(|(i, j, k)| self.points[old(i, j, k)]).collect();
        Self { degree: self.degree, points }
    }

    /// The value of the blossom at as many arguments as the degree.
    fn blossom_value(&self, arguments: impl Iterator<Item = BlossomArgument>) -> DVec4 {
        let mut net = self.points.clone();
        for (done, argument) in arguments.enumerate() {
            advance(&mut net, self.degree - done, argument);
        }
        net[0]
    }
}

/// All (i, j, k) with i + j + k = n, in the order of control points.
pub(super) fn indices(n: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..=n).flat_map(move |d| (0..=d).map(move |k| (n - d, d - k, k)))
}

/// Indices of the points of [`TrianglePatch::edge_row`].
pub(super) fn edge_row_indices(n: usize, edge: TriangleEdge, row: usize) -> impl Iterator<Item = usize> {
    let count = (n + 1).saturating_sub(row);
    (0..count).map(move |end| {
        let start = count - 1 - end;
        match edge {
            TriangleEdge::TZero => net_index(end, row),
            TriangleEdge::RZero => net_index(start, end),
            TriangleEdge::SZero => net_index(row, start),
        }
    })
}

/// The sum of Bernstein polynomials of a degree; `net` returns the point with a given index in a given row (degree - i).
fn bernstein_sum(degree: usize, at: Barycentric, net: impl Fn(usize, usize) -> DVec4) -> DVec4 {
    let (mut sum, mut e) = (DVec4::ZERO, 0);
    for (d, binomial) in binomials(degree).enumerate() {
        let mut row = BernsteinSum::new(d, at.s, at.t);
        for _ in 0..=d {
            row.push(net(e, d));
            e += 1;
        }
        sum = sum * at.r + row.sum * binomial;
    }
    sum
}
