//! Smooth metal.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};

use super::mirror::mirrored;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode};
use crate::fresnel;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// A smooth metal: a mirror after Fresnel's equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Refractive index relative to the surrounding medium, lane by lane; >= 0.
    pub eta: Spectrum,
    /// Absorption coefficient, likewise.
    pub k: Spectrum,
    /// Factor on reflected light, [0, 1]; lanes not in use should be 0 here.
    pub tint: Spectrum,
}

impl Conductor {
    /// Fraction of light reflected that arrives under the cosine `cos` to the normal.
    #[must_use]
    pub fn reflectance_at(&self, cos: f64) -> Spectrum {
        let fresnel = |eta: f32, k: f32| fresnel::conductor(cos, f64::from(eta), f64::from(k)) as f32;
        self.eta.zip(self.k, fresnel) * self.tint
    }
}

impl BsdfModel for Conductor {
    const LOBES: &'static [Lobe] = &[Lobe::SPECULAR_REFLECTION];

    /// The mirrored direction.
    fn sample(&self, wo: DVec3, _: DVec2, _: f64, _: TransportMode) -> Option<BsdfSample> {
        (wo.z != 0.0)
            .then(|| BsdfSample::delta(mirrored(wo), self.reflectance_at(wo.z), Lobe::SPECULAR_REFLECTION))
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        self.reflectance_at(wo.z)
    }
}

/// The material of [`Conductor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConductorMaterial<P: ParameterForm = ShadingForm> {
    /// Refractive index relative to the surrounding medium.
    pub eta: P::Spectrum,
    /// Absorption coefficient.
    pub k: P::Spectrum,
}

impl<P: ParameterForm> MaterialModel<P> for ConductorMaterial<P> {
    type Textured = ConductorMaterial;

    fn kind(&self) -> &'static str {
        "conductor"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<ConductorMaterial, MaterialError> {
        Ok(ConductorMaterial {
            eta: resolver.spectrum("eta", &self.eta)?,
            k: resolver.spectrum("k", &self.k)?,
        })
    }
}

impl TexturedModel for ConductorMaterial {
    type Bsdf = Conductor;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Conductor {
        Conductor { eta: at.spectrum(&self.eta), k: at.spectrum(&self.k), tint: at.white() }
    }
}

impl<P: ParameterForm> Material<P> {
    /// Smooth metal of refractive index `eta` and absorption coefficient `k`.
    #[must_use]
    pub fn conductor(eta: impl Into<P::Spectrum>, k: impl Into<P::Spectrum>) -> Self {
        Self::Conductor(ConductorMaterial { eta: eta.into(), k: k.into() })
    }
}
