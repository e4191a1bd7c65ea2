//! Rough diffuse reflection.

use std::f32::consts::FRAC_1_PI;
use std::f64::consts::FRAC_2_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, same_side};
use crate::microfacet::clamp_unit;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// A surface of symmetric V-shaped grooves whose sides follow Lambert's law, such as plaster or clay: it reflects more light back to where the light comes from.
///
/// # Source
/// @oren1994, the qualitative model without interreflection, as in @pharr2016 section 8.4.1; departure: a reflectance for which grazing light would be
/// reflected by more than all of it (above 0.985 to 1) is limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    reflectance: Spectrum,
    /// The model's A and B.
    even: f64,
    backward: f64,
}

impl OrenNayar {
    /// `reflectance`: fraction of light that the sides of the grooves reflect, [0, 1]. `sigma`: standard deviation of their angles, radians, at least 0.
    #[must_use]
    pub fn new(reflectance: Spectrum, sigma: f64) -> Self {
        let variance = sigma * sigma;
        let even = 1.0 - variance / (2.0 * (variance + 0.33));
        let backward = 0.45 * variance / (variance + 0.09);
        // The albedo grows to this at grazing light.
        let largest = (even + 0.5 * backward).max(1.0);
        let reflectance = reflectance.map(|x| x.min((1.0 / largest) as f32));
        Self { reflectance, even, backward }
    }

    /// The factor on the value of Lambert's law.
    fn factor(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (sin_o, sin_i) = (wo.truncate().length(), wi.truncate().length());
        // sin_o sin_i cos(phi_o - phi_i), where the nearer to the normal has the tangent.
        let across = wo.truncate().dot(wi.truncate()).max(0.0);
        let cos = wo.z.abs().max(wi.z.abs());
        let backward = if sin_o > 0.0 && sin_i > 0.0 { across / cos } else { 0.0 };
        self.even + self.backward * backward
    }
}

impl BsdfModel for OrenNayar {
    const LOBES: &'static [Lobe] = &[Lobe::DIFFUSE];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        if !same_side(wo, wi) {
            return Spectrum::BLACK;
        }
        self.reflectance * (FRAC_1_PI * (wi.z.abs() * self.factor(wo, wi)) as f32)
    }

    /// Proportional to the cosine.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        if same_side(wo, wi) { warp::cosine_hemisphere_pdf(wi.z.abs()) } else { SolidAnglePdf(0.0) }
    }

    fn sample(&self, wo: DVec3, xi: DVec2, _: f64, mode: TransportMode) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere(xi);
        wi.z = wi.z.copysign(wo.z);
        BsdfSample::of_direction(self, [wo, wi], Lobe::DIFFUSE, mode)
    }

    fn diffuse_probability(&self, _: DVec3) -> f64 {
        1.0
    }

    /// In closed form: with the angle t of `wo`, A + B (2 / pi) (sin t (t - sin t cos t) / 2 + tan t (1 - sin^3 t) / 3).
    fn albedo(&self, wo: DVec3) -> Spectrum {
        let cos = wo.z.abs().min(1.0);
        let sin = wo.truncate().length();
        let beyond = if cos > 0.0 { sin / cos * (1.0 - sin.powi(3)) / 3.0 } else { 0.0 };
        let backward = FRAC_2_PI * (0.5 * sin * (sin.atan2(cos) - sin * cos) + beyond);
        self.reflectance * (self.even + self.backward * backward) as f32
    }

    fn is_black(&self) -> bool {
        self.reflectance.is_black()
    }
}

/// The material of [`OrenNayar`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayarMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light that the sides of the grooves reflect, [0, 1].
    pub reflectance: P::Spectrum,
    /// Standard deviation of their angles, degrees, clamped to [0, 90].
    pub sigma: P::Float,
}

impl<P: ParameterForm> MaterialModel<P> for OrenNayarMaterial<P> {
    type Textured = OrenNayarMaterial;

    fn kind(&self) -> &'static str {
        "matte"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<OrenNayarMaterial, MaterialError> {
        Ok(OrenNayarMaterial {
            reflectance: resolver.fraction("reflectance", &self.reflectance)?,
            sigma: resolver.float("sigma", &self.sigma, f32::MIN..=f32::MAX, "a number")?,
        })
    }
}

impl TexturedModel for OrenNayarMaterial {
    type Bsdf<'a> = OrenNayar;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> OrenNayar {
        let sigma = (90.0 * clamp_unit(f64::from(at.float(&self.sigma)) / 90.0)).to_radians();
        OrenNayar::new(at.fraction(&self.reflectance), sigma)
    }
}

impl<P: ParameterForm> Material<P> {
    /// Rough diffuse reflection: the fraction of light reflected, [0, 1], and the standard deviation of the angles of grooves, degrees.
    #[must_use]
    pub fn oren_nayar(reflectance: impl Into<P::Spectrum>, sigma: impl Into<P::Float>) -> Self {
        Self::OrenNayar(OrenNayarMaterial { reflectance: reflectance.into(), sigma: sigma.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Spectrum = Spectrum::from_rgb([1.0; 3]);

    fn direction(angle: f64, azimuth: f64) -> DVec3 {
        DVec3::new(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos())
    }

    #[test]
    fn smooth_grooves_follow_lambert() {
        let bsdf = OrenNayar::new(WHITE, 0.0);
        let [wo, wi] = [direction(0.7, 0.3), direction(1.2, 0.9)];
        assert!((bsdf.eval(wo, wi).max_component() - FRAC_1_PI * wi.z as f32).abs() < 1e-7);
    }

    #[test]
    fn value_is_that_of_the_paper() {
        // Equation 30 of the paper at sigma = 30 degrees, angles 60 and 40 degrees, azimuths 20 degrees apart, reflectance 0.9:
        // A = 1 - 0.274156 / (2 * 0.604156) = 0.773109, B = 0.45 * 0.274156 / 0.364156 = 0.338784,
        // cos(20) sin(60) tan(40) = 0.939693 * 0.866025 * 0.839100 = 0.682858.
        let bsdf = OrenNayar::new(WHITE * 0.9, 30.0_f64.to_radians());
        let [wo, wi] =
            [direction(60.0_f64.to_radians(), 0.0), direction(40.0_f64.to_radians(), 20.0_f64.to_radians())];
        let expected = 0.9 * FRAC_1_PI * (0.773_109 + 0.338_784 * 0.682_858) * wi.z as f32;
        assert!((bsdf.eval(wo, wi).max_component() - expected).abs() < 1e-6);
        let away = direction(40.0_f64.to_radians(), 160.0_f64.to_radians());
        let expected = 0.9 * FRAC_1_PI * 0.773_109 * wi.z as f32;
        assert!((bsdf.eval(wo, away).max_component() - expected).abs() < 1e-6);
    }

    #[test]
    fn no_light_is_created_at_any_roughness_and_angle() {
        for degrees in 0..=90 {
            let bsdf = OrenNayar::new(WHITE, f64::from(degrees).to_radians());
            for step in 0..=200 {
                let albedo =
                    bsdf.albedo(direction(f64::from(step) / 200.0 * std::f64::consts::FRAC_PI_2, 0.0));
                assert!(albedo.max_component() <= 1.0 + 1e-6, "{degrees} {step}: {albedo:?}");
            }
        }
    }
}
