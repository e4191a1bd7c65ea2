//! Light from everywhere.

use std::f64::consts::FRAC_1_PI;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use super::LightSample;
use crate::interaction::{Interaction, Reference};

/// The same radiance from every direction.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLight {
    radiance: Spectrum,
}

impl InfiniteLight {
    /// `radiance`: W/(m^2 sr).
    #[must_use]
    pub fn new(radiance: Spectrum) -> Self {
        Self { radiance }
    }

    /// W/(m^2 sr) from every direction.
    #[must_use]
    pub fn radiance(&self) -> Spectrum {
        self.radiance
    }

    /// Directions by the cosine to the shading normal on the side of `wo`: the light is the same everywhere, so the
    /// cosine is all there is to know. What arrives through a surface is left to BSDF sampling.
    pub(super) fn sample(
        &self,
        from: &Interaction,
        xi: DVec2,
        _wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let frame = from.frame();
        let mut local = warp::cosine_hemisphere(xi);
        if frame.z.dot(from.wo) < 0.0 {
            local.z = -local.z;
        }
        let wi = frame.to_world(local);
        let pdf = self.pdf(&from.reference(), wi);
        (pdf.0 > 0.0).then(|| LightSample {
            wi,
            radiance: self.radiance,
            pdf,
            is_delta: false,
            shadow: from.spawn(wi),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }

    /// Density with which a sample from `from` takes the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, from: &Reference, wi: DVec3) -> SolidAnglePdf {
        let normal = from.shading_normal;
        let cos = normal.dot(wi) * 1.0_f64.copysign(normal.dot(from.wo));
        SolidAnglePdf(cos.max(0.0) * FRAC_1_PI)
    }
}
