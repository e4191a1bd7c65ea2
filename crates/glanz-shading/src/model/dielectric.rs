//! Glass.

use std::ops::RangeInclusive;

use glanz_light::{SpectralDistribution, Spectrum};
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::mirror::mirror_image;
use super::roughness::Roughness;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, estimated_albedo, to_side_of, upper_side};
use crate::fresnel::{self, DielectricSplit};
use crate::microfacet::interface::{InterfaceScattering, Refraction};
use crate::microfacet::{MicrofacetDistribution, half_vector};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;

/// Relative refractive indices that the material may have.
const INDICES: RangeInclusive<f32> = 1e-3..=1e3;

/// Opacity in a rasteriser: enough to see that there is glass.
const PREVIEW_OPACITY: f32 = 0.15;

/// A boundary between two transparent media, smooth or with facets, or (`thin`) a sheet between two smooth boundaries.
///
/// # Source
/// @walter2007 with the masking of @heitz2014; light between facets after @kulla2017, see [`InterfaceScattering`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    eta: f64,
    reflectance: Spectrum,
    transmittance: Spectrum,
    thin: bool,
    distribution: MicrofacetDistribution,
    /// Light between facets, of light that arrives outside.
    multiple: Option<InterfaceScattering>,
    /// Whether the index is that of the hero of sampled wavelengths, see [`BsdfModel::is_dispersive`].
    dispersive: bool,
}

/// A direction and the refractive indices seen from there, with what facets do to its light.
struct RoughView {
    /// On the upper side.
    wo: DVec3,
    /// Refractive index on the far side over that on its own side.
    eta: f64,
    multiple: Option<InterfaceScattering>,
    /// Fraction of its light that facets send to others.
    lost: f64,
}

impl Dielectric {
    /// A smooth boundary.
    ///
    /// `eta`: refractive index inside (z < 0) over that outside, in [0.001, 1000]. `reflectance` and `transmittance`: factors on reflected and on
    /// transmitted light, [0, 1]; 1 for real glass.
    #[must_use]
    pub fn new(eta: f64, reflectance: Spectrum, transmittance: Spectrum) -> Self {
        let distribution = MicrofacetDistribution::SMOOTH;
        Self { eta, reflectance, transmittance, thin: false, distribution, multiple: None, dispersive: false }
    }

    /// The same as a sheet too thin to displace a ray, which has no facets: light passes straight through and is reflected by both faces.
    #[must_use]
    pub fn as_sheet(self) -> Self {
        Self { thin: true, distribution: MicrofacetDistribution::SMOOTH, multiple: None, ..self }
    }

    /// The same boundary with facets. `multiple_scattering`: whether light between facets counts, if they are isotropic.
    #[must_use]
    pub fn with_facets(self, distribution: MicrofacetDistribution, multiple_scattering: bool) -> Self {
        let rough = Self { distribution, thin: false, ..self };
        let multiple = multiple_scattering && !rough.is_delta();
        let multiple = if multiple { InterfaceScattering::new(&distribution, self.eta) } else { None };
        Self { multiple, ..rough }
    }

    /// The same with an index that is, or is not, that of the hero of sampled wavelengths, see [`BsdfModel::is_dispersive`].
    #[must_use]
    pub fn with_dispersion(self, dispersive: bool) -> Self {
        Self { dispersive, ..self }
    }

    /// Refractive index inside (z < 0) over that outside.
    #[must_use]
    pub fn eta(&self) -> f64 {
        self.eta
    }

