//! Edges whose image in the parameters of an elementary surface is known.

use std::f64::consts::{FRAC_PI_2, TAU};

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::interval::largest;
use super::size::{curve_size, evaluation_size};
use super::{EdgeParameterCurve, ParameterCurveSource};
use crate::carrier::Carrier;
use crate::curve::{AffineMap, EdgeCurve};
use crate::model::{Curve, Placement, SplineCurve};

/// Number of chained operations for a coordinate.
const OPERATIONS: u32 = 64;

/// The image of the edge if it were exactly on the surface, with its deviation, however large; `None` where its form is not known.
pub(super) fn parameter_curve(
    carrier: &Carrier,
    edge: &EdgeCurve,
    spline: &SplineCurve<DVec3>,
) -> Option<EdgeParameterCurve> {
    let rounding = |curve: &SplineCurve<DVec2>| {
        gamma(OPERATIONS) * evaluation_size(carrier, curve, curve_size(edge.curve(), spline))
    };
    let (curve, deviation) = match (carrier, edge.curve()) {
        (Carrier::Plane(placement), _) => return projected(placement, spline, rounding),
        (Carrier::Cylinder { .. } | Carrier::Cone { .. }, Curve::Line { .. }) => ruling(carrier, edge)?,
        (Carrier::Spline(_), _) => return None,
        (_, Curve::Ellipse { center, a, b }) => circle(carrier, edge, [*center, *a, *b])?,
        _ => return None,
    };
    let deviation = deviation + rounding(&curve);
    Some(EdgeParameterCurve { curve, deviation, source: ParameterCurveSource::Exact })
}

/// The projection onto a plane. The distance of a rational curve from it is at most that of its control points.
fn projected(
    placement: &Placement,
    spline: &SplineCurve<DVec3>,
    rounding: impl Fn(&SplineCurve<DVec2>) -> f64,
) -> Option<EdgeParameterCurve> {
    let linear = |p: DVec3| DVec2::new(p.dot(placement.x), p.dot(placement.y));
    let curve = AffineMap::new(linear, -linear(placement.origin)).spline(spline)?;
    let heights = spline.control_points().iter().map(|h| placement.to_local(h.truncate() / h.w).z.abs());
    let deviation = largest(heights) + rounding(&curve);
    Some(EdgeParameterCurve { curve, deviation, source: ParameterCurveSource::Exact })
}

/// A line along a cylinder or a cone. The difference of two lines is largest at an end.
fn ruling(carrier: &Carrier, edge: &EdgeCurve) -> Option<(SplineCurve<DVec2>, f64)> {
    // The angle in the middle: at the apex of a cone there is none.
    let middle = carrier.parameters(edge.point(0.5), None).uv;
    let ends = [0.0, 1.0].map(|fraction| {
        let point = edge.point(fraction);
        let uv = DVec2::new(middle.x, carrier.parameters(point, Some(middle)).uv.y);
        (uv, carrier.point(uv).distance(point))
    });
    let curve = SplineCurve::line(ends[0].0, ends[1].0, [0.0, 1.0]).ok()?;
    Some((curve, ends[0].1.max(ends[1].1)))
}

/// A circle on which one parameter is constant and the other runs with the angle.
struct CircleOnCarrier {
    /// Centre and radii of the circle of the carrier, metres.
    circle: [DVec3; 3],
    /// Parameters at the angle 0, and their derivative by the angle.
    start: DVec2,
    slope: DVec2,
}

