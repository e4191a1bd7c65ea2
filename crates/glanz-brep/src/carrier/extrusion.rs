//! Surfaces of linear extrusion.

use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::glam::{DAffine2, DMat2};
use glanz_math::{DVec2, DVec3};

use super::conversion::{CarrierConversion, FaceExtent, scaling};
use super::revolution::{UntrimmedProfile, keeps_parameter};
use super::spline::SplineConversion;
use super::{Carrier, SplineCarrier};
use crate::curve::AffineMap;
use crate::error::BrepError;
use crate::model::{Curve, Placement};

/// The carrier of a curve moved along a direction.
pub(super) fn convert(
    curve: &Curve<DVec3>,
    direction: DVec3,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let Some(along) = direction.try_normalize() else {
        let value = direction.length();
        return Err(BrepError::DegenerateSurface { reason: "length of an extrusion", value });
    };
    let profile = UntrimmedProfile::new(curve);
    let map = scaling(DVec2::new(profile.sign, 1.0), DVec2::ZERO);
    match *profile.curve {
        Curve::Line { origin, direction: line } => {
            let sine = line.cross(direction).length() / (line.length() * direction.length());
            // How wide the plane is over the size of the face.
            let width = extent.center().map(|_| sine * 2.0 * extent.radius());
            let narrow = width.map_or(sine == 0.0, |width| width <= extent.negligible());
            let normal = line.cross(direction).try_normalize().filter(|_| !narrow);
            let Some(normal) = normal else {
                let value = line.cross(direction).length();
                return Err(BrepError::DegenerateSurface { reason: "a line along its extrusion", value });
            };
            let placement = Placement::from_axis(origin, normal, line);
            let column = |v: DVec3| DVec2::new(v.dot(placement.x), v.dot(placement.y));
            let plane = DAffine2::from_mat2(DMat2::from_cols(column(line), column(direction)));
            Ok(CarrierConversion::affine(Carrier::Plane(placement), plane * map, 0.0))
        }
        Curve::Ellipse { center, a, b } => match cylinder([center, a, b], direction, extent) {
            Some((carrier, cylinder, deviation)) => {
                Ok(CarrierConversion::affine(carrier, cylinder * map, deviation))
            }
            None => spline(curve, direction, along, extent),
        },
        _ => spline(curve, direction, along, extent),
    }
}

/// The cylinder over a circle whose axis is along the direction; `None` if it is something else.
fn cylinder(
    [center, a, b]: [DVec3; 3],
    direction: DVec3,
    extent: &FaceExtent,
) -> Option<(Carrier, DAffine2, f64)> {
    let (radius, along) = (a.length(), direction.normalize());
    let faults =
        [(b.length() - radius).abs(), (a.dot(b) / radius).abs(), a.dot(along).abs(), b.dot(along).abs()];
    if !faults.iter().all(|fault| *fault <= extent.negligible()) {
        return None;
    }
    let placement = Placement::from_axis(center, along, a);
    let turn = b.dot(placement.y).signum();
    let map = scaling(DVec2::new(turn, direction.length()), DVec2::ZERO);
    Some((Carrier::Cylinder { placement, radius }, map, faults.iter().sum()))
}

/// The ruled spline over the part of the curve that the face needs.
fn spline(
    curve: &Curve<DVec3>,
    direction: DVec3,
    along: DVec3,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let (center, radius) = extent.ball()?;
    let range = match curve.domain() {
        domain if domain.iter().all(|t| t.is_finite()) => domain,
        _ => {
            // Seen along the direction, where rulings are points.
            let flat = |p: DVec3| p - along * p.dot(along);
            let projected = AffineMap::new(flat, DVec3::ZERO).curve(curve);
            projected.unwrap_or_else(|| curve.clone()).range_near(flat(center), radius)
        }
    };
    let profile = curve.to_spline(range)?;
    let heights = profile.control_points().iter().map(|h| (h.truncate() / h.w).dot(along));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let (middle, length) = (center.dot(along), direction.length());
    let ends = [(middle - radius - high) / length, (middle + radius - low) / length];
    let ruling = |h: &glanz_math::DVec4| ends.map(|v| *h + (direction * (v * h.w)).extend(0.0));
    let points = profile.control_points().iter().flat_map(ruling).collect();
    let knots_v = KnotVector::try_new(1, vec![ends[0], ends[0], ends[1], ends[1]])?;
    let surface = NurbsSurface::from_knots(profile.knots().clone(), knots_v, points)?;
    let converted = SplineCarrier::try_new(&surface, extent.tolerance)?;
    if !keeps_parameter(curve) {
        return Ok(CarrierConversion::reparameterized(converted, 0.0));
    }
    let SplineConversion { carrier, parameters, deviation } = converted;
    Ok(CarrierConversion::affine(Carrier::Spline(carrier), parameters, deviation))
}