    /// The mirrored and the refracted direction, each with the whole fraction of light it carries as weight.
    ///
    /// `None` for one that carries nothing: total reflection, equal media, black factors.
    fn branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        if wo.z == 0.0 {
            return [None; 2];
        }
        let split = self.split(wo.z.abs(), self.eta_from(wo));
        let reflected = self.reflectance * split.reflectance as f32;
        let transmitted = self.transmittance * (1.0 - split.reflectance) as f32;
        let transmission = self.transmission(wo, split.cos_transmitted, transmitted, mode);
        [
            (!reflected.is_black()).then(|| mirror_image(wo, reflected)),
            transmission.filter(|_| !split.total && !transmitted.is_black()),
        ]
    }

    fn transmission(
        &self,
        wo: DVec3,
        cos_transmitted: f64,
        share: Spectrum,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        let lobe = Lobe::SPECULAR_TRANSMISSION;
        if self.thin {
            return Some(BsdfSample::delta(-wo, share, lobe));
        }
        let eta = self.eta_from(wo);
        let (x, y) = (-wo.x / eta, -wo.y / eta);
        let z2 = 1.0 - x * x - y * y;
        // Towards the thinner medium the tangential part determines the angle better than the cosine does.
        let cos = if eta < 1.0 && z2 > 0.0 { z2.sqrt() } else { cos_transmitted };
        let wi = DVec3::new(x, y, -cos.copysign(wo.z)).try_normalize()?;
        let eta_scale = match mode {
            // Refraction preserves radiance over the squared index.
            TransportMode::Radiance => (eta * eta) as f32,
            TransportMode::Importance => 1.0,
        };
        Some(BsdfSample { eta_scale, ..BsdfSample::delta(wi, share * (1.0 / eta_scale), lobe) })
    }

    /// Refractive index on the far side of `wo` over that on its own side.
    fn eta_from(&self, wo: DVec3) -> f64 {
        if wo.z > 0.0 { self.eta } else { 1.0 / self.eta }
    }

    /// `None` along the surface.
    fn rough_view(&self, wo: DVec3) -> Option<RoughView> {
        let eta = self.eta_from(wo);
        let multiple = self.multiple.map(|outside| if wo.z > 0.0 { outside } else { outside.beyond() });
        let [wo, _] = upper_side(wo, wo)?;
        let lost = multiple.as_ref().map_or(0.0, |multiple| multiple.lost(wo));
        Some(RoughView { wo, eta, multiple, lost })
    }

    /// Probability of reflection of light of a facet that reflects the fraction `reflectance`.
    fn reflection_probability(&self, reflectance: f64) -> f64 {
        let r = f64::from(self.reflectance.max_component()) * reflectance;
        let t = f64::from(self.transmittance.max_component()) * (1.0 - reflectance);
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }

    /// `f |cos|` of reflection to `wi` (above).
    fn rough_reflection(&self, view: &RoughView, wi: DVec3) -> f64 {
        let m = half_vector(view.wo, wi);
        let share = fresnel::dielectric(view.wo.dot(m), view.eta).reflectance;
        let multiple = view.multiple.as_ref().map_or(0.0, |x| x.reflection(view.lost, x.lost(wi)));
        share * self.distribution.reflection(view.wo, wi, m) + multiple * wi.z
    }

    /// `f |cos|` of transmission from `wi` (below), and the density of sampling `wi`.
    fn rough_transmission(&self, view: &RoughView, wi: DVec3) -> (f64, f64) {
        let eta2 = view.eta * view.eta;
        let multiple = view.multiple.as_ref().map_or(0.0, |x| x.transmission(view.lost, x.lost_beyond(-wi)));
        // Transmission in the other direction has this flux per flux; radiance changes by the square of the index.
        let multiple = multiple / eta2 * -wi.z;
        let Some(Refraction { m, jacobian }) = Refraction::between(view.wo, wi, view.eta) else {
            return (multiple, 0.0);
        };
        let share = fresnel::dielectric(view.wo.dot(m), view.eta).reflectance;
        // D G (o.m) / cos_o: that of reflection has 4 (o.m) steradians of directions per steradian of normals.
        let facets = 4.0 * self.distribution.reflection(view.wo, -wi, m) * view.wo.dot(m) * jacobian;
        let single = (1.0 - share) * facets / eta2;
        let pdf = self.distribution.visible_pdf(view.wo, m) * jacobian;
        (single + multiple, pdf * (1.0 - self.reflection_probability(share)))
    }

    /// A direction that one facet scatters, or one of light between facets.
    pub(super) fn sample_rough(&self, wo: DVec3, xi: DVec2, xi_lobe: f64) -> Option<(DVec3, Lobe)> {
        let view = self.rough_view(wo)?;
        let (wi, transmits) = if xi_lobe < view.lost {
            let transmitted = view.multiple.as_ref().map_or(0.0, |multiple| multiple.transmitted);
            let transmits = xi_lobe >= view.lost * self.reflection_probability(1.0 - transmitted);
            let wi = warp::cosine_hemisphere(xi);
            (if transmits { -wi } else { wi }, transmits)
        } else {
            let m = self.distribution.sample_visible(view.wo, xi);
            let share = fresnel::dielectric(view.wo.dot(m), view.eta).reflectance;
            let choice = (xi_lobe - view.lost) / (1.0 - view.lost);
            if choice < self.reflection_probability(share) {
                (fresnel::reflect(view.wo, m), false)
            } else {
                (fresnel::refract(view.wo, m, view.eta)?, true)
            }
        };
        let wi = to_side_of(wo, wi).normalize();
        // Facets may reflect light below the surface and refract it above.
        let lobe = if transmits { Lobe::GLOSSY_TRANSMISSION } else { Lobe::GLOSSY };
        ((wi.z * wo.z < 0.0) == transmits && wi.z != 0.0).then_some((wi, lobe))
    }

    fn split(&self, cos: f64, eta: f64) -> DielectricSplit {
        // A sheet has the same medium on both sides: its far side is never the thinner one.
        if self.thin { fresnel::pane(cos, self.eta) } else { fresnel::dielectric(cos, eta) }
    }
}

