//! Curves, in space or in the parameters of surfaces.

use std::f64::consts::TAU;

use glanz_brep::model::{Curve, SplineCurve};
use glanz_geometry::spline::MAX_DEGREE;
use glanz_math::{DMat4, DVec3, DVec4};

use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use crate::cad::{Refusal, spline_curve};

/// A curve of an entity, as a segment of a composite one.
pub(super) struct CurveSegment {
    pub(super) curve: Curve<DVec3>,
    pub(super) entity: glanz_brep::model::EntityId,
}

impl IgesReader<'_> {
    /// A curve of any kind; `outer`: the map from its coordinates, after its own transformation, to those of the model.
    pub(super) fn curve(
        &mut self,
        entity: IgesEntity<'_>,
        outer: DMat4,
        depth: usize,
    ) -> Result<Curve<DVec3>, Refusal> {
        let mut segments = self.segments(entity, outer, depth)?;
        match (segments.len(), segments.pop()) {
            (1, Some(only)) if entity.kind() != 102 => Ok(only.curve),
            (_, Some(last)) => {
                let first = segments.into_iter().chain([last]);
                Ok(Curve::Composite(first.map(|segment| (segment.curve, true)).collect()))
            }
            (_, None) => Err(entity.refuse("the curve has no segments")),
        }
    }

    /// The segments of a composite curve, also of those in it; one of other curves.
    pub(super) fn segments(
        &mut self,
        entity: IgesEntity<'_>,
        outer: DMat4,
        depth: usize,
    ) -> Result<Vec<CurveSegment>, Refusal> {
        let depth = depth
            .checked_sub(1)
            .ok_or_else(|| entity.refuse(format!("curves are nested deeper than {MAX_DEPTH} levels")))?;
        self.spend(entity)?;
        let matrix = outer * entity.matrix()?;
        if entity.kind() != 102 {
            let curve = self.simple_curve(entity)?;
            let image = curve.mapped(|v| matrix.transform_vector3(v), matrix.w_axis.truncate());
            let curve = image.filter(is_finite).ok_or_else(|| entity.refuse("the curve is not finite"))?;
            return Ok(vec![CurveSegment { curve, entity: entity.id() }]);
        }
        let mut segments = Vec::new();
        for i in 0..entity.list_length(1, 2, 1)? {
            let child = entity.reference(2 + i)?;
            // Points mark the joints.
            if !matches!(child.kind(), 116 | 132) {
                segments.extend(self.segments(child, matrix, depth)?);
            }
        }
        Ok(segments)
    }

    /// A curve in its own coordinates.
    fn simple_curve(&mut self, entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
        match entity.kind() {
            100 => arc(entity),
            104 => super::conic::conic(entity),
            106 => polyline(entity),
            110 if entity.form() == 0 => line(entity),
            112 => parametric_spline(entity),
            126 => rational_spline(entity),
            _ => Err(entity.refuse_kind("curve")),
        }
    }
}

/// Whether the ends of a curve are finite.
fn is_finite(curve: &Curve<DVec3>) -> bool {
    curve.domain().iter().all(|t| t.is_finite() && curve.point(*t).is_finite())
}

/// The part of a curve between two of its parameters.
pub(super) fn part(basis: Curve<DVec3>, range: [f64; 2]) -> Curve<DVec3> {
    Curve::Trimmed { basis: Box::new(basis), range, same_sense: true }
}

/// Counterclockwise from the first to the second point around the centre; parameters are angles from the x axis, from 0 to a turn at
/// the start.
fn arc(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let [z, cx, cy, x1, y1, x2, y2] = entity.numbers(1)?;
    let radius = (x1 - cx).hypot(y1 - cy);
    if radius <= 0.0 {
        return Err(entity.refuse("the radius of the arc is 0"));
    }
    let angle = |x: f64, y: f64| (y - cy).atan2(x - cx).rem_euclid(TAU);
    let start = angle(x1, y1);
    let sweep = if x1 == x2 && y1 == y2 { TAU } else { (angle(x2, y2) - start).rem_euclid(TAU) };
    // Ends that coincide up to rounding are those of a whole circle.
    let sweep = if sweep <= f64::EPSILON.sqrt() { TAU } else { sweep };
    let circle = Curve::Ellipse { center: DVec3::new(cx, cy, z), a: DVec3::X * radius, b: DVec3::Y * radius };
    Ok(part(circle, [start, start + sweep]))
}

