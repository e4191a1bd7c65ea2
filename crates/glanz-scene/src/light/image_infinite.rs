//! Light from all directions by a picture.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DMat3, DVec2, DVec3, SolidAnglePdf};

use super::emission::SceneSphere;
use super::photometric::{luminaire_axes, uneven};
use super::sphere_density::SphereDensity;
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
    image: SphereImage,
    /// Factor on the picture.
    emission: Spectrum,
    /// The axes of the picture in the world; orthonormal, perhaps mirrored.
    axes: DMat3,
    mean: Spectrum,
    /// Densities for samples alone and for those that are combined with others; `None` if the light is black.
    densities: Option<Arc<[SphereDensity; 2]>>,
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
        let (axes, _) =
            luminaire_axes(&input.to_world).ok_or_else(|| uneven("infinite light: transformation"))?;
        let emission = input.emission;
        let densities = SphereDensity::with_compensation(&image, |rgb| brightness_of(rgb, emission));
        let mean = emission * Spectrum::from_rgb(image.mean());
        Ok(Self { image, emission, axes, mean, densities: densities.map(Arc::new) })
    }

    /// Mean radiance over all directions, W/(m^2 sr).
    #[must_use]
    pub fn mean_radiance(&self) -> Spectrum {
        self.mean
    }

    /// W/(m^2 sr) from the direction `wi`, of any length.
    #[must_use]
    pub fn radiance(&self, wi: DVec3) -> Spectrum {
        self.radiance_of(self.axes.transpose() * wi.normalize())
    }

    fn radiance_of(&self, local: DVec3) -> Spectrum {
        self.emission * Spectrum::from_rgb(self.image.lookup(local))
    }

    /// Density with which a sample has the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, wi: DVec3) -> SolidAnglePdf {
        self.density_at(wi, |[complete, _]| complete)
    }

    /// Density with which a sample of [`Scene::sample_light_compensated`] has the unit direction `wi`.
    #[must_use]
    pub fn compensated_pdf(&self, wi: DVec3) -> SolidAnglePdf {
        self.density_at(wi, |[_, compensated]| compensated)
    }

    fn density_at(&self, wi: DVec3, pick: fn(&[SphereDensity; 2]) -> &SphereDensity) -> SolidAnglePdf {
        let densities = self.densities.as_deref().map(pick);
        densities.map_or(SolidAnglePdf(0.0), |density| density.pdf(self.axes.transpose() * wi))
    }

    fn sample_density(&self, density: &SphereDensity, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        let (local, pdf) = density.sample(xi);
        let wi = self.axes * local;
        (pdf.0 > 0.0).then(|| LightSample {
            wi,
            radiance: self.radiance_of(local),
            pdf,
            is_delta: false,
            shadow: from.spawn(wi),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }
}

/// Mean over the bands of a colour in linear Rec. 709 times `emission`.
pub(super) fn brightness_of(rgb: [f64; 3], emission: Spectrum) -> f32 {
    brightness(emission * Spectrum::from_rgb(rgb.map(|x| x as f32))) as f32
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
        let [complete, _] = self.densities.as_deref()?;
        self.sample_density(complete, from, xi)
    }

    fn sample_compensated(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        let [_, compensated] = self.densities.as_deref()?;
        self.sample_density(compensated, from, xi)
    }

    /// Directions in proportion to the picture.
    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let [complete, _] = self.densities.as_deref()?;
        let (local, pdf) = complete.sample(direction);
        let (ray, area) = SceneSphere::new(scene)?.sample(scene, self.axes * local, place)?;
        Some(LightRay::new(ray, self.radiance_of(local) * (area / pdf.0) as f32))
    }

    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        SceneSphere::new(scene).map_or(0.0, |sphere| self.pdf(wi).0 * sphere.pdf(at, wi))
    }

    fn pdf_of_ray(&self, _: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.compensated_pdf(-ray.ray.direction)
    }
}
