//! Polylines along edges, with a certified deviation.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::edge::EdgeCurve;
use crate::error::BrepError;
use crate::model::CurveVector;
use crate::parameter_curve::largest;
use crate::quadrature::{MAX_DEPTH, gauss, refined};

/// Halvings of a Bézier piece of an edge, at most.
const MAX_HALVINGS: u32 = 12;

/// Accuracy of arc lengths, relative to that of the part of the curve along a segment.
const LENGTH_ACCURACY: f64 = 1e-11;

/// Straight segments along an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgePolyline {
    /// The vertex at its start, points of the curve, the vertex at its end, metres.
    pub points: Vec<DVec3>,
    /// Bound on the distance between curve and segments, metres: each point of one has a point of the other within it. Along a segment the
    /// curve may go back and forth.
    pub deviation: f64,
    /// Arc length of the curve, metres, to about 10 digits where the curve is smooth.
    pub length: f64,
}

impl EdgeCurve {
    /// Segments that stay within `tolerance` (metres, > 0) of the curve, apart from the distance of its ends from the vertices.
    ///
    /// The pieces of the exact rational form are halved until their control points, in whose convex hull the curve lies, are that close to
    /// their chord. The deviation is larger than the tolerance where a dozen halvings do not suffice.
    ///
    /// # Errors
    /// Those of [`Self::to_spline`].
    pub fn polyline(&self, tolerance: f64) -> Result<EdgePolyline, BrepError> {
        let spline = self.to_spline()?;
        let (breaks, controls) =
            glanz_geometry::spline::polygon::bezier(spline.knots(), spline.control_points())?;
        let [start, end] = self.vertices();
        let mut polyline = EdgePolyline { points: vec![start], deviation: 0.0, length: 0.0 };
        let degree = spline.degree();
        for piece in 0..breaks.len().saturating_sub(1) {
            if let Some(piece) = controls.get(degree * piece..=degree * (piece + 1)) {
                polyline.append(piece, tolerance, MAX_HALVINGS);
            }
        }
        // The vertex takes the place of the end of the curve.
        polyline.points.pop();
        polyline.points.push(end);
        // Between its ends, a segment moves by at most as much as the end that moves more.
        polyline.deviation += self.vertex_gap();
        Ok(polyline)
    }
}

impl EdgePolyline {
    /// Adds the points of a Bézier piece after its first.
    fn append(&mut self, controls: &[DVec4], tolerance: f64, halvings: u32) {
        let (Some(&first), Some(&last)) = (controls.first(), controls.last()) else { return };
        let [start, end] = [first, last].map(DVec3::project);
        let inner = controls.iter().map(|&point| distance_to_segment(DVec3::project(point), [start, end]));
        let deviation = largest(inner);
        // Halving does not help numbers that are too large.
        if halvings == 0 || deviation <= tolerance || !deviation.is_finite() {
            self.points.push(end);
            self.deviation = largest([self.deviation, deviation]);
            // All halvings together are as deep as those of one length, so that no curve takes long.
            self.length += arc_length(controls, MAX_DEPTH.saturating_sub(MAX_HALVINGS - halvings));
            return;
        }
        let [before, after] = halves(controls);
        self.append(&before, tolerance, halvings - 1);
        self.append(&after, tolerance, halvings - 1);
    }
}

fn distance_to_segment(point: DVec3, [start, end]: [DVec3; 2]) -> f64 {
    let direction = end - start;
    let length2 = direction.length_squared();
    let t = if length2 > 0.0 { ((point - start).dot(direction) / length2).clamp(0.0, 1.0) } else { 0.0 };
    point.distance(start + t * direction)
}

/// Both halves of a Bézier curve.
///
/// # Source
/// @farin2002 section 4.
fn halves(controls: &[DVec4]) -> [Vec<DVec4>; 2] {
    let mut row = controls.to_vec();
    let mut after: Vec<DVec4> = Vec::with_capacity(row.len());
    let mut before = Vec::with_capacity(row.len());
    while let (Some(&first), Some(&last)) = (row.first(), row.last()) {
        before.push(first);
        after.push(last);
        row = row.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    }
    after.reverse();
    [before, after]
}

/// Arc length of a Bézier curve, by rules over parts that are halved at most `depth` times.
fn arc_length(controls: &[DVec4], depth: u32) -> f64 {
    let rule = |range: [f64; 2]| gauss(range, |t| speed(controls, t));
    let whole = rule([0.0, 1.0]);
    refined(&rule, [0.0, 1.0], whole, LENGTH_ACCURACY * whole, depth)
}

