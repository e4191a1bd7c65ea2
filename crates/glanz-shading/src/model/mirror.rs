//! Perfect reflection.

use glanz_light::Spectrum;
use glanz_math::DVec3;

use crate::bsdf::{BsdfSample, Lobe};

/// A mirror that reflects the same share at every angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Share of light reflected, [0, 1].
    pub reflectance: Spectrum,
}

impl Mirror {
    /// The mirrored direction.
    #[must_use]
    pub fn sample(&self, wo: DVec3) -> Option<BsdfSample> {
        (wo.z != 0.0).then(|| BsdfSample::delta(mirrored(wo), self.reflectance, Lobe::SPECULAR_REFLECTION))
    }
}

/// `wo` turned by half a turn about z.
pub(super) fn mirrored(wo: DVec3) -> DVec3 {
    DVec3::new(-wo.x, -wo.y, wo.z)
}
