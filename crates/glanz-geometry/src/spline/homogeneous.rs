//! Points with a weight: (w x, w y, w z, w), w > 0.

use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec3};

use crate::error::{SurfaceError, finite, positive};

/// The point in space, metres.
#[inline]
pub(crate) fn project(point: DVec4) -> DVec3 {
    point.truncate() / point.w
}

/// Points in space with their weights.
///
/// # Errors
/// Lists of different lengths.
pub(crate) fn with_weights(points: &[DVec3], weights: &[f64]) -> Result<Vec<DVec4>, SurfaceError> {
    if weights.len() != points.len() {
        let (count, expected) = (weights.len(), points.len());
        return Err(SurfaceError::CountMismatch { parameter: "weights", count, expected });
    }
    Ok(points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w)).collect())
}

/// # Errors
/// The wrong number of points, coordinates that are not finite, weights that are not positive.
pub(crate) fn check(points: &[DVec4], expected: usize) -> Result<(), SurfaceError> {
    if points.len() != expected {
        let (parameter, count) = ("control points", points.len());
        return Err(SurfaceError::CountMismatch { parameter, count, expected });
    }
    for point in points {
        positive("weight", point.w)?;
        for value in point.truncate().to_array() {
            finite("control point", value)?;
            finite("control point over its weight", value / point.w)?;
        }
    }
    Ok(())
}

/// Bound on the distance between the points at equal parameters of two splines over the same knots, metres.
///
/// With numerators A, A' and weights w, w' the difference is `(A - A' + (A'/w') (w' - w)) / w`. Differences of splines
/// stay below those of their control points, A'/w' stays within the hull of its control points, and w above its
/// least coefficient. Everything is seen from the middle of the points, so that the bound does not depend on where
/// they are.
pub(crate) fn deviation(before: &[DVec4], after: &[DVec4]) -> f64 {
    let bounds = Bounds3::of_points(after.iter().map(|p| project(*p)));
    let (center, radius) = (bounds.center(), bounds.min.distance(bounds.max) * 0.5);
    let least = before.iter().fold(f64::INFINITY, |w, p| w.min(p.w));
    let moved = before.iter().zip(after).map(|(a, b)| {
        let d = *a - *b;
        (d.truncate() - center * d.w).length() + radius * d.w.abs()
    });
    moved.fold(0.0, f64::max) / least
}

/// Binomial coefficient n over k, exact up to n = 50.
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}