impl BsdfModel for Dielectric {
    const LOBES: &'static [Lobe] =
        &[Lobe::SPECULAR_REFLECTION, Lobe::SPECULAR_TRANSMISSION, Lobe::GLOSSY, Lobe::GLOSSY_TRANSMISSION];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        let view = if self.is_delta() { None } else { self.rough_view(wo) };
        match (view, upper_side(wo, wi)) {
            (Some(view), Some([_, wi])) if wi.z > 0.0 => {
                self.reflectance * self.rough_reflection(&view, wi) as f32
            }
            (Some(view), Some([_, wi])) if wi.z < 0.0 => {
                self.transmittance * self.rough_transmission(&view, wi).0 as f32
            }
            _ => Spectrum::BLACK,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let view = if self.is_delta() { None } else { self.rough_view(wo) };
        let (Some(view), Some([_, wi])) = (view, upper_side(wo, wi)) else { return SolidAnglePdf(0.0) };
        let transmitted = view.multiple.as_ref().map_or(0.0, |multiple| multiple.transmitted);
        let reflected = self.reflection_probability(1.0 - transmitted);
        let (single, side) = if wi.z > 0.0 {
            let m = half_vector(view.wo, wi);
            let cos = view.wo.dot(m);
            let share = self.reflection_probability(fresnel::dielectric(cos, view.eta).reflectance);
            (share * self.distribution.visible_pdf(view.wo, m) / (4.0 * cos), reflected)
        } else {
            (self.rough_transmission(&view, wi).1, 1.0 - reflected)
        };
        let multiple = side * warp::cosine_hemisphere_pdf(wi.z.abs()).0;
        SolidAnglePdf((1.0 - view.lost) * single + view.lost * multiple)
    }

    /// The mirrored or the refracted direction, selected by `xi_lobe` in proportion to the light they carry; of rough glass at a facet.
    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        if !self.is_delta() {
            let (wi, lobe) = self.sample_rough(wo, xi, xi_lobe)?;
            return BsdfSample::of_direction(self, [wo, wi], lobe, mode);
        }
        let [reflection, transmission] = self.branches(wo, mode);
        let flux = |branch: &Option<BsdfSample>| {
            branch.as_ref().map_or(0.0, |s| f64::from((s.weight * s.eta_scale).max_component()))
        };
        let (r, t) = (flux(&reflection), flux(&transmission));
        let (branch, probability) =
            if xi_lobe * (r + t) < r { (reflection, r / (r + t)) } else { (transmission, t / (r + t)) };
        branch.map(|s| BsdfSample { weight: s.weight * (1.0 / probability) as f32, ..s })
    }

    /// Facets between equal media do nothing.
    fn is_delta(&self) -> bool {
        self.thin || self.distribution.is_smooth() || self.eta == 1.0
    }

    fn is_dispersive(&self) -> bool {
        self.dispersive
    }

    fn is_anisotropic(&self) -> bool {
        self.distribution.is_anisotropic()
    }

    fn transmits(&self) -> bool {
        !self.is_delta()
    }

    fn eta_scale(&self, wo: DVec3, wi: DVec3) -> f32 {
        if self.thin || wo.z * wi.z > 0.0 { 1.0 } else { self.eta_from(wo).powi(2) as f32 }
    }

    fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        if self.is_delta() { self.branches(wo, mode) } else { [None; 2] }
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        if !self.is_delta() {
            return estimated_albedo(self, wo);
        }
        let r = self.split(wo.z.abs(), self.eta_from(wo)).reflectance as f32;
        self.reflectance.lerp(self.transmittance, 1.0 - r)
    }

    fn preview(&self) -> PreviewSurface {
        let upright = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        PreviewSurface {
            specular: self.reflectance * upright as f32,
            roughness: self.distribution.preview_roughness(),
            opacity: PREVIEW_OPACITY,
            ..PreviewSurface::diffuse(self.transmittance)
        }
    }
}

