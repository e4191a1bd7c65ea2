//! Diffuse reflection.

use std::f32::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use crate::bsdf::{BsdfSample, Lobe, same_side};

/// Lambert's law: the same radiance in every direction of the side the light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Share of light reflected, [0, 1].
    pub reflectance: Spectrum,
}

impl Lambert {
    /// `reflectance / pi |cos|`.
    #[must_use]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        if !same_side(wo, wi) {
            return Spectrum::BLACK;
        }
        self.reflectance * (FRAC_1_PI * wi.z.abs() as f32)
    }

    /// Proportional to the cosine.
    #[must_use]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        if same_side(wo, wi) { warp::cosine_hemisphere_pdf(wi.z.abs()) } else { SolidAnglePdf(0.0) }
    }

    /// A direction with density proportional to its cosine: the weight is the reflectance.
    #[must_use]
    pub fn sample(&self, wo: DVec3, xi: DVec2) -> Option<BsdfSample> {
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
}
