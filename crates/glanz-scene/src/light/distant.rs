//! Distant light.

use glanz_light::Spectrum;
use glanz_math::{DVec3, SolidAnglePdf};

use super::LightSample;
use crate::interaction::Interaction;

/// Light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct DistantLight {
    towards: DVec3,
    irradiance: Spectrum,
}

impl DistantLight {
    /// `towards`: unit direction to the light; `irradiance`: W/m^2 on a surface that faces it.
    #[must_use]
    pub fn new(towards: DVec3, irradiance: Spectrum) -> Self {
        Self { towards, irradiance }
    }

    /// W/m^2 on a surface that faces the light.
    #[must_use]
    pub fn irradiance(&self) -> Spectrum {
        self.irradiance
    }

    /// Unit direction to the light.
    #[must_use]
    pub fn towards(&self) -> DVec3 {
        self.towards
    }

    pub(super) fn sample(&self, from: &Interaction) -> LightSample {
        LightSample {
            wi: self.towards,
            radiance: self.irradiance,
            pdf: SolidAnglePdf(1.0),
            is_delta: true,
            shadow: from.spawn(self.towards),
            t_max: f64::INFINITY,
            area_pdf: None,
        }
    }
}
