//! Rays that leave lights, for paths that begin there.

use std::f64::consts::PI;

use glanz_geometry::SurfacePoint;
use glanz_light::Spectrum;
use glanz_math::rounding::offset_origin;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, Ray};
use glanz_sampling::warp;

use super::{
    AreaLight, DistantLight, InfiniteLight, Light, LightId, PhotometricLight, PointLight, RayLight, SpotLight,
};
use crate::scene::Scene;

/// A ray that leaves a light, picked at random.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// With a unit direction.
    pub ray: Ray,
    /// What it stands for, W: the mean of many is the power of the light, of that which reaches the sphere around the scene if the light is
    /// infinitely far.
    pub power: Spectrum,
    /// Where it leaves the light, if that is a surface.
    pub from: Option<SurfacePoint>,
    /// Density of that place.
    pub area_pdf: Option<AreaPdf>,
    /// Distance, metres, at which the light has faded to nothing, if it does.
    range: Option<f64>,
}

impl LightRay {
    /// Share of the power that is left at `distance`, metres, of a light that fades.
    #[must_use]
    pub fn left_at(&self, distance: f64) -> f32 {
        super::point::window(distance, self.range)
    }
}

/// A sphere around all of a scene that has an end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

impl Around {
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let bounds = scene.bounds();
        let radius = 0.5 * bounds.diagonal().length();
        // Rays along its surface need not meet what touches it.
        (!bounds.is_empty() && radius > 0.0).then(|| Self { center: bounds.center(), radius: 1.001 * radius })
    }

    /// A ray from its surface towards the disk through its middle that faces `towards`, and the area of that disk, m^2.
    fn ray(&self, towards: DVec3, xi: DVec2) -> (Ray, f64) {
        let disk = self.radius * warp::concentric_disk(xi);
        let frame = Frame::from_z(towards);
        let origin = self.center + frame.to_world(disk.extend(self.radius));
        (Ray::new(origin, -towards), PI * self.radius * self.radius)
    }
}

impl Scene {
    /// Picks a ray that leaves the light `id` by two pairs of numbers uniform in [0, 1): a place, or of a point a direction, and a direction.
    ///
    /// `None` if the light is black there, or where no place can be picked on it. Of lights that are infinitely far only rays are picked that
    /// meet the sphere around what has an end: endless planes beyond it get none, and stop what they hide from it.
    #[must_use]
    pub fn emit(&self, id: LightId, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let ray = match self.light(id)? {
            Light::Point(light) => Some(light.emit(direction)),
            Light::Spot(light) => light.emit(direction),
            Light::Photometric(light) => light.emit(place, direction),
            Light::Rays(light) => light.emit(place.x),
            Light::Distant(light) => light.emit(&Around::of(self)?, place).filter(|ray| self.sees_afar(ray)),
            Light::Area(light) => light.emit(self, place, direction),
            Light::Infinite(light) => {
                light.emit(&Around::of(self)?, place, direction).filter(|ray| self.sees_afar(ray))
            }
        };
        ray.filter(|ray| !ray.power.is_black() && ray.power.is_finite())
    }

    /// Whether nothing endless lies between the sphere around the rest, where the ray begins, and where it comes from.
    fn sees_afar(&self, light: &LightRay) -> bool {
        !self.occluded(&Ray::new(light.ray.origin, -light.ray.direction), f64::INFINITY)
    }
}

impl PointLight {
    fn emit(&self, xi: DVec2) -> LightRay {
        let ray = Ray::new(self.position(), warp::uniform_sphere(xi));
        LightRay { ray, power: self.power(), from: None, area_pdf: None, range: self.range() }
    }
}

impl SpotLight {
    /// Directions uniform in the cone.
    fn emit(&self, xi: DVec2) -> Option<LightRay> {
        let one_minus_cos = 1.0 - self.cos_outer();
        let local = warp::uniform_cone(xi, one_minus_cos);
        let pdf = warp::uniform_cone_pdf(one_minus_cos);
        let ray = Ray::new(self.position(), Frame::from_z(self.axis()).to_world(local));
        let power = self.intensity(ray.direction) * (1.0 / pdf.0) as f32;
        (one_minus_cos > 0.0).then_some(LightRay { ray, power, from: None, area_pdf: None, range: None })
    }
}

impl PhotometricLight {
    /// Directions in proportion to the intensity: all rays carry the same.
    fn emit(&self, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let ray = Ray::new(self.place(place), self.direction(direction)?);
        Some(LightRay { ray, power: self.power(), from: None, area_pdf: None, range: None })
    }
}

impl RayLight {
    fn emit(&self, xi: f64) -> Option<LightRay> {
        Some(LightRay { ray: self.pick(xi)?, power: self.power(), from: None, area_pdf: None, range: None })
    }
}

impl DistantLight {
    fn emit(&self, around: &Around, xi: DVec2) -> Option<LightRay> {
        let (ray, area) = around.ray(self.towards(), xi);
        Some(LightRay {
            ray,
            power: self.irradiance() * area as f32,
            from: None,
            area_pdf: None,
            range: None,
        })
    }
}

impl InfiniteLight {
    fn emit(&self, around: &Around, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let (ray, area) = around.ray(warp::uniform_sphere(direction), place);
        let power = self.radiance() * (4.0 * PI * area) as f32;
        Some(LightRay { ray, power, from: None, area_pdf: None, range: None })
    }
}

impl AreaLight {
    /// Directions by the cosine; of a light with two sides either.
    fn emit(&self, scene: &Scene, place: DVec2, mut direction: DVec2) -> Option<LightRay> {
        let (point, pdf) = scene.world_object(self.object())?.sample(place)?;
        let (mut side, mut sides) = (1.0, 1.0);
        if self.is_two_sided() {
            sides = 2.0;
            let is_back = direction.x >= 0.5;
            side = if is_back { -1.0 } else { 1.0 };
            direction.x = 2.0 * direction.x - f64::from(u8::from(is_back));
        }
        let way = Frame::from_z(side * point.normal).to_world(warp::cosine_hemisphere(direction));
        let power = self.emitted(&point, way) * (PI * sides / pdf.0) as f32;
        let ray = Ray::new(offset_origin(point.position, point.error, point.normal, way), way);
        Some(LightRay { ray, power, from: Some(point), area_pdf: Some(pdf), range: None })
    }
}
