//! The curve of an edge, from its start to its end.

use glanz_math::DVec3;

use crate::error::BrepError;
use crate::model::{Curve, Edge, SplineCurve};

/// The part of a curve that runs from the start of an edge to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeCurve {
    curve: Curve<DVec3>,
    range: [f64; 2],
    vertices: [DVec3; 2],
    sense_repaired: bool,
}

impl EdgeCurve {
    /// The curve of an edge of a model with these `vertices` (metres). Its ends are the points of the curve nearest to the vertices
    /// of the edge. A closed curve, whose ends are at most `tolerance` (metres) apart, is passed over its seam where the sense
    /// of the edge demands it. The sense of the edge is ignored where it contradicts the order of the vertices on an open curve.
    ///
    /// # Errors
    /// [`BrepError::ShortEdge`] if both ends are one point and the edge is not closed, or if it is straight and closed;
    /// [`BrepError::OpenCurve`] if the edge is closed and its curve is not.
    pub fn try_new(edge: &Edge, vertices: &[DVec3], tolerance: f64) -> Result<Self, BrepError> {
        let vertex = |index: usize| vertices.get(index).copied().unwrap_or(DVec3::NAN);
        let ends = [vertex(edge.start), vertex(edge.end)];
        match &edge.curve {
            Some(curve) => Self::between(curve, ends, edge.start == edge.end, edge.same_sense, tolerance),
            None => Self::straight(ends),
        }
    }

    /// The straight line between two points, metres.
    ///
    /// # Errors
    /// [`BrepError::ShortEdge`] if the points coincide.
    pub fn straight([start, end]: [DVec3; 2]) -> Result<Self, BrepError> {
        let direction = end - start;
        if direction == DVec3::ZERO || !direction.is_finite() {
            return Err(BrepError::ShortEdge { point: start.to_array() });
        }
        let curve = Curve::Line { origin: start, direction };
        Ok(Self { curve, range: [0.0, 1.0], vertices: [start, end], sense_repaired: false })
    }

    /// The part of a curve between its points nearest to two vertices, which are the same one if it is `closed`.
    ///
    /// # Errors
    /// Those of [`Self::try_new`].
    pub fn between(
        curve: &Curve<DVec3>,
        vertices: [DVec3; 2],
        closed: bool,
        same_sense: bool,
        tolerance: f64,
    ) -> Result<Self, BrepError> {
        if let Curve::Trimmed { basis, same_sense: inner, .. } = curve {
            // The vertices trim it again; the whole curve has room for those that lie a little outside.
            return Self::between(basis, vertices, closed, same_sense == *inner, tolerance);
        }
        let period = curve.period(tolerance);
        let found = vertices.map(|vertex| curve.closest_parameter(vertex, None));
        let short = BrepError::ShortEdge { point: vertices[0].to_array() };
        let part = |range, sense_repaired| Ok(Self { curve: curve.clone(), range, vertices, sense_repaired });
        let sign = if same_sense { 1.0 } else { -1.0 };
        let Some(period) = period else {
            if closed {
                let gap = curve.domain().map(|t| curve.point(t));
                return Err(BrepError::OpenCurve { gap: gap[0].distance(gap[1]), tolerance });
            }
            let ordered = (found[1] - found[0]) * sign > 0.0;
            return if found[0] == found[1] { Err(short) } else { part(found, !ordered) };
        };
        let from = start_before_seam(curve, found[0], vertices[0], same_sense, tolerance);
        if closed {
            return part([from, from + sign * period], false);
        }
        let forward = (sign * (found[1] - from)).rem_euclid(period);
        // The remainder of a tiny negative number is the whole period.
        let forward = if forward < period { forward } else { 0.0 };
        // Vertices that (nearly) coincide bound a short edge, which noise may have turned around, not a whole turn.
        let backward = period - forward;
        let chord = vertices[0].distance(vertices[1]);
        if forward > backward && chord <= tolerance && chord > 0.0 {
            let shorter = curve.point(from - sign * 0.5 * backward).distance(vertices[0]) <= tolerance;
            if shorter && backward > 0.0 {
                return part([from, from - sign * backward], true);
            }
        }
        if forward == 0.0 {
            return Err(short);
        }
        part([from, from + sign * forward], false)
    }

