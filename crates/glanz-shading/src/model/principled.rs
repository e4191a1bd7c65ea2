//! A model with the parameters of artists: metallic-roughness with coat, sheen and transmission.

use std::f64::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::conductor::{Conductor, ConductorFresnel, MetalColor};
use super::dielectric::Dielectric;
use super::roughness::{Roughness, RoughnessScale};
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, estimated_albedo, to_side_of, upper_side};
use crate::microfacet::coat::Coat;
use crate::microfacet::sheen::SheenDistribution;
use crate::microfacet::{MicrofacetDistribution, SMOOTH, clamp_unit};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;

/// Layers as of glTF and OpenPBR: fibres over a coat over a mixture of metal, glass and a glossy diffuse surface.
///
/// A layer passes on what it does not reflect: the smaller of 1 - R(o) and 1 - R(i); the surface of the diffuse part (1 - R(o)) (1 - R(i)) / (1 - mean R), so
/// that a white one scatters all light. Both keep reciprocity, and no layer creates light.
///
/// # Source
/// @khr_gltf appendix B and its extensions, @openpbr; departures: reciprocal layers, and metals after Fresnel's equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// 1 in the lanes in use.
    white: Spectrum,
    metallic: f64,
    /// Fraction of what is not metallic.
    transmission: f64,
    metal: Conductor<'static>,
    /// The largest lane of the reflectance of the metal at normal incidence.
    metal_max: f64,
    glass: Dielectric,
    color: Spectrum,
    /// Factor on what the interface of the glossy surface reflects, and its largest component.
    specular: Spectrum,
    specular_max: f64,
    interface: Coat,
    /// 1 over the mean of what it passes on, of diffuse light.
    diffuse_scale: f64,
    coat_weight: f64,
    coat: Coat,
    /// Colour of the fibres, and its largest component.
    sheen_color: Spectrum,
    sheen_max: f64,
    sheen: SheenDistribution,
}

/// Probabilities of sampling the parts, for one direction.
struct PartProbabilities {
    diffuse: f64,
    interface: f64,
    metal: f64,
    glass: f64,
    coat: f64,
    sheen: f64,
}

impl Principled {
    /// Fractions of the light from `w` (above) that the fibres and the coat reflect.
    fn layer_reflectances(&self, w: DVec3) -> [f64; 2] {
        let sheen = if self.sheen_max > 0.0 { self.sheen_max * self.sheen.albedo(w.z) } else { 0.0 };
        let coat = if self.coat_weight > 0.0 { self.coat_weight * self.coat.reflectance(w) } else { 0.0 };
        [sheen, coat]
    }

    fn probabilities(&self, wo: DVec3) -> PartProbabilities {
        let [sheen, coat] = self.layer_reflectances(wo);
        let below = (1.0 - sheen) * (1.0 - coat);
        let (metallic, glossy) = (self.metallic, (1.0 - self.metallic) * (1.0 - self.transmission));
        let interface = if glossy > 0.0 { self.specular_max * self.interface.reflectance(wo) } else { 0.0 };
        let bright = f64::from(self.color.max_component());
        let parts = PartProbabilities {
            diffuse: below * glossy * bright * (1.0 - interface),
            interface: below * glossy * interface,
            metal: below * metallic * self.metal_max,
            glass: below * (1.0 - metallic) * self.transmission,
            coat: (1.0 - sheen) * coat,
            sheen,
        };
        let sum = parts.diffuse + parts.interface + parts.metal + parts.glass + parts.coat + parts.sheen;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        PartProbabilities {
            diffuse: parts.diffuse * scale,
            interface: parts.interface * scale,
            metal: parts.metal * scale,
            glass: parts.glass * scale,
            coat: parts.coat * scale,
            sheen: parts.sheen * scale,
        }
    }

    /// The diffuse part, `f cos` without the weight of the glossy surface.
    fn diffuse(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let through = |w| 1.0 - self.specular_max * self.interface.reflectance(w);
        self.color * (FRAC_1_PI * wi.z * through(wo) * through(wi) * self.diffuse_scale) as f32
    }

    /// The factors of the fibres on the coat, and of both on the base; both directions above.
    fn layers(&self, wo: DVec3, wi: DVec3) -> [f64; 2] {
        let ([sheen_o, coat_o], [sheen_i, coat_i]) =
            (self.layer_reflectances(wo), self.layer_reflectances(wi));
        let sheen = 1.0 - sheen_o.max(sheen_i);
        [sheen, sheen * (1.0 - coat_o.max(coat_i))]
    }

