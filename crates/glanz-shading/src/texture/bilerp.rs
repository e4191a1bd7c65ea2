//! Bilinear interpolation between four corners.

use super::{SpectrumInput, TextureMapping, TexturePoint};

/// Four inputs at the corners of the unit square, interpolated between them and extrapolated beyond.
///
/// # Source
/// @pbrt4 `BilerpTexture`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bilerp {
    /// Inputs at (0, 0), (0, 1), (1, 0) and (1, 1).
    pub corners: [SpectrumInput; 4],
    /// Coordinates in the square.
    pub mapping: TextureMapping,
}

impl Bilerp {
    /// Weights of the corners at a point; their sum is 1.
    #[must_use]
    pub fn weights(&self, at: &TexturePoint) -> [f32; 4] {
        let (s, t) = self.mapping.coordinates(at).position.truncate().into();
        [(1.0 - s) * (1.0 - t), (1.0 - s) * t, s * (1.0 - t), s * t].map(|weight| weight as f32)
    }
}
