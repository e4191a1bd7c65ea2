//! Curves of a boundary, in region coordinates.

use glanz_math::glam::DMat2;
use glanz_math::{DVec2, DVec3};

use crate::model::SplineCurve;

/// A curve of a boundary: a clamped spline in region coordinates, which are parameters of the carrier times lengths, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryCurve {
    /// Degree, from 1.
    pub degree: usize,
    /// Clamped knots.
    pub knots: Vec<f64>,
    /// Homogeneous control points (w x, w y, w).
    pub points: Vec<DVec3>,
    /// Distance within which points beside the curve belong to the face: on the surface, metres, up to [`chain`](super::chain); in region
    /// coordinates from [`close`](super::close) on.
    pub width: f64,
    /// The edge that it is the image of; `None` for sides that the file does not have: poles, seams, bridged gaps.
    pub edge: Option<usize>,
    /// The fractions of the edge, 0 at its start and 1 at its end, at which the curve starts and ends.
    pub range: [f64; 2],
}

impl BoundaryCurve {
    /// The image of a part of an edge without a width; `range`: the fractions of the edge at which it starts and ends.
    #[must_use]
    pub fn from_spline(curve: &SplineCurve<DVec2>, edge: usize, range: [f64; 2]) -> Self {
        let (knots, points) = (curve.knots(), curve.control_points());
        let (degree, knots) = (knots.degree(), knots.knots().to_vec());
        Self { degree, knots, points: points.to_vec(), width: 0.0, edge: Some(edge), range }
    }

    /// The straight segment between two points.
    #[must_use]
    pub fn line(from: DVec2, to: DVec2) -> Self {
        let points = vec![from.extend(1.0), to.extend(1.0)];
        Self { degree: 1, knots: vec![0.0, 0.0, 1.0, 1.0], points, width: 0.0, edge: None, range: [0.0, 1.0] }
    }

    /// Its first point.
    #[must_use]
    pub fn start(&self) -> DVec2 {
        self.points.first().map_or(DVec2::NAN, |&p| project(p))
    }

    /// Its last point.
    #[must_use]
    pub fn end(&self) -> DVec2 {
        self.points.last().map_or(DVec2::NAN, |&p| project(p))
    }

    /// Whether all its control points are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.points.iter().all(|&p| project(p).is_finite())
    }

    /// Corners of a box around its control points.
    #[must_use]
    pub fn bounds(&self) -> [DVec2; 2] {
        self.points
            .iter()
            .map(|&p| project(p))
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
    }

    /// The same curve from its end to its start.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        let knots = &mut self.knots;
        if let (Some(&first), Some(&last)) = (knots.first(), knots.last()) {
            knots.reverse();
            knots.iter_mut().for_each(|knot| *knot = first + (last - *knot));
        }
        self.points.reverse();
        self.range.reverse();
        self
    }

    /// The curve of the points `matrix p + offset`.
    #[must_use]
    pub fn transformed(&self, matrix: DMat2, offset: DVec2) -> Self {
        let mut moved = self.clone();
        for point in &mut moved.points {
            *point = (matrix * point.truncate() + offset * point.z).extend(point.z);
        }
        moved
    }

    /// The curve of the points `p * lengths`.
    pub(crate) fn scaled(&self, lengths: DVec2) -> Self {
        self.transformed(DMat2::from_diagonal(lengths), DVec2::ZERO)
    }

    /// Points on the curve from its start to its end.
    #[must_use]
    pub fn samples(&self) -> Vec<DVec2> {
        let mut points = vec![self.start()];
        points.extend(polyline(self));
        points
    }

    /// The same curve moved by `offset`.
    #[must_use]
    pub fn translated(&self, offset: DVec2) -> Self {
        if offset == DVec2::ZERO { self.clone() } else { self.transformed(DMat2::IDENTITY, offset) }
    }
}

fn project(point: DVec3) -> DVec2 {
    point.truncate() / point.z
}

/// Points on a closed chain.
pub(super) fn polygon(chain: &[BoundaryCurve]) -> Vec<DVec2> {
    chain.iter().flat_map(polyline).collect()
}

/// The area that a closed chain encloses to about a percent, positive if it runs counter-clockwise.
pub(super) fn signed_area(chain: &[BoundaryCurve]) -> f64 {
    let corners = polygon(chain);
    let Some(&origin) = corners.first() else { return 0.0 };
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * sides.map(|(&a, &b)| (a - origin).perp_dot(b - origin)).sum::<f64>()
}

/// Points of a clamped spline behind its start: some on each span, then its end.
fn polyline(curve: &BoundaryCurve) -> Vec<DVec2> {
    let mut found = Vec::new();
    let samples = if curve.degree > 1 { 4 * curve.degree } else { 1 };
    for [low, high] in curve.spans() {
        let at = |i: usize| low + (high - low) * i as f64 / samples as f64;
        found.extend((1..=samples).map(|i| curve.point_and_derivative(at(i)).0));
    }
    found.pop();
    found.push(curve.end());
    found
}

impl BoundaryCurve {
    /// The ranges between its knots.
    pub(crate) fn spans(&self) -> Vec<[f64; 2]> {
        let knots =
            self.knots.get(self.degree..self.knots.len().saturating_sub(self.degree)).unwrap_or_default();
        knots.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// The point at `t` and its derivative; not a number where knots and points do not match.
    ///
    /// # Source
    /// @piegl1997 section 2.2 (de Boor's algorithm); its last step holds the derivative.
    pub(crate) fn point_and_derivative(&self, t: f64) -> (DVec2, DVec2) {
        self.de_boor(t).unwrap_or((DVec2::NAN, DVec2::NAN))
    }

    fn de_boor(&self, t: f64) -> Option<(DVec2, DVec2)> {
        let p = self.degree;
        let inner = self.knots.get(p + 1..self.points.len())?;
        let span = p + inner.partition_point(|&knot| knot <= t);
        let mut row: Vec<DVec3> = self.points.get(span - p..=span)?.to_vec();
        for level in 1..p {
            for i in (level..=p).rev() {
                let (low, high) = (*self.knots.get(span - p + i)?, *self.knots.get(span + 1 + i - level)?);
                let weight = if high > low { (t - low) / (high - low) } else { 0.0 };
                row[i] = row[i - 1] * (1.0 - weight) + row[i] * weight;
            }
        }
        let (low, high) = (*self.knots.get(span)?, *self.knots.get(span + 1)?);
        let (a, b) = (*row.get(p.checked_sub(1)?)?, *row.get(p)?);
        let slope = (b - a) * (p as f64 / (high - low));
        let point = a + (b - a) * ((t - low) / (high - low));
        let position = project(point);
        Some((position, (slope.truncate() - position * slope.z) / point.z))
    }
}
