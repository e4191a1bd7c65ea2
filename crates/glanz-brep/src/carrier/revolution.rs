//! Surfaces of revolution.

use std::f64::consts::FRAC_1_SQRT_2;

use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::{DVec2, DVec3};

use super::analytic::centered;
use super::conversion::{CarrierConversion, FaceExtent, scaling, torus};
use super::{Carrier, SplineCarrier};
use crate::error::BrepError;
use crate::model::{Curve, Placement, SplineCurve};

/// A curve of a model without the trimming around it.
pub(super) struct UntrimmedProfile<'a> {
    /// The whole curve.
    pub(super) curve: &'a Curve<DVec3>,
    /// The sign of its parameter against that of the trimmed curve.
    pub(super) sign: f64,
    /// The middle of the trimmed part, in the parameter of the whole curve.
    pub(super) middle: Option<f64>,
}

impl<'a> UntrimmedProfile<'a> {
    pub(super) fn new(curve: &'a Curve<DVec3>) -> Self {
        let (mut whole, mut sign, mut middle) = (curve, 1.0, None);
        while let Curve::Trimmed { basis, range, same_sense } = whole {
            let [from, to] = basis.trimmed_range(*range, *same_sense);
            // Of the outermost part, which is the smallest.
            middle = middle.map(|t: f64| if *same_sense { t } else { -t }).or(Some(0.5 * (from + to)));
            sign = if *same_sense { sign } else { -sign };
            whole = basis;
        }
        Self { curve: whole, sign, middle }
    }
}

/// The carrier of a curve turned about an axis.
pub(super) fn convert(
    curve: &Curve<DVec3>,
    origin: DVec3,
    axis: DVec3,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let profile = UntrimmedProfile::new(curve);
    let simple = match *profile.curve {
        Curve::Line { origin: start, direction } => {
            of_line(&profile, [start, direction], Placement::from_axis(origin, axis, start - origin), extent)
        }
        Curve::Ellipse { center, a, b } => of_circle(&profile, [center, a, b], [origin, axis], extent),
        _ => None,
    };
    if let Some(simple) = simple {
        // The parameter of a trimmed curve may be the negative of that of the whole.
        let reversed = simple.reversed != (profile.sign < 0.0);
        let map = scaling(DVec2::new(1.0, profile.sign), DVec2::ZERO);
        let parameters = simple.parameters.map(|parameters| parameters * map);
        return Ok(CarrierConversion { parameters, reversed, ..simple });
    }
    let range = match curve.domain() {
        domain if domain.iter().all(|t| t.is_finite()) => domain,
        _ => {
            // A turn does not change the distance from a point of the axis.
            let (center, radius) = extent.ball()?;
            let height = (center - origin).dot(axis);
            let on_axis = origin + axis * height;
            curve.range_near(on_axis, center.distance(on_axis) + radius)
        }
    };
    let frame = Placement::from_axis(origin, axis, curve.point(0.5 * (range[0] + range[1])) - origin);
    turned(&curve.to_spline(range)?, frame, extent)
}

/// A plane, a cylinder or a cone; `None` if the line is askew to the axis. The frame has x towards a point of the line.
fn of_line(
    profile: &UntrimmedProfile<'_>,
    [start, direction]: [DVec3; 2],
    frame: Placement,
    extent: &FaceExtent,
) -> Option<CarrierConversion> {
    let rise = direction.dot(frame.z);
    let radial = direction - frame.z * rise;
    let from = frame.to_local(start);
    let length = direction.length();
    // How far a line drifts over the size of the face.
    let drift = |component: f64| {
        component.abs() / length * extent.center().map_or(f64::INFINITY, |_| 2.0 * extent.radius())
    };
    let negligible = extent.negligible();
    let height = extent.center().map(|center| (center - frame.origin).dot(frame.z));
    let small = |component: f64| component == 0.0 || drift(component) <= negligible;
    if small(radial.length()) {
        // At the height of the face.
        let t = height.map_or(0.0, |height| (height - from.z) / rise);
        let radius = frame.to_local(start + direction * t).truncate().length();
        if radius <= negligible {
            return None;
        }
        let carrier = Carrier::Cylinder { placement: frame, radius };
        let map = scaling(DVec2::new(1.0, rise), DVec2::new(0.0, from.z));
        let deviation = if radial == DVec3::ZERO { 0.0 } else { drift(radial.length()) };
        return Some(CarrierConversion::affine(carrier, map, deviation));
    }
    // Distance between line and axis.
    let outward = radial.normalize();
    let skew = (start - frame.origin).dot(frame.z.cross(outward)).abs();
    if skew > negligible {
        return None;
    }
    // The signed distance from the axis along `outward` is rho + t |radial|.
    let (rho, speed) = ((start - frame.origin).dot(outward), radial.length());
    if small(rise) {
        let at = profile.middle.map_or(rho, |t| rho + t * speed);
        let placement = Placement::from_axis(frame.origin + frame.z * from.z, frame.z, outward);
        let deviation = skew + if rise == 0.0 { 0.0 } else { drift(rise) };
        // z x outward x outward = -z where the distance grows.
        let reversed = at >= 0.0;
        return Some(CarrierConversion {
            carrier: Carrier::Plane(placement),
            parameters: None,
            deviation,
            reversed,
        });
    }
    let t = profile.middle.or_else(|| height.map(|height| (height - from.z) / rise)).unwrap_or(0.0);
    let at = rho + t * speed;
    let x = if at < 0.0 { -outward } else { outward };
    // The axis of a cone points to where its radius grows.
    let growth = (if at < 0.0 { -speed } else { speed }) / rise;
    let side = growth.signum();
    let origin = frame.origin + frame.z * (from.z + t * rise);
    let placement = Placement::from_axis(origin, frame.z * side, x);
    let carrier = Carrier::Cone { placement, radius: at.abs(), half_angle: growth.abs().atan() };
    let map = scaling(DVec2::new(side, rise * side), DVec2::new(0.0, -t * rise * side));
    Some(CarrierConversion::affine(carrier, map, skew))
}

