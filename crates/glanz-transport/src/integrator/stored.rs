//! Pictures of light stored on surfaces.

use std::f32::consts::FRAC_1_PI;
use std::fmt;
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_scene::ParametricPoint;

use super::{Context, Integrator, IntegratorSettings, mirrors};

/// View-independent light on surfaces, such as a solution of radiosity.
pub trait StoredLight: fmt::Debug + Send + Sync {
    /// Irradiance at a point in units of radiance; `None` where it is unknown.
    fn irradiance(&self, place: &ParametricPoint) -> Option<Spectrum>;
}

/// Integrator that shows light stored on surfaces (document 003 section 5.7.3).
///
/// A rough surface emits its own light and reflects the stored irradiance diffusely, by its albedo; mirrors and glass are traced as in
/// [`Whitted`](super::Whitted). No light is sampled: noise comes from edges and the depth of field alone.
/// Without stored light, surfaces show their own emission only.
#[derive(Clone, Debug)]
pub struct Stored {
    max_depth: u32,
    light: Option<Arc<dyn StoredLight>>,
}

impl Stored {
    /// With the depth of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings, light: Option<Arc<dyn StoredLight>>) -> Self {
        Self { max_depth: settings.max_depth, light }
    }
}

impl Integrator for Stored {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        mirrors::radiance(context, self.max_depth, &|context, vertex, place| {
            let irradiance = self.light.as_ref().and_then(|light| light.irradiance(place));
            let irradiance = irradiance.unwrap_or_default().upsampled_light(&context.wavelengths);
            vertex.rough_albedo() * irradiance * FRAC_1_PI
        })
    }
}
