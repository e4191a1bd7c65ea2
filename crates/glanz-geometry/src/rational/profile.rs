//! Profile curves of surfaces of revolution about the z axis.

use std::f64::consts::{FRAC_PI_3, TAU};

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::{ParameterMap, Reparameterization};

/// Largest hyperbolic angle of an arc: its weights then differ by a factor of at most 1.3.
const LONGEST_HYPERBOLA: f64 = 1.5;

/// A rational Bézier curve at azimuth 0, with the surface's v along it.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    /// Homogeneous control points.
    pub(crate) points: Vec<DVec4>,
    pub(crate) v: ParameterMap,
}

/// Number of arcs for an angle: quarters of a full turn, otherwise arcs of at most 120 degrees.
pub(super) fn arc_count(angle: f64) -> f64 {
    if angle >= TAU { 4.0 } else { (angle / (2.0 * FRAC_PI_3) - f64::EPSILON).ceil().max(1.0) }
}

/// The unit vector at `angle`; exact at quarter turns, so that a full turn ends where it starts and poles lie on the axis.
pub(super) fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = angle.sin_cos();
    // Removes the effect of rounding pi.
    let exact = |x: f64| if x.abs() < 2.0 * f64::EPSILON { 0.0 } else { x };
    DVec2::new(exact(cos), exact(sin))
}

impl Profile {
    /// The straight line between two points; v runs linearly from 0 to 1.
    pub(crate) fn line(start: DVec3, end: DVec3) -> Self {
        Self { points: vec![start.extend(1.0), end.extend(1.0)], v: ParameterMap::UNIT }
    }

    /// Arcs of the circle about (`middle`, 0) in the plane of radius and z, between two angles (radians, towards +z); v is
    /// proportional to the angle, from 0 to 1.
    pub(crate) fn circle(middle: f64, radius: f64, [from, to]: [f64; 2]) -> Vec<Self> {
        let count = arc_count(to - from);
        let half = 0.5 * (to - from) / count;
        let (c, angle) = (half.cos(), |k: f64| direction(from + (to - from) * (k / count)));
        let end = |d: DVec2| DVec4::new(middle + radius * d.x, 0.0, radius * d.y, 1.0);
        let corner = |d: DVec2| DVec4::new(middle * c + radius * d.x, 0.0, radius * d.y, c);
        let arc = |k: f64| Self {
            points: vec![end(angle(k)), corner(angle(k + 0.5)), end(angle(k + 1.0))],
            v: ParameterMap {
                ends: [k / count, (k + 1.0) / count],
                reparameterization: Reparameterization::Circular(half),
            },
        };
        (0..count as u32).map(|k| arc(k.into())).collect()
    }

    /// The parabola `rho^2 = rise z` between two distances from the axis; v is proportional to z, from 0 to 1.
    pub(crate) fn parabola(rise: f64, [inner, outer]: [f64; 2]) -> Self {
        let point = |rho: f64, product: f64| DVec4::new(rho, 0.0, product / rise, 1.0);
        let middle = point(0.5 * (inner + outer), inner * outer);
        // rho = inner + (outer - inner) y, and v is linear in rho^2.
        let k = (outer - inner) / (outer + inner);
        Self {
            points: vec![point(inner, inner * inner), middle, point(outer, outer * outer)],
            v: ParameterMap { ends: [0.0, 1.0], reparameterization: Reparameterization::Quadratic(k) },
        }
    }

    /// Arcs of the hyperbola `(a sinh |s|, c cosh s)`, on the lower sheet if not `upper`, between two values of s of the same sign,
    /// with v from `ends[0]` to `ends[1]`.
    pub(crate) fn hyperbola(
        [a, c]: [f64; 2],
        upper: bool,
        [from, to]: [f64; 2],
        ends: [f64; 2],
    ) -> Vec<Self> {
        let count = ((to - from) / LONGEST_HYPERBOLA).ceil().max(1.0);
        let half = 0.5 * (to - from) / count;
        let side = if upper { 1.0 } else { -1.0 };
        let mix = |[low, high]: [f64; 2], k: f64| low + (high - low) * (k / count);
        let point = |s: f64, weight: f64| DVec4::new(a * side * s.sinh(), 0.0, c * side * s.cosh(), weight);
        let arc = |k: f64| Self {
            points: vec![
                point(mix([from, to], k), 1.0),
                point(mix([from, to], k + 0.5), half.cosh()),
                point(mix([from, to], k + 1.0), 1.0),
            ],
            v: ParameterMap {
                ends: [mix(ends, k), mix(ends, k + 1.0)],
                reparameterization: Reparameterization::Hyperbolic(half),
            },
        };
        (0..count as u32).map(|k| arc(k.into())).collect()
    }
}
