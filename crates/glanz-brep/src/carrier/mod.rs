//! The surfaces that Glanz intersects, as carriers of faces.
//!
//! A [`Carrier`] has the parameters of the surface of its kind in [`FaceSurface`](crate::model::FaceSurface), angles in radians, and those
//! of a spline are scaled so that both are roughly metres of arc length. [`Carrier::try_from_surface`] finds one for any surface of a
//! CAD file: offsets, extrusions and revolutions that are a plane, a cylinder, a cone, a sphere or a torus become that, others a
//! rational spline.

mod analytic;
mod conversion;
mod extrusion;
mod offset;
mod revolution;
mod spline;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, TAU};

use glanz_math::{DVec2, DVec3};

pub use conversion::CarrierConversion;
pub use spline::SplineCarrier;

use crate::model::Placement;

/// A surface that carries faces; its normal is along dS/du x dS/dv.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Carrier {
    /// `o + u x + v y`.
    Plane(Placement),
    /// `o + r (cos u x + sin u y) + v z`.
    Cylinder {
        /// Frame.
        placement: Placement,
        /// r, metres, > 0.
        radius: f64,
    },
    /// `o + (r + v tan a) (cos u x + sin u y) + v z`, from the apex on.
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
        /// R, metres, > r.
        major_radius: f64,
        /// r, metres, > 0.
        minor_radius: f64,
    },
    /// A rational spline.
    Spline(SplineCarrier),
}

/// A side of the domain of a carrier that is a single point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// The parameter that is fixed: 0 for u, 1 for v.
    pub axis: usize,
    /// Its value.
    pub value: f64,
    /// The point, metres.
    pub point: DVec3,
}

/// The point of a carrier that is nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarrierProjection {
    /// Its parameters.
    pub uv: DVec2,
    /// Its distance, metres.
    pub distance: f64,
}

impl Carrier {
    /// The point at `uv`, metres. On a spline, parameters outside the domain are moved by the period, or clamped without one.
    #[must_use]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        match self {
            Self::Spline(spline) => spline.point(uv),
            _ => self.analytic_point(uv),
        }
    }

    /// The first derivatives by u and v.
    #[must_use]
    pub fn tangents(&self, uv: DVec2) -> [DVec3; 2] {
        match self {
            Self::Spline(spline) => {
                let [_, du, dv] = spline.point_and_tangents(uv);
                [du, dv]
            }
            _ => self.analytic_tangents(uv),
        }
    }

    /// The point and its first derivatives by u and v.
    pub(crate) fn point_and_tangents(&self, uv: DVec2) -> [DVec3; 3] {
        match self {
            Self::Spline(spline) => spline.point_and_tangents(uv),
            _ => {
                let [du, dv] = self.analytic_tangents(uv);
                [self.analytic_point(uv), du, dv]
            }
        }
    }

    /// The unit normal; at a pole the limit along the line of constant u (on a spline along the line to the middle of the domain).
    /// `None` where there is none.
    #[must_use]
    pub fn normal(&self, uv: DVec2) -> Option<DVec3> {
        match self {
            Self::Spline(spline) => spline.normal(uv),
            _ => Some(self.analytic_normal(uv)),
        }
    }

    /// Periods in u and v: a turn where the parameter is an angle; the length of the domain on a closed spline.
    #[must_use]
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Self::Plane(_) => [None; 2],
            Self::Cylinder { .. } | Self::Cone { .. } | Self::Sphere { .. } => [Some(TAU), None],
            Self::Torus { .. } => [Some(TAU); 2],
            Self::Spline(spline) => spline.periods(),
        }
    }

    /// Smallest and largest u, smallest and largest v; infinite where the carrier is, a turn from 0 on where it is an angle.
    #[must_use]
    pub fn domain(&self) -> [[f64; 2]; 2] {
        let (turn, line) = ([0.0, TAU], [f64::NEG_INFINITY, f64::INFINITY]);
        match self {
            Self::Plane(_) => [line; 2],
            Self::Cylinder { .. } => [turn, line],
            Self::Cone { radius, half_angle, .. } => [turn, [-radius / half_angle.tan(), f64::INFINITY]],
            Self::Sphere { .. } => [turn, [-FRAC_PI_2, FRAC_PI_2]],
            Self::Torus { .. } => [turn; 2],
            Self::Spline(spline) => spline.domain(),
        }
    }

    /// The sides of the domain that are single points.
    #[must_use]
    pub fn poles(&self) -> Vec<Pole> {
        let v = |value: f64, point| Pole { axis: 1, value, point };
        match self {
            Self::Plane(_) | Self::Cylinder { .. } | Self::Torus { .. } => Vec::new(),
            Self::Cone { placement, radius, half_angle } => {
                let value = -radius / half_angle.tan();
                vec![v(value, placement.origin + placement.z * value)]
            }
            Self::Sphere { placement, radius } => {
                let pole = |side: f64| v(side * FRAC_PI_2, placement.origin + placement.z * (side * radius));
                vec![pole(-1.0), pole(1.0)]
            }
            Self::Spline(spline) => spline.poles(),
        }
    }

    /// The parameters of the point of the carrier nearest to `point` (metres).
    ///
    /// With `near`, parameters with a period are those nearest to it, and an undefined angle is that of `near` (else 0); on a spline
    /// the point is the local minimum found from there, without `near` the nearest of all points.
    #[must_use]
    pub fn parameters(&self, point: DVec3, near: Option<DVec2>) -> CarrierProjection {
        match self {
            Self::Spline(spline) => spline.parameters(point, near),
            _ => {
                let uv = self.analytic_parameters(point, near);
                CarrierProjection { uv, distance: self.point(uv).distance(point) }
            }
        }
    }
}

/// `value`, moved by multiples of the period to the one nearest to `near`.
pub(crate) fn unwrapped(value: f64, near: f64, period: Option<f64>) -> f64 {
    period.map_or(value, |period| value + ((near - value) / period).round() * period)
}
