//! Perfect reflection.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};

use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// A mirror with the same reflectance at every angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: Spectrum,
}

impl BsdfModel for Mirror {
    const LOBES: &'static [Lobe] = &[Lobe::SPECULAR_REFLECTION];

    /// The mirrored direction.
    fn sample(&self, wo: DVec3, _: DVec2, _: f64, _: TransportMode) -> Option<BsdfSample> {
        (wo.z != 0.0).then(|| mirror_image(wo, self.reflectance))
    }

    fn albedo(&self, _: DVec3) -> Spectrum {
        self.reflectance
    }

    fn is_black(&self) -> bool {
        self.reflectance.is_black()
    }
}

/// `wo` rotated by half a turn about z.
pub(super) fn mirrored(wo: DVec3) -> DVec3 {
    DVec3::new(-wo.x, -wo.y, wo.z)
}

/// The mirrored direction, of this weight.
pub(super) fn mirror_image(wo: DVec3, weight: Spectrum) -> BsdfSample {
    BsdfSample::delta(mirrored(wo), weight, Lobe::SPECULAR_REFLECTION)
}

/// The material of [`Mirror`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: P::Spectrum,
}

impl<P: ParameterForm> MaterialModel<P> for MirrorMaterial<P> {
    type Textured = MirrorMaterial;

    fn kind(&self) -> &'static str {
        "mirror"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<MirrorMaterial, MaterialError> {
        Ok(MirrorMaterial { reflectance: resolver.fraction("reflectance", &self.reflectance)? })
    }
}

impl TexturedModel for MirrorMaterial {
    type Bsdf = Mirror;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Mirror {
        Mirror { reflectance: at.fraction(&self.reflectance) }
    }
}

impl<P: ParameterForm> Material<P> {
    /// A perfect mirror, with the fraction of light reflected, [0, 1].
    #[must_use]
    pub fn mirror(reflectance: impl Into<P::Spectrum>) -> Self {
        Self::Mirror(MirrorMaterial { reflectance: reflectance.into() })
    }
}
