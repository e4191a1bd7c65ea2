//! Selection of the lights of a scene, their samples and their radiance.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Ray, SolidAnglePdf};

use super::Scene;
use crate::interaction::{Interaction, LightSampleContext};
use crate::light::{Light, LightId, LightSample, MAX_LIGHT_GROUPS, SelectedLight};

impl Scene {
    /// The light `id`.
    #[must_use]
    pub fn light(&self, id: LightId) -> Option<&Light> {
        self.lights.get(id.0 as usize)
    }

    /// Radiance that the surface at `at` emits towards `direction`.
    #[must_use]
    pub fn emitted(&self, at: &Interaction, direction: DVec3) -> Spectrum {
        match at.light.and_then(|id| self.light(id)) {
            Some(Light::Area(light)) => light.emitted(at.point.normal, at.point.uv, direction),
            _ => Spectrum::BLACK,
        }
    }

    /// Selects a light to sample from a point by a number uniform in [0, 1).
    ///
    /// `None` if no light can be sampled, or if none can arrive.
    #[inline]
    #[must_use]
    pub fn select_light(&self, from: &LightSampleContext, xi: f64) -> Option<SelectedLight> {
        self.light_tree.select(from, xi)
    }

    /// The probability with which [`Scene::select_light`] selects the light `id` from a point.
    ///
    /// 0 only if its light cannot arrive there, or if it cannot be sampled; occlusion is ignored.
    #[inline]
    #[must_use]
    pub fn light_probability(&self, id: LightId, from: &LightSampleContext) -> f64 {
        self.light_tree.probability(id, from)
    }

    /// Whether [`Scene::select_light`] selects the light `id` from any point.
    #[must_use]
    pub fn is_selectable(&self, id: LightId) -> bool {
        self.light_tree.contains(id)
    }

    /// Selects a light for [`Scene::emit`] by a number uniform in [0, 1); returns it with its probability.
    ///
    /// Lights are selected by power, also those that cannot be sampled from a surface. `None` if no light has a known power.
    #[must_use]
    pub fn select_emitter(&self, xi: f64) -> Option<(LightId, f64)> {
        self.emitters.select(xi)
    }

    /// The light that [`Scene::select_emitter`] always selects, if there is only one.
    #[must_use]
    pub fn only_emitter(&self) -> Option<LightId> {
        self.emitters.only()
    }

    /// The probability with which [`Scene::select_emitter`] selects the light `id`.
    #[must_use]
    pub fn emitter_probability(&self, id: LightId) -> f64 {
        self.emitters.probability(id)
    }

    /// Number of groups of lights, at most [`MAX_LIGHT_GROUPS`], from which a guide can select first. Every light that can be sampled is in one of
    /// them; lights of a group are near one another.
    #[must_use]
    pub fn light_group_count(&self) -> usize {
        self.light_tree.group_count()
    }

    /// The group of the light `id`; `None` if it cannot be sampled.
    #[must_use]
    pub fn light_group(&self, id: LightId) -> Option<usize> {
        self.light_tree.group(id)
    }

    /// The probabilities with which [`Scene::select_light`] selects a light of each group from a point: 0 where no light of a group can arrive.
    #[inline]
    #[must_use]
    pub fn light_group_probabilities(&self, from: &LightSampleContext) -> [f64; MAX_LIGHT_GROUPS] {
        self.light_tree.group_probabilities(from)
    }

    /// As [`Scene::select_light`], with other `probabilities` of the groups, or weights in proportion to them.
    #[inline]
    #[must_use]
    pub fn select_light_by_groups(
        &self,
        from: &LightSampleContext,
        probabilities: &[f64; MAX_LIGHT_GROUPS],
        xi: f64,
    ) -> Option<SelectedLight> {
        self.light_tree.select_by_groups(from, probabilities, xi)
    }

    /// The probability with which [`Scene::select_light_by_groups`] selects the light `id`.
    #[inline]
    #[must_use]
    pub fn light_probability_by_groups(
        &self,
        id: LightId,
        from: &LightSampleContext,
        probabilities: &[f64; MAX_LIGHT_GROUPS],
    ) -> f64 {
        self.light_tree.probability_by_groups(id, from, probabilities)
    }

    /// Samples a direction from `from` towards the light `id` by two numbers uniform in [0, 1).
    #[must_use]
    pub fn sample_light(&self, id: LightId, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        self.light(id)?.sample(self, from, xi)
    }

