//! Mixtures by the direction of the surface.

use glanz_math::DVec3;

use super::{SpectrumInput, TexturePoint};

/// Two inputs, mixed by the angle between the surface normal and a direction.
///
/// # Source
/// @pbrt4 `DirectionMixTexture`.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionMix {
    /// Input where the normal is along the direction, to either side.
    pub along: SpectrumInput,
    /// Input where it is perpendicular.
    pub across: SpectrumInput,
    /// Unit direction in the world.
    pub direction: DVec3,
}

impl DirectionMix {
    /// Weight of [`DirectionMix::along`]: the absolute cosine of the angle.
    #[must_use]
    pub fn along_fraction(&self, at: &TexturePoint) -> f32 {
        at.normal.dot(self.direction).abs() as f32
    }
}
