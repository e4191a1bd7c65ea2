//! Surfaces at a distance from others.

use std::f64::consts::PI;

use glanz_math::DVec2;
use glanz_math::glam::DAffine2;

use super::Carrier;
use super::conversion::{CarrierConversion, FaceExtent, scaling, torus};
use crate::error::BrepError;
use crate::model::Placement;

/// The carrier at a `distance` along the normals of the surface of `basis`, metres.
pub(super) fn convert(
    basis: CarrierConversion,
    distance: f64,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let outward = if basis.reversed { -distance } else { distance };
    let (carrier, map) = match basis.carrier {
        Carrier::Plane(placement) => {
            let origin = placement.origin + placement.z * outward;
            (Carrier::Plane(Placement { origin, ..placement }), DAffine2::IDENTITY)
        }
        Carrier::Cylinder { placement, radius } => {
            let offset = checked("radius of an offset cylinder", radius + outward)?;
            // A negative radius is the opposite side.
            let turn = if offset < 0.0 { PI } else { 0.0 };
            let map = DAffine2::from_translation(DVec2::new(turn, 0.0));
            (Carrier::Cylinder { placement, radius: offset.abs() }, map)
        }
        Carrier::Cone { placement, radius, half_angle } => {
            // The normal is (cos a, -sin a) in radius and height: r + v tan a + d cos a = r + d / cos a + (v - d sin a) tan a.
            let (sin, cos) = half_angle.sin_cos();
            let mut offset = radius + outward / cos;
            let (mut placement, mut shift) = (placement, -outward * sin);
            if offset < 0.0 {
                let apex = -offset * cos / sin;
                placement.origin += placement.z * apex;
                shift -= apex;
                offset = 0.0;
            }
            let map = DAffine2::from_translation(DVec2::new(0.0, shift));
            (Carrier::Cone { placement, radius: offset, half_angle }, map)
        }
        Carrier::Sphere { placement, radius } => {
            let offset = checked("radius of an offset sphere", radius + outward)?;
            let map = if offset < 0.0 {
                scaling(DVec2::new(1.0, -1.0), DVec2::new(PI, 0.0))
            } else {
                DAffine2::IDENTITY
            };
            (Carrier::Sphere { placement, radius: offset.abs() }, map)
        }
        Carrier::Torus { placement, major_radius, minor_radius } => {
            let offset = checked("minor radius of an offset torus", minor_radius + outward)?;
            if offset.abs() >= major_radius {
                return torus(placement, [major_radius, offset.abs()], true, extent);
            }
            let turn = if offset < 0.0 { PI } else { 0.0 };
            let map = DAffine2::from_translation(DVec2::new(0.0, turn));
            (Carrier::Torus { placement, major_radius, minor_radius: offset.abs() }, map)
        }
        Carrier::Spline(_) => {
            return Err(BrepError::Unfitted {
                shape: "offset of a spline surface",
                deviation: distance.abs(),
                tolerance: extent.tolerance,
            });
        }
    };
    let reversed = basis.reversed != (map.matrix2.determinant() < 0.0);
    let parameters = basis.parameters.map(|parameters| map * parameters);
    Ok(CarrierConversion { carrier, parameters, deviation: basis.deviation, reversed })
}

fn checked(reason: &'static str, value: f64) -> Result<f64, BrepError> {
    if value == 0.0 { Err(BrepError::DegenerateSurface { reason, value }) } else { Ok(value) }
}