/// A sphere or a torus; `None` unless the curve is a circle in a plane through the axis that turns into one.
fn of_circle(
    profile: &UntrimmedProfile<'_>,
    [center, a, b]: [DVec3; 3],
    [origin, axis]: [DVec3; 2],
    extent: &FaceExtent,
) -> Option<CarrierConversion> {
    let negligible = extent.negligible();
    let radius = a.length();
    let normal = a.cross(b).try_normalize()?;
    let across = axis.cross(normal).try_normalize()?;
    let faults = [
        (b.length() - radius).abs(),
        (a.dot(b) / radius).abs(),
        (normal.dot(axis) * radius).abs(),
        (center - origin).dot(normal).abs(),
    ];
    if !faults.iter().all(|fault| *fault <= negligible) {
        return None;
    }
    // On a sphere the profile is an arc on one side of the axis.
    let middle = profile.middle.map_or(a, |t| a * t.cos() + b * t.sin());
    let distance = (center - origin).dot(across);
    let on_axis = distance.abs() <= negligible;
    let side = if on_axis { middle.dot(across) } else { distance };
    let x = if side < 0.0 { -across } else { across };
    let placement = Placement::from_axis(origin + axis * (center - origin).dot(axis), axis, x);
    // v at t is phase + turn t.
    let local = |vector: DVec3| DVec2::new(vector.dot(placement.x), vector.dot(placement.z));
    let turn = local(a).perp_dot(local(b)).signum();
    let phase = |t: f64| {
        let at = local(a * t.cos() + b * t.sin());
        at.y.atan2(at.x)
    };
    let t = profile.middle.unwrap_or(0.0);
    let start = if on_axis { centered(phase(t)) } else { phase(t) } - turn * t;
    let deviation = faults.iter().sum::<f64>() + if on_axis { distance.abs() } else { 0.0 };
    let map = scaling(DVec2::new(1.0, turn), DVec2::new(0.0, start));
    if on_axis {
        return Some(CarrierConversion::affine(Carrier::Sphere { placement, radius }, map, deviation));
    }
    if distance.abs() <= radius {
        return None;
    }
    let whole = torus(placement, [distance.abs(), radius], true, extent).ok()?;
    Some(CarrierConversion::affine(whole.carrier, map, deviation))
}

/// A part of a circle, given by centre and radii, turned about the axis of the frame.
pub(super) fn spline(
    [center, a, b]: [DVec3; 3],
    range: [f64; 2],
    frame: Placement,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    turned(&SplineCurve::elliptic_arc([center, a, b], range)?, frame, extent)
}

/// A full turn of a rational spline. Its ends are moved to the axis if they are that close.
///
/// # Source
/// @piegl1997 section 8.5.
fn turned(
    profile: &SplineCurve<DVec3>,
    frame: Placement,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let last = profile.control_points().len() - 1;
    let mut moved: f64 = 0.0;
    // Each control point as weight, its distances from the axis along x and y, its height.
    let mut row: Vec<(f64, DVec3)> = Vec::with_capacity(last + 1);
    for (j, h) in profile.control_points().iter().enumerate() {
        let mut local = frame.to_local(h.truncate() / h.w);
        let distance = local.truncate().length();
        if (j == 0 || j == last) && distance <= extent.tolerance {
            moved = moved.max(distance);
            local = DVec3::new(0.0, 0.0, local.z);
        }
        row.push((h.w, local));
    }
    // Quarters: the points at 0, 45, 90, ... degrees; those between are corners of squares, of weight cos 45 degrees.
    let directions = [
        (1.0, 0.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (-1.0, 1.0),
        (-1.0, 0.0),
        (-1.0, -1.0),
        (0.0, -1.0),
        (1.0, -1.0),
    ];
    let mut points = Vec::with_capacity(9 * row.len());
    for k in 0..9 {
        let (cos, sin) = directions[k % 8];
        let factor = if k % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 };
        points.extend(row.iter().map(|(weight, p)| {
            let local = DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
            let weight = weight * factor;
            ((frame.origin + frame.vector(local)) * weight).extend(weight)
        }));
    }
    let quarters = [0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0];
    let knots_u = KnotVector::try_new(2, quarters.to_vec())?;
    let surface = NurbsSurface::from_knots(knots_u, profile.knots().clone(), points)?;
    Ok(CarrierConversion::reparameterized(SplineCarrier::try_new(&surface, extent.tolerance)?, moved))
}

/// Whether the rational form of a curve keeps its parameter.
pub(super) fn keeps_parameter(curve: &Curve<DVec3>) -> bool {
    matches!(
        UntrimmedProfile::new(curve).curve,
        Curve::Line { .. } | Curve::Parabola { .. } | Curve::Spline(_) | Curve::Polyline(_)
    )
}
