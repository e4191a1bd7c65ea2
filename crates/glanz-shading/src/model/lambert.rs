//! Diffuse reflection.

use std::f32::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, same_side};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// Lambert's law: the same radiance in every direction of the side the light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: Spectrum,
}

impl BsdfModel for Lambert {
    const LOBES: &'static [Lobe] = &[Lobe::DIFFUSE];

    /// `reflectance / pi |cos|`.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        if !same_side(wo, wi) {
            return Spectrum::BLACK;
        }
        self.reflectance * (FRAC_1_PI * wi.z.abs() as f32)
    }

    /// Proportional to the cosine.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        if same_side(wo, wi) { warp::cosine_hemisphere_pdf(wi.z.abs()) } else { SolidAnglePdf(0.0) }
    }

    /// A direction with density proportional to its cosine: the weight is the reflectance.
    fn sample(&self, wo: DVec3, xi: DVec2, _: f64, _: TransportMode) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere(xi);
        wi.z = wi.z.copysign(wo.z);
        if !same_side(wo, wi) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight: self.reflectance,
            value: self.eval(wo, wi),
            pdf: self.pdf(wo, wi),
            lobe: Lobe::DIFFUSE,
            eta_scale: 1.0,
        })
    }

    fn diffuse_probability(&self, _: DVec3) -> f64 {
        1.0
    }

    fn albedo(&self, _: DVec3) -> Spectrum {
        self.reflectance
    }

    fn is_black(&self) -> bool {
        self.reflectance.is_black()
    }
}

/// The material of [`Lambert`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: P::Spectrum,
}

impl<P: ParameterForm> MaterialModel<P> for DiffuseMaterial<P> {
    type Textured = DiffuseMaterial;

    fn kind(&self) -> &'static str {
        "diffuse"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<DiffuseMaterial, MaterialError> {
        Ok(DiffuseMaterial { reflectance: resolver.fraction("reflectance", &self.reflectance)? })
    }
}

impl TexturedModel for DiffuseMaterial {
    type Bsdf<'a> = Lambert;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Lambert {
        Lambert { reflectance: at.fraction(&self.reflectance) }
    }
}

impl<P: ParameterForm> Material<P> {
    /// Lambert's law, with the fraction of light reflected, [0, 1].
    #[must_use]
    pub fn diffuse(reflectance: impl Into<P::Spectrum>) -> Self {
        Self::Diffuse(DiffuseMaterial { reflectance: reflectance.into() })
    }
}
