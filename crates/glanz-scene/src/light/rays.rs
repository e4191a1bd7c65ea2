//! Measured rays of a light source.

use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DMat3, DVec2, DVec3, Ray, SolidAnglePdf};
use glanz_sampling::discrete::PiecewiseConstant1;

use super::photometric::{TRANSFORMATION, luminaire_axes, uneven};
use super::{LightInput, LightModel, LightRay, LightSample, brightness};
use crate::description::SourceRay;
use crate::error::SceneErrorKind;
use crate::interaction::{Interaction, LightSampleContext};
use crate::scene::Scene;

/// A light that emits measured rays, each in proportion to its flux.
///
/// It cannot be sampled from a surface: only paths that start at lights see it.
#[derive(Clone, Debug)]
pub struct RayLight {
    rays: Arc<[SourceRay]>,
    /// Rays by flux; `None` if all are dark.
    choice: Option<Arc<PiecewiseConstant1>>,
    position: DVec3,
    /// Axes of the source in the world; orthonormal, perhaps mirrored.
    axes: DMat3,
    /// Factor on lengths in the world.
    scale: f64,
    power: Spectrum,
}

impl RayLight {
    /// `from`: the origin of the rays in the frame of the light, which has to be a similarity.
    pub(super) fn resolve(
        input: LightInput<'_>,
        rays: &Arc<[SourceRay]>,
        from: DVec3,
    ) -> Result<Self, SceneErrorKind> {
        let per_lumen = input.per_candela?;
        let (axes, scale) = luminaire_axes(&input.to_world).ok_or_else(|| uneven(TRANSFORMATION))?;
        let lumens: Vec<f64> = rays.iter().map(|ray| f64::from(ray.lumens)).collect();
        let choice = PiecewiseConstant1::try_new(&lumens).ok().map(Arc::new);
        let flux: f64 = lumens.iter().sum();
        Ok(Self {
            rays: Arc::clone(rays),
            choice,
            position: input.to_world.point(from),
            axes,
            scale,
            power: per_lumen * flux as f32,
        })
    }

    /// Total power, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// Its origin, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// One of the rays in proportion to its flux, by a number uniform in [0, 1).
    fn sample_ray(&self, xi: f64) -> Option<Ray> {
        let SourceRay { origin, direction, .. } = self.rays.get(self.choice.as_ref()?.choose(xi).index)?;
        let to_world = |v: &[f32; 3]| self.axes * DVec3::from_array(v.map(f64::from));
        let direction = to_world(direction).try_normalize()?;
        Some(Ray::new(self.position + self.scale * to_world(origin), direction))
    }
}

impl LightModel for RayLight {
    const KIND: &'static str = "photometric";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_sampled(&self) -> bool {
        false
    }

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power)
    }

    fn sample(&self, _: &Scene, _: &Interaction, _: DVec2) -> Option<LightSample> {
        None
    }

    fn emit(&self, _: &Scene, place: DVec2, _: DVec2) -> Option<LightRay> {
        Some(LightRay::new(self.sample_ray(place.x)?, self.power))
    }

    /// No other technique finds its light: any density serves.
    fn emission_pdf(&self, _: &Scene, _: DVec3, _: DVec3, _: Option<AreaPdf>) -> f64 {
        1.0
    }

    fn pdf_of_ray(&self, _: &LightSampleContext, _: &LightRay) -> SolidAnglePdf {
        SolidAnglePdf(0.0)
    }

    fn warning(&self) -> Option<&'static str> {
        Some(
            "the rays of a file cannot be sampled from surfaces: only paths that start at the lights see this light, \
             such as those of glanz illuminate",
        )
    }
}