    /// As [`Scene::sample_light`], for estimators that combine these samples with those of BSDFs: where others find the light as well, the density may
    /// be lower, and 0 where light arrives. [`Scene::compensated_infinite_pdf`] is the density.
    ///
    /// # Source
    /// @karlik2019.
    #[must_use]
    pub fn sample_light_compensated(
        &self,
        id: LightId,
        from: &Interaction,
        xi: DVec2,
    ) -> Option<LightSample> {
        self.light(id)?.sample_compensated(self, from, xi)
    }

    /// Density with which [`Scene::sample_light`] from `from` samples the point `hit` of the light `id`; without the
    /// probability of the light itself.
    #[must_use]
    pub fn light_pdf(&self, id: LightId, from: &LightSampleContext, hit: &Interaction) -> SolidAnglePdf {
        match self.light(id) {
            Some(Light::Area(light)) if light.can_be_sampled() => light.pdf(from, hit),
            _ => SolidAnglePdf(0.0),
        }
    }

    /// The infinite lights, which emit from all directions or those of a cone.
    #[must_use]
    pub fn infinite_lights(&self) -> &[LightId] {
        &self.infinite_lights
    }

    /// Radiance of the infinite light `id` along a ray that left the scene, or the rectangle through which it arrives.
    #[must_use]
    pub fn infinite_radiance(&self, id: LightId, ray: &Ray) -> Spectrum {
        match self.light(id) {
            Some(Light::Infinite(light)) => light.radiance(),
            Some(Light::ImageInfinite(light)) => light.radiance(ray.direction),
            Some(Light::PortalInfinite(light)) => light.radiance(ray.origin, ray.direction),
            Some(Light::Sun(light)) => light.radiance(ray.direction),
            _ => Spectrum::BLACK,
        }
    }

    /// Density with which [`Scene::sample_light`] from `from` samples the unit direction `wi` of the infinite light
    /// `id`; without the probability of the light itself.
    #[must_use]
    pub fn infinite_pdf(&self, id: LightId, from: &LightSampleContext, wi: DVec3) -> SolidAnglePdf {
        match self.light(id) {
            Some(Light::Infinite(light)) => light.pdf(from, wi),
            Some(Light::ImageInfinite(light)) => light.pdf(wi),
            Some(Light::PortalInfinite(light)) => light.pdf(from.position, wi),
            Some(Light::Sun(light)) => light.pdf(wi),
            _ => SolidAnglePdf(0.0),
        }
    }

    /// As [`Scene::infinite_pdf`], of [`Scene::sample_light_compensated`].
    #[must_use]
    pub fn compensated_infinite_pdf(
        &self,
        id: LightId,
        from: &LightSampleContext,
        wi: DVec3,
    ) -> SolidAnglePdf {
        match self.light(id) {
            Some(Light::ImageInfinite(light)) => light.compensated_pdf(wi),
            _ => self.infinite_pdf(id, from, wi),
        }
    }

    /// Radiance of all infinite lights along a ray that left the scene, at `wavelengths`.
    #[must_use]
    pub fn environment_radiance(&self, ray: &Ray, wavelengths: &Wavelengths) -> Spectrum {
        let lights = self.infinite_lights.iter();
        lights.map(|&id| self.light_at(id, self.infinite_radiance(id, ray), wavelengths)).sum()
    }

    /// Light of the light `id`, which the queries of lights give in RGB, at `wavelengths`.
    #[inline]
    #[must_use]
    pub fn light_at(&self, id: LightId, rgb: Spectrum, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Rgb => rgb,
            _ => {
                let spectrum = self.light_spectra.get(id.0 as usize);
                spectrum.map_or_else(
                    || rgb.upsampled_light(wavelengths),
                    |spectrum| spectrum.at(rgb, wavelengths),
                )
            }
        }
    }

    /// Radiance that a camera ray sees where it leaves the scene without being scattered: of the [backdrop](crate::Description::backdrop), or else of
    /// all infinite lights; at `wavelengths`.
    #[must_use]
    pub fn backdrop_radiance(&self, ray: &Ray, wavelengths: &Wavelengths) -> Spectrum {
        match &self.backdrop {
            Some((rgb, spectrum)) => spectrum.at(*rgb, wavelengths),
            None => self.environment_radiance(ray, wavelengths),
        }
    }
}