    /// `f cos` of the glossy surface and the layers; both directions above.
    fn opaque(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let [coat, base] = self.layers(wo, wi);
        let glossy = (1.0 - self.metallic) * (1.0 - self.transmission);
        let mut value = Spectrum::BLACK;
        if glossy > 0.0 {
            let surface = self.specular * self.interface.eval(wo, wi) as f32;
            value += (self.diffuse(wo, wi) + surface) * (glossy * base) as f32;
        }
        if self.metallic > 0.0 {
            value += self.metal.eval(wo, wi) * (self.metallic * base) as f32;
        }
        if self.coat_weight > 0.0 {
            value += self.white * (coat * self.coat_weight * self.coat.eval(wo, wi)) as f32;
        }
        if self.sheen_max > 0.0 {
            value += self.sheen_color * self.sheen.eval(wo, wi) as f32;
        }
        value
    }

    /// The factor on light that glass scatters.
    fn glass_weight(&self, wo: DVec3, wi: DVec3) -> f32 {
        let [_, base] = self.layers(wo, DVec3::new(wi.x, wi.y, wi.z.abs()));
        ((1.0 - self.metallic) * self.transmission * base) as f32
    }

    /// A sample of a delta lobe of the glass, of which `probability` is the share of samples.
    fn glass_delta(&self, wo: DVec3, sample: BsdfSample, probability: f64) -> BsdfSample {
        let [up, wi] = upper_side(wo, sample.wi).unwrap_or([wo, sample.wi]);
        let weight = sample.weight * self.glass_weight(up, wi) * (1.0 / probability) as f32;
        BsdfSample { weight, ..sample }
    }
}

impl BsdfModel for Principled {
    const LOBES: &'static [Lobe] = &[
        Lobe::DIFFUSE,
        Lobe::GLOSSY,
        Lobe::GLOSSY_TRANSMISSION,
        Lobe::SPECULAR_REFLECTION,
        Lobe::SPECULAR_TRANSMISSION,
    ];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let Some([o, i]) = upper_side(wo, wi) else { return Spectrum::BLACK };
        let mut value = if i.z > 0.0 { self.opaque(o, i) } else { Spectrum::BLACK };
        if self.transmits() {
            value += self.glass.eval(wo, wi) * self.glass_weight(o, i);
        }
        value
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let Some([o, i]) = upper_side(wo, wi) else { return SolidAnglePdf(0.0) };
        let parts = self.probabilities(o);
        let mut pdf = if parts.glass > 0.0 { parts.glass * self.glass.pdf(wo, wi).0 } else { 0.0 };
        if i.z > 0.0 {
            pdf += parts.diffuse * warp::cosine_hemisphere_pdf(i.z).0;
            // Fibres are bright at grazing angles, where the cosine has few samples.
            pdf += parts.sheen * warp::uniform_hemisphere_pdf(i.z).0;
            pdf += if parts.interface > 0.0 { parts.interface * self.interface.pdf(o, i) } else { 0.0 };
            pdf += if parts.metal > 0.0 { parts.metal * self.metal.pdf(o, i).0 } else { 0.0 };
            pdf += if parts.coat > 0.0 { parts.coat * self.coat.pdf(o, i) } else { 0.0 };
        }
        SolidAnglePdf(pdf)
    }

    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        let [up, _] = upper_side(wo, wo)?;
        let parts = self.probabilities(up);
        let mut rest = xi_lobe;
        // Whether a part is selected; `rest` becomes uniform over it.
        let mut selects = |probability: f64| {
            let is_selected = rest < probability;
            rest = if is_selected { rest / probability } else { rest - probability };
            is_selected.then_some(rest)
        };
        let (wi, lobe) = if selects(parts.diffuse).is_some() {
            (warp::cosine_hemisphere(xi), Lobe::DIFFUSE)
        } else if selects(parts.sheen).is_some() {
            (warp::uniform_hemisphere(xi), Lobe::GLOSSY)
        } else if let Some(xi_lobe) = selects(parts.interface) {
            (self.interface.sample(up, xi, xi_lobe), Lobe::GLOSSY)
        } else if let Some(xi_lobe) = selects(parts.metal) {
            (self.metal.sample_rough(up, xi, xi_lobe), Lobe::GLOSSY)
        } else if let Some(xi_lobe) = selects(parts.glass) {
            let xi_lobe = xi_lobe.min(1.0 - f64::EPSILON);
            if self.glass.is_delta() {
                let sample = self.glass.sample(wo, xi, xi_lobe, mode)?;
                return Some(self.glass_delta(wo, sample, parts.glass));
            }
            let (wi, lobe) = self.glass.sample_rough(wo, xi, xi_lobe)?;
            return BsdfSample::of_direction(self, [wo, wi], lobe, mode);
        } else {
            (self.coat.sample(up, xi, selects(parts.coat)?), Lobe::GLOSSY)
        };
        // Facets may reflect light below the surface, where glass would scatter it.
        if wi.z <= 0.0 {
            return None;
        }
        BsdfSample::of_direction(self, [wo, to_side_of(wo, wi)], lobe, mode)
    }

    /// Whether there is nothing but clear glass.
    fn is_delta(&self) -> bool {
        let covered = self.coat_weight > 0.0 || self.sheen_max > 0.0;
        self.metallic == 0.0 && self.transmission == 1.0 && !covered && self.glass.is_delta()
    }

    fn eta_scale(&self, wo: DVec3, wi: DVec3) -> f32 {
        self.glass.eta_scale(wo, wi)
    }

    fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        if self.metallic == 1.0 || self.transmission == 0.0 {
            return [None; 2];
        }
        let branches = self.glass.delta_branches(wo, mode);
        branches.map(|branch| branch.map(|branch| self.glass_delta(wo, branch, 1.0)))
    }

    fn is_anisotropic(&self) -> bool {
        let coat = self.coat_weight > 0.0 && self.coat.distribution().is_anisotropic();
        coat || self.metal.is_anisotropic()
    }

    fn transmits(&self) -> bool {
        self.metallic < 1.0 && self.transmission > 0.0 && self.glass.transmits()
    }

    fn diffuse_probability(&self, wo: DVec3) -> f64 {
        upper_side(wo, wo).map_or(0.0, |[wo, _]| self.probabilities(wo).diffuse)
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        if self.is_delta() { self.glass.albedo(wo) } else { estimated_albedo(self, wo) }
    }

    fn preview(&self) -> PreviewSurface {
        let opaque = 1.0 - (1.0 - self.metallic) * self.transmission;
        let base = self.color.lerp(self.metal.normal_reflectance(), self.metallic as f32);
        PreviewSurface {
            specular: self.specular * self.interface.reflectance(DVec3::Z) as f32,
            metallic: self.metallic as f32,
            roughness: self.interface.distribution().preview_roughness(),
            opacity: opaque.max(f64::from(self.glass.preview().opacity)) as f32,
            ..PreviewSurface::diffuse(base)
        }
    }
}

