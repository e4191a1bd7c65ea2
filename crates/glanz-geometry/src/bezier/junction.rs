//! Continuity of two patches along a common edge, and construction of smooth neighbours.

use std::f64::consts::PI;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::bernstein::elevate;
use super::tensor::{TensorEdge, TensorPatch};
use super::triangle::{TriangleEdge, TrianglePatch, edge_row_indices};
use crate::error::SurfaceError;

/// A border of a patch, in the direction that has the patch on its left.
#[derive(Clone, Copy, Debug)]
pub enum PatchBorder<'a> {
    /// Border of a patch over the unit square.
    Tensor(&'a TensorPatch, TensorEdge),
    /// Border of a patch over a triangle.
    Triangle(&'a TrianglePatch, TriangleEdge),
}

/// The relation of the derivatives across a border on both of its sides.
///
/// With D the derivative into the first patch, T the derivative along the border and e from 0 to 1 along it, the derivative
/// into the second patch is `-across D + ((1 - e) along_start + e along_end) T`. The direction into a triangle is from the start
/// of the edge (in the direction of the first patch) to the opposite corner; into a square it is perpendicular to the edge.
///
/// If `along_start` and `along_end` are equal, this is an affine map of the domains, and patches that satisfy it are C1: the
/// opposite corner of the second triangle is at (-across, 1 + across - along, along) in the coordinates (opposite corner,
/// start, end) of the first. Otherwise they are G1.
///
/// # Source
/// @pumberger2010 section 2.2.6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderContinuation {
    /// Factor of the derivative across, greater than 0.
    pub across: f64,
    /// Factor of the derivative along, at the start of the edge of the first patch.
    pub along_start: f64,
    /// Factor of the derivative along, at the end of that edge.
    pub along_end: f64,
}

impl BorderContinuation {
    /// The relation of an affine map of the domains.
    #[must_use]
    pub fn affine(across: f64, along: f64) -> Self {
        Self { across, along_start: along, along_end: along }
    }
}

/// Largest deviations from continuity along a common edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JunctionDeviation {
    /// Distance between points of equal parameter, metres.
    pub position: f64,
    /// Angle between the tangent planes of both patches, radians: 0 is smooth, pi is a fold.
    pub angle: f64,
    /// Number of points where a patch has no tangent plane, which do not count in `angle`.
    pub undecided: usize,
}

impl JunctionDeviation {
    /// Measures at `samples` points, at least 2: the ends of the edge and points between them. The edges may have either
    /// direction.
    #[must_use]
    pub fn measure(a: PatchBorder<'_>, b: PatchBorder<'_>, samples: usize) -> Self {
        let mut largest = Self { position: 0.0, angle: 0.0, undecided: 0 };
        for (p, q) in point_pairs(a, b, samples) {
            largest.position = largest.position.max(p.point.distance(q.point));
            match (p.conormal(), q.conormal()) {
                // The smaller angle by its chord, which keeps the digits near 0.
                (Some(m), Some(n)) => {
                    let bend = 2.0 * (m + n).length().atan2((m - n).length());
                    largest.angle = largest.angle.max(bend.min(PI));
                }
                _ => largest.undecided += 1,
            }
        }
        largest
    }

    /// Whether the patches meet, to `distance` metres.
    #[must_use]
    pub fn is_c0(&self, distance: f64) -> bool {
        self.position <= distance
    }

    /// Whether the patches meet, to `distance` metres, with common tangent planes, to `angle` radians.
    #[must_use]
    pub fn is_g1(&self, distance: f64, angle: f64) -> bool {
        self.is_c0(distance) && self.undecided == 0 && self.angle <= angle
    }
}

/// The largest difference between the derivative into `b` and the one that `continuation` predicts from `a`, metres per
/// parameter, at `samples` points (at least 2). Zero, up to rounding, where C0 patches are C1 (see [`BorderContinuation`]).
#[must_use]
pub fn derivative_deviation(
    a: PatchBorder<'_>,
    b: PatchBorder<'_>,
    continuation: &BorderContinuation,
    samples: usize,
) -> f64 {
    let samples = samples.max(2);
    let deviation = |(number, (p, q)): (usize, (BorderPoint, BorderPoint))| {
        let e = number as f64 / (samples - 1) as f64;
        let along = continuation.along_start * (1.0 - e) + continuation.along_end * e;
        q.inward.distance(p.along * along - p.inward * continuation.across)
    };
    point_pairs(a, b, samples).enumerate().map(deviation).fold(0.0, f64::max)
}

