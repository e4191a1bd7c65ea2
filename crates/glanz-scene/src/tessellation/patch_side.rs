//! The curves of the sides of patches.

use glanz_geometry::spline::KnotVector;
use glanz_math::Transform;
use glanz_math::glam::DVec4;

/// The curve of a side, by which neighbours are recognised.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct PatchSide {
    /// Homogeneous control points.
    points: Vec<[u64; 4]>,
    /// Inner knots, as multiples of a small part of the domain: those of the reversed curve are then as exact.
    knots: Vec<u64>,
}

/// The domain in the units of knots.
const DOMAIN: u64 = 1 << 48;

impl PatchSide {
    /// The curve of these homogeneous control points and inner knots, fractions of the domain.
    pub(super) fn new(points: impl IntoIterator<Item = DVec4>, knots: Vec<f64>) -> Self {
        // Both zeros are the same.
        let bits = |x: f64| (x + 0.0).to_bits();
        Self {
            points: points.into_iter().map(|p| p.to_array().map(bits)).collect(),
            knots: knots.into_iter().map(|knot| (knot * DOMAIN as f64).round() as u64).collect(),
        }
    }

    /// The same curve from its end to its start.
    pub(super) fn reversed(&self) -> Self {
        let points = self.points.iter().rev().copied().collect();
        let knots = self.knots.iter().rev().map(|&knot| DOMAIN.saturating_sub(knot));
        Self { points, knots: knots.collect() }
    }

    /// The same curve in the frame of the group.
    pub(super) fn moved(&self, to_group: &Transform) -> Self {
        let matrix = to_group.forward();
        let points = self.points.iter().map(|&point| {
            let p = DVec4::from_array(point.map(f64::from_bits));
            (matrix.matrix3 * p.truncate() + matrix.translation * p.w).extend(p.w)
        });
        Self { knots: self.knots.clone(), ..Self::new(points, Vec::new()) }
    }
}

/// The inner knots as fractions of the domain.
pub(super) fn inner_fractions(knots: &KnotVector) -> Vec<f64> {
    let [from, to] = knots.domain();
    knots.inner().iter().map(|knot| (knot - from) / (to - from)).collect()
}