/// The material of [`Principled`].
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipledMaterial<P: ParameterForm = ShadingForm> {
    /// Reflectance of the diffuse surface and of metal at normal incidence, transmittance of glass.
    pub base_color: P::Spectrum,
    /// 0 for a dielectric, 1 for metal.
    pub metallic: P::Float,
    /// Facets of the base.
    pub roughness: Roughness<P>,
    /// Refractive index of the base, in [1, 1000]; a texture's value outside counts as 1.
    pub eta: P::Float,
    /// Factor on the light that the glossy surface and glass reflect.
    pub specular: P::Spectrum,
    /// Optical constants of the metal, in place of the base colour.
    pub metal: Option<MetalColor<P>>,
    /// Fraction of what is not metallic that is glass.
    pub transmission: P::Float,
    /// Whether glass is a pane, too thin to displace a ray, which is always clear.
    pub thin: bool,
    /// Weight of the coat.
    pub coat: P::Float,
    /// Facets of the coat.
    pub coat_roughness: Roughness<P>,
    /// Refractive index of the coat, as `eta`.
    pub coat_eta: P::Float,
    /// Colour of the fibres of cloth.
    pub sheen: P::Spectrum,
    /// Roughness of the fibres, in [0, 1], whose square is their width.
    pub sheen_roughness: P::Float,
    /// Whether light between facets counts, of glass if they are isotropic.
    pub multiple_scattering: bool,
}

impl<P: ParameterForm<Float: From<f32>, Spectrum: From<f32>>> PrincipledMaterial<P> {
    /// A dielectric of index 1.5 and this colour, of a roughness in [0, 1] whose square is the width of facets.
    #[must_use]
    pub fn new(base_color: impl Into<P::Spectrum>, roughness: impl Into<P::Float>) -> Self {
        Self {
            base_color: base_color.into(),
            metallic: 0.0.into(),
            roughness: Roughness::isotropic(roughness, RoughnessScale::Square),
            eta: 1.5.into(),
            specular: 1.0.into(),
            metal: None,
            transmission: 0.0.into(),
            thin: false,
            coat: 0.0.into(),
            coat_roughness: Roughness::smooth(),
            coat_eta: 1.5.into(),
            sheen: 0.0.into(),
            sheen_roughness: 0.3.into(),
            multiple_scattering: true,
        }
    }
}