/// `b` with its border and the adjacent row of control points moved so that it continues `a` as `continuation` requires: C1 if
/// that is affine, G1 otherwise.
///
/// Both patches have the same orientation, so that their borders have opposite directions. With n the degree of `a`, `b` has the
/// degree n or n + 1 for an affine continuation, n + 1 for others. Rational patches are joined in homogeneous space, which is
/// sufficient, but not necessary.
///
/// # Errors
/// [`SurfaceError::CountMismatch`] for another degree of `b`; [`SurfaceError::NotPositive`] if `across` or a resulting weight is
/// not positive; [`SurfaceError::NotFinite`].
///
/// # Source
/// @pumberger2010 section 2.2.6, with the roles of r and t in g_j corrected; the G1 condition given there for squares holds for
/// triangles, where the derivative across has the degree n - 1, after one degree elevation.
pub fn join(
    a: &TrianglePatch,
    edge_a: TriangleEdge,
    b: &TrianglePatch,
    edge_b: TriangleEdge,
    continuation: &BorderContinuation,
) -> Result<TrianglePatch, SurfaceError> {
    crate::error::positive("across", continuation.across)?;
    let affine = continuation.along_start == continuation.along_end;
    let (n, degree) = (a.degree(), b.degree());
    if degree != n + 1 && !(affine && degree == n) {
        let expected = if affine { n } else { n + 1 };
        return Err(SurfaceError::CountMismatch {
            parameter: "degrees of the neighbouring patch",
            count: degree,
            expected,
        });
    }
    let border = a.edge(edge_a);
    // Control points of the derivatives over n, both of degree n - 1.
    let inward = border.iter().zip(a.edge_row(edge_a, 1)).map(|(start, p)| p - *start);
    let along = border.windows(2).map(|p| p[1] - p[0]);
    let (start, end) = (continuation.along_start, continuation.along_end);
    let (edge, row): (Vec<DVec4>, Vec<DVec4>) = if degree == n {
        let row = inward.zip(along).zip(&border).map(|((d, t), p)| *p - d * continuation.across + t * start);
        (border.clone(), row.collect())
    } else {
        let elevated = elevate(&border);
        let inward = elevate(&inward.collect::<Vec<_>>());
        let along = times_linear(&along.collect::<Vec<_>>(), start, end);
        let scale = n as f64 / degree as f64;
        let row = inward.iter().zip(along).zip(&elevated);
        let row = row.map(|((d, t), p)| *p + (t - *d * continuation.across) * scale).collect();
        (elevated, row)
    };
    let mut points = b.control_points().to_vec();
    for (number, source) in [edge, row].iter().enumerate() {
        for (e, point) in edge_row_indices(degree, edge_b, number).zip(source.iter().rev()) {
            points[e] = *point;
        }
    }
    TrianglePatch::try_new(degree, points)
}

/// Control points of the curve `(start (1 - e) + end e) c(e)`, one degree above the curve c.
fn times_linear(points: &[DVec4], start: f64, end: f64) -> Vec<DVec4> {
    let count = points.len();
    let point = |i: Option<usize>| i.and_then(|i| points.get(i)).copied().unwrap_or(DVec4::ZERO);
    (0..=count)
        .map(|j| {
            let (here, before) = (point(Some(j)), point(j.checked_sub(1)));
            (here * (start * (count - j) as f64) + before * (end * j as f64)) / count as f64
        })
        .collect()
}

/// A point of a border with two derivatives.
#[derive(Clone, Copy)]
struct BorderPoint {
    point: DVec3,
    along: DVec3,
    inward: DVec3,
}

impl BorderPoint {
    /// The unit tangent into the patch, at right angles to the border.
    fn conormal(&self) -> Option<DVec3> {
        let along = self.along.try_normalize()?;
        (self.inward - along * along.dot(self.inward)).try_normalize()
    }
}

/// Corresponding points of two borders, in the direction of `a`.
fn point_pairs<'a>(
    a: PatchBorder<'a>,
    b: PatchBorder<'a>,
    samples: usize,
) -> impl Iterator<Item = (BorderPoint, BorderPoint)> + use<'a> {
    let samples = samples.max(2);
    let gap = |e: f64, reversed: bool| a.at(e, false).point.distance(b.at(e, reversed).point);
    let reversed = gap(0.0, true) + gap(1.0, true) <= gap(0.0, false) + gap(1.0, false);
    (0..samples).map(move |i| {
        let e = i as f64 / (samples - 1) as f64;
        (a.at(e, false), b.at(e, reversed))
    })
}

impl PatchBorder<'_> {
    /// The point at `e` from 0 to 1 along the border, in the opposite direction if `reversed`.
    fn at(&self, e: f64, reversed: bool) -> BorderPoint {
        let (mut start, mut end, opposite) = match self {
            Self::Triangle(_, edge) => {
                let (a, b, c) = (DVec2::ZERO, DVec2::X, DVec2::Y);
                match edge {
                    TriangleEdge::TZero => (a, b, Some(c)),
                    TriangleEdge::RZero => (b, c, Some(a)),
                    TriangleEdge::SZero => (c, a, Some(b)),
                }
            }
            Self::Tensor(_, TensorEdge::VZero) => (DVec2::ZERO, DVec2::X, None),
            Self::Tensor(_, TensorEdge::UOne) => (DVec2::X, DVec2::ONE, None),
            Self::Tensor(_, TensorEdge::VOne) => (DVec2::ONE, DVec2::Y, None),
            Self::Tensor(_, TensorEdge::UZero) => (DVec2::Y, DVec2::ZERO, None),
        };
        // The direction into a square: to the left.
        let left = (end - start).perp();
        if reversed {
            std::mem::swap(&mut start, &mut end);
        }
        let (along, inward) = (end - start, opposite.map_or(left, |corner| corner - start));
        let at = start * (1.0 - e) + end * e;
        let (point, du, dv) = match self {
            Self::Tensor(patch, _) => patch.point_and_tangents(at.x, at.y),
            Self::Triangle(patch, _) => patch.point_and_tangents(at.x, at.y),
        };
        let directed = |d: DVec2| du * d.x + dv * d.y;
        BorderPoint { point, along: directed(along), inward: directed(inward) }
    }
}
