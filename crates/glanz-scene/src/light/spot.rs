//! Spot light.

use std::f64::consts::PI;

use glanz_light::Spectrum;
use glanz_math::DVec3;

use super::LightSample;
use super::point::sample_point;
use crate::description::SpotFalloff;
use crate::interaction::Interaction;

/// A point that shines into a cone, W/sr.
#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    position: DVec3,
    axis: DVec3,
    cos_outer: f64,
    cos_inner: f64,
    falloff: SpotFalloff,
    intensity: Spectrum,
}

impl SpotLight {
    /// `axis`: unit direction of the cone; `outer`, `inner`: half angles, radians, `inner <= outer`.
    #[must_use]
    pub fn new(
        position: DVec3,
        axis: DVec3,
        [outer, inner]: [f64; 2],
        falloff: SpotFalloff,
        intensity: Spectrum,
    ) -> Self {
        Self { position, axis, cos_outer: outer.cos(), cos_inner: inner.cos(), falloff, intensity }
    }

    /// Total power, W.
    ///
    /// The falloff as a function of the linear share x of the cosine has the mean 1/5 for x^4 and 1/2 for the
    /// smooth step.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        let mean = match self.falloff {
            SpotFalloff::Quartic => 0.2,
            SpotFalloff::Smoothstep => 0.5,
        };
        let solid_angle = 2.0 * PI * ((1.0 - self.cos_inner) + (self.cos_inner - self.cos_outer) * mean);
        self.intensity * solid_angle as f32
    }

    pub(super) fn sample(&self, from: &Interaction) -> Option<LightSample> {
        sample_point(from, self.position, |direction, _| self.intensity(direction))
    }

    /// Where it is, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Unit direction of its cone.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// Cosine of the half angle of the cone.
    #[must_use]
    pub fn cos_outer(&self) -> f64 {
        self.cos_outer
    }

    /// Cosine of the half angle inside which it does not fall.
    #[must_use]
    pub fn cos_inner(&self) -> f64 {
        self.cos_inner
    }

    /// What it sends into a unit direction, W/sr.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Spectrum {
        self.intensity * self.share(direction.dot(self.axis))
    }

    /// Share of the intensity sent under the cosine `cos` to the axis.
    fn share(&self, cos: f64) -> f32 {
        if cos <= self.cos_outer {
            return 0.0;
        }
        if cos >= self.cos_inner {
            return 1.0;
        }
        let x = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
        let share = match self.falloff {
            SpotFalloff::Quartic => x.powi(4),
            SpotFalloff::Smoothstep => x * x * (3.0 - 2.0 * x),
        };
        share as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_the_integral_of_the_intensity() {
        for falloff in [SpotFalloff::Quartic, SpotFalloff::Smoothstep] {
            let spot = SpotLight::new(DVec3::ZERO, DVec3::Z, [0.6, 0.4], falloff, Spectrum::ONE);
            // Midpoint rule over the cosine.
            let n = 100_000;
            let sum: f64 =
                (0..n).map(|i| f64::from(spot.share(1.0 - (f64::from(i) + 0.5) / f64::from(n)))).sum();
            let integral = 2.0 * PI * sum / f64::from(n);
            assert!((f64::from(spot.power().max_component()) - integral).abs() < 1e-4);
        }
    }

    #[test]
    fn sharp_cone_has_no_border_to_divide_by() {
        let spot = SpotLight::new(DVec3::ZERO, DVec3::Z, [0.5, 0.5], SpotFalloff::Smoothstep, Spectrum::ONE);
        assert_eq!(spot.share(0.49_f64.cos()), 1.0);
        assert_eq!(spot.share(0.51_f64.cos()), 0.0);
    }
}
