//! Metal.

use std::f64::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};

use super::finish::SurfaceFinish;
use super::mirror::mirror_image;
use super::roughness::Roughness;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, both_above, to_side_of, upper_side};
use crate::fresnel;
use crate::microfacet::{MicrofacetDistribution, energy, half_vector};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;

/// A metal after Fresnel's equations, smooth, with facets or with a surface finish.
///
/// # Source
/// @walter2007 with the masking of @heitz2014; light between facets after @kulla2017.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor<'a> {
    metal: ConductorFresnel,
    distribution: MicrofacetDistribution,
    /// `f` of the light between facets over the fractions that both directions lose to it.
    multiple: Spectrum,
    /// Reflectance by more than one facet over that by one, both without what others block.
    multiple_ratio: f64,
    /// Finish of a smooth surface.
    pub(super) finish: Option<&'a SurfaceFinish>,
}

/// Reflectance of a smooth metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConductorFresnel {
    /// Refractive index relative to the surrounding medium, lane by lane; >= 0.
    pub eta: Spectrum,
    /// Absorption coefficient, likewise.
    pub k: Spectrum,
    /// Factor on reflected light, [0, 1]; lanes not in use should be 0 here.
    pub tint: Spectrum,
}

impl ConductorFresnel {
    /// A metal of index 1 with this reflectance at normal incidence, clamped to [0, 0.9999]: full reflection would need infinite absorption.
    ///
    /// # Source
    /// As version 4 of pbrt: `k = 2 sqrt(r / (1 - r))`.
    #[must_use]
    pub fn of_reflectance(reflectance: Spectrum, tint: Spectrum) -> Self {
        let k = reflectance.map(|r| {
            let r = r.clamp(0.0, 0.9999);
            2.0 * (r / (1.0 - r)).sqrt()
        });
        Self { eta: Spectrum::ONE, k, tint }
    }

    /// Fraction of light reflected that arrives under the cosine `cos` to the normal.
    #[must_use]
    pub fn reflectance(&self, cos: f64) -> Spectrum {
        let fresnel = |eta: f32, k: f32| fresnel::conductor(cos, f64::from(eta), f64::from(k)) as f32;
        self.eta.zip(self.k, fresnel) * self.tint
    }

    /// The mean of [`ConductorFresnel::reflectance`] over diffuse light; error below 0.002 for metals, 0.02 for weak absorption.
    #[must_use]
    pub fn mean_reflectance(&self) -> Spectrum {
        // The Gauss rule with weight 2 cos on [0, 1].
        const RULE: [(f64, f32); 3] = [
            (0.212_340_538_239_167, 0.139_654),
            (0.590_533_135_559_282, 0.458_482_2),
            (0.911_412_040_487_302, 0.401_863_8),
        ];
        RULE.iter().map(|&(cos, weight)| self.reflectance(cos) * weight).sum()
    }
}

impl<'a> Conductor<'a> {
    /// A metal with facets. `multiple_scattering`: whether light between facets counts.
    #[must_use]
    pub fn new(
        metal: ConductorFresnel,
        distribution: MicrofacetDistribution,
        multiple_scattering: bool,
    ) -> Self {
        let mean = if multiple_scattering { energy::mean_reflected(&distribution) } else { 1.0 };
        let (mut multiple, mut multiple_ratio) = (Spectrum::BLACK, 0.0);
        if mean < 1.0 {
            // Each reflection between facets loses what the metal absorbs and what leaves.
            let single = metal.mean_reflectance();
            let color = single.map(|f| f * f * mean as f32 / (1.0 - f * (1.0 - mean as f32)));
            multiple = color * (FRAC_1_PI / (1.0 - mean)) as f32;
            multiple_ratio = f64::from(color.max_component() / single.max_component().max(f32::MIN_POSITIVE));
        }
        Self { metal, distribution, multiple, multiple_ratio, finish: None }
    }

