//! Light from all directions.

use std::f64::consts::{FRAC_1_PI, PI};

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, SolidAnglePdf};
use glanz_sampling::warp;

use super::emission::SceneSphere;
use super::{LightModel, LightRay, LightSample, brightness};
use crate::interaction::{Interaction, LightSampleContext};
use crate::scene::Scene;

/// The same radiance from every direction.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLight {
    radiance: Spectrum,
}

impl InfiniteLight {
    /// `radiance`: W/(m^2 sr).
    #[must_use]
    pub fn new(radiance: Spectrum) -> Self {
        Self { radiance }
    }

    /// W/(m^2 sr) from every direction.
    #[must_use]
    pub fn radiance(&self) -> Spectrum {
        self.radiance
    }

    /// Density with which a sample from `from` has the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, from: &LightSampleContext, wi: DVec3) -> SolidAnglePdf {
        let Some(normal) = from.shading_normal else { return warp::uniform_sphere_pdf() };
        let cos = normal.dot(wi) * 1.0_f64.copysign(normal.dot(from.wo));
        SolidAnglePdf(cos.max(0.0) * FRAC_1_PI)
    }
}

impl LightModel for InfiniteLight {
    const KIND: &'static str = "infinite";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn importance(&self, radius: f64) -> f64 {
        let disk = PI * radius * radius;
        brightness(self.radiance) * PI * 4.0 * disk
    }

    /// Directions by the cosine to [`Interaction::normal_for`] the viewer, on its side: the light is the same everywhere, so the
    /// cosine is all that varies. Light through a surface is left to BSDF sampling. In a medium light is scattered from all sides: uniform directions.
    fn sample(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        let context = from.light_sample_context();
        let wi = match context.shading_normal {
            Some(normal) => {
                let mut local = warp::cosine_hemisphere(xi);
                local.z = local.z.copysign(normal.dot(from.wo));
                Frame::from_z(normal).to_world(local)
            }
            None => warp::uniform_sphere(xi),
        };
        let pdf = self.pdf(&context, wi);
        (pdf.0 > 0.0).then(|| LightSample {
            wi,
            radiance: self.radiance,
            pdf,
            is_delta: false,
            shadow: from.spawn(wi),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }

    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let towards = warp::uniform_sphere(direction);
        let (ray, area) = SceneSphere::new(scene)?.sample(scene, towards, place)?;
        Some(LightRay::new(ray, self.radiance * (4.0 * PI * area) as f32))
    }

    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        SceneSphere::new(scene).map_or(0.0, |sphere| 0.25 * FRAC_1_PI * sphere.pdf(at, wi))
    }

    fn pdf_of_ray(&self, from: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.pdf(from, -ray.ray.direction)
    }
}
