//! Planes, cylinders, cones, spheres and tori: points, derivatives and nearest points in closed form.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec2, DVec3};

use super::{Carrier, unwrapped};
use crate::model::Placement;

/// Part of a vector at right angles to another below which it is only rounding: a large multiple of it, for vectors that are differences.
const ALONG: f64 = 1.0 / (1_u32 << 26) as f64;

impl Placement {
    /// The frame with this origin and z axis and with x towards a direction, of which the part at right angles to z counts; with any x
    /// if there is none but rounding.
    #[must_use]
    pub fn from_axis(origin: DVec3, z: DVec3, towards: DVec3) -> Self {
        let across = |vector: DVec3| vector - z * vector.dot(z);
        let radial = across(towards);
        // The second projection removes what the cancellation of the first leaves along z.
        let x = (radial.length() > ALONG * towards.length())
            .then(|| radial.try_normalize().and_then(|x| across(x).try_normalize()))
            .flatten()
            .unwrap_or_else(|| z.any_orthonormal_vector());
        Self { origin, x, y: z.cross(x), z }
    }

    /// Coordinates of a point in the frame, metres.
    pub(crate) fn to_local(self, point: DVec3) -> DVec3 {
        let d = point - self.origin;
        DVec3::new(d.dot(self.x), d.dot(self.y), d.dot(self.z))
    }

    /// The vector with these coordinates.
    pub(crate) fn vector(self, local: DVec3) -> DVec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// The unit vector at right angles to z at an angle from x towards y.
    pub(crate) fn radial(self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.x * cos + self.y * sin
    }
}

impl Carrier {
    /// The frame of an analytic carrier, the distance from its axis and the height above its origin at v, and their derivatives.
    fn profile(&self, v: f64) -> Option<(&Placement, [DVec2; 2])> {
        let (sin, cos) = v.sin_cos();
        match self {
            Self::Plane(_) | Self::Spline(_) => None,
            Self::Cylinder { placement, radius } => Some((placement, [DVec2::new(*radius, v), DVec2::Y])),
            Self::Cone { placement, radius, half_angle } => {
                let slope = half_angle.tan();
                Some((placement, [DVec2::new(radius + v * slope, v), DVec2::new(slope, 1.0)]))
            }
            Self::Sphere { placement, radius } => {
                Some((placement, [DVec2::new(cos, sin) * *radius, DVec2::new(-sin, cos) * *radius]))
            }
            Self::Torus { placement, major_radius, minor_radius } => {
                let point = DVec2::new(major_radius + minor_radius * cos, minor_radius * sin);
                Some((placement, [point, DVec2::new(-sin, cos) * *minor_radius]))
            }
        }
    }

    /// The point of a carrier that is not a spline.
    pub(super) fn analytic_point(&self, uv: DVec2) -> DVec3 {
        match (self, self.profile(uv.y)) {
            (_, Some((placement, [p, _]))) => {
                placement.origin + placement.radial(uv.x) * p.x + placement.z * p.y
            }
            (Self::Plane(placement), _) => placement.origin + placement.x * uv.x + placement.y * uv.y,
            _ => DVec3::NAN,
        }
    }

    /// The first derivatives of a carrier that is not a spline.
    pub(super) fn analytic_tangents(&self, uv: DVec2) -> [DVec3; 2] {
        match (self, self.profile(uv.y)) {
            (_, Some((placement, [p, d]))) => {
                let radial = placement.radial(uv.x);
                [placement.z.cross(radial) * p.x, radial * d.x + placement.z * d.y]
            }
            (Self::Plane(placement), _) => [placement.x, placement.y],
            _ => [DVec3::NAN; 2],
        }
    }

    /// The unit normal of a carrier that is not a spline.
    pub(super) fn analytic_normal(&self, uv: DVec2) -> DVec3 {
        match (self, self.profile(uv.y)) {
            // (z x radial) x (radial d.x + z d.y).
            (_, Some((placement, [_, d]))) => (placement.radial(uv.x) * d.y - placement.z * d.x).normalize(),
            (Self::Plane(placement), _) => placement.z,
            _ => DVec3::NAN,
        }
    }

    /// The parameters of the nearest point of a carrier that is not a spline.
    pub(super) fn analytic_parameters(&self, point: DVec3, near: Option<DVec2>) -> DVec2 {
        let angle = |y: f64, x: f64, near: Option<f64>| {
            let found = if x == 0.0 && y == 0.0 { near.unwrap_or(0.0) } else { y.atan2(x) };
            match near {
                Some(near) => unwrapped(found, near, Some(TAU)),
                None => found.rem_euclid(TAU),
            }
        };
        let placement = match self {
            Self::Plane(placement)
            | Self::Cylinder { placement, .. }
            | Self::Cone { placement, .. }
            | Self::Sphere { placement, .. }
            | Self::Torus { placement, .. } => placement,
            Self::Spline(_) => return DVec2::NAN,
        };
        let p = placement.to_local(point);
        let rho = p.x.hypot(p.y);
        let u = angle(p.y, p.x, near.map(|uv| uv.x));
        match self {
            Self::Plane(_) | Self::Spline(_) => p.truncate(),
            Self::Cylinder { .. } => DVec2::new(u, p.z),
            Self::Cone { radius, half_angle, .. } => {
                let (sin, cos) = half_angle.sin_cos();
                // The foot of the perpendicular on the generator, not before the apex.
                let foot = ((rho - radius) * sin + p.z * cos) * cos;
                DVec2::new(u, foot.max(-radius * cos / sin))
            }
            Self::Sphere { .. } => DVec2::new(u, p.z.atan2(rho)),
            Self::Torus { major_radius, .. } => {
                DVec2::new(u, angle(p.z, rho - major_radius, near.map(|uv| uv.y)))
            }
        }
    }
}

/// `angle` in (-pi, pi].
pub(super) fn centered(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}
