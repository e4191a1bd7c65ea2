//! Parts of curves between two points or parameters.

use std::f64::consts::TAU;

use glanz_brep::model::{Curve, CurveVector, SplineCurve};
use glanz_geometry::spline::NurbsCurve;

use super::geometry::{CurveUnits, FileVector, GeometryReader};
use super::part21::{Entity, EntityAttributes, Keyword, Refusal, TapeToken};

/// An end of a trimmed curve, by its point, its parameter, or both.
struct TrimEnd<P> {
    point: Option<P>,
    parameter: Option<f64>,
}

impl GeometryReader {
    /// `TRIMMED_CURVE(name, basis, ends, ends, sense, master)`.
    pub(super) fn trimmed<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        units: CurveUnits,
        depth: usize,
    ) -> Result<Curve<P>, Refusal> {
        let attributes = entity.simple();
        let basis: Curve<P> = self.curve(attributes.reference(1)?, units, depth)?;
        let same_sense = attributes.boolean(4)?;
        let prefers_points = attributes.enumeration(5) == Some(b"CARTESIAN");
        let scale = parameter_scale(&basis, units.angle);
        let mut range = [0.0; 2];
        let mut by_points = true;
        for (end, i) in range.iter_mut().zip([2, 3]) {
            let TrimEnd { point, parameter } = trim_end::<P>(&attributes, i, units)?;
            let by_point = point.filter(|_| prefers_points || parameter.is_none());
            by_points &= by_point.is_some();
            *end = match (by_point, parameter) {
                (Some(point), _) => self.parameter_of(entity, &basis, point)?,
                (None, Some(parameter)) => parameter * scale,
                (None, None) => {
                    return Err(entity.refuse(format!("attribute {} has no point or parameter", i + 1)));
                }
            };
        }
        if by_points && range[0] == range[1] && matches!(basis, Curve::Ellipse { .. }) {
            range[1] += if same_sense { TAU } else { -TAU };
        }
        Ok(Curve::Trimmed { basis: Box::new(basis), range, same_sense })
    }

    /// The parameter of the point of a curve that is nearest to a point.
    fn parameter_of<P: FileVector>(
        &mut self,
        entity: Entity<'_>,
        curve: &Curve<P>,
        point: P,
    ) -> Result<f64, Refusal> {
        let coordinates = |o: &P, a: &P, b: &P| {
            oblique_coordinates(point - *o, *a, *b)
                .ok_or_else(|| entity.refuse("the axes of the conic are parallel"))
        };
        match curve {
            Curve::Line { origin, direction } => {
                Ok((point - *origin).dot(*direction) / direction.dot(*direction))
            }
            Curve::Ellipse { center, a, b } => {
                let [x, y] = coordinates(center, a, b)?;
                Ok(y.atan2(x).rem_euclid(TAU))
            }
            Curve::Parabola { apex, a, b } => Ok(0.5 * coordinates(apex, a, b)?[1]),
            Curve::Hyperbola { center, a, b } => Ok(coordinates(center, a, b)?[1].asinh()),
            Curve::Polyline(points) => Ok(nearest_on_polyline(points, point)),
            Curve::Spline(spline) => nearest_on_spline(spline, point)
                .ok_or_else(|| entity.refuse("the spline cannot be evaluated")),
            Curve::Trimmed { basis, same_sense, .. } => {
                let parameter = self.parameter_of(entity, basis, point)?;
                Ok(if *same_sense { parameter } else { -parameter })
            }
            Curve::Composite(_) => Err(entity.refuse("a composite curve is trimmed by points")),
        }
    }
}

/// The factor from parameters of a file to those of the model: that of angles for circles and ellipses.
pub(super) fn parameter_scale<P: CurveVector>(curve: &Curve<P>, angle: f64) -> f64 {
    match curve {
        Curve::Ellipse { .. } => angle,
        Curve::Trimmed { basis, .. } => parameter_scale(basis, angle),
        _ => 1.0,
    }
}

fn trim_end<P: FileVector>(
    attributes: &EntityAttributes<'_>,
    i: usize,
    units: CurveUnits,
) -> Result<TrimEnd<P>, Refusal> {
    let mut end = TrimEnd { point: None, parameter: None };
    for at in attributes.list(i)? {
        match attributes.token(at) {
            TapeToken::Reference(_) => {
                end.point = Some(GeometryReader::located(attributes.reference_at(at)?, units)?);
            }
            TapeToken::Typed { keyword: Keyword::ParameterValue, .. }
            | TapeToken::Real(_)
            | TapeToken::Integer(_) => {
                end.parameter = attributes.number_at(at);
            }
            _ => return Err(attributes.refuse(format!("attribute {} must have points or parameters", i + 1))),
        }
    }
    Ok(end)
}

/// The x and y for which `x a + y b` is nearest to `v`.
fn oblique_coordinates<P: CurveVector>(v: P, a: P, b: P) -> Option<[f64; 2]> {
    let (aa, ab, bb, va, vb) = (a.dot(a), a.dot(b), b.dot(b), v.dot(a), v.dot(b));
    let determinant = aa * bb - ab * ab;
    let coordinates = [(va * bb - vb * ab) / determinant, (vb * aa - va * ab) / determinant];
    coordinates.iter().all(|c| c.is_finite()).then_some(coordinates)
}

fn nearest_on_polyline<P: CurveVector>(points: &[P], point: P) -> f64 {
    let mut nearest = (f64::INFINITY, 0.0);
    for (i, pair) in points.windows(2).enumerate() {
        let &[a, b] = pair else { continue };
        let along = (point - a).dot(b - a) / (b - a).dot(b - a);
        let t = if along.is_nan() { 0.0 } else { along.clamp(0.0, 1.0) };
        let distance = point.distance_to(a + (b - a) * t);
        if distance < nearest.0 {
            nearest = (distance, i as f64 + t);
        }
    }
    nearest.1
}

/// Points tested per span of a spline and per degree, before Newton's method.
const SAMPLES_PER_DEGREE: usize = 4;

/// Newton steps; from a sample nearby, four are enough.
const NEWTON_STEPS: usize = 16;

fn nearest_on_spline<P: FileVector>(spline: &SplineCurve<P>, point: P) -> Option<f64> {
    let lifted = spline.control_points().iter().map(|h| {
        let (numerator, weight) = P::split(*h);
        numerator.to_space().extend(weight)
    });
    let curve = NurbsCurve::from_knots(spline.knots().clone(), lifted.collect()).ok()?;
    let (point, breaks) = (point.to_space(), curve.knots().breaks());
    let steps = SAMPLES_PER_DEGREE * curve.knots().degree();
    let samples = breaks.windows(2).flat_map(|span| {
        let [start, end] = [span.first().copied().unwrap_or(0.0), span.last().copied().unwrap_or(0.0)];
        (0..=steps).map(move |i| start + (end - start) * i as f64 / steps as f64)
    });
    let distance = |u: f64| curve.point(u).distance_squared(point);
    let mut best = samples.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    for _ in 0..NEWTON_STEPS {
        let derivatives = curve.derivatives(best, 2);
        let [p, d, dd] = *derivatives.first_chunk()?;
        let next = curve.knots().clamp(best - (p - point).dot(d) / (d.dot(d) + (p - point).dot(dd)));
        if !next.is_finite() || distance(next) >= distance(best) {
            break;
        }
        best = next;
    }
    Some(best)
}
