//! Curves in the parameter plane.

use std::f64::consts::FRAC_1_SQRT_2;

use glanz_math::{DVec2, DVec3};

use crate::bezier::bernstein;
use crate::error::{SurfaceError, finite, finite_point, not_negative, positive};

/// Largest degree of a trimming curve.
pub const MAX_DEGREE: usize = bernstein::ROW_DEGREE;

/// A connected, directed curve of rational Bézier pieces in the parameter plane.
///
/// Control points are homogeneous: `(w u, w v, w)` with `w > 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurve {
    /// Control points of the pieces; each piece ends where the next starts.
    pub(super) pieces: Vec<Vec<DVec3>>,
    /// Smallest and largest coordinates of the control points that the curve was made from.
    pub(super) bounds: [DVec2; 2],
    /// `None`: that of the region.
    pub(super) width: Option<f64>,
}

impl TrimCurve {
    fn new(pieces: Vec<Vec<DVec3>>, control_points: &[DVec3]) -> Self {
        let bounds = control_points
            .iter()
            .map(|&p| project(p))
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
        Self { pieces, bounds, width: None }
    }

    /// The straight line from `start` to `end`.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`].
    pub fn try_line(start: DVec2, end: DVec2) -> Result<Self, SurfaceError> {
        Self::try_polyline(&[start, end])
    }

    /// The polyline through these points, at least two.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`], [`SurfaceError::NotFinite`].
    pub fn try_polyline(points: &[DVec2]) -> Result<Self, SurfaceError> {
        if points.len() < 2 {
            return Err(SurfaceError::TooFew {
                parameter: "points of a polyline",
                count: points.len(),
                min: 2,
            });
        }
        for &point in points {
            finite_point("point of a polyline", point)?;
        }
        let points: Vec<DVec3> = points.iter().map(|p| p.extend(1.0)).collect();
        Ok(Self::new(points.windows(2).map(<[DVec3]>::to_vec).collect(), &points))
    }

    /// The closed polygon with these corners, at least three.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`], [`SurfaceError::NotFinite`].
    pub fn try_polygon(corners: &[DVec2]) -> Result<Self, SurfaceError> {
        let (Some(&first), true) = (corners.first(), corners.len() >= 3) else {
            return Err(SurfaceError::TooFew {
                parameter: "corners of a polygon",
                count: corners.len(),
                min: 3,
            });
        };
        let mut points = corners.to_vec();
        points.push(first);
        Self::try_polyline(&points)
    }