/// A latitude or a meridian. The difference of two circles with the same angle t is `c + cos t a + sin t b`, the square of
/// which is at most that of |c|, that of the largest singular value of the matrix of a and b, and `2 |(c . a, c . b)|`.
fn circle(
    carrier: &Carrier,
    edge: &EdgeCurve,
    [center, a, b]: [DVec3; 3],
) -> Option<(SplineCurve<DVec2>, f64)> {
    let (placement, tilt) = match carrier {
        Carrier::Cylinder { placement, .. }
        | Carrier::Cone { placement, .. }
        | Carrier::Sphere { placement, .. }
        | Carrier::Torus { placement, .. } => (*placement, a.cross(b).normalize_or_zero().dot(placement.z)),
        Carrier::Plane(_) | Carrier::Spline(_) => return None,
    };
    let [from, to] = edge.range();
    // Nearer to the axis than to its plane: a latitude.
    let on_carrier = if tilt.abs() > 0.5 {
        latitude(carrier, &placement, [center, a], tilt.signum())
    } else {
        meridian(carrier, &placement, [center, a, b], 0.5 * (from + to))?
    };
    let [c, da, db] = [0, 1, 2].map(|i| [center, a, b][i] - on_carrier.circle[i]);
    let (e, f, g) = (da.length_squared(), da.dot(db), db.length_squared());
    let square =
        c.length_squared() + 0.5 * (e + g) + (0.5 * (e - g)).hypot(f) + 2.0 * c.dot(da).hypot(c.dot(db));
    let mut deviation = square.sqrt();
    let mut ends = [from, to].map(|t| on_carrier.start + on_carrier.slope * t);
    if let (Carrier::Sphere { radius, .. }, true) = (carrier, on_carrier.slope.y != 0.0) {
        // An edge that ends in the pole up to the tolerance may pass it.
        for end in &mut ends {
            let inside = end.y.clamp(-FRAC_PI_2, FRAC_PI_2);
            deviation += (end.y - inside).abs() * radius;
            end.y = inside;
        }
    }
    let turns = (ends[0].x / TAU).floor() * TAU;
    let [start, end] = ends.map(|uv| uv - DVec2::new(turns, 0.0));
    Some((SplineCurve::line(start, end, [0.0, 1.0]).ok()?, deviation))
}

/// The circle about the axis at the height of the centre.
fn latitude(carrier: &Carrier, placement: &Placement, [center, a]: [DVec3; 2], turn: f64) -> CircleOnCarrier {
    let u = a.dot(placement.y).atan2(a.dot(placement.x));
    let point = center + a;
    let uv = carrier.parameters(point, Some(DVec2::new(u, 0.0))).uv;
    let v = DVec2::new(u, uv.y);
    let on_carrier = carrier.point(v);
    let middle = placement.origin + placement.z * placement.to_local(on_carrier).z;
    let radius = on_carrier - middle;
    let circle = [middle, radius, placement.z.cross(radius) * turn];
    CircleOnCarrier { circle, start: v, slope: DVec2::new(turn, 0.0) }
}

/// The circle in a plane through the axis; `None` on cylinders and cones. `middle`: angle of the middle of the edge.
fn meridian(
    carrier: &Carrier,
    placement: &Placement,
    [center, a, b]: [DVec3; 3],
    middle: f64,
) -> Option<CircleOnCarrier> {
    let at_middle = a * middle.cos() + b * middle.sin();
    let (towards, major, minor) = match carrier {
        // The side of the sphere on which the edge lies.
        Carrier::Sphere { radius, .. } => (at_middle, 0.0, *radius),
        Carrier::Torus { major_radius, minor_radius, .. } => {
            (center - placement.origin, *major_radius, *minor_radius)
        }
        _ => return None,
    };
    // On a sphere the middle may be a pole; then any direction in the plane of the circle will do.
    let flat = |p: DVec3| p - placement.z * p.dot(placement.z);
    let across = placement.z.cross(a.cross(b)).try_normalize()?;
    let outward = if flat(towards).dot(across) < 0.0 { -across } else { across };
    let u = outward.dot(placement.y).atan2(outward.dot(placement.x));
    let angle = |p: DVec3| p.dot(placement.z).atan2(p.dot(outward));
    let turn = (a.dot(outward) * b.dot(placement.z) - a.dot(placement.z) * b.dot(outward)).signum();
    // The angle at the middle lies in the right turn.
    let v = angle(at_middle) - turn * middle;
    let (sin, cos) = v.sin_cos();
    let [radius, next] = [outward * cos + placement.z * sin, placement.z * cos - outward * sin];
    let circle = [placement.origin + outward * major, radius * minor, next * (minor * turn)];
    Some(CircleOnCarrier { circle, start: DVec2::new(u, v), slope: DVec2::new(0.0, turn) })
}
