//! Lengths and angles of a surface.

use glanz_scene::description::GeometryDescription;
use serde::Serialize;

/// Radii and angles of a quadric or a torus; `None` for those that it lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SurfaceDimensions {
    /// Radius of a sphere, a cylinder or a disk, metres.
    pub radius: Option<f64>,
    /// Radius of a torus from its middle to that of the tube, metres.
    pub major_radius: Option<f64>,
    /// Radius of the tube of a torus, metres.
    pub minor_radius: Option<f64>,
    /// Angle between the axis of a cone and its lines, radians.
    pub half_angle: Option<f64>,
}

impl SurfaceDimensions {
    /// Those of a surface in its own frame.
    pub(super) fn of(geometry: &GeometryDescription) -> Self {
        let none = Self::default();
        match *geometry {
            GeometryDescription::Sphere { radius, .. }
            | GeometryDescription::Cylinder { radius, .. }
            | GeometryDescription::Disk { radius, .. } => Self { radius: Some(radius), ..none },
            GeometryDescription::Torus { major_radius, minor_radius, .. } => {
                Self { major_radius: Some(major_radius), minor_radius: Some(minor_radius), ..none }
            }
            GeometryDescription::Cone { radius, height, .. } => {
                Self { half_angle: Some(radius.atan2(height.abs())), ..none }
            }
            _ => none,
        }
    }

    /// Those of the surface enlarged by a factor.
    #[must_use]
    pub(super) fn scaled(self, factor: f64) -> Self {
        let scaled = |length: Option<f64>| length.map(|length| factor * length);
        Self {
            radius: scaled(self.radius),
            major_radius: scaled(self.major_radius),
            minor_radius: scaled(self.minor_radius),
            half_angle: self.half_angle,
        }
    }
}
