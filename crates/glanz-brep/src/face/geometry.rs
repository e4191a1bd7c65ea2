//! Surfaces of trimmed faces as Glanz intersects them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glanz_geometry::spline::NurbsSurface;
use glanz_math::glam::DMat2;
use glanz_math::{Bounds3, DMat4, DVec2, DVec3};

use crate::boundary::BoundaryCurve;
use crate::carrier::Carrier;
use crate::model::Placement;

/// The surface of a face in its own frame, with the parameters of the surfaces of `glanz-geometry`.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceGeometry {
    /// A rectangle of the plane z = 0, metres.
    Plane {
        /// Smallest and largest x.
        x: [f64; 2],
        /// Smallest and largest y.
        y: [f64; 2],
    },
    /// A cylinder about the z axis.
    Cylinder {
        /// Radius, metres.
        radius: f64,
        /// Smallest and largest z, metres.
        z: [f64; 2],
        /// Largest azimuth, radians.
        phi_max: f64,
    },
    /// A cone about the z axis with its base in z = 0 and its apex above.
    Cone {
        /// Radius of the base, metres.
        radius: f64,
        /// Height of the apex, metres.
        height: f64,
        /// Largest azimuth, radians.
        phi_max: f64,
    },
    /// A zone of a sphere about the origin.
    Sphere {
        /// Radius, metres.
        radius: f64,
        /// Smallest and largest z, metres.
        z: [f64; 2],
        /// Largest azimuth, radians.
        phi_max: f64,
    },
    /// A torus about the z axis.
    Torus {
        /// Radius of the circle inside the tube, metres.
        major_radius: f64,
        /// Radius of the tube, metres.
        minor_radius: f64,
        /// Largest azimuth, radians.
        phi_max: f64,
    },
    /// A rational B-spline.
    Spline(NurbsSurface),
}

/// A window of a carrier: its geometry, its place, and where boundaries lie on it.
pub(super) struct PlacedGeometry {
    pub(super) geometry: FaceGeometry,
    pub(super) to_part: DMat4,
    /// Length of each parameter of the geometry, metres.
    pub(super) scale: DVec2,
    /// From region coordinates of the carrier to parameters of the geometry times `scale`: diagonal, of entries +-1.
    matrix: DMat2,
    offset: DVec2,
}

impl PlacedGeometry {
    /// The curve in the parameters of the geometry.
    pub(super) fn curve(&self, curve: &BoundaryCurve) -> BoundaryCurve {
        curve.transformed(self.matrix, self.offset).scaled(self.scale.recip())
    }

    /// The window of the carrier in parameters of the geometry.
    pub(super) fn domain(&self, [[x0, x1], [y0, y1]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        let corners = [DVec2::new(x0, y0), DVec2::new(x1, y1)];
        let [a, b] = corners.map(|corner| (self.matrix * corner + self.offset) / self.scale);
        [[a.x.min(b.x), a.x.max(b.x)], [a.y.min(b.y), a.y.max(b.y)]]
    }
}

/// Metres per unit of the parameters of a carrier where they are longest; `reach`: largest distance of the face from the axis, metres.
///
/// Region coordinates are parameters times these lengths.
pub(super) fn metric(carrier: &Carrier, reach: f64) -> DVec2 {
    match *carrier {
        Carrier::Plane(_) | Carrier::Spline(_) => DVec2::ONE,
        Carrier::Cylinder { radius, .. } => DVec2::new(radius, 1.0),
        Carrier::Cone { half_angle, .. } => DVec2::new(reach, 1.0 / half_angle.cos()),
        Carrier::Sphere { radius, .. } => DVec2::splat(radius),
        Carrier::Torus { major_radius, minor_radius, .. } => {
            DVec2::new(major_radius + minor_radius, minor_radius)
        }
    }
}

/// The largest distance of a box from the axis of a carrier; the radius at the origin of a cone where the box is empty.
pub(super) fn reach(carrier: &Carrier, extent: Bounds3) -> f64 {
    let Carrier::Cone { placement, radius, .. } = carrier else { return 1.0 };
    let corners = (0..8).map(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { extent.min[axis] } else { extent.max[axis] };
        DVec3::new(pick(0), pick(1), pick(2)) - placement.origin
    });
    let distance = |p: DVec3| (p - placement.z * p.dot(placement.z)).length();
    let largest = corners.map(distance).fold(0.0, f64::max);
    if largest.is_finite() && largest > 0.0 { largest } else { radius.max(f64::MIN_POSITIVE) }
}

