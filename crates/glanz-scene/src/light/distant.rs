//! Distant light.

use std::f64::consts::PI;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, SolidAnglePdf};

use super::emission::SceneSphere;
use super::extent::DirectionCone;
use super::{
    IncidentLight, LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, range_error,
};
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// Light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct DistantLight {
    towards: DVec3,
    irradiance: Spectrum,
}

impl DistantLight {
    /// `towards`: unit direction to the light; `irradiance`: W/m^2 on a surface that faces it.
    #[must_use]
    pub fn new(towards: DVec3, irradiance: Spectrum) -> Self {
        Self { towards, irradiance }
    }

    /// W/m^2 on a surface that faces the light.
    #[must_use]
    pub fn irradiance(&self) -> Spectrum {
        self.irradiance
    }

    /// Unit direction to the light.
    #[must_use]
    pub fn towards(&self) -> DVec3 {
        self.towards
    }

    /// `from`, `to`: in the frame of the light.
    pub(super) fn resolve(input: &LightInput<'_>, from: DVec3, to: DVec3) -> Result<Self, SceneErrorKind> {
        let towards = input.to_world.vector(from - to).try_normalize();
        let error = || range_error("distant light: from", from, "different from to");
        Ok(Self::new(towards.ok_or_else(error)?, input.emission))
    }
}

impl LightModel for DistantLight {
    const KIND: &'static str = "distant";

    fn importance(&self, radius: f64) -> f64 {
        brightness(self.irradiance) * (PI * radius * radius)
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        LightExtent::Distant(DirectionCone { axis: self.towards, half_angle: 0.0 })
    }

    fn sample(&self, _: &Scene, from: &Interaction, _: DVec2) -> Option<LightSample> {
        Some(LightSample {
            wi: self.towards,
            radiance: self.irradiance,
            pdf: SolidAnglePdf(1.0),
            is_delta: true,
            shadow: from.spawn(self.towards),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }

    fn emit(&self, scene: &Scene, place: DVec2, _: DVec2) -> Option<LightRay> {
        let (ray, area) = SceneSphere::new(scene)?.sample(scene, self.towards, place)?;
        Some(LightRay::new(ray, self.irradiance * area as f32))
    }

    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        SceneSphere::new(scene).map_or(0.0, |sphere| sphere.pdf(at, wi))
    }

    fn incident(&self, _: DVec3) -> Option<IncidentLight> {
        Some(IncidentLight { towards: self.towards, irradiance: self.irradiance, distance: f64::INFINITY })
    }
}
