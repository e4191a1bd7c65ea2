//! Point light.

use std::f64::consts::{FRAC_1_PI, PI};

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Ray, SolidAnglePdf};
use glanz_sampling::warp;

use super::extent::EmissionBounds;
use super::{
    IncidentLight, LightExtent, LightInput, LightModel, LightRange, LightRay, LightSample, brightness,
    range_error,
};
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// A point that emits alike in all directions, W/sr.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    position: DVec3,
    intensity: Spectrum,
    range: Option<f64>,
}

impl PointLight {
    /// `range`: distance, metres, at which the light has faded to nothing, if it does.
    #[must_use]
    pub fn new(position: DVec3, intensity: Spectrum, range: Option<f64>) -> Self {
        Self { position, intensity, range }
    }

    /// Total power, W, without the fading by range.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.intensity * (4.0 * PI) as f32
    }

    /// W/sr in every direction.
    #[must_use]
    pub fn intensity(&self) -> Spectrum {
        self.intensity
    }

    /// Its position, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Distance at which it has faded to nothing, metres, if it does.
    #[must_use]
    pub fn range(&self) -> Option<f64> {
        self.range
    }

    /// `from`: in the frame of the light.
    pub(super) fn resolve(
        input: &LightInput<'_>,
        from: DVec3,
        range: Option<f64>,
    ) -> Result<Self, SceneErrorKind> {
        match range {
            Some(range) if range.is_nan() || range <= 0.0 => {
                Err(range_error("point light: range", range, "positive"))
            }
            _ => Ok(Self::new(input.to_world.point(from), input.emission, range)),
        }
    }
}

impl LightModel for PointLight {
    const KIND: &'static str = "point";

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power())
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        let range = self.range.unwrap_or(f64::INFINITY);
        LightExtent::Bounded(EmissionBounds { range, ..EmissionBounds::point(self.position) })
    }

    fn sample(&self, _: &Scene, from: &Interaction, _: DVec2) -> Option<LightSample> {
        sample_point(from, self.position, |_, distance| self.intensity * window(distance, self.range))
    }

    fn emit(&self, _: &Scene, _: DVec2, direction: DVec2) -> Option<LightRay> {
        let ray = Ray::new(self.position, warp::uniform_sphere(direction));
        Some(LightRay { range: LightRange(self.range), ..LightRay::new(ray, self.power()) })
    }

    fn emission_pdf(&self, _: &Scene, at: DVec3, _: DVec3, _: Option<AreaPdf>) -> f64 {
        0.25 * FRAC_1_PI / (at - self.position).length_squared()
    }

    fn incident(&self, point: DVec3) -> Option<IncidentLight> {
        IncidentLight::from_position(self.position, point, |_, distance| {
            self.power() * (window(distance, self.range) / (4.0 * PI) as f32)
        })
    }
}

/// Fraction of light left at `distance` from a light of finite range: `1 - (distance / range)^4`, not below 0.
///
/// # Source
/// @khr_lights_punctual, attenuation by range.
pub(super) fn window(distance: f64, range: Option<f64>) -> f32 {
    range.map_or(1.0, |range| (1.0 - (distance / range).powi(4)).max(0.0) as f32)
}

/// A sample of the point `position` that emits `intensity(direction from the light, distance)`, W/sr.
pub(super) fn sample_point(
    from: &Interaction,
    position: DVec3,
    intensity: impl Fn(DVec3, f64) -> Spectrum,
) -> Option<LightSample> {
    let offset = position - from.point.position;
    let distance = offset.length();
    if distance.is_nan() || distance <= 0.0 {
        return None;
    }
    let wi = offset / distance;
    let radiance = intensity(-wi, distance) * (1.0 / (distance * distance)) as f32;
    if radiance.is_black() || !radiance.is_finite() {
        return None;
    }
    let shadow = from.spawn_to(position, None);
    Some(LightSample {
        wi,
        radiance,
        pdf: SolidAnglePdf(1.0),
        is_delta: true,
        shadow,
        t_max: 1.0,
        area_pdf: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_ends_at_the_range() {
        assert_eq!(window(3.0, None), 1.0);
        assert_eq!(window(0.0, Some(2.0)), 1.0);
        assert_eq!(window(1.0, Some(2.0)), 0.9375);
        assert_eq!(window(2.0, Some(2.0)), 0.0);
        assert_eq!(window(9.0, Some(2.0)), 0.0);
    }
}
