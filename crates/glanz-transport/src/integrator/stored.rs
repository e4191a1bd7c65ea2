//! Light that was found before, looked at from anywhere.

use std::f32::consts::FRAC_1_PI;
use std::fmt;
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_scene::ParametricPoint;

use super::{Context, Integrator, IntegratorSettings, mirrors};

/// Light on surfaces that does not depend on who looks: a solution of radiosity.
pub trait StoredLight: fmt::Debug + Send + Sync {
    /// Irradiance at a place in units of radiance; `None` where none is known.
    fn irradiance(&self, place: &ParametricPoint) -> Option<Spectrum>;
}

/// Shows light that is stored on surfaces (document 003 section 5.7.3).
///
/// A rough surface sends its own light and reflects the stored irradiance evenly, by its albedo; mirrors and glass are followed as in
/// [`Whitted`](super::Whitted). No light is sampled: noise comes from edges and the depth of field alone.
/// Without stored light surfaces show what they give off themselves.
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
        mirrors::radiance(context, self.max_depth, &|_, vertex, place| {
            let irradiance = self.light.as_ref().and_then(|light| light.irradiance(place));
            vertex.albedo() * irradiance.unwrap_or_default() * FRAC_1_PI
        })
    }
}
