//! Homogeneous control points: (w x, w y, w z, w), w > 0.

use glanz_math::Bounds3;
use glanz_math::glam::DVec4;

pub(crate) use crate::bezier::homogeneous::{check_points as check, homogeneous_points, project};

/// Bound on the distance between points of equal parameter on two splines over the same knots, metres.
///
/// With numerators A, A' and weights w, w' the difference is `(A - A' + (A'/w') (w' - w)) / w`. A difference of splines is at
/// most the largest difference of their control points, A'/w' lies in the hull of its control points, and w is at least its
/// smallest coefficient. Coordinates are relative to the middle of the points, so that the bound does not depend on their
/// position.
pub(crate) fn deviation(before: &[DVec4], after: &[DVec4]) -> f64 {
    let bounds = Bounds3::from_points(after.iter().map(|p| project(*p)));
    let (center, radius) = (bounds.center(), bounds.min.distance(bounds.max) * 0.5);
    let smallest = before.iter().fold(f64::INFINITY, |w, p| w.min(p.w));
    let moved = before.iter().zip(after).map(|(a, b)| {
        let d = *a - *b;
        (d.truncate() - center * d.w).length() + radius * d.w.abs()
    });
    moved.fold(0.0, f64::max) / smallest
}
