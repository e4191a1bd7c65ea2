//! Smooth metal.

use glanz_light::Spectrum;
use glanz_math::DVec3;

use super::mirror::mirrored;
use crate::bsdf::{BsdfSample, Lobe};
use crate::fresnel;

/// A smooth metal: a mirror after Fresnel's equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Refractive index relative to the surrounding medium, lane by lane; >= 0.
    pub eta: Spectrum,
    /// Absorption coefficient, likewise.
    pub k: Spectrum,
    /// Factor on what is reflected, [0, 1]; lanes not in use should be 0 here.
    pub tint: Spectrum,
}

impl Conductor {
    /// Share of light reflected that comes under the cosine `cos` to the normal.
    #[must_use]
    pub fn reflectance_at(&self, cos: f64) -> Spectrum {
        let fresnel = |eta: f32, k: f32| fresnel::conductor(cos, f64::from(eta), f64::from(k)) as f32;
        self.eta.zip(self.k, fresnel) * self.tint
    }

    /// The mirrored direction.
    #[must_use]
    pub fn sample(&self, wo: DVec3) -> Option<BsdfSample> {
        (wo.z != 0.0)
            .then(|| BsdfSample::delta(mirrored(wo), self.reflectance_at(wo.z), Lobe::SPECULAR_REFLECTION))
    }
}