/// The material of [`Dielectric`].
#[derive(Clone, Debug, PartialEq)]
pub struct DielectricMaterial<P: ParameterForm = ShadingForm> {
    /// Refractive index inside over outside, in [0.001, 1000] (far beyond any medium; squares still fit `f32`); a
    /// texture's value outside counts as 1. At sampled wavelengths that of `dispersion` replaces it.
    pub eta: P::Float,
    /// Refractive index by wavelength, which a pane does not use; without effect unless it is sampled and differs between wavelengths.
    pub dispersion: Option<SpectralDistribution>,
    /// Factor on reflected light.
    pub reflectance: P::Spectrum,
    /// Factor on transmitted light.
    pub transmittance: P::Spectrum,
    /// Whether the surface is a pane with two faces, too thin to displace a ray, instead of the border of a solid.
    pub thin: bool,
    /// Facets, which a pane does not have.
    pub roughness: Roughness<P>,
    /// Whether light between facets counts, if they are isotropic.
    pub multiple_scattering: bool,
}

impl<P: ParameterForm> MaterialModel<P> for DielectricMaterial<P> {
    type Textured = DielectricMaterial;

    fn kind(&self) -> &'static str {
        if self.thin { "thindielectric" } else { "dielectric" }
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<DielectricMaterial, MaterialError> {
        let samples = match &self.dispersion {
            Some(SpectralDistribution::Sampled(samples)) if !self.thin => Some(samples),
            _ => None,
        };
        if let Some(samples) = samples {
            let (low, high) = samples.range();
            if let Some(value) = [low, high].into_iter().find(|value| !INDICES.contains(value)) {
                let range = "a number between 0.001 and 1000 at every wavelength";
                return Err(MaterialError::Range { parameter: "eta", value, range });
            }
        }
        Ok(DielectricMaterial {
            eta: resolver.float("eta", &self.eta, INDICES, "a number between 0.001 and 1000")?,
            // With the same index everywhere all wavelengths can continue.
            dispersion: samples
                .filter(|samples| !samples.is_flat())
                .map(|samples| SpectralDistribution::Sampled(samples.clone())),
            reflectance: resolver.fraction("reflectance", &self.reflectance)?,
            transmittance: resolver.fraction("transmittance", &self.transmittance)?,
            thin: self.thin,
            roughness: self.roughness.resolve("roughness", resolver)?,
            multiple_scattering: self.multiple_scattering,
        })
    }
}

impl TexturedModel for DielectricMaterial {
    type Bsdf<'a> = Dielectric;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Dielectric {
        let hero = self.dispersion.as_ref().and_then(|dispersion| at.hero_index(dispersion));
        let eta = hero.unwrap_or_else(|| at.float(&self.eta));
        let eta = if INDICES.contains(&eta) { f64::from(eta) } else { 1.0 };
        let smooth = Dielectric::new(eta, at.fraction(&self.reflectance), at.fraction(&self.transmittance));
        let smooth = smooth.with_dispersion(hero.is_some());
        if self.thin {
            smooth.as_sheet()
        } else {
            smooth.with_facets(self.roughness.distribution(at), self.multiple_scattering)
        }
    }
}

impl<P: ParameterForm<Float: From<f32>>> Material<P> {
    /// Smooth glass of refractive index `eta`, with factors on the light that it reflects and transmits.
    #[must_use]
    pub fn dielectric(
        eta: impl Into<P::Float>,
        reflectance: impl Into<P::Spectrum>,
        transmittance: impl Into<P::Spectrum>,
    ) -> Self {
        Self::Dielectric(DielectricMaterial {
            eta: eta.into(),
            dispersion: None,
            reflectance: reflectance.into(),
            transmittance: transmittance.into(),
            thin: false,
            roughness: Roughness::smooth(),
            multiple_scattering: true,
        })
    }

