//! A diffuse base under a clear coat: plastic, varnished wood, glossy paint.

use std::f64::consts::{FRAC_1_PI, PI};

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::mirror::mirror_image;
use super::roughness::Roughness;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, both_above, to_side_of, upper_side};
use crate::microfacet::coat::Coat;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;

/// Lambert's law under a coat, the same on both sides.
///
/// The base forgets directions, so that all reflections between base and interface add up in closed form: with T the fraction that the
/// interface transmits, r that which it reflects of diffuse light from inside, and R the reflectance of the base,
/// f = T(o) T(i) R / (pi eta^2 (1 - r R)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatedDiffuse {
    coat: Coat,
    /// Fraction of diffuse light from outside that the coat transmits.
    transmitted: f64,
    /// 1 in the lanes in use.
    white: Spectrum,
    /// `R / (pi eta^2 (1 - r R))`.
    base: Spectrum,
}

impl CoatedDiffuse {
    /// A base of this reflectance, [0, 1], under a coat. `white`: 1 in the lanes in use, else 0.
    #[must_use]
    pub fn new(reflectance: Spectrum, white: Spectrum, coat: Coat) -> Self {
        // R / (pi eta^2 (1 - r R)) with r = 1 - t / eta^2, free of cancellation.
        let (eta2, transmitted) = (coat.eta().powi(2), coat.mean_transmittance());
        let base = reflectance.map(|r| {
            let r = f64::from(r);
            (FRAC_1_PI * r / (eta2 * (1.0 - r) + r * transmitted)) as f32
        });
        Self { coat, transmitted, white, base }
    }

    /// Fraction of the light of which the coat reflects the fraction `reflected` that the base scatters.
    fn base_albedo(&self, reflected: f64) -> Spectrum {
        self.base * (PI * (1.0 - reflected) * self.transmitted) as f32
    }

    /// Probability of sampling the base for a direction of which the coat reflects this fraction.
    fn base_probability(&self, reflected: f64) -> f64 {
        let base = f64::from(self.base_albedo(reflected).max_component());
        // A black base under an interface that reflects nothing.
        if base + reflected > 0.0 { base / (base + reflected) } else { 1.0 }
    }
}

impl BsdfModel for CoatedDiffuse {
    const LOBES: &'static [Lobe] = &[Lobe::DIFFUSE, Lobe::SPECULAR_REFLECTION, Lobe::GLOSSY];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let Some([wo, wi]) = both_above(wo, wi) else { return Spectrum::BLACK };
        let [o, i] = [wo, wi].map(|w| 1.0 - self.coat.reflectance(w));
        let base = self.base * (o * i * wi.z) as f32;
        if self.coat.is_smooth() { base } else { base + self.white * self.coat.eval(wo, wi) as f32 }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let Some([wo, wi]) = both_above(wo, wi) else { return SolidAnglePdf(0.0) };
        let base = self.base_probability(self.coat.reflectance(wo));
        let diffuse = base * warp::cosine_hemisphere_pdf(wi.z).0;
        let glossy = if self.coat.is_smooth() { 0.0 } else { (1.0 - base) * self.coat.pdf(wo, wi) };
        SolidAnglePdf(diffuse + glossy)
    }

    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        let [up, _] = upper_side(wo, wo)?;
        let reflected = self.coat.reflectance(up);
        let base = self.base_probability(reflected);
        let (wi, lobe) = if xi_lobe < base {
            (warp::cosine_hemisphere(xi), Lobe::DIFFUSE)
        } else if self.coat.is_smooth() {
            let weight = self.white * (reflected / (1.0 - base)) as f32;
            return Some(mirror_image(wo, weight));
        } else {
            (self.coat.sample(up, xi, (xi_lobe - base) / (1.0 - base)), Lobe::GLOSSY)
        };
        BsdfSample::of_direction(self, [wo, to_side_of(wo, wi)], lobe, mode)
    }

    fn delta_branches(&self, wo: DVec3, _: TransportMode) -> [Option<BsdfSample>; 2] {
        let up = upper_side(wo, wo).filter(|_| self.coat.is_smooth());
        let weight = up.map(|[up, _]| self.white * self.coat.reflectance(up) as f32);
        let branch = weight.filter(|weight| !weight.is_black());
        [branch.map(|weight| mirror_image(wo, weight)), None]
    }

    fn diffuse_probability(&self, wo: DVec3) -> f64 {
        upper_side(wo, wo).map_or(0.0, |[wo, _]| self.base_probability(self.coat.reflectance(wo)))
    }

    fn is_anisotropic(&self) -> bool {
        self.coat.distribution().is_anisotropic()
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        let reflected = upper_side(wo, wo).map_or(1.0, |[wo, _]| self.coat.reflectance(wo));
        self.white * reflected as f32 + self.base_albedo(reflected)
    }

    fn preview(&self) -> PreviewSurface {
        let reflected = self.coat.reflectance(DVec3::Z);
        PreviewSurface {
            specular: self.white * reflected as f32,
            roughness: self.coat.distribution().preview_roughness(),
            ..PreviewSurface::diffuse(self.base_albedo(reflected))
        }
    }
}

/// The material of [`CoatedDiffuse`].
#[derive(Clone, Debug, PartialEq)]
pub struct CoatedDiffuseMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light that the base would reflect without a coat.
    pub reflectance: P::Spectrum,
    /// Refractive index of the coat, in [1, 1000]; a texture's value outside counts as 1.
    pub eta: P::Float,
    /// Facets of the coat.
    pub roughness: Roughness<P>,
    /// Whether light between facets counts, if they are isotropic.
    pub multiple_scattering: bool,
}

impl<P: ParameterForm> MaterialModel<P> for CoatedDiffuseMaterial<P> {
    type Textured = CoatedDiffuseMaterial;

    fn kind(&self) -> &'static str {
        "coateddiffuse"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<CoatedDiffuseMaterial, MaterialError> {
        Ok(CoatedDiffuseMaterial {
            reflectance: resolver.fraction("reflectance", &self.reflectance)?,
            eta: resolver.float("eta", &self.eta, Coat::INDICES, "a number between 1 and 1000")?,
            roughness: self.roughness.resolve("roughness", resolver)?,
            multiple_scattering: self.multiple_scattering,
        })
    }
}

impl TexturedModel for CoatedDiffuseMaterial {
    type Bsdf<'a> = CoatedDiffuse;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> CoatedDiffuse {
        let coat = Coat::new(at.float(&self.eta), self.roughness.distribution(at), self.multiple_scattering);
        CoatedDiffuse::new(at.fraction(&self.reflectance), at.white(), coat)
    }
}

impl<P: ParameterForm<Float: From<f32>>> Material<P> {
    /// A diffuse base under a smooth coat of refractive index `eta`.
    #[must_use]
    pub fn coated_diffuse(reflectance: impl Into<P::Spectrum>, eta: impl Into<P::Float>) -> Self {
        Self::CoatedDiffuse(CoatedDiffuseMaterial {
            reflectance: reflectance.into(),
            eta: eta.into(),
            roughness: Roughness::smooth(),
            multiple_scattering: true,
        })
    }
}
