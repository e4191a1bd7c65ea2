//! Densities of the rays that leave lights, for those who could have found the same path from its other end.

use std::f64::consts::{FRAC_1_PI, PI};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{AreaPdf, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::emission::{Around, LightRay};
use super::{AreaLight, Light, LightId, PhotometricLight, PointLight, SpotLight};
use crate::interaction::Reference;
use crate::scene::Scene;

impl Scene {
    /// Density of the rays of [`Scene::emit`] that arrive at `at` (world space, metres) from the unit direction `wi`.
    ///
    /// Of lights that a ray can meet: per square metre across the ray and steradian, the same along all of a ray. Of
    /// others: per square metre across the ray at `at`. `area_pdf`: density of the place on the light,
    /// if that is a surface, as [`LightSample::area_pdf`](crate::LightSample::area_pdf) tells. 0 where no ray of the light arrives; what
    /// stands between is not looked at.
    #[must_use]
    pub fn emission_pdf(&self, id: LightId, at: DVec3, wi: DVec3, area_pdf: Option<AreaPdf>) -> f64 {
        let far = || Around::of(self).map_or(0.0, |around| around.pdf(at, wi));
        match self.light(id) {
            None => 0.0,
            Some(Light::Point(light)) => light.emission_pdf(at),
            Some(Light::Spot(light)) => light.emission_pdf(at),
            Some(Light::Photometric(light)) => light.emission_pdf(at, wi),
            // Nothing else finds its light: any density will do, as long as it is one.
            Some(Light::Rays(_)) => 1.0,
            Some(Light::Distant(_)) => far(),
            Some(Light::Area(light)) => area_pdf.map_or(0.0, |pdf| light.emission_pdf(pdf)),
            Some(Light::Infinite(_)) => 0.25 * FRAC_1_PI * far(),
        }
    }

    /// Density with which [`Scene::sample_light`] from `from` takes the direction that `ray` came from, which the light `id`
    /// sent; without the probability of the light itself. 1 for those that no ray can meet.
    #[must_use]
    pub fn light_pdf_of_ray(&self, id: LightId, from: &Reference, ray: &LightRay) -> SolidAnglePdf {
        match self.light(id) {
            Some(Light::Area(light)) => match (&ray.from, ray.area_pdf) {
                (Some(point), Some(pdf)) => light.pdf_at(from, point, pdf),
                _ => SolidAnglePdf(0.0),
            },
            Some(Light::Infinite(light)) => light.pdf(from, -ray.ray.direction),
            Some(Light::Point(_) | Light::Spot(_) | Light::Photometric(_) | Light::Distant(_)) => {
                SolidAnglePdf(1.0)
            }
            Some(Light::Rays(_)) | None => SolidAnglePdf(0.0),
        }
    }
}

impl Around {
    /// Density per square metre across them of the rays of [`Around::ray`] that come from `towards`.
    fn pdf(&self, at: DVec3, towards: DVec3) -> f64 {
        let offset = at - self.center;
        let along = offset.dot(towards);
        // Rays begin where they would enter the sphere at the latest; what lies before they do not meet.
        let beside = (offset - along * towards).length_squared();
        let met = along <= self.radius && beside <= self.radius * self.radius;
        if met { 1.0 / (PI * self.radius * self.radius) } else { 0.0 }
    }
}

impl PointLight {
    fn emission_pdf(&self, at: DVec3) -> f64 {
        0.25 * FRAC_1_PI / (at - self.position()).length_squared()
    }
}

impl SpotLight {
    fn emission_pdf(&self, at: DVec3) -> f64 {
        let offset = at - self.position();
        let distance_squared = offset.length_squared();
        if offset.dot(self.axis()) < self.cos_outer() * distance_squared.sqrt() {
            return 0.0;
        }
        warp::uniform_cone_pdf(1.0 - self.cos_outer()).0 / distance_squared
    }
}

impl PhotometricLight {
    /// As if all of it were in its middle: paths weigh their ways by this, which from both ends has to be the same, not exact.
    fn emission_pdf(&self, at: DVec3, wi: DVec3) -> f64 {
        let wavelengths = Wavelengths::default();
        let bright = |light: Spectrum| f64::from(light.mean(&wavelengths));
        let share = bright(self.intensity(-wi)) / bright(self.power());
        let distance_squared = (at - self.center()).length_squared();
        let pdf = share / distance_squared;
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

impl AreaLight {
    /// The cosine of the direction's density is that which makes an area one across the ray.
    fn emission_pdf(&self, area_pdf: AreaPdf) -> f64 {
        let sides = if self.is_two_sided() { 2.0 } else { 1.0 };
        area_pdf.0 * FRAC_1_PI / sides
    }
}
