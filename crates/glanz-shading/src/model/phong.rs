//! The Phong model: normalised for transport, and in its classical form for the first renderers of the documents.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, Frame, SolidAnglePdf};
use glanz_sampling::warp;

use super::mirror::mirrored;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, same_side};
use crate::fresnel::reflect;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;
use crate::texture::SpectrumInput;

/// The modified Phong model: `kd / pi + ks (n + 2) / (2 pi) max(0, cos alpha)^n`, alpha from the mirrored direction.
///
/// Reciprocal, and creates no energy as long as `kd + ks <= 1`.
///
/// # Source
/// @lafortune1994.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    coefficients: PhongCoefficients,
    /// Factor that makes diffuse + specular at most 1.
    energy_scale: f32,
    /// Probability to sample the diffuse lobe.
    diffuse_probability: f64,
}

/// Coefficients of the classical model (document 001 section 3.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongCoefficients {
    /// Ambient coefficient.
    pub ambient: Spectrum,
    /// Diffuse coefficient.
    pub diffuse: Spectrum,
    /// Specular coefficient.
    pub specular: Spectrum,
    /// Sharpness of the highlight, >= 0.
    pub exponent: f64,
}

impl Phong {
    /// A model with these coefficients.
    ///
    /// Negative coefficients count as 0. Where diffuse + specular is above 1 in some lane, transport uses
    /// both scaled down by [`Phong::energy_scale`], the same in all lanes; the classical coefficients are not
    /// changed. An exponent below 0 or not a number counts as 0.
    #[must_use]
    pub fn new(coefficients: PhongCoefficients) -> Self {
        Self::with_largest_sum(coefficients, 0.0)
    }

    /// The model of [`Phong::new`], of which diffuse + specular is at most `largest_sum` at other wavelengths.
    fn with_largest_sum(coefficients: PhongCoefficients, largest_sum: f32) -> Self {
        let positive = |s: Spectrum| s.map(|x| x.max(0.0));
        let coefficients = PhongCoefficients {
            ambient: positive(coefficients.ambient),
            diffuse: positive(coefficients.diffuse),
            specular: positive(coefficients.specular),
            exponent: coefficients.exponent.max(0.0),
        };
        let (d, s) = (coefficients.diffuse.max_component(), coefficients.specular.max_component());
        let most = (coefficients.diffuse + coefficients.specular).max_component().max(largest_sum);
        let diffuse_probability = if d + s > 0.0 { f64::from(d / (d + s)) } else { 1.0 };
        Self { coefficients, energy_scale: if most > 1.0 { 1.0 / most } else { 1.0 }, diffuse_probability }
    }

    /// The coefficients as given.
    #[must_use]
    pub fn coefficients(&self) -> &PhongCoefficients {
        &self.coefficients
    }

    /// The factor in (0, 1] that transport applies to the diffuse and the specular coefficient.
    #[must_use]
    pub fn energy_scale(&self) -> f32 {
        self.energy_scale
    }

    /// `max(0, cos alpha)^n`.
    fn power(&self, wo: DVec3, wi: DVec3) -> f64 {
        let cos = mirrored(wo).dot(wi);
        if cos > 0.0 { cos.min(1.0).powf(self.coefficients.exponent) } else { 0.0 }
    }

    /// `f factor` for that power.
    fn value(&self, power: f64, factor: f64) -> Spectrum {
        let PhongCoefficients { diffuse, specular, exponent, .. } = self.coefficients;
        let factor = factor * f64::from(self.energy_scale);
        diffuse * (FRAC_1_PI * factor) as f32 + specular * ((exponent + 2.0) / TAU * power * factor) as f32
    }

    /// The density for that power, of directions on one side.
    fn density(&self, power: f64, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        let below = self.power(wo, DVec3::new(wi.x, wi.y, -wi.z));
        let specular = (self.coefficients.exponent + 1.0) / TAU * (power + below);
        let diffuse = warp::cosine_hemisphere_pdf(wi.z.abs()).0;
        SolidAnglePdf(self.diffuse_probability * diffuse + (1.0 - self.diffuse_probability) * specular)
    }
}

impl BsdfModel for Phong {
    const LOBES: &'static [Lobe] = &[Lobe::DIFFUSE, Lobe::GLOSSY];

