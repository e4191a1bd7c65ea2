//! Points of the plane and of space.

use std::fmt::Debug;
use std::ops::{Add, Mul, Sub};

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

/// A point of a plane or of space, with its homogeneous form.
pub trait CurveVector:
    Copy + Debug + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
    /// The point times its weight, with the weight.
    type Homogeneous: Copy
        + Debug
        + PartialEq
        + Add<Output = Self::Homogeneous>
        + Sub<Output = Self::Homogeneous>
        + Mul<f64, Output = Self::Homogeneous>;

    /// The origin.
    const ZERO: Self;

    /// Scalar product.
    #[must_use]
    fn dot(self, other: Self) -> f64;

    /// Whether all coordinates are finite.
    #[must_use]
    fn is_finite(self) -> bool;

    /// The homogeneous point with this numerator (the point times the weight) and weight.
    #[must_use]
    fn with_weight(self, weight: f64) -> Self::Homogeneous;

    /// Numerator and weight of a homogeneous point.
    #[must_use]
    fn split(point: Self::Homogeneous) -> (Self, f64);

    /// The point of a homogeneous one.
    #[must_use]
    fn project(point: Self::Homogeneous) -> Self {
        let (numerator, weight) = Self::split(point);
        // Division by 1 changes no bit, multiplication by the inverse of another weight would.
        if weight == 1.0 { numerator } else { Self::divided(numerator, weight) }
    }

    /// `self / divisor`.
    #[must_use]
    fn divided(self, divisor: f64) -> Self;

    /// Length.
    #[must_use]
    fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Distance from another point.
    #[must_use]
    fn distance_to(self, other: Self) -> f64 {
        (self - other).norm()
    }
}

impl CurveVector for DVec2 {
    type Homogeneous = DVec3;

    const ZERO: Self = Self::ZERO;

    fn dot(self, other: Self) -> f64 {
        Self::dot(self, other)
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    fn with_weight(self, weight: f64) -> DVec3 {
        self.extend(weight)
    }

    fn split(point: DVec3) -> (Self, f64) {
        (point.truncate(), point.z)
    }

    fn divided(self, divisor: f64) -> Self {
        self / divisor
    }
}

impl CurveVector for DVec3 {
    type Homogeneous = DVec4;

    const ZERO: Self = Self::ZERO;

    fn dot(self, other: Self) -> f64 {
        Self::dot(self, other)
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    fn with_weight(self, weight: f64) -> DVec4 {
        self.extend(weight)
    }

    fn split(point: DVec4) -> (Self, f64) {
        (point.truncate(), point.w)
    }

    fn divided(self, divisor: f64) -> Self {
        self / divisor
    }
}