    /// The border of the rectangle between two corners, counter-clockwise: it keeps the inside.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::EmptyRange`] unless `min < max` in both coordinates.
    pub fn try_rectangle(min: DVec2, max: DVec2) -> Result<Self, SurfaceError> {
        check_range("rectangle", min, max)?;
        Self::try_polygon(&[min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)])
    }

    /// The full circle, counter-clockwise: it keeps the inside.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`].
    pub fn try_circle(center: DVec2, radius: f64) -> Result<Self, SurfaceError> {
        let radius = positive("radius", radius)?;
        Self::try_ellipse(center, DVec2::new(radius, 0.0), DVec2::new(0.0, radius))
    }

    /// The full ellipse with conjugate half axes `a` and `b`, from `center + a` through `center + b`, exact.
    ///
    /// With `b` to the left of `a` it runs counter-clockwise and keeps the inside, otherwise the outside.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] if the axes span no area.
    ///
    /// # Source
    /// @farin2002 chapter 12: quarters of weights 1, sqrt(1/2), 1.
    pub fn try_ellipse(center: DVec2, a: DVec2, b: DVec2) -> Result<Self, SurfaceError> {
        for point in [center, a, b] {
            finite_point("ellipse coordinate", point)?;
        }
        positive("area between the half axes of an ellipse", a.perp_dot(b).abs())?;
        let directions = [a, b, -a, -b, a];
        let quarter = |ends: &[DVec2]| {
            let [from, to] = [ends[0], ends[1]];
            let corner = (center + from + to) * FRAC_1_SQRT_2;
            vec![(center + from).extend(1.0), corner.extend(FRAC_1_SQRT_2), (center + to).extend(1.0)]
        };
        let quarters: Vec<Vec<DVec3>> = directions.windows(2).map(quarter).collect();
        let control_points = quarters.concat();
        Ok(Self::new(quarters, &control_points))
    }

    /// The rational Bézier curve with homogeneous control points `(w u, w v, w)`, degree + 1 of them.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::NotFinite`], and [`SurfaceError::NotPositive`] for a
    /// weight.
    pub fn try_bezier(control_points: &[DVec3]) -> Result<Self, SurfaceError> {
        let degree = control_points.len().saturating_sub(1);
        check_degree(degree)?;
        check_control_points(control_points)?;
        Ok(Self::new(vec![control_points.to_vec()], control_points))
    }

    /// The NURBS curve with homogeneous control points `(w u, w v, w)` over `[knots[degree], knots[n]]`, where n is the number
    /// of control points.
    ///
    /// `knots`: n + degree + 1 values that do not decrease, clamped or not; an inner knot may be repeated `degree` times.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::TooFew`] control points,
    /// [`SurfaceError::CountMismatch`], [`SurfaceError::KnotsDecrease`], [`SurfaceError::KnotMultiplicity`] or
    /// [`SurfaceError::EmptyRange`] for the knots, [`SurfaceError::NotFinite`], and [`SurfaceError::NotPositive`] for a
    /// weight.
    ///
    /// # Source
    /// @farin2002 chapter 8: the control points of a Bézier piece are the curve's polar form at the ends of its
    /// knot interval.
    pub fn try_nurbs(degree: usize, knots: &[f64], control_points: &[DVec3]) -> Result<Self, SurfaceError> {
        let count = control_points.len();
        check_knots(degree, knots, count)?;
        check_control_points(control_points)?;
        let mut pieces: Vec<Vec<DVec3>> = Vec::new();
        for span in degree..count {
            let (low, high) = (knots[span], knots[span + 1]);
            if low >= high {
                continue;
            }
            let mut piece: Vec<DVec3> =
                (0..=degree).map(|j| polar_form(degree, knots, control_points, span, j)).collect();
            // The same point computed twice: rounding must not open a gap.
            if let (Some(last), Some(first)) = (pieces.last().and_then(|p| p.last()), piece.first_mut()) {
                *first = *last;
            }
            pieces.push(piece);
        }
        Ok(Self::new(pieces, control_points))
    }

    /// The same curve in the opposite direction.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.pieces.reverse();
        for piece in &mut self.pieces {
            piece.reverse();
        }
        self
    }

    /// The same curve with a border: regions keep the points within `width` of it, on either side.
    ///
    /// `width`: in the coordinates of the region, see [`RegionSettings::scale`](super::RegionSettings::scale).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::Negative`].
    pub fn with_width(self, width: f64) -> Result<Self, SurfaceError> {
        Ok(Self { width: Some(not_negative("width of a trimming curve", width)?), ..self })
    }

    /// The curve with both coordinates multiplied.
    pub(super) fn scaled(mut self, scale: DVec2) -> Self {
        let scale3 = scale.extend(1.0);
        self.pieces.iter_mut().flatten().for_each(|point| *point *= scale3);
        Self { bounds: self.bounds.map(|corner| corner * scale), ..self }
    }

    /// Start point.
    #[must_use]
    pub fn start(&self) -> DVec2 {
        self.pieces.first().and_then(|p| p.first()).map_or(DVec2::ZERO, |&p| project(p))
    }

    /// End point.
    #[must_use]
    pub fn end(&self) -> DVec2 {
        self.pieces.last().and_then(|p| p.last()).map_or(DVec2::ZERO, |&p| project(p))
    }

    /// Number of rational Bézier pieces.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        self.pieces.len()
    }

    /// The point at parameter `t` in [0, 1] of the Bézier piece number `piece`; `None` beyond the last piece.
    #[must_use]
    pub fn point(&self, piece: usize, t: f64) -> Option<DVec2> {
        self.pieces.get(piece).map(|points| evaluate(points, t))
    }

    /// Moves the first control point to `start` and the last one to `end`.
    pub(super) fn move_ends(&mut self, start: DVec2, end: DVec2) {
        if let Some(first) = self.pieces.first_mut().and_then(|p| p.first_mut()) {
            *first = (start * first.z).extend(first.z);
        }
        if let Some(last) = self.pieces.last_mut().and_then(|p| p.last_mut()) {
            *last = (end * last.z).extend(last.z);
        }
    }
}

