//! Carriers of the surfaces of a model.

use glanz_math::glam::{DAffine2, DMat2};
use glanz_math::{Bounds3, DVec2, DVec3};

use super::spline::SplineConversion;
use super::{Carrier, SplineCarrier, extrusion, offset, revolution};
use crate::error::BrepError;
use crate::model::{FaceSurface, Placement};

/// Part of the tolerance up to which a shape counts as one of a simpler kind; the difference is reported as deviation.
const NEGLIGIBLE: f64 = 1.0 / 64.0;

/// A carrier with its relation to the surface from which it was made.
#[derive(Clone, Debug)]
pub struct CarrierConversion {
    /// The carrier.
    pub carrier: Carrier,
    /// The map from the parameters of the surface to those of the carrier; `None` if it is not affine.
    pub parameters: Option<DAffine2>,
    /// Bound on the distance between surface and carrier, metres; 0 if they are the same up to rounding. For the fitted offset of a
    /// spline it is an estimate: twice the largest distance of samples.
    pub deviation: f64,
    /// Whether their normals are opposite.
    pub reversed: bool,
}

/// What a conversion must know of the face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceExtent {
    /// A box around the edges of the face, metres.
    pub(super) bounds: Bounds3,
    /// Distance below which points coincide, metres.
    pub(super) tolerance: f64,
}

impl FaceExtent {
    /// Distance up to which a shape counts as one of a simpler kind.
    pub(super) fn negligible(&self) -> f64 {
        self.tolerance * NEGLIGIBLE
    }

    /// The middle of the box, if there is one.
    pub(super) fn center(&self) -> Option<DVec3> {
        (!self.bounds.is_empty() && self.bounds.is_finite()).then(|| self.bounds.center())
    }

    /// Half the diagonal of the box with a margin, metres.
    pub(super) fn radius(&self) -> f64 {
        // The box contains the edges; the margin is for the face between them, and for numbers near the border.
        self.bounds.diagonal().length() * (0.5 + 1.0 / 16.0) + 2.0 * self.tolerance
    }

    /// A ball around the face.
    ///
    /// # Errors
    /// [`BrepError::UnboundedExtent`] if the face has no edges.
    pub(super) fn ball(&self) -> Result<(DVec3, f64), BrepError> {
        self.center().map(|center| (center, self.radius())).ok_or(BrepError::UnboundedExtent)
    }
}

impl CarrierConversion {
    /// A conversion with an affine map of parameters, whose orientation tells whether the normals agree.
    pub(super) fn affine(carrier: Carrier, parameters: DAffine2, deviation: f64) -> Self {
        let reversed = parameters.matrix2.determinant() < 0.0;
        Self { carrier, parameters: Some(parameters), deviation, reversed }
    }

    /// The conversion of the same surface with parameters that run against its own where `same_sense` is false.
    pub(crate) fn turned(self, same_sense: [bool; 2]) -> Self {
        let sign = DVec2::from(same_sense.map(|same| if same { 1.0 } else { -1.0 }));
        let reversed = self.reversed != (sign.x * sign.y < 0.0);
        let parameters = self.parameters.map(|map| map * scaling(sign, DVec2::ZERO));
        Self { parameters, reversed, ..self }
    }

    /// A spline over other parameters that run in the same directions.
    pub(super) fn reparameterized(spline: SplineConversion, deviation: f64) -> Self {
        let carrier = Carrier::Spline(spline.carrier);
        Self { carrier, parameters: None, deviation: spline.deviation + deviation, reversed: false }
    }
}

/// The map that scales u and v, and then moves them.
pub(super) fn scaling(scale: DVec2, translation: DVec2) -> DAffine2 {
    DAffine2::from_mat2_translation(DMat2::from_diagonal(scale), translation)
}

impl Carrier {
    /// The carrier of a surface for a face whose edges lie in the box `extent`, by which unbounded profiles are cut.
    ///
    /// `tolerance` (metres): distance up to which points of the file coincide. Borders that are that close are joined; shapes that differ
    /// from one of a simpler kind by a small part of it become that. Offsets of splines are fitted within it.
    ///
    /// # Errors
    /// [`BrepError::DegenerateSurface`], [`BrepError::UnboundedExtent`] if the box is needed and empty, [`BrepError::UnappliedRange`] for
    /// a rectangle of a surface if the box is empty, [`BrepError::Unfitted`] for an offset, and [`BrepError::Surface`] where numbers overflow.
    pub fn try_from_surface(
        surface: &FaceSurface,
        extent: Bounds3,
        tolerance: f64,
    ) -> Result<CarrierConversion, BrepError> {
        convert(surface, &FaceExtent { bounds: extent, tolerance })
    }
}

