//! Clear coats.

use std::ops::RangeInclusive;

use glanz_math::{DVec2, DVec3};

use super::interface::{InterfaceScattering, mean_dielectric};
use super::{MicrofacetDistribution, energy, half_vector};
use crate::fresnel;

/// The interface between the air and the coat of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Refractive index, >= 1.
    eta: f64,
    distribution: MicrofacetDistribution,
    multiple: Option<InterfaceScattering>,
}

impl Coat {
    /// Refractive indices that a coat may have.
    pub const INDICES: RangeInclusive<f32> = 1.0..=1e3;

    /// A coat of refractive index `eta`; one out of [`Coat::INDICES`] counts as 1. `multiple_scattering`: whether light between facets counts, if they are
    /// isotropic.
    #[must_use]
    pub fn new(eta: f32, distribution: MicrofacetDistribution, multiple_scattering: bool) -> Self {
        let eta = if Self::INDICES.contains(&eta) { f64::from(eta) } else { 1.0 };
        let multiple = if multiple_scattering { InterfaceScattering::new(&distribution, eta) } else { None };
        Self { eta, distribution, multiple }
    }

    /// Its refractive index.
    #[must_use]
    pub fn eta(&self) -> f64 {
        self.eta
    }

    /// Its facets.
    #[must_use]
    pub fn distribution(&self) -> &MicrofacetDistribution {
        &self.distribution
    }

    /// Whether it reflects into a single direction.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.distribution.is_smooth()
    }

    /// Fraction of diffuse light from outside that is transmitted.
    #[must_use]
    pub fn mean_transmittance(&self) -> f64 {
        if self.distribution.is_smooth() {
            return 1.0 - mean_dielectric(self.eta);
        }
        let between = self.multiple.as_ref().map_or(0.0, |x| (1.0 - x.transmitted) * x.mean_lost());
        1.0 - energy::mean_directional_reflectance(&self.distribution, self.eta) - between
    }

    /// Fraction of the light from `w` (above) that facets reflect more than once.
    fn multiple_reflectance(&self, w: DVec3) -> f64 {
        self.multiple.as_ref().map_or(0.0, |x| (1.0 - x.transmitted) * x.lost(w))
    }

    /// Fraction of the light from `w` (above) that is reflected.
    #[must_use]
    pub fn reflectance(&self, w: DVec3) -> f64 {
        if self.distribution.is_smooth() {
            return fresnel::dielectric(w.z, self.eta).reflectance;
        }
        let once = energy::directional_reflectance(&self.distribution, self.eta, w);
        (once + self.multiple_reflectance(w)).min(1.0)
    }

    /// `f cos` of rough reflection; both directions above.
    #[must_use]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let m = half_vector(wo, wi);
        let facets =
            fresnel::dielectric(wo.dot(m), self.eta).reflectance * self.distribution.reflection(wo, wi, m);
        let multiple = self.multiple.as_ref().map_or(0.0, |x| x.reflection(x.lost(wo), x.lost(wi)) * wi.z);
        facets + multiple
    }

    /// The fraction of reflected light that facets reflect more than once.
    fn multiple_probability(&self, w: DVec3) -> f64 {
        let multiple = self.multiple_reflectance(w);
        if multiple > 0.0 { multiple / self.reflectance(w) } else { 0.0 }
    }

    /// Density of sampling rough reflection; both directions above.
    #[must_use]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.distribution.scattering_pdf(wo, wi, self.multiple_probability(wo))
    }

    /// A direction of rough reflection, for `wo` above.
    #[must_use]
    pub fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64) -> DVec3 {
        self.distribution.sample_scattering(wo, self.multiple_probability(wo), xi, xi_lobe)
    }
}
