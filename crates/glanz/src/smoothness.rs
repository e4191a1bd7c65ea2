//! Smoothness of surfaces.

use glanz_shading::FloatInput;
use glanz_shading::microfacet::MicrofacetDistribution;
use glanz_shading::model::Roughness;

/// Whether a surface has no facets anywhere: its roughness is constant, and too small to matter.
pub(crate) fn is_smooth(roughness: &Roughness) -> bool {
    match (&roughness.u, &roughness.v) {
        (FloatInput::Constant(u), FloatInput::Constant(v)) => {
            let [u, v] = [*u, *v].map(|x| roughness.scale.alpha(x));
            MicrofacetDistribution::new(u, v).is_smooth()
        }
        _ => false,
    }
}