/// The part of a carrier over a window in region coordinates.
pub(super) fn placed(carrier: &Carrier, metric: DVec2, window: [[f64; 2]; 2]) -> PlacedGeometry {
    let [u, v] = [0, 1].map(|axis| window[axis].map(|end| end / metric[axis]));
    // A full turn has no ends, at which rounding would open it.
    let phi_max = if u[1] - u[0] >= TAU * (1.0 - 64.0 * f64::EPSILON) { TAU } else { u[1] - u[0] };
    let start = DVec2::new(u[0], v[0]) * metric;
    let along = |to_part: DMat4, geometry: FaceGeometry, scale: DVec2, offset: DVec2| PlacedGeometry {
        geometry,
        to_part,
        scale,
        matrix: DMat2::IDENTITY,
        offset,
    };
    match *carrier {
        Carrier::Plane(placement) => along(
            matrix(&placement, 0.0),
            FaceGeometry::Plane { x: u, y: v },
            DVec2::new(u[1] - u[0], v[1] - v[0]),
            -start,
        ),
        Carrier::Cylinder { placement, radius } => along(
            matrix(&placement, u[0]),
            FaceGeometry::Cylinder { radius, z: v, phi_max },
            DVec2::new(phi_max, v[1] - v[0]) * metric,
            -start,
        ),
        Carrier::Cone { placement, radius, half_angle } => {
            // Turned upside down about x, so that the apex is above: both parameters run the other way.
            let Placement { origin, x, y, z } = placement;
            let turned = Placement { origin: origin + v[1] * z, x, y: -y, z: -z };
            let base = radius + v[1] * half_angle.tan();
            let height = base / half_angle.tan();
            PlacedGeometry {
                geometry: FaceGeometry::Cone { radius: base, height, phi_max },
                to_part: matrix(&turned, -u[0] - phi_max),
                scale: DVec2::new(phi_max, height) * metric,
                matrix: -DMat2::IDENTITY,
                offset: DVec2::new(u[0] + phi_max, v[1]) * metric,
            }
        }
        Carrier::Sphere { placement, radius } => {
            let (low, high) = (zone_end(radius, v[0], -1.0), zone_end(radius, v[1], 1.0));
            along(
                matrix(&placement, u[0]),
                FaceGeometry::Sphere { radius, z: [low.0, high.0], phi_max },
                DVec2::new(phi_max, high.1 - low.1) * metric,
                -DVec2::new(u[0], low.1) * metric,
            )
        }
        Carrier::Torus { placement, major_radius, minor_radius } => along(
            matrix(&placement, u[0]),
            FaceGeometry::Torus { major_radius, minor_radius, phi_max },
            DVec2::new(phi_max, TAU) * metric,
            -DVec2::new(u[0], 0.0) * metric,
        ),
        Carrier::Spline(ref spline) => {
            let surface = spline.surface();
            let domain = [surface.knots_u().domain(), surface.knots_v().domain()];
            let part = [0, 1]
                .map(|axis| [window[axis][0].max(domain[axis][0]), window[axis][1].min(domain[axis][1])]);
            // Files often cut small faces from large surfaces.
            let surface = if part == domain {
                surface.clone()
            } else {
                surface.restrict(part).unwrap_or_else(|_| surface.clone())
            };
            along(DMat4::IDENTITY, FaceGeometry::Spline(surface), DVec2::ONE, DVec2::ZERO)
        }
    }
}

/// Height and latitude of the lower (`side` -1) or upper (+1) end of a zone of a sphere that reaches at least to a latitude.
///
/// Near the poles a height is known to fewer digits than a latitude: the zone goes on to the pole at its side, and begins before that at
/// the other.
fn zone_end(radius: f64, latitude: f64, side: f64) -> (f64, f64) {
    const HIGHEST: f64 = 0.4 * PI;
    let towards_pole = latitude * side;
    if towards_pole > HIGHEST {
        return (radius * side, FRAC_PI_2 * side);
    }
    let z = radius * towards_pole.max(-HIGHEST).sin() * side;
    (z, z.atan2(((radius - z) * (radius + z)).sqrt()))
}

/// The frame of a placement, turned about its z axis by `azimuth`.
fn matrix(placement: &Placement, azimuth: f64) -> DMat4 {
    let Placement { origin, x, y, z } = *placement;
    let (sin, cos) = azimuth.sin_cos();
    let columns = [cos * x + sin * y, cos * y - sin * x, z].map(|axis: DVec3| axis.extend(0.0));
    DMat4::from_cols(columns[0], columns[1], columns[2], origin.extend(1.0))
}