/// Names of the optical constants of the metal in errors.
const METAL_NAMES: [&str; 2] = ["metal.eta", "metal.k"];

impl<P: ParameterForm> MaterialModel<P> for PrincipledMaterial<P> {
    type Textured = PrincipledMaterial;

    fn kind(&self) -> &'static str {
        "principled"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<PrincipledMaterial, MaterialError> {
        let fraction = |name, input| resolver.float(name, input, 0.0..=1.0, "a number between 0 and 1");
        let index = |name, input| resolver.float(name, input, Coat::INDICES, "a number between 1 and 1000");
        Ok(PrincipledMaterial {
            base_color: resolver.fraction("basecolor", &self.base_color)?,
            metallic: fraction("metallic", &self.metallic)?,
            roughness: self.roughness.resolve("roughness", resolver)?,
            eta: index("eta", &self.eta)?,
            specular: resolver.fraction("specular", &self.specular)?,
            metal: self.metal.as_ref().map(|metal| metal.resolve(METAL_NAMES, resolver)).transpose()?,
            transmission: fraction("transmission", &self.transmission)?,
            thin: self.thin,
            coat: fraction("coat", &self.coat)?,
            coat_roughness: self.coat_roughness.resolve("coat.roughness", resolver)?,
            coat_eta: index("coat.eta", &self.coat_eta)?,
            sheen: resolver.fraction("sheen", &self.sheen)?,
            sheen_roughness: fraction("sheen.roughness", &self.sheen_roughness)?,
            multiple_scattering: self.multiple_scattering,
        })
    }
}

impl TexturedModel for PrincipledMaterial {
    type Bsdf<'a> = Box<Principled>;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Box<Principled> {
        let fraction = |input| clamp_unit(f64::from(at.float(input)));
        // Facets so small look smooth, and all parts but clear glass then have densities.
        let rough = |roughness: &Roughness| {
            let [x, y] = roughness.distribution(at).alpha();
            MicrofacetDistribution::new(x.max(SMOOTH), y.max(SMOOTH))
        };
        let [metallic, transmission, coat_weight] =
            [&self.metallic, &self.transmission, &self.coat].map(fraction);
        let glossy = (1.0 - metallic) * (1.0 - transmission);
        // Light between facets costs much to prepare; parts without weight do without.
        let multiple = |weight: f64| self.multiple_scattering && weight > 0.0;
        let white = at.white();
        let (color, specular) = (at.fraction(&self.base_color), at.fraction(&self.specular));
        let (distribution, eta) = (rough(&self.roughness), at.float(&self.eta));
        let interface = Coat::new(eta, distribution, multiple(glossy));
        let specular_max = f64::from(at.largest(specular, |at| at.fraction(&self.specular)));
        let mean_reflected =
            if glossy > 0.0 { specular_max * (1.0 - interface.mean_transmittance()) } else { 0.0 };
        let metal = match &self.metal {
            Some(metal) => metal.at(at),
            None => ConductorFresnel::of_reflectance(color, white),
        };
        let glass = Dielectric::new(interface.eta(), specular, color);
        let sheen_color = at.fraction(&self.sheen);
        Box::new(Principled {
            white,
            metallic,
            transmission,
            metal_max: if metallic > 0.0 { f64::from(metal.reflectance(1.0).max_component()) } else { 0.0 },
            metal: Conductor::new(metal, distribution, multiple(metallic)),
            glass: if self.thin {
                glass.as_sheet()
            } else {
                glass.with_facets(self.roughness.distribution(at), multiple(transmission))
            },
            color,
            specular,
            specular_max,
            interface,
            diffuse_scale: 1.0 / (1.0 - mean_reflected),
            coat_weight,
            coat: Coat::new(at.float(&self.coat_eta), rough(&self.coat_roughness), multiple(coat_weight)),
            sheen_color,
            sheen_max: f64::from(at.largest(sheen_color, |at| at.fraction(&self.sheen))),
            sheen: SheenDistribution::new(fraction(&self.sheen_roughness).powi(2)),
        })
    }
}

impl<P: ParameterForm<Float: From<f32>, Spectrum: From<f32>>> Material<P> {
    /// A dielectric after [`PrincipledMaterial::new`].
    #[must_use]
    pub fn principled(base_color: impl Into<P::Spectrum>, roughness: impl Into<P::Float>) -> Self {
        Self::Principled(PrincipledMaterial::new(base_color, roughness))
    }
}
