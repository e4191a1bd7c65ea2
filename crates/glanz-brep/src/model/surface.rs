//! Surfaces of faces.

use glanz_geometry::spline::NurbsSurface;
use glanz_math::DVec3;

use super::curve::Curve;

/// A right-handed orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Origin, metres.
    pub origin: DVec3,
    /// Unit vector.
    pub x: DVec3,
    /// Unit vector.
    pub y: DVec3,
    /// Unit vector `x` x `y`; the axis of surfaces of revolution.
    pub z: DVec3,
}

/// A surface with the parameterization of @iso10303-42 section 4.5; the normal is along dS/du x dS/dv.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaceSurface {
    /// `o + u x + v y`.
    Plane(Placement),
    /// `o + r (cos u x + sin u y) + v z`.
    Cylinder {
        /// Frame.
        placement: Placement,
        /// r, metres, > 0.
        radius: f64,
    },
    /// `o + (r + v tan a) (cos u x + sin u y) + v z`.
    Cone {
        /// Frame.
        placement: Placement,
        /// r, metres, >= 0.
        radius: f64,
        /// a, radians, between 0 and pi / 2.
        half_angle: f64,
    },
    /// `o + r cos v (cos u x + sin u y) + r sin v z`.
    Sphere {
        /// Frame.
        placement: Placement,
        /// r, metres, > 0.
        radius: f64,
    },
    /// `o + (R + r cos v) (cos u x + sin u y) + r sin v z`.
    Torus {
        /// Frame.
        placement: Placement,
        /// R, metres, > 0.
        major_radius: f64,
        /// r, metres, > 0; from R on the tube meets the axis.
        minor_radius: f64,
        /// Of a tube that meets the axis: whether the outer part is meant (the apple) or the inner one (the lemon).
        select_outer: bool,
    },
    /// A rational B-spline.
    Spline(NurbsSurface),
    /// A curve of parameter v turned by the angle u about an axis.
    Revolution {
        /// The curve at u = 0.
        curve: Box<Curve<DVec3>>,
        /// A point of the axis.
        origin: DVec3,
        /// Unit vector along the axis.
        axis: DVec3,
    },
    /// A curve of parameter u moved by `v direction`.
    Extrusion {
        /// The curve at v = 0.
        curve: Box<Curve<DVec3>>,
        /// Displacement at v = 1.
        direction: DVec3,
    },
    /// The surface at a distance from another, with its parameters.
    Offset {
        /// The other surface.
        basis: Box<Self>,
        /// Distance along its normal, metres.
        distance: f64,
    },
    /// A rectangle of the parameters of another surface.
    Rectangular {
        /// The other surface.
        basis: Box<Self>,
        /// Its parameters at the start and at the end, u and v.
        ranges: [[f64; 2]; 2],
        /// Whether u and v run along those of the other surface.
        same_sense: [bool; 2],
    },
}

impl FaceSurface {
    /// Its kind in a word.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Plane(_) => "plane",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Spline(_) => "spline",
            Self::Revolution { .. } => "revolution",
            Self::Extrusion { .. } => "extrusion",
            Self::Offset { .. } => "offset",
            Self::Rectangular { .. } => "rectangular",
        }
    }
}