/// The conversion of any surface.
pub(super) fn convert(surface: &FaceSurface, extent: &FaceExtent) -> Result<CarrierConversion, BrepError> {
    let same = |carrier| Ok(CarrierConversion::affine(carrier, DAffine2::IDENTITY, 0.0));
    match *surface {
        FaceSurface::Plane(placement) => same(Carrier::Plane(placement)),
        FaceSurface::Cylinder { placement, radius } => same(Carrier::Cylinder { placement, radius }),
        FaceSurface::Cone { placement, radius, half_angle } => {
            Ok(cone(placement, radius, half_angle, extent))
        }
        FaceSurface::Sphere { placement, radius } => same(Carrier::Sphere { placement, radius }),
        FaceSurface::Torus { placement, major_radius, minor_radius, select_outer } => {
            torus(placement, [major_radius, minor_radius], select_outer, extent)
        }
        FaceSurface::Spline(ref surface) => {
            let SplineConversion { carrier, parameters, deviation } =
                SplineCarrier::try_new(surface, extent.tolerance)?;
            Ok(CarrierConversion::affine(Carrier::Spline(carrier), parameters, deviation))
        }
        FaceSurface::Revolution { ref curve, origin, axis } => {
            revolution::convert(curve, origin, axis, extent)
        }
        FaceSurface::Extrusion { ref curve, direction } => extrusion::convert(curve, direction, extent),
        FaceSurface::Offset { ref basis, distance } => {
            // A point of the basis is at the distance from one of the face.
            let bounds = extent.bounds.expanded(distance.abs());
            offset::convert(convert(basis, &FaceExtent { bounds, ..*extent })?, distance, extent)
        }
        FaceSurface::Rectangular { ref basis, same_sense, .. } => {
            // The edges of a face lie within the range; without them it would be the whole basis.
            if extent.center().is_none() {
                return Err(BrepError::UnappliedRange);
            }
            Ok(convert(basis, extent)?.turned(same_sense))
        }
    }
}

/// The nappe of a cone on which the face lies, from its apex on.
pub(super) fn cone(
    placement: Placement,
    radius: f64,
    half_angle: f64,
    extent: &FaceExtent,
) -> CarrierConversion {
    let apex = -radius / half_angle.tan();
    let beyond = extent.center().is_some_and(|center| placement.to_local(center).z < apex);
    if !beyond {
        return CarrierConversion::affine(
            Carrier::Cone { placement, radius, half_angle },
            DAffine2::IDENTITY,
            0.0,
        );
    }
    other_nappe(placement, apex, half_angle)
}

/// The nappe of a cone before its apex, which is at this height.
///
/// Half a turn about x exchanges the nappes. A point at (u, v) has the radius (v - apex) tan a < 0, thus the azimuth u + pi about the old
/// axis, which is its negative about the new one.
pub(super) fn other_nappe(placement: Placement, apex: f64, half_angle: f64) -> CarrierConversion {
    let turned = Placement {
        origin: placement.origin + placement.z * apex,
        y: -placement.y,
        z: -placement.z,
        ..placement
    };
    let carrier = Carrier::Cone { placement: turned, radius: 0.0, half_angle };
    let map = scaling(DVec2::NEG_ONE, DVec2::new(-std::f64::consts::PI, apex));
    CarrierConversion::affine(carrier, map, 0.0)
}

/// A torus, or the outer or inner part of a tube that meets the axis, as the revolution of an arc.
pub(super) fn torus(
    placement: Placement,
    [major_radius, minor_radius]: [f64; 2],
    select_outer: bool,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    if major_radius > minor_radius {
        let carrier = Carrier::Torus { placement, major_radius, minor_radius };
        return Ok(CarrierConversion::affine(carrier, DAffine2::IDENTITY, 0.0));
    }
    // Of a tube that touches the axis, a hole too narrow to matter makes a whole torus: its meridians all pass through one point.
    let opened = minor_radius + extent.negligible();
    // A tube that passes the axis meets it at these heights, between which the whole torus has an inner part.
    let inner = ((minor_radius - major_radius) * (minor_radius + major_radius)).sqrt();
    if select_outer && opened > minor_radius && inner <= extent.negligible() {
        let carrier = Carrier::Torus { placement, major_radius: opened, minor_radius };
        return Ok(CarrierConversion::affine(carrier, DAffine2::IDENTITY, opened - major_radius + inner));
    }
    // The tube meets the axis where R + r cos v = 0.
    let end = (-major_radius / minor_radius).clamp(-1.0, 0.0).acos();
    let range = if select_outer { [-end, end] } else { [end, std::f64::consts::TAU - end] };
    if !select_outer && range[1] - range[0] <= 0.0 {
        return Err(BrepError::DegenerateSurface { reason: "inner part of a torus", value: 0.0 });
    }
    let center = placement.origin + placement.x * major_radius;
    let arc = [center, placement.x * minor_radius, placement.z * minor_radius];
    revolution::spline(arc, range, placement, extent)
}
