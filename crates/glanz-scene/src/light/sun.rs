//! Light from a disk on the sky.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, SolidAnglePdf};
use glanz_sampling::warp;

use super::emission::SceneSphere;
use super::extent::DirectionCone;
use super::{LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, range_error};
use crate::error::SceneErrorKind;
use crate::interaction::{Interaction, LightSampleContext};
use crate::object::SceneObject;
use crate::scene::Scene;

/// The same radiance from all directions of a cone.
#[derive(Clone, Copy, Debug)]
pub struct SunLight {
    frame: Frame,
    /// 1 - cos of the angular radius.
    one_minus_cos: f64,
    irradiance: Spectrum,
    radiance: Spectrum,
}

impl SunLight {
    /// `towards`: unit direction to its middle; `angular_radius`: half angle of the cone, radians, in (0, pi / 2]; `irradiance`: W/m^2 on a
    /// surface that faces it.
    #[must_use]
    pub fn new(towards: DVec3, angular_radius: f64, irradiance: Spectrum) -> Self {
        let sin = angular_radius.sin();
        // Irradiance is the integral of radiance times cosine over the cone: pi sin^2.
        let radiance = irradiance * (1.0 / (PI * sin * sin)) as f32;
        let one_minus_cos = warp::one_minus_cos(sin * sin);
        Self { frame: Frame::from_z(towards), one_minus_cos, irradiance, radiance }
    }

    /// W/m^2 on a surface that faces the middle.
    #[must_use]
    pub fn irradiance(&self) -> Spectrum {
        self.irradiance
    }

    /// Unit direction to the middle.
    #[must_use]
    pub fn towards(&self) -> DVec3 {
        self.frame.z
    }

    /// W/(m^2 sr) from the direction `wi`, of any length.
    #[must_use]
    pub fn radiance(&self, wi: DVec3) -> Spectrum {
        if self.covers(wi.normalize()) { self.radiance } else { Spectrum::BLACK }
    }

    /// Density with which a sample has the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, wi: DVec3) -> SolidAnglePdf {
        if self.covers(wi) { warp::uniform_cone_pdf(self.one_minus_cos) } else { SolidAnglePdf(0.0) }
    }

    /// Whether the unit direction `wi` lies in the cone.
    fn covers(&self, wi: DVec3) -> bool {
        // The squared distance of two unit vectors is 2 (1 - cos), precise also for small angles.
        wi.distance_squared(self.frame.z) <= 2.0 * self.one_minus_cos
    }

    /// `from`, `to`: in the frame of the light; `angular_radius`: radians.
    pub(super) fn resolve(
        input: &LightInput<'_>,
        [from, to]: [DVec3; 2],
        angular_radius: f64,
    ) -> Result<Self, SceneErrorKind> {
        let towards = input.to_world.vector(from - to).try_normalize();
        let towards = towards.ok_or_else(|| range_error("sun: from", from, "different from to"))?;
        if !(angular_radius > 0.0 && angular_radius <= FRAC_PI_2) {
            let degrees = angular_radius.to_degrees();
            return Err(range_error("sun: angular radius", degrees, "between 0 and 90 degrees"));
        }
        let light = Self::new(towards, angular_radius, input.emission);
        if !light.radiance.is_finite() || light.one_minus_cos <= 0.0 {
            let range = "so large that the radiance is finite; use a light of the kind \"distant\"";
            return Err(range_error("sun: angular radius", format!("{angular_radius:e} radians"), range));
        }
        Ok(light)
    }
}

impl LightModel for SunLight {
    const KIND: &'static str = "sun";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn importance(&self, radius: f64) -> f64 {
        brightness(self.irradiance) * (PI * radius * radius)
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        // The chord of the cone is precise also where it is narrow.
        let half_angle = 2.0 * (0.5 * self.one_minus_cos).sqrt().min(1.0).asin();
        LightExtent::Distant(DirectionCone { axis: self.frame.z, half_angle })
    }

    fn sample(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        let wi = self.frame.to_world(warp::uniform_cone(xi, self.one_minus_cos));
        Some(LightSample {
            wi,
            radiance: self.radiance,
            pdf: warp::uniform_cone_pdf(self.one_minus_cos),
            is_delta: false,
            shadow: from.spawn(wi),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }

    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let towards = self.frame.to_world(warp::uniform_cone(direction, self.one_minus_cos));
        let (ray, area) = SceneSphere::new(scene)?.sample(scene, towards, place)?;
        let solid_angle = 1.0 / warp::uniform_cone_pdf(self.one_minus_cos).0;
        Some(LightRay::new(ray, self.radiance * (solid_angle * area) as f32))
    }

    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        SceneSphere::new(scene).map_or(0.0, |sphere| self.pdf(wi).0 * sphere.pdf(at, wi))
    }

    fn pdf_of_ray(&self, _: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.pdf(-ray.ray.direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::description::{Description, LightDescription, LightKind};

    #[test]
    fn disks_too_small_for_their_radiance_are_refused() {
        for (angular_radius, valid) in
            [(1e-9, true), (1e-25, false), (1e-200, false), (f64::MIN_POSITIVE, false)]
        {
            let kind = LightKind::Sun { from: DVec3::Z, to: DVec3::ZERO, angular_radius };
            let lights = vec![LightDescription::new(kind, 1.0)];
            let resolved = Scene::resolve(Description { lights, ..Description::default() });
            assert_eq!(resolved.is_ok(), valid, "{angular_radius}");
        }
    }
}