    /// The same metal with a surface finish, which has no effect on facets, nor if it scatters nothing. Light is scattered as by facets that
    /// mirror it: Fresnel's equations count under half of the angle between its directions, so that the metal stays reciprocal.
    #[must_use]
    pub fn with_finish(self, finish: Option<&'a SurfaceFinish>) -> Self {
        let has_effect =
            |finish: &&SurfaceFinish| self.distribution.is_smooth() && finish.total_scatter() > 0.0;
        Self { finish: finish.filter(has_effect), ..self }
    }

    /// Fraction of the flux from `wo` (above) that facets send to other facets, if that light counts.
    fn lost(&self, w: DVec3) -> f64 {
        if self.multiple.is_black() { 0.0 } else { 1.0 - energy::reflected(&self.distribution, w) }
    }

    /// A direction of rough reflection, for `wo` above; it may be below the surface.
    pub(super) fn sample_rough(&self, wo: DVec3, xi: DVec2, xi_lobe: f64) -> DVec3 {
        self.distribution.sample_scattering(wo, self.multiple_probability(self.lost(wo)), xi, xi_lobe)
    }

    /// Reflectance of a smooth surface at normal incidence.
    pub(super) fn normal_reflectance(&self) -> Spectrum {
        self.metal.reflectance(1.0)
    }

    /// Probability of sampling light between facets: about its fraction of the light.
    fn multiple_probability(&self, lost: f64) -> f64 {
        let multiple = lost * self.multiple_ratio;
        multiple / (multiple + 1.0 - lost)
    }
}

impl BsdfModel for Conductor<'_> {
    const LOBES: &'static [Lobe] = &[Lobe::SPECULAR_REFLECTION, Lobe::GLOSSY];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let Some([wo, wi]) = both_above(wo, wi).filter(|_| !self.is_delta()) else {
            return Spectrum::BLACK;
        };
        let m = half_vector(wo, wi);
        if let Some(finish) = self.finish {
            return self.metal.reflectance(wo.dot(m)) * finish.value(wo, wi) as f32;
        }
        let single = self.metal.reflectance(wo.dot(m)) * self.distribution.reflection(wo, wi, m) as f32;
        single + self.multiple * (self.lost(wo) * self.lost(wi) * wi.z) as f32
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let Some([wo, wi]) = both_above(wo, wi).filter(|_| !self.is_delta()) else {
            return SolidAnglePdf(0.0);
        };
        if let Some(finish) = self.finish {
            return SolidAnglePdf(finish.pdf(wo, wi));
        }
        let multiple = self.multiple_probability(self.lost(wo));
        SolidAnglePdf(self.distribution.scattering_pdf(wo, wi, multiple))
    }

    /// The mirrored direction, or one of light that a finish scatters, that a facet mirrors, or of light between facets.
    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        let [up, _] = upper_side(wo, wo)?;
        if let Some(finish) = self.finish {
            return finish.sample(self, self.metal.reflectance(wo.z), wo, (xi, xi_lobe), mode);
        }
        if self.is_delta() {
            return Some(mirror_image(wo, self.metal.reflectance(wo.z)));
        }
        let wi = to_side_of(wo, self.sample_rough(up, xi, xi_lobe));
        BsdfSample::of_direction(self, [wo, wi], Lobe::GLOSSY, mode)
    }

    fn is_delta(&self) -> bool {
        self.distribution.is_smooth() && self.finish.is_none()
    }

    fn delta_branches(&self, wo: DVec3, _: TransportMode) -> [Option<BsdfSample>; 2] {
        if !self.distribution.is_smooth() {
            return [None, None];
        }
        let reflectance = self.metal.reflectance(wo.z);
        let image = || (wo.z != 0.0).then(|| mirror_image(wo, reflectance));
        let image = self.finish.map_or_else(image, |finish| finish.mirror_image(reflectance, wo));
        [image.filter(|image| !image.weight.is_black()), None]
    }

    fn is_anisotropic(&self) -> bool {
        self.distribution.is_anisotropic()
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        if self.is_delta() { self.metal.reflectance(wo.z) } else { crate::bsdf::estimated_albedo(self, wo) }
    }

    fn preview(&self) -> PreviewSurface {
        let roughness = self.distribution.preview_roughness();
        PreviewSurface { roughness, ..PreviewSurface::metal(self.normal_reflectance()) }
    }
}

