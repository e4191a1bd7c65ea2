//! Light from all directions by a picture.

use std::f64::consts::PI;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, SolidAnglePdf};

use super::emission::SceneSphere;
use super::sphere_emission::SphereEmission;
use super::{LightInput, LightModel, LightRay, LightSample, SphereImage, brightness};
use crate::description::SphereMapping;
use crate::error::SceneErrorKind;
use crate::interaction::{Interaction, LightSampleContext};
use crate::scene::Scene;

/// Radiance by direction from infinitely far, by a picture.
///
/// # Source
/// @pharr2023 section 12.5.2; sampling for combined estimators by @karlik2019.
#[derive(Clone, Debug)]
pub struct ImageInfiniteLight {
    /// Radiance, sampled for estimators of light samples alone.
    complete: SphereEmission,
    /// The same radiance, sampled for those that combine them with others.
    compensated: SphereEmission,
    mean: Spectrum,
}

impl ImageInfiniteLight {
    pub(super) fn resolve(
        input: &LightInput<'_>,
        image: usize,
        mapping: SphereMapping,
    ) -> Result<Self, SceneErrorKind> {
        Self::try_new(input, input.sphere_image(image, mapping)?)
    }

    /// The light of a picture that the emission of `input` multiplies.
    pub(super) fn try_new(input: &LightInput<'_>, image: SphereImage) -> Result<Self, SceneErrorKind> {
        let axes = input.axes("infinite light: transformation")?;
        let complete = SphereEmission::new(image, input.emission, axes);
        Ok(Self { mean: complete.mean(), compensated: complete.compensated(), complete })
    }

    /// Mean radiance over all directions, W/(m^2 sr).
    #[must_use]
    pub fn mean_radiance(&self) -> Spectrum {
        self.mean
    }

    /// W/(m^2 sr) from the direction `wi`, of any length.
    #[must_use]
    pub fn radiance(&self, wi: DVec3) -> Spectrum {
        self.complete.light(wi.normalize())
    }

    /// Density with which a sample has the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, wi: DVec3) -> SolidAnglePdf {
        self.complete.pdf(wi)
    }

    /// Density with which a sample of [`Scene::sample_light_compensated`] has the unit direction `wi`.
    #[must_use]
    pub fn compensated_pdf(&self, wi: DVec3) -> SolidAnglePdf {
        self.compensated.pdf(wi)
    }
}

/// A sample of the light that arrives at `from`.
fn light_sample(radiance: &SphereEmission, from: &Interaction, xi: DVec2) -> Option<LightSample> {
    let (wi, radiance, pdf) = radiance.sample(xi)?;
    let (shadow, t_max) = (from.spawn(wi), f64::INFINITY);
    Some(LightSample { wi, radiance, pdf, is_delta: false, shadow, t_max, area_pdf: None })
}

impl LightModel for ImageInfiniteLight {
    const KIND: &'static str = "infinite";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn importance(&self, radius: f64) -> f64 {
        let disk = PI * radius * radius;
        brightness(self.mean) * PI * 4.0 * disk
    }

    fn sample(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        light_sample(&self.complete, from, xi)
    }

    fn sample_compensated(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        light_sample(&self.compensated, from, xi)
    }

    /// Directions in proportion to the picture.
    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let (towards, radiance, pdf) = self.complete.sample(direction)?;
        let (ray, area) = SceneSphere::new(scene)?.sample(scene, towards, place)?;
        Some(LightRay::new(ray, radiance * (area / pdf.0) as f32))
    }

    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        SceneSphere::new(scene).map_or(0.0, |sphere| self.pdf(wi).0 * sphere.pdf(at, wi))
    }

    fn pdf_of_ray(&self, _: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.compensated_pdf(-ray.ray.direction)
    }
}