    /// `f |cos|`.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        if !same_side(wo, wi) {
            return Spectrum::BLACK;
        }
        self.value(self.power(wo, wi), wi.z.abs())
    }

    /// A mixture of the cosine and the lobe, of which the part below the horizon is mirrored up.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        if !same_side(wo, wi) {
            return SolidAnglePdf(0.0);
        }
        self.density(self.power(wo, wi), wo, wi)
    }

    /// A direction from one of the two lobes, weighted by both.
    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, _: TransportMode) -> Option<BsdfSample> {
        let (mut wi, lobe) = if xi_lobe < self.diffuse_probability {
            (warp::cosine_hemisphere(xi), Lobe::DIFFUSE)
        } else {
            let around = Frame::from_z(mirrored(wo));
            (around.to_world(warp::phong_lobe(xi, self.coefficients.exponent)).normalize(), Lobe::GLOSSY)
        };
        // Mirroring at the horizon loses no sample and does not lower the density above it.
        wi.z = wi.z.abs().copysign(wo.z);
        if !same_side(wo, wi) {
            return None;
        }
        let power = self.power(wo, wi);
        let pdf = self.density(power, wo, wi);
        if pdf.0 <= 0.0 {
            return None;
        }
        let value = self.value(power, wi.z.abs());
        // Before the cosine or the density is rounded to f32, where it might underflow.
        let weight = self.value(power, wi.z.abs() / pdf.0);
        Some(BsdfSample { wi, weight, value, pdf, lobe, eta_scale: 1.0 })
    }

    fn diffuse_probability(&self, _: DVec3) -> f64 {
        self.diffuse_probability
    }

    /// Relative accuracy of the specular part about 1e-4.
    fn albedo(&self, wo: DVec3) -> Spectrum {
        let PhongCoefficients { diffuse, specular, exponent, .. } = self.coefficients;
        (diffuse + specular * specular_albedo(wo.z.abs().min(1.0), exponent) as f32) * self.energy_scale
    }

    fn preview(&self) -> PreviewSurface {
        let PhongCoefficients { diffuse, specular, exponent, .. } = self.coefficients;
        PreviewSurface {
            specular: specular * self.energy_scale,
            exponent: Some(exponent),
            // The width of a microfacet lobe as sharp as cos^n.
            roughness: (2.0 / (exponent + 2.0)).sqrt() as f32,
            ..PreviewSurface::diffuse(diffuse * self.energy_scale)
        }
    }
}

/// The material of [`Phong`]; see [`Phong::new`] for coefficients that would create energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongMaterial<P: ParameterForm = ShadingForm> {
    /// Ambient coefficient, only of the classical model.
    pub ambient: P::Spectrum,
    /// Diffuse coefficient.
    pub diffuse: P::Spectrum,
    /// Specular coefficient.
    pub specular: P::Spectrum,
    /// Sharpness of the highlight, >= 0.
    pub exponent: P::Float,
}

impl<P: ParameterForm> MaterialModel<P> for PhongMaterial<P> {
    type Textured = PhongMaterial;

    fn kind(&self) -> &'static str {
        "phong"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<PhongMaterial, MaterialError> {
        Ok(PhongMaterial {
            ambient: resolver.fraction("ambient", &self.ambient)?,
            diffuse: resolver.fraction("diffuse", &self.diffuse)?,
            specular: resolver.fraction("specular", &self.specular)?,
            exponent: resolver.float("exponent", &self.exponent, 0.0..=f32::MAX, "a number of at least 0")?,
        })
    }
}

impl TexturedModel for PhongMaterial {
    type Bsdf<'a> = Phong;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Phong {
        let [ambient, diffuse, specular] =
            [&self.ambient, &self.diffuse, &self.specular].map(|input| at.spectrum(input));
        let sum = |at: &TextureEvaluator<'_>| at.spectrum(&self.diffuse) + at.spectrum(&self.specular);
        let largest_sum = at.largest(diffuse + specular, sum);
        let exponent = f64::from(at.float(&self.exponent));
        Phong::with_largest_sum(PhongCoefficients { ambient, diffuse, specular, exponent }, largest_sum)
    }

    /// Names the largest sum of constant diffuse and specular coefficients where it is above 1; textured ones do not count.
    fn warning(&self) -> Option<String> {
        let constant = |input: &SpectrumInput| match input {
            SpectrumInput::Constant(value) => Some(*value),
            SpectrumInput::Spectral(constant) => Some(constant.rgb),
            SpectrumInput::Texture(_) => None,
        };
        let sum = (constant(&self.diffuse)? + constant(&self.specular)?).max_component();
        let message =
            || format!("diffuse plus specular is {sum}; path-traced light scales both down to a sum of 1");
        (sum > 1.0).then(message)
    }
}