/// Straight between two points, with parameters from 0 to 1.
fn line(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let [x1, y1, z1, x2, y2, z2] = entity.numbers(1)?;
    let origin = DVec3::new(x1, y1, z1);
    let direction = DVec3::new(x2, y2, z2) - origin;
    if direction == DVec3::ZERO {
        // A degenerate side, as in a pole.
        return Ok(Curve::Polyline(vec![origin; 2]));
    }
    Ok(part(Curve::Line { origin, direction }, [0.0, 1.0]))
}

/// The points of copious data.
fn polyline(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let (size, first) = match entity.form() {
        11 | 63 => (2, 4),
        12 => (3, 3),
        13 => (6, 3),
        _ => return Err(entity.refuse_kind("curve")),
    };
    let count = entity.list_length(2, first, size)?;
    let level = if size == 2 { entity.number(3)? } else { 0.0 };
    let mut points = Vec::with_capacity(count);
    for i in 0..count {
        let [x, y] = entity.numbers(first + size * i)?;
        let z = if size == 2 { level } else { entity.number(first + size * i + 2)? };
        points.push(DVec3::new(x, y, z));
    }
    points.dedup();
    if points.len() < 2 {
        Err(entity.refuse("there are fewer than 2 points"))
    } else {
        Ok(Curve::Polyline(points))
    }
}

/// Cubic polynomials between breakpoints.
fn parametric_spline(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let count = entity.count(4)?;
    // N + 1 breakpoints and 12 coefficients per segment.
    if count == 0 || entity.len() < 5 + 13 * count {
        return Err(entity.refuse(format!("there are too few coefficients for {count} segments")));
    }
    let mut knots = Vec::with_capacity(3 * count + 5);
    let mut points: Vec<DVec4> = Vec::with_capacity(3 * count + 1);
    for i in 0..count {
        let [start, end] = entity.numbers(5 + i)?;
        let width = end - start;
        let c: [f64; 12] = entity.numbers(6 + count + 12 * i)?;
        let column = |k: usize| DVec3::new(c[k], c[4 + k], c[8 + k]);
        let [a, b, c, d] =
            [column(0), column(1) * width, column(2) * (width * width), column(3) * (width * width * width)];
        let bezier = [a, a + b / 3.0, a + (b * 2.0 + c) / 3.0, a + b + c + d];
        let skipped = usize::from(i > 0);
        if i == 0 {
            knots.push(start);
        }
        knots.extend([start; 3]);
        points.extend(bezier.into_iter().skip(skipped).map(|point| point.extend(1.0)));
        if i + 1 == count {
            knots.extend([end; 4]);
        }
    }
    let spline = spline_curve::<DVec3>(3, knots, points).map_err(|reason| entity.refuse(reason))?;
    Ok(Curve::Spline(spline))
}

/// Degree, knots and range of one parameter of a spline.
pub(super) fn check_degree(entity: IgesEntity<'_>, i: usize) -> Result<usize, Refusal> {
    let degree = entity.count(i)?;
    if (1..=MAX_DEGREE).contains(&degree) {
        Ok(degree)
    } else {
        Err(entity.refuse(format!("the degree is {degree}; it must be from 1 to {MAX_DEGREE}")))
    }
}

/// `K, M, PROP1-4, knots, weights, points, V0, V1`.
fn rational_spline(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let (count, degree) = (entity.count(1)? + 1, check_degree(entity, 2)?);
    let (knots_at, weights_at) = (7, 7 + count + degree + 1);
    let points_at = weights_at + count;
    if count <= degree || entity.len() + 1 < points_at + 3 * count {
        return Err(entity.refuse(format!("there are too few parameters for {count} control points")));
    }
    let knots = (knots_at..weights_at).map(|i| entity.number(i)).collect::<Result<Vec<f64>, _>>()?;
    let mut points = Vec::with_capacity(count);
    for i in 0..count {
        let (weight, [x, y, z]) = (entity.number(weights_at + i)?, entity.numbers(points_at + 3 * i)?);
        points.push((DVec3::new(x, y, z) * weight).extend(weight));
    }
    let spline: SplineCurve<DVec3> =
        spline_curve(degree, knots, points).map_err(|reason| entity.refuse(reason))?;
    let domain = spline.domain();
    let ends_at = points_at + 3 * count;
    let curve = Curve::Spline(spline);
    if entity.len() < ends_at + 1 {
        return Ok(curve);
    }
    let [from, to]: [f64; 2] = entity.numbers(ends_at)?;
    let slack = f64::EPSILON.sqrt() * (domain[1] - domain[0]);
    let is_part =
        (from > domain[0] + slack && from < domain[1]) || (to < domain[1] - slack && to > domain[0]);
    if is_part && from < to {
        return Ok(part(curve, [from.max(domain[0]), to.min(domain[1])]));
    }
    Ok(curve)
}
