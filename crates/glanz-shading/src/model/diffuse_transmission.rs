//! Diffuse reflection and transmission.

use std::f32::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// A thin sheet, such as paper or a leaf, that scatters light diffusely to both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    reflectance: Spectrum,
    transmittance: Spectrum,
    reflection_probability: f64,
}

impl DiffuseTransmission {
    /// A sheet with these fractions of light; where their sum is above 1, both are scaled down.
    #[must_use]
    pub fn new(reflectance: Spectrum, transmittance: Spectrum) -> Self {
        let scale = (reflectance + transmittance).map(|sum| 1.0 / sum.max(1.0));
        let (reflectance, transmittance) = (reflectance * scale, transmittance * scale);
        let (r, t) = (reflectance.max_component(), transmittance.max_component());
        let reflection_probability = if r + t > 0.0 { f64::from(r / (r + t)) } else { 1.0 };
        Self { reflectance, transmittance, reflection_probability }
    }
}

impl BsdfModel for DiffuseTransmission {
    const LOBES: &'static [Lobe] = &[Lobe::DIFFUSE, Lobe::DIFFUSE_TRANSMISSION];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let fraction = if wo.z * wi.z > 0.0 { self.reflectance } else { self.transmittance };
        if wo.z == 0.0 { Spectrum::BLACK } else { fraction * (FRAC_1_PI * wi.z.abs() as f32) }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let reflection = self.reflection_probability;
        let probability = if wo.z * wi.z > 0.0 { reflection } else { 1.0 - reflection };
        SolidAnglePdf(if wo.z == 0.0 { 0.0 } else { probability * warp::cosine_hemisphere_pdf(wi.z.abs()).0 })
    }

    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere(xi);
        let reflects = xi_lobe < self.reflection_probability;
        wi.z = if reflects { wi.z.copysign(wo.z) } else { -wi.z.copysign(wo.z) };
        let lobe = if reflects { Lobe::DIFFUSE } else { Lobe::DIFFUSE_TRANSMISSION };
        BsdfSample::of_direction(self, [wo, wi], lobe, mode)
    }

    fn diffuse_probability(&self, _: DVec3) -> f64 {
        self.reflection_probability
    }

    fn albedo(&self, _: DVec3) -> Spectrum {
        self.reflectance + self.transmittance
    }

    fn reflected(&self, _: DVec3) -> Spectrum {
        self.reflectance
    }

    fn is_black(&self) -> bool {
        self.reflectance.is_black() && self.transmittance.is_black()
    }
}

/// The material of [`DiffuseTransmission`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmissionMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light reflected.
    pub reflectance: P::Spectrum,
    /// Fraction of light transmitted.
    pub transmittance: P::Spectrum,
}

impl<P: ParameterForm> MaterialModel<P> for DiffuseTransmissionMaterial<P> {
    type Textured = DiffuseTransmissionMaterial;

    fn kind(&self) -> &'static str {
        "diffusetransmission"
    }

    fn resolve<R: ParameterResolver<P>>(
        &self,
        resolver: &R,
    ) -> Result<DiffuseTransmissionMaterial, MaterialError> {
        Ok(DiffuseTransmissionMaterial {
            reflectance: resolver.fraction("reflectance", &self.reflectance)?,
            transmittance: resolver.fraction("transmittance", &self.transmittance)?,
        })
    }
}

impl TexturedModel for DiffuseTransmissionMaterial {
    type Bsdf<'a> = DiffuseTransmission;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> DiffuseTransmission {
        DiffuseTransmission::new(at.fraction(&self.reflectance), at.fraction(&self.transmittance))
    }
}

impl<P: ParameterForm> Material<P> {
    /// A sheet that scatters these fractions of light diffusely to both sides.
    #[must_use]
    pub fn diffuse_transmission(
        reflectance: impl Into<P::Spectrum>,
        transmittance: impl Into<P::Spectrum>,
    ) -> Self {
        let (reflectance, transmittance) = (reflectance.into(), transmittance.into());
        Self::DiffuseTransmission(DiffuseTransmissionMaterial { reflectance, transmittance })
    }
}