impl<P: ParameterForm> Material<P> {
    /// The Phong model; `ambient` counts in the classical model only.
    #[must_use]
    pub fn phong(
        ambient: impl Into<P::Spectrum>,
        diffuse: impl Into<P::Spectrum>,
        specular: impl Into<P::Spectrum>,
        exponent: impl Into<P::Float>,
    ) -> Self {
        let (ambient, diffuse, specular) = (ambient.into(), diffuse.into(), specular.into());
        Self::Phong(PhongMaterial { ambient, diffuse, specular, exponent: exponent.into() })
    }
}

/// `(n + 2) / (2 pi)` times the integral of `cos^n(alpha) cos(theta)` over the hemisphere, for a lobe under `cos_axis`.
///
/// Without the horizon the integral over the whole lobe is `cos_axis`. The part that the horizon cuts off has a closed
/// form over the azimuth of the lobe; the integral of the remaining bounded function over the uniform variable
/// `cos^(n+1)(alpha)` is left to the midpoint rule.
fn specular_albedo(cos_axis: f64, exponent: f64) -> f64 {
    const STEPS: u32 = 32;
    let sin_axis = (1.0 - cos_axis * cos_axis).max(0.0).sqrt();
    let cut: f64 = (0..STEPS)
        .map(|i| {
            let cos = ((f64::from(i) + 0.5) / f64::from(STEPS)).powf(1.0 / (exponent + 1.0));
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            // The mean of max(0, a + b cos(phi)) over a turn, minus a.
            let (a, b) = (cos_axis * cos, sin_axis * sin);
            if a >= b {
                return 0.0;
            }
            let phi = (-a / b).acos();
            (a * phi + b * phi.sin()) / PI - a
        })
        .sum();
    (cos_axis + (exponent + 2.0) / (exponent + 1.0) * cut / f64::from(STEPS)).min(1.0)
}

/// A light of the classical model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassicLight {
    /// Unit direction to the light.
    pub direction: DVec3,
    /// Intensity for diffuse scattering.
    pub diffuse: Spectrum,
    /// Intensity for the highlight.
    pub specular: Spectrum,
}

/// Contribution of one visible light in the classical model: `Md Ld max(0, n.l) + Ms Ls max(0, r.v)^n`.
///
/// `normal` is on the side of the viewer; `to_viewer` and all other directions have unit length and point away from the
/// surface. Intensities are used as they are, without division by pi or by squared distances. An exponent of
/// 0 gives a highlight wherever `r.v > 0`.
///
/// # Source
/// Document 001 section 3.4. Departures: the power is taken of max(0, r.v), and only where n.l
/// > 0, so that an even power does not light the back.
#[must_use]
pub fn classic(
    surface: &PhongCoefficients,
    normal: DVec3,
    to_viewer: DVec3,
    light: &ClassicLight,
) -> Spectrum {
    let cos = normal.dot(light.direction);
    if cos <= 0.0 {
        return Spectrum::BLACK;
    }
    let diffuse = surface.diffuse * light.diffuse * cos as f32;
    let highlight = reflect(light.direction, normal).dot(to_viewer);
    if highlight <= 0.0 {
        return diffuse;
    }
    diffuse + surface.specular * light.specular * highlight.powf(surface.exponent) as f32
}

