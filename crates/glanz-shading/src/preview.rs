//! Materials in a rasteriser.

use glanz_light::Spectrum;

/// A metallic-roughness surface that resembles a scattering model.
///
/// # Source
/// The terms are those of glTF 2.0 and of UsdPreviewSurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewSurface {
    /// Base colour, [0, 1].
    pub base: Spectrum,
    /// Reflectance at normal incidence besides the base, [0, 1].
    pub specular: Spectrum,
    /// 1 for a metal, else 0.
    pub metallic: f32,
    /// 0 for a mirror, 1 for a diffuse surface.
    pub roughness: f32,
    /// Fraction of light that does not pass, [0, 1].
    pub opacity: f32,
    /// Exponent of the highlight in the Phong model, >= 0.
    pub exponent: Option<f64>,
}

impl PreviewSurface {
    /// A diffuse surface.
    #[must_use]
    pub fn diffuse(base: Spectrum) -> Self {
        Self { base, specular: Spectrum::BLACK, metallic: 0.0, roughness: 1.0, opacity: 1.0, exponent: None }
    }

    /// A polished metal.
    #[must_use]
    pub fn metal(base: Spectrum) -> Self {
        Self { metallic: 1.0, roughness: 0.0, ..Self::diffuse(base) }
    }
}
