//! Rough interfaces between two dielectrics.

use std::f64::consts::FRAC_1_PI;
use std::sync::LazyLock;

use glanz_math::DVec3;
use glanz_sampling::basis::GaussLegendre;

use super::{MicrofacetDistribution, energy};
use crate::fresnel;

/// Light between the facets of a rough interface between dielectrics, for one of its sides.
///
/// As with metals, a diffuse lobe returns what facets send to other facets. A part of it is reflected and the rest transmitted; the parts of
/// both sides are such that light is transmitted alike in both directions (up to the change of radiance by refraction).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceScattering {
    alpha: f64,
    eta: f64,
    /// The mean loss of this side and of the other.
    means: [f64; 2],
    /// The fraction of the lost light of this side that is transmitted.
    pub transmitted: f64,
}

impl InterfaceScattering {
    /// The scattering of light that arrives on one side; `None` for smooth and for anisotropic surfaces, of which the energy is not known.
    ///
    /// `eta`: refractive index on the other side over that on this side.
    #[must_use]
    pub fn new(distribution: &MicrofacetDistribution, eta: f64) -> Option<Self> {
        if distribution.is_smooth() || distribution.is_anisotropic() {
            return None;
        }
        let alpha = distribution.mean_width();
        let [near, far] = [eta, 1.0 / eta].map(|eta| energy::mean_interface_loss(alpha, eta));
        // From the thinner side; from the denser side this fraction is transmitted less total reflection.
        let entering = entering_share(alpha, eta.max(1.0 / eta));
        let share = if eta < 1.0 { entering * eta * eta } else { entering };
        let largest = near.max(far);
        let transmitted = if largest > 0.0 { share * far / largest } else { 0.0 };
        Some(Self { alpha, eta, means: [near, far], transmitted })
    }

    /// The scattering of light that arrives on the other side.
    #[must_use]
    pub fn beyond(&self) -> Self {
        let [near, far] = self.means;
        // Light is transmitted alike in both directions: the parts over the means of the side beyond differ by the square of the index.
        let share = if far > 0.0 { near / far } else { 0.0 };
        let transmitted = self.transmitted * share / (self.eta * self.eta);
        Self { eta: 1.0 / self.eta, means: [far, near], transmitted, ..*self }
    }

    /// Fraction of the light from `w` (above, which is this side) that facets send to others.
    #[must_use]
    pub fn lost(&self, w: DVec3) -> f64 {
        energy::interface_loss(self.alpha, self.eta, w.z)
    }

    /// The mean of [`InterfaceScattering::lost`] over diffuse light.
    #[must_use]
    pub fn mean_lost(&self) -> f64 {
        self.means[0]
    }

    /// Fraction of the light from `w` (mirrored above) on the other side that facets send to others.
    #[must_use]
    pub fn lost_beyond(&self, w: DVec3) -> f64 {
        energy::interface_loss(self.alpha, 1.0 / self.eta, w.z)
    }

    /// `f` of reflected light between facets, for the fractions that both directions lose.
    #[must_use]
    pub fn reflection(&self, lost_o: f64, lost_i: f64) -> f64 {
        let [near, _] = self.means;
        if near > 0.0 { FRAC_1_PI * (1.0 - self.transmitted) * lost_o * lost_i / near } else { 0.0 }
    }

    /// `f` of light between facets that continues from this side to the other: flux per flux, for the fractions that both directions lose.
    #[must_use]
    pub fn transmission(&self, lost_o: f64, lost_beyond: f64) -> f64 {
        let [_, far] = self.means;
        if far > 0.0 { FRAC_1_PI * self.transmitted * lost_o * lost_beyond / far } else { 0.0 }
    }
}

/// The part of the light lost between facets that gets through the interface from the thinner side: nearly all of it where facets are steep,
/// because it meets several and each reflects little.
///
/// A fit to random walks between facets (@heitz2016). `eta`: at least 1. Error for indices from 1.1 to 3 and widths of 0.4 or more below 0.012, for widths from 0.2, where
/// little is lost, below 0.03 up to an index of 2.
fn entering_share(alpha: f64, eta: f64) -> f64 {
    let reflectance = mean_dielectric(eta);
    let gain = (1.0 - 3.0 * (-4.15 * alpha).exp()).max(-1.0);
    (1.0 - reflectance) * (1.0 + gain * reflectance)
}

/// The mean reflectance of a smooth interface for diffuse light. `eta`: refractive index on the far side over that on the near side.
///
/// Error below 1e-4.
#[must_use]
pub fn mean_dielectric(eta: f64) -> f64 {
    if eta < 1.0 {
        // Diffuse light stays diffuse: what leaves the denser side is what enters it, over the larger number of directions.
        return 1.0 - (1.0 - mean_dielectric(1.0 / eta)) * eta * eta;
    }
    static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(6));
    energy::diffuse_mean(&RULE, |cos| fresnel::dielectric(cos, eta).reflectance)
}

