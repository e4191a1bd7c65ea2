//! Axis-aligned bounding boxes.

use crate::DVec3;

/// An axis-aligned box, closed on every side; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds3 {
    /// Smallest coordinates, metres.
    pub min: DVec3,
    /// Largest coordinates, metres.
    pub max: DVec3,
}

impl Bounds3 {
    /// The empty box, the neutral element of [`Bounds3::union`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box between two opposite corners, in any order.
    #[must_use]
    pub fn new(a: DVec3, b: DVec3) -> Self {
        Self { min: a.min(b), max: a.max(b) }
    }

    /// The smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::including)
    }

    /// The smallest box around this box and `point`.
    #[must_use]
    pub fn including(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box around both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether the box contains no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// Whether every coordinate is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Whether `point` lies in the box or on its border.
    #[must_use]
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Middle of the box.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Vector from the smallest to the largest corner.
    #[must_use]
    pub fn diagonal(&self) -> DVec3 {
        self.max - self.min
    }

    /// Area of the six sides, m^2; 0 if empty.
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.diagonal();
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }

    /// The box widened by `margin` (metres) on every side.
    #[must_use]
    pub fn expanded(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// The eight corners; unspecified if the box is empty.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_in_a_union() {
        let b = Bounds3::new(DVec3::new(1.0, 5.0, -1.0), DVec3::ZERO);
        assert_eq!(Bounds3::EMPTY.union(b), b);
        assert!(Bounds3::EMPTY.is_empty());
        assert_eq!(Bounds3::EMPTY.surface_area(), 0.0);
    }

    #[test]
    fn unit_cube_has_six_square_metres() {
        let cube = Bounds3::new(DVec3::ZERO, DVec3::ONE);
        assert_eq!(cube.surface_area(), 6.0);
        assert!(cube.corners().iter().all(|&c| cube.contains(c)));
        assert_eq!(Bounds3::from_points(cube.corners()), cube);
    }
}
