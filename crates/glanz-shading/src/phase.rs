//! Scattering of light in a medium.

use std::f64::consts::FRAC_1_PI;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, Frame, SolidAnglePdf};

use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode};

/// The phase function of Henyey and Greenstein: the density per solid angle of the direction in which a particle scatters light.
///
/// As a [`BsdfModel`] it is one of a point without a surface: directions to both sides are alike, and its value is the density itself, without a
/// cosine. It scatters all light; what the medium absorbs is no part of it.
///
/// # Source
/// @henyey1941; directions as in @pharr2023 section 11.3.1: both point away from the particle, so that `wi = -wo` continues straight ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

/// |g| below which samples are uniform: the formula divides by g.
const ISOTROPIC: f64 = 1e-6;

impl HenyeyGreenstein {
    /// `g`: the asymmetry parameter, the mean cosine of the scattering angle, between -1 and 1 (both excluded): above 0 forwards, below 0 backwards.
    /// `None` for others.
    #[must_use]
    pub fn try_new(g: f64) -> Option<Self> {
        (g > -1.0 && g < 1.0).then_some(Self { g })
    }

    /// The density of a direction with this cosine to `wo`.
    fn density(&self, cos: f64) -> f64 {
        let g = self.g;
        // 1 + g^2 + 2 g cos without cancellation where it is small.
        let denominator = (1.0 - g.abs()).powi(2) + 2.0 * (g.abs() + g * cos).max(0.0);
        0.25 * FRAC_1_PI * (1.0 - g * g) / (denominator * denominator.sqrt())
    }

    /// The cosine to `wo` that a number uniform in [0, 1) selects.
    fn cosine(&self, xi: f64) -> f64 {
        let g = self.g;
        if g.abs() < ISOTROPIC {
            return 1.0 - 2.0 * xi;
        }
        let quotient = (1.0 - g * g) / (1.0 + g - 2.0 * g * xi);
        (-(1.0 + g * g - quotient * quotient) / (2.0 * g)).clamp(-1.0, 1.0)
    }
}

impl BsdfModel for HenyeyGreenstein {
    const LOBES: &'static [Lobe] = &[Lobe::GLOSSY, Lobe::GLOSSY_TRANSMISSION];

    fn sample(&self, wo: DVec3, xi: DVec2, _: f64, mode: TransportMode) -> Option<BsdfSample> {
        let cos = self.cosine(xi.x);
        let (sin, azimuth) = ((1.0 - cos * cos).max(0.0).sqrt(), std::f64::consts::TAU * xi.y);
        let wi = Frame::from_z(wo).to_world(DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos));
        let lobe = if wo.z * wi.z < 0.0 { Lobe::GLOSSY_TRANSMISSION } else { Lobe::GLOSSY };
        BsdfSample::of_direction(self, [wo, wi], lobe, mode)
    }

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        Spectrum::splat(self.density(wo.dot(wi)) as f32)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        SolidAnglePdf(self.density(wo.dot(wi)))
    }

    fn albedo(&self, _: DVec3) -> Spectrum {
        Spectrum::ONE
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glanz_sampling::hash::{combine, unit_f64};
    use glanz_sampling::statistics::chi_square;

    use super::*;

    const VALUES: [f64; 7] = [-0.99, -0.6, 0.0, 5e-5, 0.3, 0.85, 0.999];

    fn phase(g: f64) -> HenyeyGreenstein {
        HenyeyGreenstein::try_new(g).unwrap()
    }

    /// The probability of a cosine to `wo` of at most `cos`, from the antiderivative of the density: with c the cosine of deflection,
    /// 2 pi p integrates to (1 - g^2) / (2 g) (1 / sqrt(1 + g^2 - 2 g c) - 1 / (1 + g)) from -1 on.
    fn probability_below(g: f64, cos: f64) -> f64 {
        if g.abs() < 1e-3 {
            return 0.5 * (1.0 + cos);
        }
        let below =
            |c: f64| (1.0 - g * g) / (2.0 * g) * (1.0 / (1.0 + g * g - 2.0 * g * c).sqrt() - 1.0 / (1.0 + g));
        1.0 - below(-cos)
    }

    #[test]
    fn samples_follow_the_density_by_angle_and_azimuth() {
        let wo = DVec3::new(0.48, -0.6, 0.64);
        let frame = Frame::from_z(wo);
        let (rows, columns, n) = (20, 8, 40_000_u64);
        for g in VALUES {
            // Rows of equal probability, by bisection of the closed form.
            let edge = |row: usize| {
                let (mut low, mut high) = (-1.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if probability_below(g, middle) < row as f64 / rows as f64 {
                        low = middle
                    } else {
                        high = middle
                    }
                }
                low
            };
            let edges: Vec<f64> = (1..rows).map(edge).collect();
            let mut counts = vec![0_u64; rows * columns];
            for i in 0..n {
                let xi = DVec2::new(unit_f64(combine(1, i)), unit_f64(combine(2, i)));
                let sample = phase(g).sample(wo, xi, 0.5, TransportMode::Radiance).unwrap();
                assert!((sample.wi.length() - 1.0).abs() < 1e-12);
                let local = frame.to_local(sample.wi);
                let row = edges.partition_point(|&edge| edge <= local.z);
                let turn = (local.y.atan2(local.x) / TAU).rem_euclid(1.0);
                counts[row * columns + (turn * columns as f64) as usize % columns] += 1;
            }
            let expected = vec![n as f64 / (rows * columns) as f64; rows * columns];
            let test = chi_square(&counts, &expected);
            assert!(test.p_value > 0.001 / VALUES.len() as f64, "g {g}: {test:?}");
        }
    }

    #[test]
    fn density_integrates_to_one_with_the_mean_deflection_g() {
        for g in VALUES.into_iter().filter(|g| g.abs() < 0.9) {
            let (mut total, mut mean, n) = (0.0, 0.0, 200_000);
            for i in 0..n {
                let cos = -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n);
                let wi = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let weight = 2.0 * PI * phase(g).pdf(DVec3::Z, wi).0 * 2.0 / f64::from(n);
                total += weight;
                // Deflection is measured from straight on, which is -wo.
                mean -= cos * weight;
            }
            assert!((total - 1.0).abs() < 1e-6 && (mean - g).abs() < 1e-6, "{g}: {total} {mean}");
        }
    }

    #[test]
    fn positive_g_scatters_onwards() {
        let forward = phase(0.7);
        // (1 - g^2) / (4 pi (1 - g)^3) = 0.51 / (4 pi 0.027), and with (1 + g)^3 back.
        assert!((forward.pdf(DVec3::Z, -DVec3::Z).0 - 0.51 / (4.0 * PI * 0.027)).abs() < 1e-12);
        assert!((forward.pdf(DVec3::Z, DVec3::Z).0 - 0.51 / (4.0 * PI * 4.913)).abs() < 1e-12);
        for g in [-1.0, 1.0, 1.5, f64::NAN] {
            assert_eq!(HenyeyGreenstein::try_new(g), None);
        }
    }
}