/// Facets between two directions, and what they do to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refraction {
    /// Normal of the facets, on the upper side.
    pub m: DVec3,
    /// Steradians of facet normals per steradian of transmitted directions.
    pub jacobian: f64,
}

impl Refraction {
    /// The facets that refract between `wo` (above) and `wi` (below); `None` if there are none. `eta`: refractive index below over that
    /// above.
    ///
    /// # Source
    /// @walter2007 eq. (16), (17).
    #[must_use]
    pub fn between(wo: DVec3, wi: DVec3, eta: f64) -> Option<Self> {
        let half = wo + wi * eta;
        let m = half.try_normalize()?;
        let m = if m.z < 0.0 { -m } else { m };
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        if !(cos_o > 0.0 && cos_i < 0.0) {
            return None;
        }
        let jacobian = eta * eta * -cos_i / (cos_o + eta * cos_i).powi(2);
        jacobian.is_finite().then_some(Self { m, jacobian })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattering_beyond_is_that_of_the_inverse_index() {
        for (alpha, eta) in [(0.1, 1.5), (0.6, 1.01), (1.0, 1.0 / 1.33), (0.3, 900.0)] {
            let facets = MicrofacetDistribution::isotropic(alpha);
            let near = InterfaceScattering::new(&facets, eta).unwrap();
            let (found, expected) = (near.beyond(), InterfaceScattering::new(&facets, 1.0 / eta).unwrap());
            assert!((found.transmitted / expected.transmitted - 1.0).abs() < 1e-12, "{found:?} {expected:?}");
            assert_eq!(found.means, expected.means);
            assert!((found.eta * eta - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn light_between_facets_gets_through_as_in_random_walks() {
        // Reflected parts of what is lost, of diffuse light from the thinner side, by 240 000 walks each between facets of Smith's model.
        for (eta, alpha, reflected) in [
            (1.1, 0.2, 0.0315),
            (1.1, 0.6, 0.0072),
            (1.1, 1.0, 0.0032),
            (1.5, 0.2, 0.1299),
            (1.5, 0.4, 0.0549),
            (1.5, 0.6, 0.0281),
            (1.5, 1.0, 0.0130),
            (2.0, 0.2, 0.2014),
            (2.0, 0.4, 0.1049),
            (2.0, 0.6, 0.0615),
            (2.0, 1.0, 0.0301),
            (3.0, 0.4, 0.1894),
            (3.0, 0.6, 0.1369),
            (3.0, 1.0, 0.0778),
        ] {
            let facets = MicrofacetDistribution::isotropic(alpha);
            let found = 1.0 - InterfaceScattering::new(&facets, eta).unwrap().transmitted;
            let tolerance = if alpha < 0.4 { 0.03 } else { 0.012 };
            assert!(
                (found - reflected).abs() < tolerance,
                "index {eta}, width {alpha}: {found}, not {reflected}"
            );
        }
    }

    #[test]
    fn mean_reflectance_of_glass_is_the_closed_form() {
        // Walsh's formula for n = 1.5, from outside and inside.
        let n: f64 = 1.5;
        let (n2, l) = (n * n, n.ln());
        let walsh = 0.5
            + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
            + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
            - 2.0 * n.powi(3) * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n.powi(4) - 1.0))
            + 8.0 * n.powi(4) * (n.powi(4) + 1.0) / ((n2 + 1.0) * (n.powi(4) - 1.0).powi(2)) * l;
        assert!((mean_dielectric(n) - walsh).abs() < 1e-4, "{} {walsh}", mean_dielectric(n));
        assert!((mean_dielectric(1.0 / n) - (1.0 - (1.0 - walsh) / n2)).abs() < 1e-4);
    }

    #[test]
    fn jacobian_is_the_ratio_of_solid_angles() {
        let (wo, eta) = (DVec3::new(0.3, -0.2, 0.8).normalize(), 1.5);
        for m in [DVec3::Z, DVec3::new(0.2, 0.1, 1.0).normalize()] {
            let (a, b) = m.any_orthonormal_pair();
            let step = 1e-5;
            let refracted =
                |x: f64, y: f64| fresnel::refract(wo, (m + a * x + b * y).normalize(), eta).unwrap();
            let du = (refracted(step, 0.0) - refracted(-step, 0.0)) / (2.0 * step);
            let dv = (refracted(0.0, step) - refracted(0.0, -step)) / (2.0 * step);
            let found = Refraction::between(wo, refracted(0.0, 0.0), eta).unwrap();
            assert!((found.m - m).length() < 1e-12);
            assert!((found.jacobian * du.cross(dv).length() - 1.0).abs() < 1e-8);
        }
        assert!(Refraction::between(wo, DVec3::new(0.9, 0.0, -0.1).normalize(), eta).is_none());
    }
}