/// The point with the homogeneous coordinates `point`.
pub(super) fn project(point: DVec3) -> DVec2 {
    point.truncate() / point.z
}

/// The point at `t` of a rational Bézier curve.
pub(super) fn evaluate(points: &[DVec3], t: f64) -> DVec2 {
    evaluate_in(&mut points.to_vec(), t)
}

/// The point at `t` of the rational Bézier curve with the control points `row`, which are overwritten.
///
/// # Source
/// @farin2002 section 4.3 (de Casteljau).
pub(super) fn evaluate_in(row: &mut [DVec3], t: f64) -> DVec2 {
    for left in (1..row.len()).rev() {
        for i in 0..left {
            row[i] = bernstein::mix(row[i], row[i + 1], t);
        }
    }
    row.first().map_or(DVec2::ZERO, |&p| project(p))
}

pub(super) fn check_range(parameter: &'static str, min: DVec2, max: DVec2) -> Result<(), SurfaceError> {
    finite_point(parameter, min)?;
    finite_point(parameter, max)?;
    for (min, max) in [(min.x, max.x), (min.y, max.y)] {
        // A domain whose width overflows cannot be divided into cells.
        finite(parameter, max - min)?;
        if min >= max {
            return Err(SurfaceError::EmptyRange { parameter, min, max });
        }
    }
    Ok(())
}

fn check_control_points(points: &[DVec3]) -> Result<(), SurfaceError> {
    for point in points {
        positive("weight of a trimming curve", point.z)?;
        finite_point("control point of a trimming curve", point.truncate())?;
        finite_point("control point of a trimming curve", project(*point))?;
    }
    Ok(())
}

fn check_degree(degree: usize) -> Result<(), SurfaceError> {
    if degree == 0 || degree > MAX_DEGREE {
        let (value, max) = (degree as f64, MAX_DEGREE as f64);
        return Err(SurfaceError::OutOfRange {
            parameter: "degree of a trimming curve",
            value,
            min: 1.0,
            max,
        });
    }
    Ok(())
}

fn check_knots(degree: usize, knots: &[f64], points: usize) -> Result<(), SurfaceError> {
    check_degree(degree)?;
    if points <= degree {
        return Err(SurfaceError::TooFew { parameter: "control points", count: points, min: degree + 1 });
    }
    let expected = points + degree + 1;
    if knots.len() != expected {
        return Err(SurfaceError::CountMismatch { parameter: "knots", count: knots.len(), expected });
    }
    for &knot in knots {
        finite("knot", knot)?;
    }
    if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
        let (previous, value) = (knots[i], knots[i + 1]);
        return Err(SurfaceError::KnotsDecrease { parameter: "knot", position: i + 1, value, previous });
    }
    let (min, max) = (knots[degree], knots[points]);
    finite("knot range", max - min)?;
    if min >= max {
        return Err(SurfaceError::EmptyRange { parameter: "knot range", min, max });
    }
    for equal in knots.chunk_by(|a, b| a == b) {
        if equal.len() > degree && equal[0] > min && equal[0] < max {
            let (value, multiplicity, max) = (equal[0], equal.len(), degree);
            return Err(SurfaceError::KnotMultiplicity { parameter: "knot", value, multiplicity, max });
        }
    }
    Ok(())
}

/// Control point `j` of the Bézier piece over `[knots[span], knots[span + 1]]`: the polar form at `degree - j` times the
/// lower and `j` times the upper knot, by convex combinations only.
fn polar_form(degree: usize, knots: &[f64], points: &[DVec3], span: usize, j: usize) -> DVec3 {
    let mut d: Vec<DVec3> = points[span - degree..=span].to_vec();
    for round in 1..=degree {
        let knot = if round > j { knots[span] } else { knots[span + 1] };
        for i in (round..=degree).rev() {
            let (low, high) = (knots[span - degree + i], knots[span + 1 + i - round]);
            let share = (knot - low) / (high - low);
            d[i] = bernstein::mix(d[i - 1], d[i], share);
        }
    }
    d[degree]
}