/// The optical constants of a metal.
#[derive(Clone, Debug, PartialEq)]
pub enum MetalColor<P: ParameterForm = ShadingForm> {
    /// By its complex refractive index.
    Index {
        /// Refractive index relative to the surrounding medium.
        eta: P::Spectrum,
        /// Absorption coefficient.
        k: P::Spectrum,
    },
    /// By its reflectance at normal incidence, see [`ConductorFresnel::of_reflectance`].
    Reflectance(P::Spectrum),
}

impl<P: ParameterForm> MetalColor<P> {
    /// Checks the parameters and converts them for shading. `names`: those of the index and of the absorption coefficient in errors.
    pub(super) fn resolve<R: ParameterResolver<P>>(
        &self,
        names: [&'static str; 2],
        resolver: &R,
    ) -> Result<MetalColor, MaterialError> {
        Ok(match self {
            Self::Index { eta, k } => MetalColor::Index {
                eta: resolver.spectrum(names[0], eta)?,
                k: resolver.spectrum(names[1], k)?,
            },
            Self::Reflectance(reflectance) => {
                MetalColor::Reflectance(resolver.fraction("reflectance", reflectance)?)
            }
        })
    }
}

impl MetalColor {
    /// The metal at a point.
    pub(super) fn at(&self, at: &TextureEvaluator<'_>) -> ConductorFresnel {
        match self {
            Self::Index { eta, k } => {
                ConductorFresnel { eta: at.spectrum(eta), k: at.spectrum(k), tint: at.white() }
            }
            Self::Reflectance(reflectance) => {
                ConductorFresnel::of_reflectance(at.fraction(reflectance), at.white())
            }
        }
    }
}

/// The material of [`Conductor`].
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorMaterial<P: ParameterForm = ShadingForm> {
    /// Its optical constants.
    pub color: MetalColor<P>,
    /// Its facets.
    pub roughness: Roughness<P>,
    /// Whether light between facets counts.
    pub multiple_scattering: bool,
    /// Finish of the surface, which must have no facets.
    pub finish: Option<SurfaceFinish>,
}

impl<P: ParameterForm> MaterialModel<P> for ConductorMaterial<P> {
    type Textured = ConductorMaterial;

    fn kind(&self) -> &'static str {
        "conductor"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<ConductorMaterial, MaterialError> {
        let roughness = self.roughness.resolve("roughness", resolver)?;
        if self.finish.is_some() && !roughness.is_smooth() {
            return Err(MaterialError::RoughFinish);
        }
        Ok(ConductorMaterial {
            color: self.color.resolve(["eta", "k"], resolver)?,
            roughness,
            multiple_scattering: self.multiple_scattering,
            finish: self.finish.clone().filter(|finish| finish.total_scatter() > 0.0),
        })
    }
}

impl TexturedModel for ConductorMaterial {
    type Bsdf<'a> = Conductor<'a>;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Conductor<'_> {
        let metal =
            Conductor::new(self.color.at(at), self.roughness.distribution(at), self.multiple_scattering);
        metal.with_finish(self.finish.as_ref())
    }
}

impl<P: ParameterForm<Float: From<f32>>> Material<P> {
    /// Smooth metal of refractive index `eta` and absorption coefficient `k`.
    #[must_use]
    pub fn conductor(eta: impl Into<P::Spectrum>, k: impl Into<P::Spectrum>) -> Self {
        Self::Conductor(ConductorMaterial {
            color: MetalColor::Index { eta: eta.into(), k: k.into() },
            roughness: Roughness::smooth(),
            multiple_scattering: true,
            finish: None,
        })
    }
}
