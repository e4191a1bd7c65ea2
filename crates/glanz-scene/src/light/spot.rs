//! Spot light.

use std::f64::consts::PI;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, Ray};
use glanz_sampling::warp;

use super::extent::{DirectionCone, EmissionBounds};
use super::point::sample_point;
use super::{
    IncidentLight, LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, range_error,
};
use crate::description::SpotFalloff;
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// A point that emits into a cone, W/sr.
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

    /// `from`, `to`: in the frame of the light; `cone_angle`, `inner_angle`: half angles, radians.
    pub(super) fn resolve(
        input: &LightInput<'_>,
        [from, to]: [DVec3; 2],
        [cone_angle, inner_angle]: [f64; 2],
        falloff: SpotFalloff,
    ) -> Result<Self, SceneErrorKind> {
        let axis = input
            .to_world
            .vector(to - from)
            .try_normalize()
            .ok_or_else(|| range_error("spot light: to", to, "different from its position"))?;
        if !(cone_angle > 0.0 && cone_angle <= PI) {
            let degrees = cone_angle.to_degrees();
            return Err(range_error("spot light: cone angle", degrees, "above 0 and at most 180"));
        }
        let angles = [cone_angle, inner_angle.clamp(0.0, cone_angle)];
        Ok(Self::new(input.to_world.point(from), axis, angles, falloff, input.emission))
    }

    /// Total power, W.
    ///
    /// The falloff as a function of the linear fraction x of the cosine has the mean 1/5 for x^4 and 1/2 for the
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

    /// Its position, metres.
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

    /// Cosine of the half angle inside which the intensity is constant.
    #[must_use]
    pub fn cos_inner(&self) -> f64 {
        self.cos_inner
    }

    /// Intensity in a unit direction, W/sr.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Spectrum {
        self.intensity * self.attenuation(direction.dot(self.axis))
    }

    /// Fraction of the intensity sent under the cosine `cos` to the axis.
    fn attenuation(&self, cos: f64) -> f32 {
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

impl LightModel for SpotLight {
    const KIND: &'static str = "spot";

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power())
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        let inner = DirectionCone { axis: self.axis, half_angle: self.cos_inner.acos() };
        LightExtent::Bounded(EmissionBounds::beam(self.position, inner, self.cos_outer.acos()))
    }

    fn sample(&self, _: &Scene, from: &Interaction, _: DVec2) -> Option<LightSample> {
        sample_point(from, self.position, |direction, _| self.intensity(direction))
    }

    /// Directions uniform in the cone.
    fn emit(&self, _: &Scene, _: DVec2, direction: DVec2) -> Option<LightRay> {
        let one_minus_cos = 1.0 - self.cos_outer;
        let local = warp::uniform_cone(direction, one_minus_cos);
        let pdf = warp::uniform_cone_pdf(one_minus_cos);
        let ray = Ray::new(self.position, Frame::from_z(self.axis).to_world(local));
        let power = self.intensity(ray.direction) * (1.0 / pdf.0) as f32;
        (one_minus_cos > 0.0).then(|| LightRay::new(ray, power))
    }

    fn emission_pdf(&self, _: &Scene, at: DVec3, _: DVec3, _: Option<AreaPdf>) -> f64 {
        let offset = at - self.position;
        let distance_squared = offset.length_squared();
        if offset.dot(self.axis) < self.cos_outer * distance_squared.sqrt() {
            return 0.0;
        }
        warp::uniform_cone_pdf(1.0 - self.cos_outer).0 / distance_squared
    }

    fn incident(&self, point: DVec3) -> Option<IncidentLight> {
        IncidentLight::from_position(self.position, point, |direction, _| self.intensity(direction))
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
                (0..n).map(|i| f64::from(spot.attenuation(1.0 - (f64::from(i) + 0.5) / f64::from(n)))).sum();
            let integral = 2.0 * PI * sum / f64::from(n);
            assert!((f64::from(spot.power().max_component()) - integral).abs() < 1e-4);
        }
    }

    #[test]
    fn sharp_cone_has_no_border_to_divide_by() {
        let spot = SpotLight::new(DVec3::ZERO, DVec3::Z, [0.5, 0.5], SpotFalloff::Smoothstep, Spectrum::ONE);
        assert_eq!(spot.attenuation(0.49_f64.cos()), 1.0);
        assert_eq!(spot.attenuation(0.51_f64.cos()), 0.0);
    }
}