    /// A pane of smooth glass, too thin to displace a ray, with the parameters of [`Material::dielectric`].
    #[must_use]
    pub fn thin_dielectric(
        eta: impl Into<P::Float>,
        reflectance: impl Into<P::Spectrum>,
        transmittance: impl Into<P::Spectrum>,
    ) -> Self {
        match Self::dielectric(eta, reflectance, transmittance) {
            Self::Dielectric(glass) => Self::Dielectric(DielectricMaterial { thin: true, ..glass }),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Dielectric {
        fn draw(&self, wo: DVec3, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
            self.sample(wo, DVec2::splat(0.5), xi_lobe, mode)
        }
    }

    fn glass(thin: bool) -> Dielectric {
        let glass = Dielectric::new(1.5, Spectrum::ONE, Spectrum::ONE);
        if thin { glass.as_sheet() } else { glass }
    }

    #[test]
    fn glass_at_normal_incidence_reflects_four_percent_of_samples_with_weight_one() {
        for (xi, transmission) in [(0.0399, false), (0.0401, true)] {
            let s = glass(false).draw(DVec3::Z, xi, TransportMode::Importance).unwrap();
            assert_eq!(s.lobe.transmission, transmission);
            assert!((s.weight - Spectrum::ONE).max_component().abs() < 1e-6);
            assert_eq!(s.pdf, SolidAnglePdf(f64::INFINITY));
            assert_eq!(s.wi, if transmission { -DVec3::Z } else { DVec3::Z });
        }
    }

    #[test]
    fn radiance_entering_and_leaving_glass_is_unchanged_and_eta_scale_undoes_each_change() {
        let wo = DVec3::new(0.6, 0.0, 0.8);
        let enter = glass(false).draw(wo, 0.999, TransportMode::Radiance).unwrap();
        assert!((enter.wi.x + 0.4).abs() < 1e-15, "Snell: 0.6 / 1.5");
        assert!((enter.weight * enter.eta_scale - Spectrum::ONE).max_component().abs() < 1e-6);
        assert!((enter.eta_scale - 2.25).abs() < 1e-6);
        // From inside, `wo` of the next vertex is the way back.
        let leave = glass(false).draw(-enter.wi, 0.999, TransportMode::Radiance);
        let outside =
            glass(false).draw(DVec3::new(0.4, 0.0, -(1.0_f64 - 0.16).sqrt()), 0.999, TransportMode::Radiance);
        let (leave, outside) = (leave.unwrap(), outside.unwrap());
        assert!((leave.eta_scale * 1.0 - 2.25).abs() < 1e-6, "still seen from outside");
        assert!((outside.eta_scale - 1.0 / 2.25).abs() < 1e-6);
        assert!((outside.wi - DVec3::new(-0.6, 0.0, 0.8)).length() < 1e-15);
        let product = enter.weight * outside.weight;
        assert!((product - Spectrum::ONE).max_component().abs() < 1e-6);
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        let wo = DVec3::new(0.8, 0.0, -0.6);
        for xi in [0.0, 0.5, 0.999_999] {
            let s = glass(false).draw(wo, xi, TransportMode::Radiance).unwrap();
            assert_eq!(s.lobe, Lobe::SPECULAR_REFLECTION);
            assert_eq!(s.weight, Spectrum::ONE);
            assert_eq!(s.wi, DVec3::new(-0.8, 0.0, -0.6));
        }
    }

    #[test]
    fn thin_sheet_is_the_same_from_both_sides_and_reflects_twice_as_much() {
        for z in [1.0, -1.0] {
            // 2 * 0.04 / 1.04
            let limit = 0.08 / 1.04;
            let s = glass(true).draw(DVec3::Z * z, limit - 1e-6, TransportMode::Radiance).unwrap();
            assert_eq!(s.lobe, Lobe::SPECULAR_REFLECTION);
            let s = glass(true).draw(DVec3::Z * z, limit + 1e-6, TransportMode::Radiance).unwrap();
            assert_eq!((s.wi, s.eta_scale), (DVec3::Z * -z, 1.0));
        }
    }

    #[test]
    fn coloured_glass_keeps_its_expectation() {
        let wo = DVec3::new(0.96, 0.0, 0.28);
        for thin in [false, true] {
            let model = Dielectric {
                reflectance: Spectrum::from_rgb([0.5, 0.2, 0.1]),
                transmittance: Spectrum::from_rgb([0.1, 0.9, 0.4]),
                ..glass(thin)
            };
            let n = 10_000;
            let sum: Spectrum = (0..n)
                .filter_map(|i| {
                    model.draw(wo, (f64::from(i) + 0.5) / f64::from(n), TransportMode::Importance)
                })
                .map(|s| s.weight)
                .sum();
            let expected = model.albedo(wo);
            // The midpoint rule in xi errs by one sample at the border of the lobes.
            let error = (sum * (1.0 / n as f32) - expected).map(f32::abs).max_component();
            assert!(error < 2e-4, "{thin}: {error}");
        }
    }

    #[test]
    fn sheet_transmits_the_mean_of_both_polarisations() {
        // (1 - r) / (1 + r) with r of each, by Fresnel's equations: values of n = 1.5 at 60, 70 and 80 degrees, and of n = 2.4 at 60.
        for (n, degrees, transmitted) in
            [(1.5, 60.0, 0.848_128), (1.5, 70.0, 0.728_712), (1.5, 80.0, 0.458_473), (2.4, 60.0, 0.697_291)]
        {
            let sheet = Dielectric::new(n, Spectrum::ONE, Spectrum::ONE).as_sheet();
            let angle = f64::to_radians(degrees);
            for z in [angle.cos(), -angle.cos()] {
                let wo = DVec3::new(angle.sin(), 0.0, z);
                for mode in [TransportMode::Radiance, TransportMode::Importance] {
                    let [reflection, transmission] = sheet.branches(wo, mode).map(Option::unwrap);
                    let weights =
                        [reflection.weight, transmission.weight].map(|w| f64::from(w.max_component()));
                    let [r, t] = weights;
                    assert!(
                        (t - transmitted).abs() < 1e-6 && (r + t - 1.0).abs() < 2e-7,
                        "{n} {degrees}: {r} {t}"
                    );
                    // Samples: transmission from the reflected fraction on, each of weight 1.
                    for (xi, passes) in [(r - 1e-6, false), (r + 1e-6, true)] {
                        let sample = sheet.draw(wo, xi, mode).unwrap();
                        assert_eq!(sample.lobe.transmission, passes);
                        assert!((sample.weight - Spectrum::ONE).map(f32::abs).max_component() < 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn branches_share_the_flux_and_samples_are_branches() {
        let wo = DVec3::new(0.6, 0.0, 0.8);
        for model in [glass(false), glass(true)] {
            let branches = model.branches(wo, TransportMode::Radiance);
            let flux: Spectrum = branches.iter().flatten().map(|s| s.weight * s.eta_scale).sum();
            assert!((flux - Spectrum::ONE).map(f32::abs).max_component() < 1e-6);
            for (branch, xi) in branches.into_iter().zip([0.0, 0.999_999]) {
                let (branch, sample) =
                    (branch.unwrap(), model.draw(wo, xi, TransportMode::Radiance).unwrap());
                assert_eq!(
                    (branch.wi, branch.lobe, branch.eta_scale),
                    (sample.wi, sample.lobe, sample.eta_scale)
                );
            }
        }
        // Beyond the critical angle of 41.8 degrees there is one branch; where the media agree there is the other.
        let inside = DVec3::new(0.8, 0.0, -0.6);
        assert!(matches!(glass(false).branches(inside, TransportMode::Radiance), [Some(_), None]));
        let matched = Dielectric { eta: 1.0, ..glass(false) };
        assert!(matches!(matched.branches(inside, TransportMode::Radiance), [None, Some(_)]));
    }

    #[test]
    fn black_lobes_are_never_selected() {
        let model = Dielectric { reflectance: Spectrum::BLACK, ..glass(false) };
        let s = model.draw(DVec3::Z, 0.0, TransportMode::Importance).unwrap();
        assert!(s.lobe.transmission);
        assert!((s.weight - Spectrum::splat(0.96)).max_component().abs() < 1e-6);
    }
}
