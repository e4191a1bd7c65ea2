//! Mixtures of materials.

use super::Material;
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};

/// One of two other materials at each point, selected at random: on average the sum of both, weighted.
///
/// # Source
/// As version 4 of pbrt.
#[derive(Clone, Debug, PartialEq)]
pub struct MixMaterial<P: ParameterForm = ShadingForm> {
    /// Numbers of the materials.
    pub materials: [usize; 2],
    /// Probability of the second, clamped to [0, 1].
    pub amount: P::Float,
}

impl<P: ParameterForm> MixMaterial<P> {
    /// Checks the parameters and converts them for shading.
    ///
    /// # Errors
    /// [`MaterialError`] for an amount that is not finite or without its texture.
    pub(super) fn resolve<R: ParameterResolver<P>>(
        &self,
        resolver: &R,
    ) -> Result<MixMaterial, MaterialError> {
        let range = "a finite number";
        let amount = resolver.float("amount", &self.amount, f32::MIN..=f32::MAX, range)?;
        Ok(MixMaterial { materials: self.materials, amount })
    }
}

impl MixMaterial {
    /// The number of the material that is selected at a point by a number in [0, 1).
    #[must_use]
    pub fn select(&self, at: &TextureEvaluator<'_>, xi: f64) -> usize {
        self.materials[usize::from(xi < f64::from(at.float(&self.amount)))]
    }
}

impl<P: ParameterForm> Material<P> {
    /// The second of two materials, by their numbers, with the probability `amount`, else the first.
    #[must_use]
    pub fn mix(materials: [usize; 2], amount: impl Into<P::Float>) -> Self {
        Self::Mix(MixMaterial { materials, amount: amount.into() })
    }
}
