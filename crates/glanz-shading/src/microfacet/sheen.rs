//! Fibres of cloth.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glanz_math::DVec3;
use glanz_sampling::basis::GaussLegendre;

use super::table::InterpolationTable;
use super::{clamp_unit, half_vector};

/// The lobe of the fibres of cloth, which is bright towards grazing angles; for a white colour, directions above.
///
/// # Source
/// @estevez2017, with the fit of its masking, as in glTF (extension `KHR_materials_sheen`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheenDistribution {
    alpha: f64,
    /// Exponent of the sine.
    exponent: f64,
    /// Coefficients of the masking.
    masking: [f64; 5],
}

/// The least width: narrower lobes of grazing directions cannot be sampled well.
const SMALLEST_ALPHA: f64 = 0.07;

/// Coefficients of the masking for widths 0 and 1.
const MASKING: [[f64; 5]; 2] =
    [[25.3245, 3.32435, 0.16801, -1.27393, -4.85967], [21.5473, 3.82987, 0.19823, -1.97760, -4.32054]];

impl SheenDistribution {
    /// Fibres of the width `alpha`, in [0.07, 1]; others count as the nearest. That of glTF is the square of its roughness.
    #[must_use]
    pub fn new(alpha: f64) -> Self {
        let alpha = clamp_unit(alpha).max(SMALLEST_ALPHA);
        let smooth = (1.0 - alpha).powi(2);
        let masking = std::array::from_fn(|i| smooth * MASKING[0][i] + (1.0 - smooth) * MASKING[1][i]);
        Self { alpha, exponent: 1.0 / alpha, masking }
    }

    /// `f cos_i`.
    #[must_use]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let m = half_vector(wo, wi);
        let sin2 = (1.0 - m.z * m.z).max(0.0);
        let density = (2.0 + self.exponent) * sin2.powf(0.5 * self.exponent) / TAU;
        // Along the surface the lobe has a limit.
        density / (4.0 * wo.z.max(1e-6) * (1.0 + self.lambda(wo.z) + self.lambda(wi.z)))
    }

    /// Area of hidden fibres per area of visible ones.
    fn lambda(&self, cos: f64) -> f64 {
        let [a, b, c, d, e] = self.masking;
        let fit = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
        if cos < 0.5 { fit(cos).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cos)).exp() }
    }

    /// Fraction of the light from a direction with this cosine that is reflected, below 1; error at most 0.03.
    #[must_use]
    pub fn albedo(&self, cos: f64) -> f64 {
        let width = (self.alpha - SMALLEST_ALPHA) / (1.0 - SMALLEST_ALPHA);
        ALBEDO.at([width, cos.max(0.0).sqrt()])
    }
}

/// Width above the smallest, square root of the cosine.
static ALBEDO: LazyLock<InterpolationTable<2>> = LazyLock::new(|| {
    let rule = GaussLegendre::new(32);
    InterpolationTable::new([33, 33], |[width, root]| {
        let alpha = SMALLEST_ALPHA + width * (1.0 - SMALLEST_ALPHA);
        let (sheen, cos) = (SheenDistribution::new(alpha), (root * root).clamp(1e-4, 1.0));
        let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        rule.integrate(0.0, 1.0, |x| {
            // Closer nodes at grazing angles: z = x^2.
            let (z, sin) = (x * x, (1.0 - x.powi(4)).sqrt());
            2.0 * x
                * 2.0
                * rule
                    .integrate(0.0, PI, |phi| sheen.eval(wo, DVec3::new(sin * phi.cos(), sin * phi.sin(), z)))
        })
    })
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedo_is_the_integral_over_directions_and_below_one() {
        for alpha in [0.07, 0.1, 0.35, 0.62, 1.0] {
            for cos in [0.03_f64, 0.2, 0.7, 1.0] {
                let sheen = SheenDistribution::new(alpha);
                let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let n = 600;
                let mut sum = 0.0;
                for i in 0..n {
                    for j in 0..n {
                        let (z, phi) =
                            ((f64::from(i) + 0.5) / f64::from(n), TAU * (f64::from(j) + 0.5) / f64::from(n));
                        let sin = (1.0 - z * z).sqrt();
                        sum += sheen.eval(wo, DVec3::new(sin * phi.cos(), sin * phi.sin(), z));
                    }
                }
                let albedo = sum * TAU / f64::from(n * n);
                assert!((sheen.albedo(cos) - albedo).abs() < 0.01, "{alpha} {cos}: {albedo}");
                assert!(albedo < 1.0);
            }
        }
    }
}
