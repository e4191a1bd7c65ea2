//! Estimates of the light that arrives at a point.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_math::DVec3;

use crate::interaction::LightSampleContext;
use crate::light::extent::{DirectionCone, EmissionBounds};

/// Cosines below zero, or below that of the widest angle, by no more than this count as the limit: the sine of a cosine that was rounded near 1
/// has an error up to the root of twice the rounding error, 2e-8, and four are added.
const ROUNDING: f64 = 1e-7;

/// Smallest squared distance, m^2: estimates of spectra in single precision stay finite.
const NEAREST: f64 = f32::MIN_POSITIVE as f64;

/// The sine and cosine of an angle in [0, pi].
#[derive(Clone, Copy, Debug)]
struct Angle {
    sin: f64,
    cos: f64,
}

impl Angle {
    fn new(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { sin, cos }
    }

    #[inline]
    fn from_cos(cos: f64) -> Self {
        Self { sin: (1.0 - cos * cos).max(0.0).sqrt(), cos }
    }

    /// The angle up to pi / 2 of a sine.
    #[inline]
    fn from_sin(sin: f64) -> Self {
        Self { sin, cos: (1.0 - sin * sin).max(0.0).sqrt() }
    }

    /// The angle of the cosine `cos` less `other`, not below zero. Without a root where that is zero, as for most lights.
    #[inline]
    fn beyond(cos: f64, other: Self) -> Self {
        if cos >= other.cos { Self { sin: 0.0, cos: 1.0 } } else { Self::from_cos(cos).less(other) }
    }

    /// The angle less `other`, not below zero.
    #[inline]
    fn less(self, other: Self) -> Self {
        if self.cos >= other.cos {
            return Self { sin: 0.0, cos: 1.0 };
        }
        Self {
            sin: self.sin * other.cos - self.cos * other.sin,
            cos: self.cos * other.cos + self.sin * other.sin,
        }
    }
}

/// Lights in a box, in the form in which their importance is evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightCluster {
    /// Middle of the box, metres.
    center: DVec3,
    /// Of the sphere around the box, metres.
    radius: f64,
    /// Distance from the middle, squared, from which on no light is left.
    reach_squared: f64,
    /// Axis and half angle of the cone of normals.
    axis: DVec3,
    inner: Angle,
    /// Cosine of the widest angle of emission from the normals.
    cos_spread: f64,
    two_sided: bool,
    /// Intensity along the normals, W/sr.
    intensity: f64,
}

impl LightCluster {
    /// Lights of a total `power`, W.
    pub(super) fn new(extent: &EmissionBounds, power: f64) -> Self {
        let radius = 0.5 * extent.bounds.diagonal().length();
        let reach = extent.range + radius;
        Self {
            center: extent.bounds.center(),
            radius,
            reach_squared: reach * reach,
            axis: extent.normals.axis,
            inner: Angle::new(extent.normals.half_angle),
            cos_spread: extent.spread.cos(),
            two_sided: extent.two_sided,
            intensity: power / extent.solid_angle(),
        }
    }

    /// Estimate of the irradiance, W/m^2, without occlusion; above 0 wherever light may arrive.
    ///
    /// # Source
    /// @contyestevez2018 section 4.3 as in @pharr2023 section 12.6.3; departure: the shortest distance is the radius of the sphere around the lights.
    #[inline]
    pub(super) fn importance(&self, from: &LightSampleContext) -> f64 {
        let offset = from.position - self.center;
        let distance_squared = offset.length_squared();
        if distance_squared > self.reach_squared {
            return 0.0;
        }
        // Within the sphere, light may come from all directions.
        let radius_squared = self.radius * self.radius;
        if distance_squared <= radius_squared {
            return self.intensity / radius_squared.max(NEAREST);
        }
        let inverse = 1.0 / distance_squared.sqrt();
        let direction = offset * inverse;
        let size = Angle::from_sin(self.radius * inverse);
        let along = self.axis.dot(direction);
        let along = if self.two_sided { along.abs() } else { along };
        let emitted = Angle::beyond(along, self.inner).less(size).cos;
        if emitted < self.cos_spread - ROUNDING {
            return 0.0;
        }
        let received = from.normal.map_or(1.0, |normal| Angle::beyond(-normal.dot(direction), size).cos);
        if received < -ROUNDING {
            return 0.0;
        }
        let falloff = (inverse * inverse).min(1.0 / NEAREST);
        self.intensity * emitted.max(ROUNDING) * received.max(ROUNDING) * falloff
    }
}

/// A light that is infinitely far away, in the form in which its importance is evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct DistantCluster {
    /// Unit direction to its middle.
    towards: DVec3,
    /// Angle of its directions from the middle; `None` if they are a hemisphere or more.
    size: Option<Angle>,
    /// Irradiance on a surface that faces it, or the mean over all surfaces, W/m^2.
    irradiance: f64,
}

impl DistantCluster {
    /// `power`: W through the sphere around the scene with this `radius`, metres.
    pub(super) fn new(directions: &DirectionCone, power: f64, radius: f64) -> Self {
        let fluence = power / (PI * radius * radius);
        let narrow = directions.half_angle < FRAC_PI_2;
        Self {
            towards: directions.axis,
            size: narrow.then(|| Angle::new(directions.half_angle)),
            // A surface receives a quarter of the fluence in the mean over its orientations.
            irradiance: if narrow { fluence } else { 0.25 * fluence },
        }
    }

    /// As [`LightCluster::importance`].
    #[inline]
    pub(super) fn importance(&self, from: &LightSampleContext) -> f64 {
        let (Some(size), Some(normal)) = (self.size, from.normal) else { return self.irradiance };
        let received = Angle::beyond(normal.dot(self.towards), size).cos;
        if received < -ROUNDING { 0.0 } else { self.irradiance * received.max(ROUNDING) }
    }
}