/// Length of the derivative of a Bézier curve over [0, 1].
fn speed(controls: &[DVec4], t: f64) -> f64 {
    let degree = controls.len().saturating_sub(1) as f64;
    let mut row = controls.to_vec();
    while row.len() > 2 {
        row = row.windows(2).map(|pair| pair[0] + t * (pair[1] - pair[0])).collect();
    }
    let [a, b] = row[..] else { return 0.0 };
    let (point, derivative) = (a + t * (b - a), degree * (b - a));
    (derivative.truncate() - point.truncate() / point.w * derivative.w).length() / point.w
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use super::*;
    use crate::model::{Curve, SplineCurve};

    fn circle(radius: f64) -> Curve<DVec3> {
        Curve::Ellipse { center: DVec3::Z, a: DVec3::X * radius, b: DVec3::Y * radius }
    }

    fn edge(curve: &Curve<DVec3>, range: [f64; 2]) -> EdgeCurve {
        let [start, end] = range.map(|t| curve.point(t));
        let closed = start.distance(end) < 1e-9;
        EdgeCurve::between(curve, [start, if closed { start } else { end }], closed, true, 1e-9).unwrap()
    }

    /// The slow twin: the largest distance of many points of the curve from the segments.
    fn measured(edge: &EdgeCurve, polyline: &EdgePolyline) -> f64 {
        let nearest = |p: DVec3| {
            let sides = polyline.points.windows(2);
            sides.map(|side| distance_to_segment(p, [side[0], side[1]])).fold(f64::INFINITY, f64::min)
        };
        (0..=5000).map(|i| nearest(edge.point(f64::from(i) / 5000.0))).fold(0.0, f64::max)
    }

    #[test]
    fn a_straight_edge_is_one_segment() {
        let straight = EdgeCurve::straight([DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0)]).unwrap();
        let polyline = straight.polyline(1e-6).unwrap();
        assert_eq!(polyline.points, [DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0)]);
        assert!(polyline.deviation < 1e-15 && (polyline.length - 5.0).abs() < 1e-14);
    }

    #[test]
    fn segments_of_a_circle_have_its_length_and_no_more_points_than_needed() {
        for tolerance in [1e-1, 1e-3, 1e-5] {
            let edge = edge(&circle(2.0), [0.0, TAU]);
            let polyline = edge.polyline(tolerance).unwrap();
            assert!((polyline.length - 2.0 * TAU).abs() < 1e-9, "{}", polyline.length);
            assert!(polyline.deviation <= tolerance);
            // A chord over the angle h is r (1 - cos(h / 2)) off; the hull doubles that, and halving may again fourfold it.
            let needed = PI / (1.0 - 0.5 * tolerance).acos();
            let count = polyline.points.len() - 1;
            assert!(count as f64 >= needed && count as f64 <= 3.0 * needed.max(4.0), "{count} {needed}");
            assert_eq!(polyline.points.first(), polyline.points.last());
        }
    }

    #[test]
    fn the_deviation_bounds_that_of_all_points() {
        let [x, y, z] = DVec3::AXES;
        let controls = [(0.0, 0.0, 1.0), (1.0, 2.0, 3.0), (3.0, -1.0, 0.4), (4.0, 1.0, 1.0), (5.0, 0.5, 1.5)];
        let controls = controls.map(|(u, v, w)| (u * x + v * y + u * v * z).extend(1.0) * w).to_vec();
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.7, 1.0, 1.0, 1.0, 1.0];
        let spline = Curve::Spline(SplineCurve::try_new(3, knots, controls).unwrap());
        let parabola = Curve::Parabola { apex: z, a: x, b: y };
        let hyperbola = Curve::Hyperbola { center: z, a: x, b: 0.5 * y };
        let ellipse = Curve::Ellipse { center: z, a: 3.0 * x, b: 0.2 * y };
        let corner = Curve::Polyline(vec![DVec3::ZERO, x, x + y]);
        let cases = [
            (spline, [0.0, 1.0]),
            (parabola, [-2.0, 1.0]),
            (hyperbola, [-1.0, 2.0]),
            (ellipse, [0.3, 4.0]),
            (corner, [0.0, 2.0]),
        ];
        for (curve, range) in cases {
            for tolerance in [0.3, 1e-2, 1e-4] {
                let edge = edge(&curve, range);
                let polyline = edge.polyline(tolerance).unwrap();
                let (found, bound) = (measured(&edge, &polyline), polyline.deviation);
                assert!(found <= bound + 1e-12 && bound <= tolerance + 1e-12, "{found} {bound} {tolerance}");
            }
        }
    }

    #[test]
    fn a_parabola_has_its_length() {
        // y = x^2 / 4 from x = 0 to 2: sqrt 2 + asinh 1.
        let parabola = Curve::Parabola { apex: DVec3::ZERO, a: DVec3::Y, b: DVec3::X };
        let length = edge(&parabola, [0.0, 1.0]).polyline(1e-3).unwrap().length;
        assert!((length - (2f64.sqrt() + 1f64.asinh())).abs() < 1e-10, "{length}");
    }

    #[test]
    fn a_flat_ellipse_has_its_length_however_coarse_the_segments() {
        let flat = Curve::Ellipse { center: DVec3::Z, a: DVec3::X, b: 0.01 * DVec3::Y };
        // 4 E(e^2) with e^2 = 1 - 1e-4.
        let expected = 4.001_098_329_722_652;
        for tolerance in [0.1, 1e-3] {
            let length = edge(&flat, [0.0, TAU]).polyline(tolerance).unwrap().length;
            assert!((length - expected).abs() < 1e-9, "{length}");
        }
    }

    #[test]
    fn vertices_beside_the_curve_are_its_ends_and_count_in_the_deviation() {
        let ends = [DVec3::new(1.001, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];
        let quarter = EdgeCurve::between(&circle(1.0), ends, false, true, 1e-2).unwrap();
        let polyline = quarter.polyline(1e-4).unwrap();
        assert_eq!((polyline.points[0], *polyline.points.last().unwrap()), (ends[0], ends[1]));
        assert!(polyline.deviation >= 1e-3 && polyline.deviation < 1.2e-3);
        assert!((polyline.length - FRAC_PI_2).abs() < 1e-9);
    }
}
