//! Roughness of materials.

use crate::microfacet::MicrofacetDistribution;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::texture::FloatInput;

/// How a number for the roughness becomes the width alpha of the facets, see [`MicrofacetDistribution`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum RoughnessScale {
    /// The number itself.
    #[default]
    Alpha,
    /// Its square root, as in version 4 of pbrt.
    SquareRoot,
    /// A polynomial of its logarithm, as in version 3 of pbrt (@pbrt3 section 8.4.3).
    Logarithmic,
    /// Its square: equal steps look equal, as in glTF (@burley2012).
    Square,
}

impl RoughnessScale {
    /// The width for a roughness of at least 0.
    #[must_use]
    pub fn alpha(self, roughness: f32) -> f64 {
        let x = f64::from(roughness.max(0.0));
        match self {
            Self::Alpha => x,
            Self::SquareRoot => x.sqrt(),
            Self::Logarithmic => {
                let x = x.max(1e-3).ln();
                1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
            }
            Self::Square => x * x,
        }
    }
}

/// Roughness along the two directions of the surface's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Roughness<P: ParameterForm = ShadingForm> {
    /// Roughness along the first, >= 0.
    pub u: P::Float,
    /// Roughness along the second, >= 0.
    pub v: P::Float,
    /// The meaning of the numbers.
    pub scale: RoughnessScale,
}

impl<P: ParameterForm> Roughness<P> {
    /// The same roughness in all directions.
    #[must_use]
    pub fn isotropic(roughness: impl Into<P::Float>, scale: RoughnessScale) -> Self {
        let u = roughness.into();
        Self { v: u.clone(), u, scale }
    }

    /// A smooth surface.
    #[must_use]
    pub fn smooth() -> Self
    where
        P::Float: From<f32>,
    {
        Self::isotropic(0.0, RoughnessScale::Alpha)
    }

    /// Checks the parameters, called `name` in errors, and converts them for shading.
    pub(super) fn resolve<R: ParameterResolver<P>>(
        &self,
        name: &'static str,
        resolver: &R,
    ) -> Result<Roughness, MaterialError> {
        let number = |input| resolver.float(name, input, 0.0..=f32::MAX, "a number of at least 0");
        Ok(Roughness { u: number(&self.u)?, v: number(&self.v)?, scale: self.scale })
    }
}

impl Roughness {
    /// Whether a surface has no facets anywhere: its roughness is constant, and too small to matter.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        match (&self.u, &self.v) {
            (FloatInput::Constant(u), FloatInput::Constant(v)) => {
                let [u, v] = [*u, *v].map(|x| self.scale.alpha(x));
                MicrofacetDistribution::new(u, v).is_smooth()
            }
            _ => false,
        }
    }

    /// The facets at a point.
    pub(super) fn distribution(&self, at: &TextureEvaluator<'_>) -> MicrofacetDistribution {
        let alpha = |input| self.scale.alpha(at.float(input));
        let u = alpha(&self.u);
        MicrofacetDistribution::new(u, if self.v == self.u { u } else { alpha(&self.v) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_map_as_their_sources_state() {
        assert_eq!(RoughnessScale::SquareRoot.alpha(0.25), 0.5);
        assert_eq!(RoughnessScale::Square.alpha(0.5), 0.25);
        // At roughness 1 the logarithm is 0.
        assert_eq!(RoughnessScale::Logarithmic.alpha(1.0), 1.62142);
        assert_eq!(RoughnessScale::Alpha.alpha(-1.0), 0.0);
    }
}
