//! The size of the numbers from which points of curves and carriers are computed, which rounding is relative to.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::interval::largest;
use crate::carrier::{Carrier, SplineCarrier};
use crate::model::{Curve, Placement, SplineCurve};

/// Number of chained operations for a coordinate of a point.
pub(super) const OPERATIONS: u32 = 256;

/// Bound on the absolute values of all terms of the coordinates of points of an edge of size `edge` and of a curve on a carrier, metres.
/// An angle contributes its value times the radius, since its own rounding is relative to it.
pub(super) fn evaluation_size(carrier: &Carrier, curve: &SplineCurve<DVec2>, edge: f64) -> f64 {
    let [u, v] = [0, 1].map(|axis| largest(curve.control_points().iter().map(|p| (p[axis] / p.z).abs())));
    let origin = |placement: &Placement| placement.origin.abs().max_element();
    let on_carrier = match carrier {
        Carrier::Plane(placement) => origin(placement) + u + v,
        Carrier::Cylinder { placement, radius } => origin(placement) + radius * (1.0 + u) + v,
        Carrier::Cone { placement, radius, half_angle } => {
            let rho = radius + v * half_angle.tan();
            origin(placement) + rho * (1.0 + u) + v
        }
        Carrier::Sphere { placement, radius } => origin(placement) + radius * (1.0 + u + v),
        Carrier::Torus { placement, major_radius, minor_radius } => {
            origin(placement) + (major_radius + minor_radius) * (1.0 + u + v)
        }
        Carrier::Spline(spline) => {
            // Each level of a combination of control points takes three operations, the division by the weight a few more.
            let part = (3 * curve.degree() + 8) as f64 / f64::from(OPERATIONS);
            let [su, sv] = speeds(spline, curve);
            largest(spline.surface().control_points().iter().map(size)) + part * (su * u + sv * v)
        }
    };
    largest([edge, on_carrier])
}

/// The largest speeds in u and v along a curve on a spline. Bounds on those of the whole surface are too large by far where weights vary.
fn speeds(spline: &SplineCarrier, curve: &SplineCurve<DVec2>) -> [f64; 2] {
    /// Between samples speeds are taken to be less than this times larger.
    const SAFETY: f64 = 2.0;
    let breaks = curve.knots().breaks();
    let samples = breaks.windows(2).flat_map(|ends| [ends[0], 0.5 * (ends[0] + ends[1])]);
    let places = samples.chain(breaks.last().copied()).map(|t| curve.point(t));
    let found: Vec<[DVec3; 3]> = places.map(|uv| spline.point_and_tangents(uv)).collect();
    [1, 2].map(|i| SAFETY * largest(found.iter().map(|derivatives| derivatives[i].length())))
}

/// The size of a spline: that of its control points.
pub(super) fn spline_size(edge: &SplineCurve<DVec3>) -> f64 {
    largest(edge.control_points().iter().map(size))
}

/// The size of the curve of an edge, with its rational form: a conic is the sum of its centre and its axes.
pub(super) fn curve_size(curve: &Curve<DVec3>, spline: &SplineCurve<DVec3>) -> f64 {
    let terms = match curve {
        Curve::Ellipse { center, a, b } => (center.abs() + a.abs() + b.abs()).max_element(),
        _ => 0.0,
    };
    largest([terms, spline_size(spline)])
}

fn size(point: &DVec4) -> f64 {
    (point.truncate() / point.w).abs().max_element()
}
