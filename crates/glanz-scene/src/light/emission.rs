//! Rays that leave lights, for paths that start there, and their densities.

use std::f64::consts::PI;

use glanz_geometry::AreaSample;
use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, Ray, SolidAnglePdf};
use glanz_sampling::warp;

use super::LightId;
use crate::interaction::LightSampleContext;
use crate::scene::Scene;

/// A sampled ray that leaves a light.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// The ray, with a unit direction.
    pub ray: Ray,
    /// Power over density, W: the mean of many is the power of the light; of an infinitely far one, the power that reaches the sphere around
    /// the scene.
    pub power: Spectrum,
    /// The point at which it leaves the light, if that is a surface.
    pub from: Option<AreaSample>,
    /// The range of its light.
    pub range: LightRange,
}

impl LightRay {
    /// A ray that does not leave a surface, of a light without a range.
    pub(super) fn new(ray: Ray, power: Spectrum) -> Self {
        Self { ray, power, from: None, range: LightRange::default() }
    }

    /// Density of the point at which it leaves the light, if that is a surface.
    #[must_use]
    pub fn area_pdf(&self) -> Option<AreaPdf> {
        self.from.map(|from| from.pdf)
    }
}

/// Distance, metres, at which light has faded to nothing, if it does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightRange(pub(super) Option<f64>);

impl LightRange {
    /// Fraction of the power that is left at `distance`, metres, of a light that fades.
    #[must_use]
    pub fn attenuation(self, distance: f64) -> f32 {
        super::point::window(distance, self.0)
    }
}

/// A sphere around all bounded parts of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneSphere {
    center: DVec3,
    radius: f64,
}

impl SceneSphere {
    /// `None` if the scene has no bounded part of an extent.
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        let bounds = scene.bounds();
        let radius = 0.5 * bounds.diagonal().length();
        // Rays along its surface might miss objects that touch it.
        (!bounds.is_empty() && radius > 0.0).then(|| Self { center: bounds.center(), radius: 1.001 * radius })
    }

    /// A ray from its surface towards the disk through its middle that faces `towards`, and the area of that disk, m^2.
    ///
    /// `None` where something unbounded lies between the sphere and the light.
    pub(super) fn sample(&self, scene: &Scene, towards: DVec3, xi: DVec2) -> Option<(Ray, f64)> {
        let disk = self.radius * warp::concentric_disk(xi);
        let origin = self.center + Frame::from_z(towards).to_world(disk.extend(self.radius));
        let is_free = !scene.occluded(&Ray::new(origin, towards), f64::INFINITY);
        is_free.then(|| (Ray::new(origin, -towards), PI * self.radius * self.radius))
    }

    /// Density per square metre across them of the rays of [`SceneSphere::sample`] at `at` that come from `towards`.
    pub(super) fn pdf(&self, at: DVec3, towards: DVec3) -> f64 {
        let offset = at - self.center;
        let along = offset.dot(towards);
        // Rays start at the point of entry into the sphere at the latest; they do not hit anything before it.
        let beside = (offset - along * towards).length_squared();
        let met = along <= self.radius && beside <= self.radius * self.radius;
        if met { 1.0 / (PI * self.radius * self.radius) } else { 0.0 }
    }
}

impl Scene {
    /// Samples a ray that leaves the light `id` by two pairs of numbers uniform in [0, 1): a place, or of a point a direction, and a direction.
    ///
    /// `None` if the light is black there, or where no place can be sampled on it. Of infinitely far lights only rays are sampled that
    /// meet the sphere around the bounded parts of the scene: infinite planes beyond it get none, and occlude what they hide.
    #[inline]
    #[must_use]
    pub fn emit(&self, id: LightId, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let ray = self.light(id)?.emit(self, place, direction);
        ray.filter(|ray| !ray.power.is_black() && ray.power.is_finite())
    }

    /// Density of the rays of [`Scene::emit`] that arrive at `at` (world space, metres) from the unit direction `wi`.
    ///
    /// Of lights that a ray can hit: per square metre across the ray and steradian, the same along all of a ray. Of
    /// others: per square metre across the ray at `at`. `area_pdf`: density of the point on the light,
    /// if that is a surface, as of [`LightSample::area_pdf`](crate::LightSample::area_pdf). 0 where no ray of the light arrives; occlusion
    /// is ignored.
    #[must_use]
    pub fn emission_pdf(&self, id: LightId, at: DVec3, wi: DVec3, area_pdf: Option<AreaPdf>) -> f64 {
        self.light(id).map_or(0.0, |light| light.emission_pdf(self, at, wi, area_pdf))
    }

    /// Density with which [`Scene::sample_light_compensated`] from `from` samples the direction that `ray` came from, which the light `id`
    /// sent; without the probability of the light itself. 1 for lights that no ray can hit.
    #[must_use]
    pub fn light_pdf_of_ray(&self, id: LightId, from: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.light(id).map_or(SolidAnglePdf(0.0), |light| light.pdf_of_ray(from, ray))
    }
}
