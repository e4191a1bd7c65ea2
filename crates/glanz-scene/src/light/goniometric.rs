//! A point with a picture of its intensity.

use std::f64::consts::PI;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DMat3, DVec2, DVec3, Ray};

use super::extent::EmissionBounds;
use super::point::sample_point;
use super::sphere_emission::SphereEmission;
use super::{IncidentLight, LightExtent, LightInput, LightModel, LightRay, LightSample, brightness};
use crate::description::SphereMapping;
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// A point whose intensity in each direction is a picture's.
///
/// # Source
/// @pharr2023 section 12.2.3. Departure: interpolation between pixels.
#[derive(Clone, Debug)]
pub struct GoniometricLight {
    position: DVec3,
    /// W/sr.
    intensity: SphereEmission,
    power: Spectrum,
}

impl GoniometricLight {
    pub(super) fn resolve(
        input: &LightInput<'_>,
        image: usize,
        mapping: SphereMapping,
    ) -> Result<Self, SceneErrorKind> {
        let image = input.sphere_image(image, mapping)?;
        let axes = input.axes("goniometric light: transformation")?;
        // The axis of such pictures is y.
        let axes = DMat3::from_cols(axes.x_axis, axes.z_axis, axes.y_axis);
        let intensity = SphereEmission::new(image, input.emission, axes);
        let power = intensity.mean() * (4.0 * PI) as f32;
        Ok(Self { position: input.to_world.point(DVec3::ZERO), intensity, power })
    }

    /// Total power, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// Its position, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Intensity in a unit direction, W/sr.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Spectrum {
        self.intensity.light(direction)
    }
}

impl LightModel for GoniometricLight {
    const KIND: &'static str = "goniometric";

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power)
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        LightExtent::Bounded(EmissionBounds::point(self.position))
    }

    fn sample(&self, _: &Scene, from: &Interaction, _: DVec2) -> Option<LightSample> {
        sample_point(from, self.position, |direction, _| self.intensity(direction))
    }

    /// Directions in proportion to the intensity.
    fn emit(&self, _: &Scene, _: DVec2, direction: DVec2) -> Option<LightRay> {
        let (way, intensity, pdf) = self.intensity.sample(direction)?;
        Some(LightRay::new(Ray::new(self.position, way), intensity * (1.0 / pdf.0) as f32))
    }

    fn emission_pdf(&self, _: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        self.intensity.pdf(-wi).0 / (at - self.position).length_squared()
    }

    fn incident(&self, point: DVec3) -> Option<IncidentLight> {
        IncidentLight::from_position(self.position, point, |direction, _| self.intensity(direction))
    }
}