/// Contribution of ambient light in the classical model: `Ma Sa`.
#[must_use]
pub fn classic_ambient(surface: &PhongCoefficients, ambient_light: Spectrum) -> Spectrum {
    surface.ambient * ambient_light
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coefficients(diffuse: f32, specular: f32, exponent: f64) -> PhongCoefficients {
        PhongCoefficients {
            ambient: Spectrum::splat(0.1),
            diffuse: Spectrum::splat(diffuse),
            specular: Spectrum::splat(specular),
            exponent,
        }
    }

    fn light(direction: DVec3) -> ClassicLight {
        ClassicLight { direction, diffuse: Spectrum::splat(2.0), specular: Spectrum::splat(3.0) }
    }

    fn near(a: Spectrum, b: f32) -> bool {
        (a - Spectrum::splat(b)).map(f32::abs).max_component() < 1e-6
    }

    #[test]
    fn lobes_are_selected_with_the_stated_probability() {
        // 0.6 of 0.6 + 0.2.
        let phong = Phong::new(coefficients(0.6, 0.2, 5.0));
        assert!((phong.diffuse_probability(DVec3::Z) - 0.75).abs() < 1e-7);
        let lobe = |xi_lobe| {
            phong
                .sample(DVec3::Z, DVec2::new(0.3, 0.6), xi_lobe, TransportMode::Radiance)
                .map(|sample| sample.lobe)
        };
        assert_eq!((lobe(0.749), lobe(0.751)), (Some(Lobe::DIFFUSE), Some(Lobe::GLOSSY)));
    }

    #[test]
    fn classic_shading_by_hand() {
        // n = z, l = (0.6, 0, 0.8), so r = (-0.6, 0, 0.8).
        let l = light(DVec3::new(0.6, 0.0, 0.8));
        let m = coefficients(0.5, 0.25, 5.0);
        // Viewer in the mirrored direction: 0.5 * 2 * 0.8 + 0.25 * 3 * 1 = 1.55.
        assert!(near(classic(&m, DVec3::Z, DVec3::new(-0.6, 0.0, 0.8), &l), 1.55));
        // Viewer above: r.v = 0.8; 0.8 + 0.75 * 0.8^5 = 0.8 + 0.75 * 0.32768 = 1.04576.
        assert!(near(classic(&m, DVec3::Z, DVec3::Z, &l), 1.045_76));
        // Viewer at (0.96, 0, 0.28): r.v = -0.576 + 0.224 < 0; only 0.8 is left, for an even power too.
        let side = DVec3::new(0.96, 0.0, 0.28);
        assert!(near(classic(&m, DVec3::Z, side, &l), 0.8));
        assert!(near(classic(&coefficients(0.5, 0.25, 4.0), DVec3::Z, side, &l), 0.8));
        assert!(near(classic_ambient(&m, Spectrum::splat(0.3)), 0.03));
    }

    #[test]
    fn classic_light_behind_the_surface_contributes_nothing() {
        // With an even power, the uncorrected formula gives a highlight here.
        let l = light(DVec3::new(0.0, 0.6, -0.8));
        let m = coefficients(0.5, 0.25, 4.0);
        assert_eq!(classic(&m, DVec3::Z, DVec3::new(0.0, 0.6, 0.8), &l), Spectrum::BLACK);
    }

    #[test]
    fn too_much_energy_is_scaled_down_for_transport_but_not_for_classic_use() {
        let p = Phong::new(coefficients(0.9, 0.6, 10.0));
        assert!((p.energy_scale() - 1.0 / 1.5).abs() < 1e-6);
        assert_eq!(p.coefficients().diffuse, Spectrum::splat(0.9));
        assert!(p.albedo(DVec3::Z).max_component() <= 1.0 + 1e-6);
        assert_eq!(Phong::new(coefficients(0.5, 0.5, 10.0)).energy_scale(), 1.0);
    }

    #[test]
    fn specular_albedo_is_one_at_normal_incidence_and_closed_at_grazing() {
        for n in [0.0, 1.0, 5.0, 100.0, 1e4] {
            // cos_axis = 1: (n+2)/(2 pi) * 2 pi / (n + 2) = 1.
            assert!((specular_albedo(1.0, n) - 1.0).abs() < 1e-12, "{n}");
        }
        // cos_axis = 0, n = 1: 3 / (2 pi) * integral over half the lobe of sin(alpha) cos(phi) cos(alpha):
        // azimuth gives 2, alpha gives integral of cos sin^2 = 1/3, so 1 / pi.
        assert!((specular_albedo(0.0, 1.0) - FRAC_1_PI).abs() < 1e-3);
    }

    #[test]
    fn exponents_and_coefficients_out_of_range_are_brought_into_it() {
        let p = Phong::new(coefficients(-0.5, 0.5, f64::NAN));
        assert_eq!(p.coefficients().exponent, 0.0);
        assert_eq!(p.coefficients().diffuse, Spectrum::BLACK);
        let black = Phong::new(coefficients(0.0, 0.0, 5.0));
        let s = black.sample(DVec3::Z, DVec2::splat(0.3), 0.7, TransportMode::Radiance).unwrap();
        assert!(s.weight.is_black());
    }
}