    /// The whole curve of which it is a part.
    #[must_use]
    pub fn curve(&self) -> &Curve<DVec3> {
        &self.curve
    }

    /// Parameters of the curve at the start and at the end; they descend where the edge runs against the curve.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Its vertices, metres.
    #[must_use]
    pub fn vertices(&self) -> [DVec3; 2] {
        self.vertices
    }

    /// Whether the edge runs along the curve against the sense that the model gives.
    #[must_use]
    pub fn sense_repaired(&self) -> bool {
        self.sense_repaired
    }

    /// Whether it ends where it starts.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.vertices[0] == self.vertices[1]
    }

    /// The point at a fraction from 0 (start) to 1 (end) of its range of parameters, metres.
    #[must_use]
    pub fn point(&self, fraction: f64) -> DVec3 {
        self.curve.point(self.parameter(fraction))
    }

    /// The parameter of the curve at a fraction of the range.
    #[must_use]
    pub fn parameter(&self, fraction: f64) -> f64 {
        let [from, to] = self.range;
        // Exact at both ends.
        if fraction > 0.5 { to + (from - to) * (1.0 - fraction) } else { from + (to - from) * fraction }
    }

    /// The fraction at which it is nearest to a point (metres).
    #[must_use]
    pub fn nearest_fraction(&self, point: DVec3) -> f64 {
        let [from, to] = self.range;
        let t = self.curve.closest_in(point, [from.min(to), from.max(to)]);
        ((t - from) / (to - from)).clamp(0.0, 1.0)
    }

    /// The larger distance of an end of the curve from its vertex, metres.
    #[must_use]
    pub fn vertex_gap(&self) -> f64 {
        self.point(0.0).distance(self.vertices[0]).max(self.point(1.0).distance(self.vertices[1]))
    }

    /// The parts between the ends and the parameters of the curve in `cuts`, which lie inside and in the order of the edge.
    #[must_use]
    pub fn split(&self, cuts: &[f64]) -> Vec<Self> {
        let [from, to] = self.range;
        let ends: Vec<f64> = [from].iter().chain(cuts).chain(&[to]).copied().collect();
        let vertex = |t: f64| {
            let [start, end] = self.vertices;
            if t == from {
                start
            } else if t == to {
                end
            } else {
                self.curve.point(t)
            }
        };
        let part = |pair: &[f64]| {
            let range = [pair[0], pair[1]];
            Self { range, vertices: range.map(vertex), ..self.clone() }
        };
        ends.windows(2).map(part).collect()
    }

    /// Its exact rational form, from start to end.
    ///
    /// # Errors
    /// Those of [`Curve::to_spline`].
    pub fn to_spline(&self) -> Result<SplineCurve<DVec3>, BrepError> {
        self.curve.to_spline(self.range)
    }
}

/// The parameter at the start of an edge on a closed curve, with the seam at that end of the domain from which the edge can continue.
fn start_before_seam(curve: &Curve<DVec3>, t: f64, vertex: DVec3, same_sense: bool, tolerance: f64) -> f64 {
    let [start, end] = curve.domain();
    let seam = if same_sense { start } else { end };
    let other = if same_sense { end } else { start };
    // Within the tolerance of the seam and nearer to its other side.
    let at_seam = curve.point(other).distance(vertex) <= tolerance && (t - other).abs() < (t - seam).abs();
    let leaves = curve.point(0.5 * (t + other)).distance(vertex) <= tolerance;
    if t == other || (at_seam && leaves) { seam } else { t }
}
